"""`fatplan record`: recorded motions, checked; reactions, recognised; preferences, learnt from observed cycles.

`record import` is in a file of its own.
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import ExitCode
from fatigue_planner.core.executors.executor import ONE_THREAD
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    from fatigue_planner.recordings.check import Checked
    from fatigue_planner.recordings.learning.learnt import Learnt

app = typer.Typer(
    name="record",
    help="Check and import recorded motions; recognise reactions; learn preferences.",
    no_args_is_help=True,
)

Units = Annotated[Literal["mm", "cm", "m"] | None, typer.Option("--units", help="Unit of length.")]
Up = Annotated[
    Literal["+x", "+y", "+z", "-x", "-y", "-z"] | None, typer.Option("--up", help="Axis that points upwards.")
]
Rate = Annotated[float | None, typer.Option("--rate", min=0.1, max=100_000, help="Frames per second.")]
Prefix = Annotated[str | None, typer.Option("--prefix", help="What stands before the labels of the person, without :.")]
MappingName = Annotated[
    str | None, typer.Option("--mapping", help="Mapping of labels that ships, or a YAML file. Default: the best one.")
]
Mass = Annotated[float | None, typer.Option("--mass", min=20, max=300, help="Mass of the body in kg.")]
Heading = Annotated[
    float | None,
    typer.Option(
        "--heading", min=-360, max=360, help="Degrees from x towards y, z up, in which the person first faces."
    ),
]
ExchangeSides = Annotated[
    bool, typer.Option("--exchange-sides", help="The labels say left where right is, and the other way round.")
]
AnglesIn = Annotated[
    Literal["deg", "rad"] | None, typer.Option("--angles", help="Unit of angles, where a file leaves it open.")
]
Reader = Annotated[
    Literal["ezc3d", "c3d"] | None, typer.Option("--reader", help="Library to believe where two read C3D differently.")
]


@app.callback()
def one_thread() -> None:
    """Let linear algebra be done by one thread, before its libraries are loaded.

    What is computed of a recording is then the same, to the bit, on any number of cores; and the banded systems of the
    smoother are solved three times as fast as by two threads that wait for each other.
    """
    for library in ONE_THREAD:
        os.environ[library] = "1"


@app.command(epilog=options.EXIT_CODES)
def check(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="C3D, TRC, MOT, STO, BVH, MVNX or CSV.")],
    units: Units = None,
    up: Up = None,
    rate: Rate = None,
    prefix: Prefix = None,
    mapping: MappingName = None,
    mass: Mass = None,
    heading: Heading = None,
    exchange_sides: ExchangeSides = False,
    angles: AnglesIn = None,
    reader: Reader = None,
    as_json: options.Json = False,
) -> None:
    """Read FILES and say what they hold, what is inferred, and what is wrong. Options overrule what is inferred."""
    from fatigue_planner.recordings.check import check as check_files
    from fatigue_planner.recordings.formats.registry import Choices
    from fatigue_planner.recordings.inference.finding import Given
    from fatigue_planner.recordings.mapping import load_mapping

    if mapping is not None:
        load_mapping(mapping)
    given = Given(units, up, rate, prefix, mapping, mass, heading_deg=heading, exchange_sides=exchange_sides)
    checked = check_files(files, given, Choices(reader, None if angles is None else angles == "deg"))
    document = {"files": [_row(one) for one in checked], "refused": sum(one.found is None for one in checked)}
    options.present(document, "\n".join(map(told, checked)), as_json)
    if document["refused"]:
        raise typer.Exit(ExitCode.FAILED_PARTS)


@app.command(epilog=options.EXIT_CODES)
def learn(
    cycles: Annotated[
        Path, typer.Argument(metavar="CYCLES", help="CSV: action, reaction (empty: not seen) and perhaps time_s.")
    ],
    experiment: Annotated[
        Path, typer.Option("--experiment", help="The experiment file (YAML), or the name of one that ships.")
    ],
    condition: Annotated[
        str | None,
        typer.Option("--condition", help="Condition that says who works and how tired he began. Default: the first."),
    ] = None,
    labelled: Annotated[
        Path | None,
        typer.Option(
            "--labelled",
            help="CSV of labelled repetitions: preference, recognised, count and perhaps action. Default: the "
            "experiment's recognition is taken for certain.",
        ),
    ] = None,
    write: Annotated[
        Path | None, typer.Option("--write", help="Write the learnt worker (YAML), to be put into an experiment.")
    ] = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Learn beta of Eq. 4, an offset per preference and inertia from the CYCLES of one worker.

    Says what the data cannot tell, and about how many more cycles would.
    """
    import yaml

    from fatigue_planner.core.files import publish_text
    from fatigue_planner.experiment.build import load_cycle_profiles
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.recordings.learning.worker import learn_worker

    loaded = load_experiment(experiment)
    profiles = load_cycle_profiles(loaded, cache, options.command_line("simulate", experiment, cache))
    found = learn_worker(loaded, profiles, condition, cycles, labelled)
    if write is not None:
        publish_text(write, yaml.safe_dump(found.worker, sort_keys=False, default_flow_style=None, width=120))
    document = {
        "cycles": found.cycles,
        "seen": found.seen,
        "parameters": [
            {
                "name": one.name, "estimate": one.interval.estimate, "low": one.interval.low,
                "high": one.interval.high, "told_from_0": one.is_told, "more_cycles": one.more_cycles,
            }
            for one in found.parameters
        ],
        "models": [
            {"name": name, "aic": fit.aic, "log_likelihood": fit.log_likelihood, "parameters": fit.parameters}
            for name, fit in found.fits.items()
        ],
        "chosen": found.chosen,
        "cannot_tell": found.sentences(),
        "worker": found.worker,
        "file": write,
    }  # fmt: skip
    options.present(document, _learnt_text(found, write), as_json)


def _learnt_text(found: "Learnt", write: Path | None) -> str:
    lines = [f"{counted(found.cycles, 'cycle')}, of which {found.seen} seen. With 95 % intervals:"]
    lines += [
        f"  {one.name}: {one.interval.estimate:.4g} ({one.interval.low:.4g} to {one.interval.high:.4g})"
        for one in found.parameters
    ]
    best = min(fit.aic for fit in found.fits.values())
    ranked = sorted(found.fits.items(), key=lambda item: item[1].aic)
    lines.append(f"Models by AIC: {', '.join(f'{name} +{fit.aic - best:.1f}' for name, fit in ranked)}.")
    lines += found.sentences()
    if write is not None:
        lines.append(f"{write}: the worker by {found.chosen}.")
    return "\n".join(lines)


def _row(one: "Checked") -> dict[str, Any]:
    if one.found is None:
        return {"file": one.file, "refused": one.refused}
    recording = one.found.recording
    return {
        "file": one.file,
        "refused": None,
        "format": one.format,
        "digest": recording.digest,
        "frames": recording.frames,
        "rate_hz": recording.rate_hz,
        "points": recording.labels,
        "angles": () if recording.angles is None else recording.angles.names,
        "plates": len(recording.ground),
        "mapping": one.found.mapping,
        "findings": one.found.findings,
        "remarks": one.found.remarks,
    }


def told(one: "Checked") -> str:
    """What a file holds, what was inferred and what is wrong with it, in lines."""
    if one.found is None:
        return f"{one.refused}\n  refused"
    recording = one.found.recording
    sizes = [
        (len(recording.labels), "point"),
        (0 if recording.angles is None else len(recording.angles.names), "angle"),
    ]
    sizes.append((len(recording.ground), "plate"))
    told = ", ".join(counted(number, what) for number, what in sizes if number)
    lines = [f"{one.file}: {one.format}, {counted(recording.frames, 'frame')}, {recording.duration_s:.2f} s, {told}"]
    lines += [f"  {finding.what}: {finding.value} ({finding.source})" for finding in one.found.findings]
    lines += [f"  fault {remark.fault}: {remark.text}" for remark in one.found.remarks]
    return "\n".join(lines)

"""`fatplan record recognise`: a recogniser from labelled repetitions, simulated or recorded, and what it can do."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError, listed

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.recordings.recognition.repetitions import CaptureError, Repetitions

TOLD_APART = 0.75
# The settings of `CaptureError` by option.
CAPTURE = {"offset_deg": "offset", "noise_deg": "noise", "repetitions": "repetitions", "seed": "seed"}


def recognise(
    experiment: options.ExperimentFile,
    recordings: Annotated[
        Path | None,
        typer.Option(
            "--recordings",
            metavar="TABLE",
            help="CSV of labelled recordings: file, person, action, preference, and perhaps begins_s, reached_s, "
            "left_s, ends_s, static, mapping. Default: the simulated reactions in the cache.",
        ),
    ] = None,
    offset: Annotated[
        float | None,
        typer.Option(min=0, max=30, help="Simulated: standard deviation in degrees of a session's error. Default: 5."),
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(min=0, max=30, help="Simulated: standard deviation in degrees of the changing error. Default: 3."),
    ] = None,
    repetitions: Annotated[
        int | None,
        typer.Option(min=1, max=1000, help="Simulated: how often every worker repeats a reaction. Default: 20."),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**63 - 1, help="Simulated: seed of the errors. Default: 0.")
    ] = None,
    told_apart: Annotated[
        float, typer.Option(min=0.5, max=1, help="Two reactions are one if less than this share is told apart.")
    ] = TOLD_APART,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    as_json: options.Json = False,
) -> None:
    """Learn to recognise the reactions of an EXPERIMENT from joint angles, and say how often that errs.

    Everybody is judged by what the others do: at least three people must show a reaction. People are those of the
    recordings, or the workers, whose simulated reactions are repeated with the errors of motion capture. The
    recogniser, the matrices for the experiment (`recognition_by_action`), a page and its tables go to the results
    folder.
    """
    import yaml

    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.output.reports.recognition.page import Judged, recognition_report
    from fatigue_planner.recordings.recognition import tables
    from fatigue_planner.recordings.recognition.recogniser import train
    from fatigue_planner.recordings.recognition.repetitions import CaptureError
    from fatigue_planner.recordings.recognition.stored import StoredRecogniser

    asked = {"offset": offset, "noise": noise, "repetitions": repetitions, "seed": seed}
    given = {name: value for name, value in asked.items() if value is not None}
    settings = load_experiment(experiment)
    command = options.command_line("recognise", experiment, cache, results).replace("recognise", "record recognise", 1)
    command += "".join(f" --{name} {value:g}" for name, value in given.items())
    command += f" --told-apart {told_apart:g}" if told_apart != TOLD_APART else ""
    if recordings is None:
        own = {name: given[option] for name, option in CAPTURE.items() if option in given}
        capture = CaptureError.model_validate(own)
        shown, digests = _simulated(settings, experiment, cache, capture)
    elif given:
        options_given = listed(f"--{name}" for name in given)
        raise SelectionError(f"--recordings: real errors are in the recordings; give no {options_given} with it.")
    else:
        capture = None
        shown, digests = _recorded(settings, recordings)
        command += f" --recordings {shlex.quote(str(recordings))}"
    recogniser, held_out = train(shown, settings.cycle, told_apart)
    stored = StoredRecogniser.of(recogniser, settings.name, digests, capture, told_apart)
    folder = writable_folder(results / settings.name / "recognition")
    stored.publish(folder / "recogniser.json")
    matrices = {action: known.confusion.plain() for action, known in recogniser.actions.items()}
    written = yaml.safe_dump({"recognition_by_action": matrices}, sort_keys=False, default_flow_style=None, width=120)
    publish_text(folder / "recognition.yaml", written)
    judged, figures = Judged(stored, recogniser, held_out), FigureFolder(folder)
    made = recognition_report(judged, figures, command)
    files = ["recogniser.json", "recognition.yaml", *(file.name for file in figures.files)]
    document = {
        "key": stored.key,
        "recognition_by_action": matrices,
        "confusion": made["confusion"].to_dict("records"),
        "pairs": made["pairs"].to_dict("records"),
        "calibration": made["calibration"].to_dict("records"),
        "known_from_s": judged.known_from_s(),
        "folder": folder,
        "files": files,
    }
    text = "\n".join(tables.lines(recogniser, judged.known_from_s()))
    options.present(document, f"{text}\n{folder / REPORT_FILE}: the page; beside it {len(files) - 1} files.", as_json)


def _simulated(
    settings: "Experiment", experiment: Path, cache: Path, capture: "CaptureError"
) -> "tuple[Repetitions, dict[str, str]]":
    """Repetitions of the reactions in the cache, and the digests of these."""
    from fatigue_planner.experiment.build import load_reactions
    from fatigue_planner.recordings.recognition.repetitions import measured

    reactions = load_reactions(settings, cache, options.command_line("simulate", experiment, cache))
    return measured(reactions, settings.cycle, capture), {str(one.name): one.digest for one in reactions}


def _recorded(settings: "Experiment", table: Path) -> "tuple[Repetitions, dict[str, str]]":
    """Repetitions of a table of recordings, and the digests of these."""
    from fatigue_planner.recordings.recognition.recorded import read_labels, recorded

    labels = read_labels(table, tuple(settings.actions), tuple(settings.preferences), settings.cycle)
    return recorded(table, labels, settings.workers, settings.cycle)

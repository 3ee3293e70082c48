"""`fatplan live rehearse`, `ur` and `lsl`: what talks to a server beside a robot, each a process of its own."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.live import need_server, policy_of, task_of
from fatigue_planner.cli.progress import progress, talk
from fatigue_planner.core.errors import ExitCode, OutputFolderError, SelectionError, listed

if TYPE_CHECKING:
    from fatigue_planner.live.rehearsal.fault import Fault
    from fatigue_planner.live.rehearsal.rehearse import Rehearsal

NO_FAULT = "none"


def rehearse(
    experiment: options.ExperimentFile,
    journal: Annotated[Path, typer.Option("--journal", help="The journal to write; there must be none yet.")] = Path(
        "rehearsal.fatplan"
    ),
    cycles: Annotated[int, typer.Option("--cycles", min=1, max=100_000, help="How many cycles.")] = 1800,
    faults: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="NAME[=RATE]",
            help="Only this fault, in this share of the cycles (repeatable); none: without. Default: all.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the worker and the faults.")] = 1,
    speed: Annotated[
        float, typer.Option("--speed", min=0, help="How many times faster than real time; 0: as fast as it goes.")
    ] = 0.0,
    condition: Annotated[
        str | None, typer.Option("--condition", help="Condition of the experiment's benchmark. Default: the first.")
    ] = None,
    policy: Annotated[
        str | None,
        typer.Option("--policy", help="Policy of the experiment's benchmark. Default: an exact lookahead of 2 cycles."),
    ] = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Rehearse a shift of an EXPERIMENT: a real server, a simulated worker and robot, simulated time, and faults.

    The table says how often each fault came and what the server did. Exit code 3: it did not do what is right.
    """
    need_server()
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.rehearsal.registry import FAULTS
    from fatigue_planner.live.rehearsal.rehearse import rehearse
    from fatigue_planner.live.rules import DEFAULT_POLICY
    from fatigue_planner.planners.registry import policy as policy_settings

    rates = {name: fault.rate for name, fault in FAULTS.items()} if faults is None else _rates(faults, FAULTS)
    if journal.exists():
        raise OutputFolderError(f"{journal}: is there already; a rehearsal begins a journal.")
    loaded = load_experiment(experiment)
    settings = policy_of(loaded, "policy", policy) or policy_settings(DEFAULT_POLICY)
    task = task_of(loaded, condition, cache, options.command_line("simulate", experiment, cache))
    words = [str(experiment), "--condition", task.name, "--cache", str(cache)]
    words += [] if policy is None else ["--policy", policy]
    words += [word for file in plugins or () for word in ("--plugin", str(file))]
    with progress("Rehearsed", cycles) as done:
        came = rehearse(
            journal, task, settings, words, cycles, rates, seed, speed,
            started=lambda page: talk().print(f"The operators' page: {page}", markup=False),
            advance=lambda number: done.advance(number, number),
        )  # fmt: skip
    document = {"journal": journal, "right": came.is_right, **asdict(came)}
    options.present(document, _table(came, journal), as_json)
    if not came.is_right:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _rates(asked: list[str], known: "Mapping[str, Fault]") -> dict[str, float]:
    """By name, in which share of the cycles each fault is to happen. Raises SelectionError."""
    rates: dict[str, float] = {}
    for word in asked:
        name, _, text = word.partition("=")
        if name == NO_FAULT and len(asked) == 1 and not text:
            return {}
        if name not in known:
            raise SelectionError(f"--fault {word}: there is no such fault; available: {listed([*known, NO_FAULT])}.")
        try:
            rates[name] = float(text) if text else known[name].rate
        except ValueError:
            rates[name] = -1.0
        if not 0 <= rates[name] <= 1:
            raise SelectionError(f"--fault {word}: should be {name}=RATE with a rate from 0 to 1.")
    if sum(rates.values()) > 1:
        raise SelectionError(f"--fault: the rates' sum is {sum(rates.values()):g}; at most 1 fault comes per cycle.")
    return rates


def _table(came: "Rehearsal", journal: Path) -> str:
    """The rehearsal's table: fault, how often it came, what the server did, whether that is right."""
    lines = [("fault", "times", "what the server did", "right")]
    for row in came.rows:
        did = [f"{what} ({times})" for what, times in row.did.items()] or ["-"]
        right = f"no ({row.wrong})" if row.wrong else "yes" if row.times else "-"
        lines.append((row.fault, str(row.times), did[0], right))
        lines += [("", "", one, "") for one in did[1:]]
    name, times, what = (max(len(line[column]) for line in lines) for column in range(3))
    text = [f"{one:{name}}  {two:>{times}}  {three:{what}}  {four}".rstrip() for one, two, three, four in lines]
    wrong = len(came.wrong_inputs)
    said = f"{wrong} of {came.inputs} inputs are not what was said" if wrong else f"all {came.inputs} inputs are right"
    belief = "the belief is that of a shift without faults" if came.belief_is_right else "the belief is wrong"
    text += ["", f"{journal}: a rehearsal, {came.cycles} cycles, {came.seconds / 3600:.1f} h; {said}; {belief}."]
    return "\n".join([*text, *came.wrong_inputs[:3]])

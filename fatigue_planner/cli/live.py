"""`fatplan live`: what to do with the journal of a shift."""

import json
import os
import time
from dataclasses import replace
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import talk, warn
from fatigue_planner.core.errors import ExitCode, MissingExtraError, SelectionError, check_known
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.live.events import AlarmSettings
    from fatigue_planner.planners.policy import PolicySettings
    from fatigue_planner.pomdp.scenario import Scenario

app = typer.Typer(
    name="live",
    help="A shift beside a robot: serve it, rehearse it, and report, export, recover and clear its journal.",
    no_args_is_help=True,
)

JournalFile = Annotated[Path, typer.Argument(metavar="JOURNAL", help="The journal of a shift.")]
ConditionName = Annotated[
    str | None, typer.Option("--condition", help="Condition of the experiment's benchmark. Default: the first.")
]
PolicyName = Annotated[
    str | None,
    typer.Option("--policy", help="Policy of the experiment's benchmark. Default: an exact lookahead of 2 cycles."),
]


def policy_of(loaded: "Experiment", option: str, name: str | None) -> "PolicySettings | None":
    """The policy that an option names, if it names one. Raises SelectionError."""
    known = loaded.benchmark.policies
    if name is None:
        return None
    check_known(option, name, known)
    return known[name]


def need_server() -> None:
    """Raise MissingExtraError if there is nothing to serve the face with."""
    if find_spec("starlette") is None or find_spec("uvicorn") is None:
        raise MissingExtraError("fatplan live needs Starlette and uvicorn: pip install 'fatigue-planner[live]'.")


@app.command(epilog=options.EXIT_CODES)
def serve(
    experiment: options.ExperimentFile,
    journal: Annotated[Path, typer.Option("--journal", help="The journal; one that is there is gone on with.")] = Path(
        "shift.fatplan"
    ),
    condition: ConditionName = None,
    policy: PolicyName = None,
    deadline_s: Annotated[float, typer.Option("--deadline", help="Seconds after which an answer is late.")] = 0.05,
    safe_action: Annotated[
        str | None, typer.Option("--safe-action", help="Action if nothing else decides. Default: the most ergonomic.")
    ] = None,
    limit: Annotated[
        float, typer.Option("--limit", min=0.01, max=0.99, help="Fatigue above which a pause is wanted.")
    ] = 0.5,
    limit_source: Annotated[
        str | None, typer.Option("--limit-source", help="Where the limit comes from, as the page says.")
    ] = None,
    repeat_s: Annotated[
        float,
        typer.Option("--repeat-after", min=1, max=86400, help="Seconds after which a seen alarm is told again."),
    ] = 600.0,
    host: Annotated[
        str, typer.Option("--host", help="Address of this machine; any but loopback needs a certificate.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port; 0: any that is free.")] = 8765,
    tls_cert: Annotated[
        Path | None, typer.Option("--tls-cert", help="Certificate in PEM, with the chain: the face speaks HTTPS.")
    ] = None,
    tls_key: Annotated[Path | None, typer.Option("--tls-key", help="Its key in PEM, without a password.")] = None,
    search: Annotated[
        str | None,
        typer.Option("--search", help="Policy of the experiment's benchmark that improves decisions, in time or not."),
    ] = None,
    unseen_limit: Annotated[
        int, typer.Option("--unseen-limit", help="Cycles not seen, in a row, after which the schedule decides.")
    ] = 20,
    accept: Annotated[
        bool, typer.Option("--accept", help="Begin a new segment where the journal's shift had another situation.")
    ] = False,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Real-time priority for answers, where the system permits it.")
    ] = False,
    rehearsal: Annotated[
        bool, typer.Option("--rehearsal", help="Simulated time, which a client moves on. The journal says so.")
    ] = False,
    keep_days: Annotated[
        int | None,
        typer.Option(
            "--keep-days", min=1, help="First remove older journals from the journal's folder; they are named."
        ),
    ] = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
) -> None:
    """Run a shift of an EXPERIMENT beside a robot: HTTP and JSON, and a page for operators.

    Two tokens, to look and to act, are written beside the journal, into files that only you can read.
    """
    need_server()
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.clock import RehearsalClock
    from fatigue_planner.live.face.guard import Tokens
    from fatigue_planner.live.face.server import bound, check_host, names_of, serve, write_token
    from fatigue_planner.live.face.tls import certificate
    from fatigue_planner.live.journal_file import last_seconds
    from fatigue_planner.live.realtime import answer_first
    from fatigue_planner.live.session import Session

    if (tls_cert is None) != (tls_key is None):
        raise SelectionError("--tls-cert and --tls-key: give both, or none.")
    shown = None if tls_cert is None or tls_key is None else certificate(tls_cert, tls_key)
    check_host(host, shown)
    alarms = alarm_settings(limit, limit_source, repeat_s)
    loaded = load_experiment(experiment)
    settings, searching = policy_of(loaded, "policy", policy), policy_of(loaded, "search", search)
    task = task_of(loaded, condition, cache, options.command_line("simulate", experiment, cache))
    with bound(host, port) as listening:
        removed = [] if keep_days is None else expired(journal.parent, keep_days, journal)
        talk().print("Compiling and running everything once ...")
        began = time.perf_counter()
        clock = RehearsalClock(last_seconds(journal)) if rehearsal else None
        with Session.open(
            journal,
            task,
            settings,
            deadline_s,
            safe_action,
            clock,
            alarms,
            search=searching,
            unseen_limit=unseen_limit,
            accept=accept,
            experiment=from_folder_of(journal, experiment),
            cache=from_folder_of(journal, cache),
        ) as session:
            tokens, view, act = Tokens.make()
            names = names_of(host, listening.getsockname()[1], shown)
            address = f"{'http' if shown is None else 'https'}://{names[0]}"
            for right, token in (("view", view), ("act", act)):
                write_token(journal.with_name(f"{journal.name}.{right}-token"), token)
            for name in removed:
                session.note(f"{name}: removed, older than {keep_days} days")
            typer.echo(f"{address}/#{view}")
            talk().print(
                f"Ready after {time.perf_counter() - began:.1f} s. Cycle {session.cycle} of {journal}. "
                f"The line above is the page; the token to act is in "
                f"{journal.name}.act-token; {address}/openapi.json describes the calls. Ctrl-C ends.",
                markup=False,
            )
            if realtime and (refused := answer_first()):
                warn([f"--realtime: {refused}."])
            serve(session, listening, tokens, frozenset(names), shown, clock)


def alarm_settings(limit: float, source: str | None, repeat_s: float) -> "AlarmSettings":
    """When a pause is wanted. Raises SelectionError."""
    from fatigue_planner.live.events import MAX_SOURCE_LENGTH, AlarmSettings

    if source is not None and len(source) > MAX_SOURCE_LENGTH:
        raise SelectionError(f"--limit-source: should have at most {MAX_SOURCE_LENGTH} characters, has {len(source)}.")
    if source is None and limit == AlarmSettings().limit:
        return AlarmSettings(repeat_s=repeat_s)
    return AlarmSettings(limit=limit, limit_source=source or "--limit, no source given", repeat_s=repeat_s)


def task_of(loaded: "Experiment", condition: str | None, cache: Path, command: str) -> "Scenario":
    """The scenario of a condition, by default the first; `command` simulates its reactions. Raises SelectionError."""
    from fatigue_planner.experiment.build import load_cycle_profiles, scenario
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible

    conditions = loaded.benchmark.conditions
    chosen = next(iter(conditions)) if condition is None else condition
    check_known("condition", chosen, conditions)
    profiles = load_cycle_profiles(loaded, cache, command)
    warn(omissions(loaded, profiles, profiles.ruled_out))
    possible = without_infeasible(loaded, profiles, profiles.ruled_out)
    return replace(scenario(possible, profiles, possible.benchmark.conditions[chosen]), name=chosen)


def expired(folder: Path, keep_days: int, but: Path) -> list[str]:
    """Remove the journals of a folder that are older, but for one, and say so; the names of those that are gone."""
    from fatigue_planner.live.retention import remove_old, too_old

    old = [one for one in too_old(folder, keep_days, datetime.now(UTC)) if one.path.name != but.name]
    gone = []
    for one, why in remove_old(old):
        talk().print(f"{one.path}, last event {one.last:%Y-%m-%d}: {why or 'removed'}.", markup=False)
        gone += [] if why else [one.path.name]
    return gone


def from_folder_of(journal: Path, path: Path) -> str:
    """Where a file or folder lies, from the journal's folder; the name of an experiment that ships as it is."""
    return os.path.relpath(path, journal.parent) if path.exists() else str(path)


@app.command(epilog=options.EXIT_CODES)
def export(
    journal: JournalFile,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write.")],
    form: Annotated[
        Literal["csv", "jsonl"] | None, typer.Option("--format", help="Default: by the file's ending.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Write the events of a JOURNAL as a table (CSV) or as lines of JSON. Workers are random numbers in it."""
    import pandas as pd

    from fatigue_planner.core.files import canonical_json, publish_csv, publish_text
    from fatigue_planner.live.journal_file import read_journal

    form = form or {".csv": "csv", ".jsonl": "jsonl"}.get(file.suffix)  # type: ignore[assignment]
    if form is None:
        raise SelectionError(f"{file}: should end in .csv or .jsonl, or give --format.")
    rows = [
        {"number": one.number, "seconds": one.seconds, "utc": one.utc, **one.event.plain()}
        for one in read_journal(journal)
    ]
    if form == "jsonl":
        publish_text(file, "".join(f"{canonical_json(row)}\n" for row in rows))
    else:
        nested = [
            {key: json.dumps(value) if isinstance(value, dict | list) else value for key, value in row.items()}
            for row in rows
        ]
        publish_csv(file, pd.DataFrame(nested).convert_dtypes())
    options.present({"file": file, "events": len(rows)}, f"{file}: {counted(len(rows), 'event')}.", as_json)


@app.command(epilog=options.EXIT_CODES)
def recover(
    journal: JournalFile,
    into: Annotated[Path, typer.Argument(metavar="NEW", help="The new journal.")],
    from_cycle: Annotated[
        int | None,
        typer.Option("--from", metavar="CYCLE", help="Cycle to go on with. Default: the one after the last intact."),
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Copy what is intact of a damaged JOURNAL, from its beginning, to a NEW one, with which a shift can go on."""
    from fatigue_planner.live.recovery import recover

    events = recover(journal, into, from_cycle)
    options.present({"file": into, "events": len(events)}, f"{into}: {counted(len(events), 'event')}.", as_json)


@app.command(epilog=options.EXIT_CODES)
def erase(
    journal: JournalFile,
    pseudonym: Annotated[str, typer.Argument(metavar="PSEUDONYM", help="The worker's pseudonym.")],
    as_json: options.Json = False,
) -> None:
    """Erase what joins a worker's events in a JOURNAL to a PSEUDONYM. The events, which name nobody, stay."""
    from fatigue_planner.live.journal_file import erase

    if not erase(journal, pseudonym):
        raise SelectionError(f"{journal}: no worker has the pseudonym {pseudonym!r}.")
    options.present({"journal": journal, "erased": True}, f"{journal}: {pseudonym} is erased.", as_json)


@app.command(epilog=options.EXIT_CODES)
def expire(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Where journals lie.")],
    keep_days: Annotated[int, typer.Option("--keep-days", min=1, help="For how many days after its last event.")],
    remove: Annotated[bool, typer.Option("--remove", help="Remove them; otherwise they are only listed.")] = False,
    as_json: options.Json = False,
) -> None:
    """List the journals in a FOLDER that are older than they should become, or remove them and what lies beside them.

    One that is being written stays. Reports in other folders are copies, which whoever has them removes.
    """
    from fatigue_planner.live.retention import remove_old, too_old

    old = too_old(folder, keep_days, datetime.now(UTC))
    outcomes = list(remove_old(old)) if remove else [(one, "") for one in old]
    rows = [
        {"journal": one.path, "last_event": one.last.isoformat(), "files": [file.name for file in one.files],
         "removed": remove and not why, "why_not": why or None}
        for one, why in outcomes
    ]  # fmt: skip
    what = {True: "removed", False: "would be removed with --remove"}[remove]
    lines = [f"{one.path}, last event {one.last:%Y-%m-%d}: {why or what}." for one, why in outcomes]
    nothing = f"{folder}: no journal is older than {counted(keep_days, 'day')}."
    options.present({"journals": rows}, "\n".join(lines) or nothing, as_json)
    if any(why for _, why in outcomes):
        raise typer.Exit(ExitCode.FAILED_PARTS)

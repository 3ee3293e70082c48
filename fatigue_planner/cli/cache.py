"""`fatplan cache`: the folder of reaction libraries."""

from collections.abc import Sequence
from pathlib import Path

import typer

from fatigue_planner.cli.options import ALL_CORES, DEFAULT_CACHE, EXIT_CODES, CacheFolder, Jobs
from fatigue_planner.cli.progress import progress
from fatigue_planner.errors import DamagedFileError, ExitCode, FatplanError, MissingLibraryError, OtherVersionError
from fatigue_planner.executors.processes import LocalProcesses
from fatigue_planner.reactions.audit import Audit, audit
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.library import names_in
from fatigue_planner.reactions.reaction import ReactionName

app = typer.Typer(help="Look after the reaction cache.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    pass


@app.command(epilog=EXIT_CODES)
def verify(cache: CacheFolder = DEFAULT_CACHE, jobs: Jobs = ALL_CORES) -> None:
    """Check every stored reaction again: its hash, and every invariant of its motion.

    The invariants (equation of motion, friction, centre of pressure, limits, feet, hands, balance,
    power) are recomputed from the stored motion and compared with what was stored of them. Nothing is
    changed; `fatplan simulate` mends what its experiment needs. Exit code 4 if a file is damaged, 3 if
    a motion does not keep its bars.
    """
    files = ReactionCache(cache).files()
    if not files:
        raise MissingLibraryError(f"{cache}: no reaction library there. Run `fatplan simulate` first.")
    places, unreadable = _contents(files)
    audits = {}
    with progress("Checking reactions", len(places)) as counter:
        for place, result in LocalProcesses(jobs).run(audit, places):
            audits[place] = result if isinstance(result, Audit) else Audit(*places[place], "failed", result.reason)
            counter.advance()
    ordered = [audits[place] for place in range(len(places))]
    _print(ordered, unreadable)
    counts = {verdict: sum(result.verdict == verdict for result in ordered) for verdict in ("ok", "degraded", "failed")}
    broken = {result.path for result in ordered if result.damaged}
    n_damaged = sum(isinstance(error, DamagedFileError) for error in unreadable) + len(broken)
    summary = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    typer.echo(f"{len(ordered)} reactions in {len(files)} files: {summary}; {n_damaged} files damaged.")
    if n_damaged or counts["failed"]:
        typer.echo("`fatplan simulate` sets damaged files aside and simulates again what its experiment needs.")
        raise typer.Exit(ExitCode.DAMAGED_STORE if n_damaged else ExitCode.FAILED_PARTS)


def _contents(files: Sequence[Path]) -> tuple[list[tuple[Path, ReactionName]], list[FatplanError]]:
    """What the files hold, and why some of them cannot be looked into."""
    places: list[tuple[Path, ReactionName]] = []
    unreadable: list[FatplanError] = []
    for path in files:
        try:
            places += [(path, name) for name in names_in(path)]
        except (OtherVersionError, DamagedFileError) as error:
            unreadable.append(error)
    return places, unreadable


def _print(audits: Sequence[Audit], unreadable: Sequence[FatplanError]) -> None:
    path = None
    for result in audits:
        if result.path != path:
            path = result.path
            typer.echo(f"{path}:")
        reason = f": {result.reason}" if result.reason else ""
        typer.echo(f"  {result.name!s:<32} {'DAMAGED' if result.damaged else result.verdict}{reason}")
    for error in unreadable:
        typer.echo(f"{'DAMAGED' if isinstance(error, DamagedFileError) else 'Not checked'}: {error}")

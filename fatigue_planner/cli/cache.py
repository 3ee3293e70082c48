"""`fatplan cache`: the folder of reaction libraries."""

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from fatigue_planner.cli.options import ALL_CORES, DEFAULT_CACHE, CacheFolder, Jobs, talk
from fatigue_planner.errors import DamagedFileError, ExitCode, MissingLibraryError, OtherVersionError
from fatigue_planner.parallel import run_parallel
from fatigue_planner.reactions.audit import audit
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.library import names_in

app = typer.Typer(help="Look after the reaction cache.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    pass


@app.command()
def verify(cache: CacheFolder = DEFAULT_CACHE, jobs: Jobs = ALL_CORES) -> None:
    """Check every stored reaction again: the file's hashes, and every invariant of its motion.

    The invariants (equation of motion, friction, centre of pressure, limits, feet, hands, balance,
    power) are recomputed from the stored motion and compared with what was stored of them. Nothing is
    changed; `fatplan simulate` mends what its experiment needs. Exit code 4 if a file is damaged, 3 if
    a motion does not keep its bars.
    """
    files = ReactionCache(cache).files()
    if not files:
        raise MissingLibraryError(f"{cache}: no reaction library there. Run `fatplan simulate` first.")
    places, damaged, other = [], [], []
    for path in files:
        try:
            places += [(path, name) for name in names_in(path)]
        except OtherVersionError as error:
            other.append(str(error))
        except DamagedFileError as error:
            damaged.append(str(error))
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    audits = {}
    with Progress(*columns, console=talk()) as bar:
        task = bar.add_task("Checking reactions", total=len(places))
        for place, result in run_parallel(audit, places, jobs):
            audits[place] = result
            bar.advance(task)
    ordered = [audits[place] for place in range(len(places))]
    for path in files:
        own = [result for result in ordered if result.path == path]
        if own:
            typer.echo(f"{path}:")
        for result in own:
            reason = f": {result.reason}" if result.reason else ""
            typer.echo(f"  {result.name!s:<32} {'DAMAGED' if result.damaged else result.verdict}{reason}")
    for message in other:
        typer.echo(f"Not checked: {message}")
    for message in damaged:
        typer.echo(f"DAMAGED: {message}")
    counts = {verdict: sum(result.verdict == verdict for result in ordered) for verdict in ("ok", "degraded", "failed")}
    broken = {result.path for result in ordered if result.damaged}
    n_damaged = len(damaged) + len(broken)
    summary = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    typer.echo(f"{len(ordered)} reactions in {len(files)} files: {summary}; {n_damaged} files damaged.")
    if n_damaged:
        raise typer.Exit(ExitCode.DAMAGED_STORE)
    if counts["failed"]:
        raise typer.Exit(ExitCode.FAILED_PARTS)

"""`fatplan cache`: the folder of reactions."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    EXIT_CODES,
    CacheFolder,
    ExperimentFile,
    Jobs,
    command_line,
    counter,
    talk,
)
from fatigue_planner.errors import ExitCode, MissingReactionsError
from fatigue_planner.executors.processes import LocalProcesses
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import reaction_requests
from fatigue_planner.reactions.audit import Audit, audit
from fatigue_planner.reactions.bundle import export_bundle, import_bundle
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.housekeeping import Contents, contents, useless
from fatigue_planner.reactions.why import Difference, Miss, explain
from fatigue_planner.reports.html.words import counted

app = typer.Typer(help="Look after the cache of reactions.", no_args_is_help=True)

LONGEST_VALUE = 40
BundleFile = Annotated[Path, typer.Argument(metavar="BUNDLE", help="The file with the reactions (ZIP).")]


@app.command("list", epilog=EXIT_CODES)
def list_(cache: CacheFolder = DEFAULT_CACHE) -> None:
    """List the stored reactions: name, size, and whether this version of fatplan can find them."""
    found = _contents(ReactionCache(cache))
    for one in (*found.current, *found.other):
        use = "" if one.key.is_current else "  made by other sources or libraries"
        typer.echo(f"  {one.name!s:<40} {one.path.stat().st_size / 1e6:6.1f} MB  {one.path.name}{use}")
    for _, reason in (*found.unreadable, *found.damaged):
        typer.echo(f"  {reason}")
    size = sum(path.stat().st_size for path in ReactionCache(cache).files()) / 1e6
    typer.echo(
        f"{cache}: {counted(len(found.current), 'reaction')}, {len(found.other) + len(found.unreadable)} of other "
        f"versions, {len(found.damaged)} damaged; {size:.1f} MB."
    )


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
        raise MissingReactionsError(f"{cache}: no reaction there. Run `fatplan simulate` first.")
    audits: dict[int, Audit] = {}
    with counter(talk()) as bar:
        task = bar.add_task("Checking reactions", total=len(files))
        for place, result in LocalProcesses(jobs).run(audit, files):
            audits[place] = result if isinstance(result, Audit) else Audit(files[place], "failed", reason=result.reason)
            bar.advance(task)
    for place in range(len(files)):
        typer.echo(f"  {_verdict(audits[place])}")
    counts = Counter(result.verdict for result in audits.values() if not result.damaged)
    n_damaged = sum(result.damaged for result in audits.values())
    typer.echo(
        f"{cache}: {counted(len(files), 'reaction')}: {counts['ok']} ok, {counts['degraded']} degraded, "
        f"{counts['failed']} failed, {n_damaged} damaged, {counts[None]} of other versions, not checked."
    )
    if n_damaged or counts["failed"]:
        typer.echo("`fatplan simulate` sets damaged files aside and simulates again what its experiment needs.")
        raise typer.Exit(ExitCode.DAMAGED_STORE if n_damaged else ExitCode.FAILED_PARTS)


@app.command(epilog=EXIT_CODES)
def why(experiment: ExperimentFile = DEFAULT_EXPERIMENT, cache: CacheFolder = DEFAULT_CACHE) -> None:
    """Say which reactions of an EXPERIMENT are not in the cache, and what has changed since there were such.

    Each is compared with the nearest stored one: settings by their path, the files of fatplan that produce motions,
    and the versions of numerical libraries, solvers included.
    """
    requests = reaction_requests(load_experiment(experiment))
    found = _contents(ReactionCache(cache))
    there = {one.key.digest for one in found.current}
    misses = [explain(one, (*found.current, *found.other)) for one in requests if one.digest not in there]
    for miss in misses:
        for line in _reasons(miss):
            typer.echo(line)
    for _, reason in found.damaged:
        typer.echo(f"Damaged, and so not found: {reason}")
    rest = f" `{command_line('simulate', experiment, cache)}` simulates the others." if misses else ""
    typer.echo(f"{cache}: {len(requests) - len(misses)} of {counted(len(requests), 'reaction')} are there.{rest}")


@app.command(epilog=EXIT_CODES)
def gc(
    cache: CacheFolder = DEFAULT_CACHE,
    delete: Annotated[bool, typer.Option("--delete", help="Delete them; without it they are only listed.")] = False,
) -> None:
    """List what no run of this version will ever read again, or delete it.

    That is: reactions made by other versions of fatplan or of the numerical libraries, files set aside as damaged, and
    what killed runs have left behind. A reaction that this version can find is never deleted.
    """
    store = ReactionCache(cache)
    files = useless(store, _contents(store))
    for one in files:
        typer.echo(f"  {one.path.name}: {one.reason} ({one.size_bytes / 1e6:.1f} MB)")
        if delete:
            one.path.unlink(missing_ok=True)
    size = sum(one.size_bytes for one in files) / 1e6
    done = "deleted" if delete else "can go; `fatplan cache gc --delete` deletes them" if files else "can go"
    typer.echo(f"{cache}: {counted(len(files), 'file')} of {size:.1f} MB {done}.")


@app.command(epilog=EXIT_CODES)
def export(
    experiment: ExperimentFile,
    bundle: BundleFile,
    cache: CacheFolder = DEFAULT_CACHE,
) -> None:
    """Put the reactions of an EXPERIMENT into one file, for another machine with the same versions."""
    requests = reaction_requests(load_experiment(experiment))
    paths = ReactionCache(cache).paths(requests, command_line("simulate", experiment, cache))
    export_bundle(paths, bundle)
    typer.echo(f"{bundle}: {counted(len(paths), 'reaction')}, {bundle.stat().st_size / 1e6:.1f} MB.")


@app.command("import", epilog=EXIT_CODES)
def import_(bundle: BundleFile, cache: CacheFolder = DEFAULT_CACHE) -> None:
    """Take the reactions of a file made by `fatplan cache export` into the cache.

    Nothing in the file is believed: every reaction is checked as if it had just been simulated, and refused if it could
    not have been. Exit code 3 if some are refused.
    """
    refused, new, known = 0, 0, 0
    with counter(talk()) as bar:
        task = bar.add_task("Checking reactions", total=None)
        for one in import_bundle(bundle, ReactionCache(cache)):
            bar.advance(task)
            refused, new, known = refused + bool(one.refused), new + one.new, known + (not one.refused and not one.new)
            typer.echo(f"  REFUSED {one.refused}" if one.refused else f"  {one.path}{'' if one.new else ': was there'}")
    typer.echo(f"{cache}: {new} taken, {known} there already, {refused} refused.")
    if refused:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _contents(store: ReactionCache) -> Contents:
    with counter(talk()) as bar:
        task = bar.add_task("Reading the cache", total=len(store.files()))
        return contents(store, lambda: bar.advance(task))


def _verdict(result: Audit) -> str:
    if result.verdict is None:
        return f"not checked: {result.reason}"
    name = result.path.name if result.name is None else str(result.name)
    reason = f": {result.reason}" if result.reason else ""
    return f"{name:<40} {'DAMAGED' if result.damaged else result.verdict}{reason}"


def _reasons(miss: Miss) -> list[str]:
    if miss.nearest is None:
        return [f"  {miss.name}: nothing like it was ever stored here"]
    file = miss.nearest.path.name
    other = (
        "" if miss.nearest.name == miss.name else f"there is none of this name; the nearest is {miss.nearest.name}; "
    )
    return [f"  {miss.name}: {other}{file} was made for", *(f"    {_difference(one)}" for one in miss.differences)]


def _difference(one: Difference) -> str:
    if one.part.startswith("source "):
        change = "is new" if one.stored is None else "is gone" if one.wanted is None else "has changed"
        return f"other code: {one.part} {change}"
    return f"{one.part}: {_shown(one.stored)}, now it is {_shown(one.wanted)}"


def _shown(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}…"

"""`fatplan cache`: the folder of reactions."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.cli.json_output import (
    CacheCheck,
    CacheContents,
    CacheMisses,
    CacheRubbish,
    CheckedReaction,
    ExportedArchive,
    ImportedArchive,
    ImportedReaction,
    KeyDifference,
    MissingReaction,
    StoredReaction,
    UnreadableFile,
    UselessFile,
)
from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    EXIT_CODES,
    CacheFolder,
    ExperimentFile,
    Jobs,
    command_line,
)
from fatigue_planner.cli.output import Json, present
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.errors import ExitCode, MissingReactionsError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.text import counted
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.reactions.archive import export_archive, import_archive
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.cache_miss import Miss, explain
from fatigue_planner.reactions.housekeeping import Contents, contents, useless
from fatigue_planner.reactions.verify import Verification, verify_entry

app = typer.Typer(help="Look after the cache of reactions.", no_args_is_help=True)

MAX_VALUE_LENGTH = 40
BundleFile = Annotated[Path, typer.Argument(metavar="BUNDLE", help="The file with the reactions (ZIP).")]


@app.command("list", epilog=EXIT_CODES)
def list_(cache: CacheFolder = DEFAULT_CACHE, as_json: Json = False) -> None:
    """List the stored reactions: name, size, and whether this version of fatplan can find them."""
    found = _contents(ReactionCache(cache))
    reactions = [
        StoredReaction(str(one.name), one.key.digest, one.path.name, one.path.stat().st_size, one.key.is_current)
        for one in (*found.current, *found.other)
    ]
    unreadable = [UnreadableFile(path.name, damaged, reason)
                  for damaged, files in ((False, found.unreadable), (True, found.damaged))
                  for path, reason in files]  # fmt: skip
    size = sum(path.stat().st_size for path in ReactionCache(cache).files())
    document = CacheContents(cache, reactions, unreadable, size)
    present(document, _contents_text(document), as_json)


@app.command(epilog=EXIT_CODES)
def verify(cache: CacheFolder = DEFAULT_CACHE, jobs: Jobs = ALL_CORES, as_json: Json = False) -> None:
    """Check every stored reaction again: its hash, and every invariant of its motion.

    The invariants (equation of motion, friction, centre of pressure, limits, feet, hands, balance,
    power) are recomputed from the stored motion and compared with what was stored of them. Nothing is
    changed; `fatplan simulate` mends what its experiment needs. Exit code 4 if a file is damaged, 3 if
    a motion does not keep its bars.
    """
    files = ReactionCache(cache).files()
    if not files:
        raise MissingReactionsError(f"{cache}: no reaction there. Run `fatplan simulate` first.")
    checked: dict[int, CheckedReaction] = {}
    with progress("Checking reactions", len(files)) as counter:
        for place, result in LocalProcesses(jobs).run(verify_entry, files):
            one = (
                result
                if isinstance(result, Verification)
                else Verification(files[place], "failed", reason=result.reason)
            )
            name = None if one.name is None else str(one.name)
            verdict = "damaged" if one.damaged else one.verdict or "other version"
            checked[place] = CheckedReaction(one.path.name, name, verdict, one.reason)
            counter.advance()
    counts = Counter(one.verdict for one in checked.values())
    document = CacheCheck(cache, counts, [checked[place] for place in range(len(files))])
    present(document, _check_text(document), as_json)
    if counts["damaged"] or counts["failed"]:
        raise typer.Exit(ExitCode.DAMAGED_STORE if counts["damaged"] else ExitCode.FAILED_PARTS)


@app.command(epilog=EXIT_CODES)
def why(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT, cache: CacheFolder = DEFAULT_CACHE, as_json: Json = False
) -> None:
    """Say which reactions of an EXPERIMENT are not in the cache, and what has changed since there were such.

    Each is compared with the nearest stored one: settings by their path, the files of fatplan that produce motions,
    and the versions of numerical libraries, solvers included.
    """
    requests = reaction_requests(load_experiment(experiment))
    found = _contents(ReactionCache(cache))
    there = {one.key.digest for one in found.current}
    misses = [explain(one, (*found.current, *found.other)) for one in requests if one.digest not in there]
    document = CacheMisses(
        folder=cache,
        wanted=len(requests),
        found=len(requests) - len(misses),
        missing=[_missing(miss) for miss in misses],
        damaged=[reason for _, reason in found.damaged],
    )
    present(document, _misses_text(document, command_line("simulate", experiment, cache)), as_json)


@app.command(epilog=EXIT_CODES)
def gc(
    cache: CacheFolder = DEFAULT_CACHE,
    delete: Annotated[bool, typer.Option("--delete", help="Delete them; without it they are only listed.")] = False,
    as_json: Json = False,
) -> None:
    """List what no run of this version will ever read again, or delete it.

    That is: reactions made by other versions of fatplan or of the numerical libraries, files set aside as damaged, and
    what killed runs have left behind. A reaction that this version can find is never deleted.
    """
    store = ReactionCache(cache)
    files = useless(store, _contents(store))
    if delete:
        for one in files:
            one.path.unlink(missing_ok=True)
    listed = [UselessFile(one.path.name, one.reason, one.size_bytes) for one in files]
    lines = [f"  {one.file}: {one.reason} ({_megabytes(one.size_bytes)})" for one in listed]
    done = "deleted" if delete else "can go; `fatplan cache gc --delete` deletes them" if files else "can go"
    size = _megabytes(sum(one.size_bytes for one in listed))
    text = "\n".join([*lines, f"{cache}: {counted(len(listed), 'file')} of {size} {done}."])
    present(CacheRubbish(cache, listed, delete), text, as_json)


@app.command(epilog=EXIT_CODES)
def export(
    experiment: ExperimentFile, bundle: BundleFile, cache: CacheFolder = DEFAULT_CACHE, as_json: Json = False
) -> None:
    """Put the reactions of an EXPERIMENT into one file, for another machine with the same versions."""
    requests = reaction_requests(load_experiment(experiment))
    n = export_archive(ReactionCache(cache), requests, bundle, command_line("simulate", experiment, cache))
    document = ExportedArchive(bundle, n, bundle.stat().st_size)
    present(document, f"{bundle}: {counted(n, 'reaction')}, {_megabytes(document.size_bytes)}.", as_json)


@app.command("import", epilog=EXIT_CODES)
def import_(bundle: BundleFile, cache: CacheFolder = DEFAULT_CACHE, as_json: Json = False) -> None:
    """Take the reactions of a file made by `fatplan cache export` into the cache.

    Nothing in the file is believed: every reaction is checked as if it had just been simulated, and refused if it could
    not have been. Exit code 3 if some are refused.
    """
    store = ReactionCache(cache)
    found = [ImportedReaction(one.member, one.path, one.new, one.refused) for one in import_archive(bundle, store)]
    warn(store.damaged)
    taken, refused = sum(one.new for one in found), sum(bool(one.refused) for one in found)
    lines = [
        f"  REFUSED {one.refused}" if one.refused else f"  {one.path}{'' if one.new else ': was there'}"
        for one in found
    ]
    summary = f"{cache}: {taken} taken, {len(found) - taken - refused} there already, {refused} refused."
    present(ImportedArchive(cache, found, taken, refused), "\n".join([*lines, summary]), as_json)
    if refused:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _contents(store: ReactionCache) -> Contents:
    with progress("Reading the cache", len(store.files())) as counter:
        return contents(store, counter.advance)


def _contents_text(found: CacheContents) -> str:
    lines = [
        f"  {one.name:<40} {_megabytes(one.size_bytes):>10}  {one.file}"
        f"{'' if one.current else '  made by other sources or libraries'}"
        for one in found.reactions
    ]
    lines += [f"  {one.reason}" for one in found.unreadable]
    current, damaged = sum(one.current for one in found.reactions), sum(one.damaged for one in found.unreadable)
    others = len(found.reactions) + len(found.unreadable) - current - damaged
    summary = (
        f"{found.folder}: {counted(current, 'reaction')}, {others} of other versions, {damaged} damaged; "
        f"{_megabytes(found.size_bytes)}."
    )
    return "\n".join([*lines, summary])


def _check_text(check: CacheCheck) -> str:
    lines = [
        f"  {one.name or one.file:<40} {one.verdict.upper() if one.verdict == 'damaged' else one.verdict}"
        f"{f': {one.reason}' if one.reason else ''}"
        for one in check.reactions
    ]
    counts = check.counts
    lines.append(
        f"{check.folder}: {counted(len(check.reactions), 'reaction')}: {counts['ok']} ok, {counts['degraded']} "
        f"degraded, {counts['failed']} failed, {counts['damaged']} damaged, {counts['other version']} of other "
        "versions, not checked."
    )
    if counts["damaged"] or counts["failed"]:
        lines.append("`fatplan simulate` sets damaged files aside and simulates again what its experiment needs.")
    return "\n".join(lines)


def _missing(miss: Miss) -> MissingReaction:
    differences = [KeyDifference(one.part, one.wanted, one.stored) for one in miss.differences]
    nearest = miss.nearest
    if nearest is None:
        return MissingReaction(str(miss.name), None, None, differences)
    return MissingReaction(str(miss.name), nearest.path.name, str(nearest.name), differences)


def _misses_text(misses: CacheMisses, simulate: str) -> str:
    lines = [line for one in misses.missing for line in _reasons(one)]
    lines += [f"Damaged, and so not found: {reason}" for reason in misses.damaged]
    rest = f" `{simulate}` simulates the others." if misses.missing else ""
    summary = f"{misses.folder}: {misses.found} of {counted(misses.wanted, 'reaction')} are there.{rest}"
    return "\n".join([*lines, summary])


def _reasons(miss: MissingReaction) -> list[str]:
    if miss.nearest is None:
        return [f"  {miss.name}: nothing like it was ever stored here"]
    other = "" if miss.nearest_name == miss.name else f"none of this name; the nearest is {miss.nearest_name}; "
    return [f"  {miss.name}: {other}{miss.nearest} was made for", *(f"    {_part(one)}" for one in miss.differences)]


def _part(one: KeyDifference) -> str:
    if one.part.startswith("source "):
        change = "is new" if one.stored is None else "is gone" if one.wanted is None else "has changed"
        return f"other code: {one.part} {change}"
    return f"{one.part}: {_shown(one.stored)}, now it is {_shown(one.wanted)}"


def _shown(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= MAX_VALUE_LENGTH else f"{text[:MAX_VALUE_LENGTH]}…"


def _megabytes(size_bytes: int) -> str:
    return f"{size_bytes / 1e6:.1f} MB"

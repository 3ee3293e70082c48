"""`fatplan cache`: what to do with the folder of reactions."""

import json
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.errors import ExitCode, MissingReactionsError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.contents import Contents, Difference, Miss

app = typer.Typer(name="cache", help="List, check, explain, clean and move stored reactions.", no_args_is_help=True)

MAX_VALUE_LENGTH = 40
BundleFile = Annotated[Path, typer.Argument(metavar="BUNDLE", help="The file with the reactions (ZIP).")]


@app.command("list", epilog=options.EXIT_CODES)
def list_(cache: options.CacheFolder = options.DEFAULT_CACHE, as_json: options.Json = False) -> None:
    """List the stored reactions: name, size, and whether this version of fatplan can find them."""
    from fatigue_planner.reactions.cache import ReactionCache

    store = ReactionCache(cache)
    found = _contents(store)
    reactions: list[dict[str, Any]] = [
        {
            "name": str(stored.name),
            "digest": stored.key.digest,
            "file": stored.path.name,
            "size_bytes": stored.path.stat().st_size,
            "current": stored.key.is_current,
        }
        for stored in (*found.current, *found.other)
    ]
    unreadable = [
        {"file": path.name, "damaged": damaged, "reason": reason}
        for damaged, files in ((False, found.unreadable), (True, found.damaged))
        for path, reason in files
    ]
    size_bytes = sum(path.stat().st_size for path in store.files())
    lines = [
        f"  {reaction['name']:<40} {_megabytes(reaction['size_bytes']):>10}  {reaction['file']}"
        f"{'' if reaction['current'] else '  made by other sources or libraries'}"
        for reaction in reactions
    ]
    lines += [f"  {file['reason']}" for file in unreadable]
    lines.append(
        f"{cache}: {counted(len(found.current), 'reaction')}, {len(found.other) + len(found.unreadable)} of other "
        f"versions, {len(found.damaged)} damaged; {_megabytes(size_bytes)}."
    )
    document = {"folder": cache, "reactions": reactions, "unreadable": unreadable, "size_bytes": size_bytes}
    options.present(document, "\n".join(lines), as_json)


@app.command(epilog=options.EXIT_CODES)
def verify(
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    jobs: options.Jobs = options.ALL_CORES,
    as_json: options.Json = False,
) -> None:
    """Check every stored reaction again: its hash and every invariant of its motion.

    The invariants (equation of motion, friction, centre of pressure, limits, feet, hands, balance,
    power) are recomputed from the stored motion and compared with what was stored of them. Nothing is
    changed; `fatplan simulate` replaces what its experiment needs. Exit code 4 if a file is damaged, 3 if
    a motion violates an invariant.
    """
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.verify import Verification, verify_entry

    files = ReactionCache(cache).files()
    if not files:
        raise MissingReactionsError(f"{cache}: no reaction there. Run `fatplan simulate` first.")
    checked: dict[int, dict[str, Any]] = {}
    with progress("Checking reactions", len(files)) as counter:
        for index, result in LocalProcesses(jobs).run(verify_entry, files):
            done = (
                result
                if isinstance(result, Verification)
                else Verification(files[index], "failed", reason=result.reason)
            )
            checked[index] = {
                "file": done.path.name,
                "name": None if done.name is None else str(done.name),
                "verdict": "damaged" if done.damaged else done.verdict or "other version",
                "reason": done.reason,
            }
            counter.advance()
    reactions = [checked[index] for index in range(len(files))]
    counts = Counter(reaction["verdict"] for reaction in reactions)
    lines = [
        f"  {reaction['name'] or reaction['file']:<40} "
        f"{'DAMAGED' if reaction['verdict'] == 'damaged' else reaction['verdict']}"
        + (f": {reaction['reason']}" if reaction["reason"] else "")
        for reaction in reactions
    ]
    lines.append(
        f"{cache}: {counted(len(files), 'reaction')}: {counts['ok']} ok, {counts['degraded']} degraded, "
        f"{counts['failed']} failed, {counts['damaged']} damaged, {counts['other version']} of other versions, not "
        "checked."
    )
    if counts["damaged"] or counts["failed"]:
        lines.append("`fatplan simulate` sets damaged files aside and simulates again what its experiment needs.")
    options.present({"folder": cache, "counts": counts, "reactions": reactions}, "\n".join(lines), as_json)
    if counts["damaged"] or counts["failed"]:
        raise typer.Exit(ExitCode.DAMAGED_STORE if counts["damaged"] else ExitCode.FAILED_PARTS)


@app.command(epilog=options.EXIT_CODES)
def why(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Say which reactions of an EXPERIMENT are not in the cache, and what has changed since they were.

    Each is compared with the nearest stored one: settings by their path, the files of fatplan that produce motions,
    and the versions of numerical libraries, solvers included.
    """
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.contents import explain

    requests = reaction_requests(load_experiment(experiment))
    stored = _contents(ReactionCache(cache))
    there = {reaction.key.digest for reaction in stored.current}
    misses = [explain(request, (*stored.current, *stored.other)) for request in requests if request.digest not in there]
    found, damaged = len(requests) - len(misses), [reason for _, reason in stored.damaged]
    document = {
        "folder": cache,
        "wanted": len(requests),
        "found": found,
        "missing": [
            {
                "name": str(miss.name),
                "nearest": miss.nearest and miss.nearest.path.name,
                "nearest_name": miss.nearest and str(miss.nearest.name),
                "differences": miss.differences,
            }
            for miss in misses
        ],
        "damaged": damaged,
    }
    lines = [line for miss in misses for line in _reasons(miss)]
    lines += [f"Damaged, and so not found: {reason}" for reason in damaged]
    rest = f" `{options.command_line('simulate', experiment, cache)}` simulates the others." if misses else ""
    lines.append(f"{cache}: {found} of {counted(len(requests), 'reaction')} are there.{rest}")
    options.present(document, "\n".join(lines), as_json)


@app.command(epilog=options.EXIT_CODES)
def gc(
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    delete: Annotated[bool, typer.Option("--delete", help="Delete them; without it they are only listed.")] = False,
    as_json: options.Json = False,
) -> None:
    """List the files that no run of this version will ever read again, or delete them.

    These are reactions made by other versions of fatplan or of the numerical libraries, files set aside as damaged, and
    what killed runs have left behind. A reaction that this version can find is never deleted.
    """
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.contents import useless

    store = ReactionCache(cache)
    files = useless(store, _contents(store))
    if delete:
        for file in files:
            file.path.unlink(missing_ok=True)
    lines = [f"  {file.path.name}: {file.reason} ({_megabytes(file.size_bytes)})" for file in files]
    done = "deleted" if delete else "can go; `fatplan cache gc --delete` deletes them" if files else "can go"
    size = _megabytes(sum(file.size_bytes for file in files))
    lines.append(f"{cache}: {counted(len(files), 'file')} of {size} {done}.")
    listed = [{"file": file.path.name, "reason": file.reason, "size_bytes": file.size_bytes} for file in files]
    options.present({"folder": cache, "files": listed, "deleted": delete}, "\n".join(lines), as_json)


@app.command(epilog=options.EXIT_CODES)
def export(
    experiment: options.ExperimentFile,
    bundle: BundleFile,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Put the reactions of an EXPERIMENT into one file, for another machine with the same versions."""
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.reactions.archive import export_archive
    from fatigue_planner.reactions.cache import ReactionCache

    requests = reaction_requests(load_experiment(experiment))
    n = export_archive(ReactionCache(cache), requests, bundle, options.command_line("simulate", experiment, cache))
    size_bytes = bundle.stat().st_size
    document = {"file": bundle, "reactions": n, "size_bytes": size_bytes}
    options.present(document, f"{bundle}: {counted(n, 'reaction')}, {_megabytes(size_bytes)}.", as_json)


@app.command("import", epilog=options.EXIT_CODES)
def import_(
    bundle: BundleFile, cache: options.CacheFolder = options.DEFAULT_CACHE, as_json: options.Json = False
) -> None:
    """Take the reactions of a file made by `fatplan cache export` into the cache.

    Nothing in the file is trusted: every reaction is checked as if it had just been simulated, and refused if it fails.
    Exit code 3 if some are refused.
    """
    from fatigue_planner.reactions.archive import import_archive
    from fatigue_planner.reactions.cache import ReactionCache

    store = ReactionCache(cache)
    reactions = list(import_archive(bundle, store))
    warn(store.damaged)
    taken = sum(reaction.new for reaction in reactions)
    refused = sum(bool(reaction.refused) for reaction in reactions)
    lines = [
        f"  REFUSED {reaction.refused}"
        if reaction.refused
        else f"  {reaction.path}{'' if reaction.new else ': was there'}"
        for reaction in reactions
    ]
    lines.append(f"{cache}: {taken} taken, {len(reactions) - taken - refused} there already, {refused} refused.")
    document = {"folder": cache, "reactions": reactions, "taken": taken, "refused": refused}
    options.present(document, "\n".join(lines), as_json)
    if refused:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _contents(store: "ReactionCache") -> "Contents":
    from fatigue_planner.reactions.contents import contents

    with progress("Reading the cache", len(store.files())) as counter:
        return contents(store, counter.advance)


def _reasons(miss: "Miss") -> list[str]:
    if miss.nearest is None:
        return [f"  {miss.name}: nothing like it was ever stored here"]
    nearest = miss.nearest
    other = "" if nearest.name == miss.name else f"none of this name; the nearest is {nearest.name}; "
    return [f"  {miss.name}: {other}{nearest.path.name} was made for", *map(_difference_text, miss.differences)]


def _difference_text(difference: "Difference") -> str:
    if difference.part.startswith("source "):
        change = "is new" if difference.stored is None else "is gone" if difference.wanted is None else "has changed"
        return f"    other code: {difference.part} {change}"
    return f"    {difference.part}: {_shown(difference.stored)}, now it is {_shown(difference.wanted)}"


def _shown(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= MAX_VALUE_LENGTH else f"{text[:MAX_VALUE_LENGTH]}…"


def _megabytes(size_bytes: int) -> str:
    return f"{size_bytes / 1e6:.1f} MB"

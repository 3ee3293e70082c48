"""The folder of reaction libraries: find what is there, simulate what is missing.

A finished library is `<experiment>-<digest>.h5`; what an unfinished run has simulated so far waits in
`partial/`, one library of one reaction each, and is taken from there by the next run. No motion is
held in memory longer than it takes to check and copy it, however large the library.
"""

import re
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fatigue_planner.errors import DamagedFileError, FailedMotionError, MissingLibraryError, OtherVersionError
from fatigue_planner.executors.executor import Executor, Lost
from fatigue_planner.files import DIGEST_LENGTH, set_aside, writable_folder
from fatigue_planner.motion.quality import Quality, Verdict
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure
from fatigue_planner.reactions.library import (
    Source,
    assemble_library,
    library_digest,
    names_in,
    read_reaction,
    write_reaction,
)
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest

PARTIAL = "partial"
# Ours are <experiment>-<digest>.h5 and partial/<digest>.h5; other files in the folder are left alone.
_LIBRARY_NAME = re.compile(rf"([A-Za-z][\w.-]*-)?[0-9a-f]{{{DIGEST_LENGTH}}}\.h5")


@dataclass(frozen=True)
class Outcome:
    """What became of one request: the verdict on it, whether it was found, and why it failed if it did."""

    name: ReactionName
    digest: str
    verdict: Verdict
    found: bool
    quality: Quality | None = None
    failure: str = ""


class ReactionCache:
    """The libraries in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[str] = []

    def path(self, experiment: str, requests: Sequence[ReactionRequest]) -> Path:
        """Where the library of these requests is, under whatever name, or where it would be published."""
        digest = library_digest([(request.name, request.digest) for request in requests])[:DIGEST_LENGTH]
        return next(iter(sorted(self.folder.glob(f"[!.]*-{digest}.h5"))), self.folder / f"{experiment}-{digest}.h5")

    def files(self) -> list[Path]:
        """All libraries of the folder, finished ones first."""
        finished, partial = (sorted(folder.glob("*.h5")) for folder in (self.folder, self.folder / PARTIAL))
        return [path for path in (*finished, *partial) if _LIBRARY_NAME.fullmatch(path.name)]

    def stream(
        self,
        experiment: str,
        requests: Sequence[ReactionRequest],
        how: str,
        chosen: Container[ReactionName] | None = None,
    ) -> Iterator[Reaction]:
        """The reactions of a finished library one by one, all or those chosen, in the order of the requests.

        `how` is the command that makes the library, for the message. Raises MissingLibraryError if
        there is none, DamagedFileError if it is not what was written or holds other reactions.
        """
        path = self.path(experiment, requests)
        if not path.exists():
            kept = [request for request in requests if self._partial(request.digest).exists()]
            if not kept:
                raise MissingLibraryError(f"{path}: no reactions for this experiment's settings. Run `{how}` first.")
            wanted = [request for request in requests if chosen is not None and request.name in chosen]
            if not wanted or not all(request in kept for request in wanted):
                raise MissingLibraryError(
                    f"{path}: only {len(kept)} of {len(requests)} reactions are there: "
                    f"{', '.join(str(request.name) for request in kept)}. `{how}` says why the others are not."
                )
            for request in wanted:
                (name,) = names_in(self._partial(request.digest))
                yield replace(read_reaction(self._partial(request.digest), name), name=request.name)
            return
        try:
            if not _holds(path, requests):
                raise DamagedFileError(f"{path}: holds other reactions than its name says.")
            for request in requests:
                if chosen is None or request.name in chosen:
                    reaction = read_reaction(path, request.name)
                    if reaction.settings != request.settings:
                        raise DamagedFileError(f"{path}: {request.name} has other settings than its digest says.")
                    yield reaction
        except DamagedFileError as error:
            raise DamagedFileError(f"{error} Run `{how}`: it sets the file aside and simulates again.") from error

    def load(self, experiment: str, requests: Sequence[ReactionRequest], how: str) -> tuple[Reaction, ...]:
        """All reactions of a finished library at once; see `stream`."""
        return tuple(self.stream(experiment, requests, how))

    def complete(
        self,
        experiment: str,
        requests: Sequence[ReactionRequest],
        executor: Executor,
        progress: Callable[[Outcome], None],
    ) -> tuple[Path, list[Outcome]]:
        """Find or simulate every request; publish the library if none failed.

        `progress` hears of every outcome as it comes. Damaged files are set aside (`damaged` lists
        the messages). Returns the library's path and the outcomes in the order of the requests.
        """
        path = self.path(experiment, requests)
        by_digest = {request.digest: request for request in requests}
        places, outcomes = self._find(path, set(by_digest))
        for outcome in outcomes.values():
            progress(outcome)
        missing = [(request, self._partial(digest)) for digest, request in by_digest.items() if digest not in outcomes]
        if missing:
            writable_folder(self.folder / PARTIAL)
        for place, done in executor.run(_simulate_and_keep, missing):
            request = missing[place][0]
            outcome = (
                Outcome(request.name, request.digest, "failed", False, failure=done.reason)
                if isinstance(done, Lost)
                else done
            )
            outcomes[outcome.digest] = outcome
            places[outcome.digest] = (self._partial(outcome.digest), by_digest[outcome.digest].name)
            progress(outcome)
        ordered = [replace(outcomes[request.digest], name=request.name) for request in requests]
        if all(outcome.verdict != "failed" for outcome in ordered):
            if not _holds(path, requests):
                try:
                    assemble_library(path, [Source(r.name, r.digest, *places[r.digest]) for r in requests])
                except FileNotFoundError:  # another run has published the same library and tidied up
                    if not _holds(path, requests):
                        raise
            for outcome in ordered:
                if self._partial(outcome.digest).exists():
                    self._partial(outcome.digest).unlink(missing_ok=True)
        return path, ordered

    def _partial(self, digest: str) -> Path:
        return self.folder / PARTIAL / f"{digest[:DIGEST_LENGTH]}.h5"

    def _find(self, first: Path, wanted: set[str]) -> tuple[dict[str, tuple[Path, ReactionName]], dict[str, Outcome]]:
        """Where the wanted reactions are, by digest, in all libraries; damaged libraries are set aside.

        `first` is read first, if it exists, so that it is checked even if others hold the same.
        """
        places: dict[str, tuple[Path, ReactionName]] = {}
        outcomes: dict[str, Outcome] = {}
        for path in sorted(self.files(), key=lambda path: path != first):
            try:
                here = {digest: name for name, digest in names_in(path).items() if digest in wanted - places.keys()}
                found = {digest: _found(read_reaction(path, name)) for digest, name in here.items()}
            except OtherVersionError:
                continue
            except DamagedFileError as error:
                if not path.exists():
                    continue  # another run has just taken it
                aside = set_aside(path)
                self.damaged.append(f"{error} It is set aside as {aside.name}; what it held is simulated again.")
                continue
            places |= {digest: (path, name) for digest, name in here.items()}
            outcomes |= found
        return places, outcomes


def _holds(path: Path, requests: Sequence[ReactionRequest]) -> bool:
    """Whether a library is there and names just these reactions."""
    return path.exists() and names_in(path) == {request.name: request.digest for request in requests}


def _found(reaction: Reaction) -> Outcome:
    return Outcome(reaction.name, reaction.digest, reaction.quality.kept_as(), True, reaction.quality)


def _lost(request: ReactionRequest, lost: Lost) -> Outcome:
    return Outcome(request.name, request.digest, "failed", False, failure=lost.reason)


def _simulate_and_keep(work: tuple[ReactionRequest, Path]) -> Outcome:
    """Simulate a reaction, check it and, if it is good, publish it at once, whatever becomes of the parent process."""
    request, path = work
    try:
        motion = simulate(request.motion)
    except FailedMotionError as error:
        return Outcome(request.name, request.digest, "failed", False, failure=str(error))
    quality = measure(request.motion, motion)
    faults = quality.faults(request.accuracy)
    if faults:
        return Outcome(request.name, request.digest, "failed", False, quality, "; ".join(faults))
    write_reaction(path, Reaction(request.name, request.digest, request.settings, motion, quality))
    return Outcome(request.name, request.digest, quality.kept_as(), False, quality)

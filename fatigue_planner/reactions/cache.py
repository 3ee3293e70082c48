"""The folder of reaction libraries: find what is there, simulate what is missing.

A finished library is `<experiment>-<digest>.h5`; what an unfinished run has simulated so far waits in
`partial/`, one library of one reaction each, and is taken from there by the next run.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fatigue_planner.errors import DamagedFileError, FailedMotionError, MissingLibraryError
from fatigue_planner.files import DIGEST_LENGTH, set_aside, writable_folder
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure
from fatigue_planner.parallel import run_parallel
from fatigue_planner.reactions.library import library_digest, read_library, write_library
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest

PARTIAL = "partial"
# Ours are <experiment>-<digest>.h5 and partial/<digest>.h5; other files in the folder are left alone.
_LIBRARY_NAME = re.compile(rf"([A-Za-z][\w.-]*-)?[0-9a-f]{{{DIGEST_LENGTH}}}\.h5")


@dataclass(frozen=True)
class Outcome:
    """What became of one request: found, simulated, or failed with a reason."""

    name: ReactionName
    digest: str
    reaction: Reaction | None
    found: bool
    failure: str = ""


class ReactionCache:
    """The libraries in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[str] = []

    def path(self, experiment: str, requests: Sequence[ReactionRequest]) -> Path:
        """Where the library of these requests is, under whatever name, or where it would be published."""
        digest = library_digest([(request.name, request.digest()) for request in requests])[:DIGEST_LENGTH]
        return next(iter(sorted(self.folder.glob(f"[!.]*-{digest}.h5"))), self.folder / f"{experiment}-{digest}.h5")

    def load(self, experiment: str, requests: Sequence[ReactionRequest], how: str) -> tuple[Reaction, ...]:
        """The reactions of a finished library, in the order of the requests.

        `how` is the command that makes the library, for the message. Raises MissingLibraryError if
        there is none, DamagedFileError if it is not what was written or holds other reactions.
        """
        path = self.path(experiment, requests)
        if not path.exists():
            raise MissingLibraryError(f"{path}: no reactions for this experiment's settings. Run `{how}` first.")
        try:
            by_name = {reaction.name: reaction for reaction in read_library(path)}
            reactions = tuple(by_name[request.name] for request in requests)
        except DamagedFileError as error:
            raise DamagedFileError(f"{error} Run `{how}`: it sets the file aside and simulates again.") from error
        except KeyError as error:
            missing = ", ".join(str(r.name) for r in requests if r.name not in by_name)
            raise DamagedFileError(f"{path}: holds no reaction {missing}. Run `{how}`.") from error
        for request, reaction in zip(requests, reactions, strict=True):
            if request.digest() != reaction.digest:
                raise DamagedFileError(f"{path}: {reaction.name} was made with other settings. Run `{how}`.")
        return reactions

    def complete(
        self, experiment: str, requests: Sequence[ReactionRequest], jobs: int, progress: Callable[[Outcome], None]
    ) -> tuple[Path, list[Outcome]]:
        """Find or simulate every request; publish the library if none failed.

        `progress` hears of every outcome as it comes. Damaged files are set aside (`damaged` lists
        the messages). Returns the library's path and the outcomes in the order of the requests.
        """
        writable_folder(self.folder / PARTIAL)
        path = self.path(experiment, requests)
        found = self._find(path, {request.digest() for request in requests})
        outcomes: dict[str, Outcome] = {}
        missing = []
        for request in requests:
            digest = request.digest()
            if digest in found:
                outcomes[str(request.name)] = Outcome(request.name, digest, found[digest], found=True)
                progress(outcomes[str(request.name)])
            else:
                missing.append((request, self._partial(digest)))
        for _, outcome in run_parallel(_simulate_and_keep, missing, jobs):
            outcomes[str(outcome.name)] = outcome
            progress(outcome)
        ordered = [outcomes[str(request.name)] for request in requests]
        reactions = [replace(o.reaction, name=o.name) for o in ordered if o.reaction is not None]
        if len(reactions) == len(requests):
            if not self._holds(path, {outcome.digest for outcome in ordered}):
                write_library(path, reactions)
            for outcome in ordered:
                self._partial(outcome.digest).unlink(missing_ok=True)
        return path, ordered

    def _holds(self, path: Path, digests: set[str]) -> bool:
        """Whether a library is there and complete."""
        return path.exists() and {reaction.digest for reaction in read_library(path, digests)} == digests

    def _partial(self, digest: str) -> Path:
        return self.folder / PARTIAL / f"{digest[:DIGEST_LENGTH]}.h5"

    def _find(self, first: Path, wanted: set[str]) -> dict[str, Reaction]:
        """The wanted reactions, by digest, from all libraries; damaged ones are set aside.

        `first` is read first, if it exists, so that it is checked even if others hold the same.
        """
        found: dict[str, Reaction] = {}
        files = [path for pattern in ("*.h5", f"{PARTIAL}/*.h5") for path in self.folder.glob(pattern)]
        for path in sorted(files, key=lambda path: (path != first, str(path))):
            if not _LIBRARY_NAME.fullmatch(path.name):
                continue
            try:
                found |= {reaction.digest: reaction for reaction in read_library(path, wanted - found.keys())}
            except DamagedFileError as error:
                if not path.exists():
                    continue  # another run has just taken it
                aside = set_aside(path)
                self.damaged.append(f"{error} It is set aside as {aside.name}; what it held is simulated again.")
        return found


def _simulate_and_keep(work: tuple[ReactionRequest, Path]) -> Outcome:
    """Simulate a reaction and, if it is good, publish it at once, whatever becomes of the parent process."""
    request, path = work
    outcome = simulate_reaction(request)
    if outcome.reaction is not None:
        write_library(path, [outcome.reaction])
    return outcome


def simulate_reaction(request: ReactionRequest) -> Outcome:
    """Simulate one reaction and check it; an inaccurate motion is a failure."""
    digest = request.digest()
    try:
        motion = simulate(request.motion)
    except FailedMotionError as error:
        return Outcome(request.name, digest, None, found=False, failure=str(error))
    quality = measure(request.motion, motion)
    faults = quality.faults(request.accuracy)
    if faults:
        return Outcome(request.name, digest, None, found=False, failure="; ".join(faults))
    reaction = Reaction(request.name, digest, request.settings(), motion, quality)
    return Outcome(request.name, digest, reaction, found=False)

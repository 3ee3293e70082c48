"""The folder of reaction libraries: find what is there, simulate what is missing.

A finished library is `<experiment>-<digest>.h5`; what an unfinished run has simulated so far waits in
`partial/`, one library of one reaction each, and is taken from there by the next run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.errors import DamagedFileError, FailedMotionError, MissingLibraryError
from fatigue_planner.files import writable_folder
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure
from fatigue_planner.parallel import run_parallel
from fatigue_planner.reactions.library import library_digest, read_library, write_library
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest

DIGEST_LENGTH = 16  # hexadecimal digits of a digest in a file name


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
            raise DamagedFileError(f"{path}: holds no reaction {error}. Run `{how}`.") from error
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
        writable_folder(self.folder)
        known = self._find({request.digest() for request in requests})
        path = self.path(experiment, requests)
        outcomes: dict[str, Outcome] = {}
        missing = []
        for request in requests:
            digest = request.digest()
            if digest in known:
                outcomes[str(request.name)] = Outcome(request.name, digest, known[digest], found=True)
                progress(outcomes[str(request.name)])
            else:
                missing.append(request)
        for _, outcome in run_parallel(simulate_reaction, missing, jobs):
            outcomes[str(outcome.name)] = outcome
            if outcome.reaction is not None:
                write_library(self._partial(outcome.digest), [outcome.reaction])
            progress(outcome)
        ordered = [outcomes[str(request.name)] for request in requests]
        reactions = [outcome.reaction for outcome in ordered if outcome.reaction is not None]
        if len(reactions) == len(requests):
            if not path.exists():
                named = [
                    Reaction(o.name, o.digest, r.settings, r.motion, r.quality)
                    for o, r in zip(ordered, reactions, strict=True)
                ]
                write_library(path, named)
            for outcome in ordered:
                self._partial(outcome.digest).unlink(missing_ok=True)
        return path, ordered

    def _partial(self, digest: str) -> Path:
        return self.folder / "partial" / f"{digest[:DIGEST_LENGTH]}.h5"

    def _find(self, wanted: set[str]) -> dict[str, Reaction]:
        """The wanted reactions, by digest, from all libraries; damaged files are set aside."""
        found: dict[str, Reaction] = {}
        for path in sorted([*self.folder.glob("[!.]*.h5"), *self.folder.glob("partial/[!.]*.h5")]):
            try:
                found |= {reaction.digest: reaction for reaction in read_library(path, wanted - found.keys())}
            except DamagedFileError as error:
                aside = path.with_suffix(".damaged")
                path.replace(aside)
                self.damaged.append(f"{error} It is set aside as {aside.name}; what it held is simulated again.")
        return found


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

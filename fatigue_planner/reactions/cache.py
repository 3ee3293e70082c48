"""The folder of reactions: find what is there, simulate what is missing.

Every reaction has a file of its own, called after its digest (see `reaction.file_name`), which is found whatever
experiment it was made for. It is written by the process that asked for it, whole or not at all. Files of others are
left alone.
"""

import os
import re
import stat
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fatigue_planner.core.errors import (
    DamagedFileError,
    FailedMotionError,
    MissingReactionsError,
    OtherVersionError,
    listed,
)
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import DIGEST_LENGTH, publish_bytes, set_aside, writable_folder
from fatigue_planner.motion.quality import Quality, Verdict
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import MismatchError, check_shape, measure
from fatigue_planner.reactions.hdf5_layout import MAX_BYTES, entry_bytes, has_valid_checksum, read_entry
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest, file_name

_FILE_NAME = re.compile(rf"[^.].*-([0-9a-f]{{{DIGEST_LENGTH}}})\.h5")


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
    """The reactions in one folder.

    damaged: messages about files that were set aside; lost: about reactions whose simulation killed its workers.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[str] = []
        self.lost: list[str] = []

    def files(self) -> list[Path]:
        """All entries, in the order of their names."""
        found = (path for path in self.folder.glob("*.h5") if _FILE_NAME.fullmatch(path.name))
        return sorted(path for path in found if path.name.isprintable())

    def path(self, request: ReactionRequest) -> Path:
        """Where a reaction is published."""
        return self.folder / file_name(request.name, request.digest)

    def read(self, path: Path) -> Reaction:
        """The reaction in a file of the folder.

        Raises OtherVersionError for a file of another format, DamagedFileError if it is damaged or stands under the
        name of another one.
        """
        reaction = read_entry(read_content(path), str(path))
        if not path.stem.endswith(f"-{reaction.digest[:DIGEST_LENGTH]}"):
            raise DamagedFileError(
                f"{path}: holds another reaction than its name says, {file_name(reaction.name, reaction.digest)}."
            )
        return reaction

    def stream(
        self, requests: Sequence[ReactionRequest], how: str, chosen: Container[ReactionName] | None = None
    ) -> Iterator[Reaction]:
        """The reactions one by one, all or those chosen, in the order of the requests.

        `how` is the command that makes them, for the message. Raises MissingReactionsError if some are not there,
        before any is read; DamagedFileError for one that is not what was written.
        """
        wanted = [request for request in requests if chosen is None or request.name in chosen]
        for request, path in zip(wanted, self.paths(wanted, how), strict=True):
            try:
                reaction = self._read_for(request, path)
            except (DamagedFileError, OtherVersionError) as error:
                raise DamagedFileError(f"{error} Run `{how}`: it sets the file aside and simulates again.") from error
            yield replace(reaction, name=request.name)

    def paths(self, requests: Sequence[ReactionRequest], how: str) -> list[Path]:
        """Where these reactions are, by their names' digests. Raises MissingReactionsError as `stream`."""
        places = self._places()
        missing = [str(request.name) for request in requests if request.digest[:DIGEST_LENGTH] not in places]
        if missing:
            raise MissingReactionsError(
                f"{self.folder}: {len(missing)} of {len(requests)} reactions are not there: {listed(missing)}. Run "
                f"`{how}` first. If they were there once, `fatplan cache why EXPERIMENT` says what has changed."
            )
        return [places[request.digest[:DIGEST_LENGTH]][0] for request in requests]

    def load(self, requests: Sequence[ReactionRequest], how: str) -> tuple[Reaction, ...]:
        """All of these reactions at once; see `stream`."""
        return tuple(self.stream(requests, how))

    def complete(
        self, requests: Sequence[ReactionRequest], executor: Executor, progress: Callable[[Outcome], None]
    ) -> list[Outcome]:
        """Find or simulate every request; the outcomes in the order of the requests.

        `progress` hears of every outcome as it comes. Damaged files are set aside (see `damaged`), what they held is
        simulated again. Raises OutputFolderError if the folder cannot be written.
        """
        by_digest = {request.digest: request for request in requests}
        places = self._places()
        outcomes: dict[str, Outcome] = {}
        for digest, request in by_digest.items():
            reaction = self._find(places.get(digest[:DIGEST_LENGTH], []), request)
            if reaction is not None:
                quality = reaction.quality
                outcomes[digest] = Outcome(reaction.name, digest, quality.kept_as(), True, quality)
                progress(outcomes[digest])
        missing = [request for digest, request in by_digest.items() if digest not in outcomes]
        if missing:
            writable_folder(self.folder)
        for place, made in executor.run(simulated, missing):
            request = missing[place]
            if isinstance(made, Lost):
                self.lost.append(f"{request.name}: {made.reason}")
                made = Made(Outcome(request.name, request.digest, "failed", False, failure=made.reason))  # noqa: PLW2901
            elif made.content is not None:
                if not has_valid_checksum(made.content):
                    raise DamagedFileError(f"{request.name}: was damaged on its way from the worker. Run again.")
                publish_bytes(self.path(request), made.content)
            outcomes[request.digest] = made.outcome
            progress(made.outcome)
        return [replace(outcomes[request.digest], name=request.name) for request in requests]

    def _places(self) -> dict[str, list[Path]]:
        """Where reactions are, by the beginning of their digest; several names of one are possible."""
        places: dict[str, list[Path]] = {}
        for path in self.files():
            places.setdefault(path.stem[-DIGEST_LENGTH:], []).append(path)
        return places

    def _find(self, paths: Sequence[Path], request: ReactionRequest) -> Reaction | None:
        """The first whole reaction in some files; the others before it are set aside."""
        for path in paths:
            try:
                return self._read_for(request, path)
            except (DamagedFileError, OtherVersionError) as error:
                aside = set_aside(path)
                self.damaged.append(f"{error} It is set aside as {aside.name}; what it held is simulated again.")
        return None

    def _read_for(self, request: ReactionRequest, path: Path) -> Reaction:
        """As `read`, and the reaction is what was asked for, of the length its settings say."""
        reaction = self.read(path)
        if reaction.digest != request.digest:
            raise DamagedFileError(f"{path}: holds another reaction than its name says.")
        try:
            check_shape(request.motion, reaction.motion)
        except MismatchError as error:
            raise DamagedFileError(f"{path}: {error}.") from error
        return reaction


@dataclass(frozen=True)
class Made:
    """What a simulation leaves: its outcome and, if it is good, the content of its file."""

    outcome: Outcome
    content: bytes | None = None


def simulated(request: ReactionRequest) -> Made:
    """Simulate a reaction and check it."""
    try:
        motion = simulate(request.motion)
    except FailedMotionError as error:
        return Made(Outcome(request.name, request.digest, "failed", False, failure=str(error)))
    quality = measure(request.motion, motion)
    faults = quality.faults(request.accuracy)
    if faults:
        return Made(Outcome(request.name, request.digest, "failed", False, quality, "; ".join(faults)))
    outcome = Outcome(request.name, request.digest, quality.kept_as(), False, quality)
    return Made(outcome, entry_bytes(Reaction(request.name, request.key, motion, quality)))


def read_content(path: Path) -> bytes:
    """The bytes of a file that may be one of ours. Raises DamagedFileError if it cannot be."""
    try:
        # a pipe is opened, too, without waiting for somebody to write to it
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode):
                raise DamagedFileError(f"{path}: is not a file.")
            if status.st_size > MAX_BYTES:
                raise DamagedFileError(f"{path}: has {status.st_size} bytes; none of ours has more than {MAX_BYTES}.")
            with os.fdopen(descriptor, "rb", closefd=False) as file:
                return file.read(MAX_BYTES)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise DamagedFileError(f"{path}: cannot be read ({error.strerror}).") from error

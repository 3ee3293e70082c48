"""The folder of reactions: find what is there, simulate what is missing.

Every reaction has a file of its own, named after its digest (see `reaction.file_name`), which is found whatever
experiment it was made for. It is written by the process that asked for it, whole or not at all. Files of others are
left alone. A reaction that cannot be performed is a result like any other, and kept with its reason; whether a motion
is accurate enough is decided when it is read, by the accuracy of whoever asks.
"""

import os
import re
import stat
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np

from fatigue_planner.core.errors import (
    DamagedFileError,
    FailedMotionError,
    MissingReactionsError,
    OtherVersionError,
    listed,
)
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import DIGEST_LENGTH, publish_bytes, set_aside, writable_folder
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.causes import causes_of, on_target
from fatigue_planner.motion.motion import ROWS, Motion
from fatigue_planner.motion.plausibility import Finding
from fatigue_planner.motion.quality import Quality, Verdict
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import MismatchError, check_shape, measure
from fatigue_planner.reactions.hdf5_layout import MAX_BYTES, MAX_MAGNITUDE, entry_bytes, has_valid_checksum, read_entry
from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionName, ReactionRequest, file_name
from fatigue_planner.reactions.recorded import RecordedQuality

# What to do where a recorded reaction is missing.
REIMPORT = (
    "`fatplan record import` makes them from their files; it says another key where file, worker, cycle, action, tool "
    "or program have changed."
)
_FILE_NAME = re.compile(rf"[^.].*-([0-9a-f]{{{DIGEST_LENGTH}}})\.h5")


@dataclass(frozen=True)
class Outcome:
    """What became of one request: the verdict on it, and why it failed if it did.

    found: it was in the cache already; kept: it is there now, which it is unless its simulation itself broke off.
    quality: of the motion, None if there is none.
    """

    name: ReactionName
    digest: str
    verdict: Verdict
    found: bool
    quality: Quality | RecordedQuality | None = None
    failure: str = ""
    kept: bool = True

    @classmethod
    def of(
        cls,
        request: ReactionRequest,
        quality: Quality | RecordedQuality | None,
        failure: str,
        found: bool = False,
        kept: bool = True,
    ) -> Self:
        """The verdict on a motion of this quality by the accuracy of the request; without a motion it has failed."""
        verdict: Verdict = "failed"
        if quality is not None:
            verdict, failure = request.verdict(quality), "; ".join(request.faults(quality))
        return cls(request.name, request.digest, verdict, found, quality, failure, kept)

    @property
    def is_recorded(self) -> bool:
        """Whether it is the motion of a recording."""
        return isinstance(self.quality, RecordedQuality)

    @property
    def findings(self) -> list[Finding]:
        """What no person would do, of a simulated motion."""
        return self.quality.plausibility.findings() if isinstance(self.quality, Quality) else []


class ReactionCache:
    """The reactions in one folder; `damaged`: messages about files that were set aside."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[str] = []

    def files(self) -> list[Path]:
        """All entries, in the order of their names."""
        found = (path for path in self.folder.glob("*.h5") if _FILE_NAME.fullmatch(path.name))
        return sorted(path for path in found if path.name.isprintable())

    def path(self, request: ReactionRequest) -> Path:
        """Where a reaction is published."""
        return self.folder / file_name(request.name, request.digest)

    def read(self, path: Path) -> Reaction | FailedReaction:
        """The reaction in a file of the folder.

        Raises OtherVersionError for a file of another format, DamagedFileError if it is damaged or has the name of
        another one.
        """
        reaction = read_entry(read_content(path), str(path))
        if not path.stem.endswith(f"-{reaction.digest[:DIGEST_LENGTH]}"):
            raise DamagedFileError(
                f"{path}: holds another reaction than its name says, {file_name(reaction.name, reaction.digest)}."
            )
        return reaction

    def store(self, reaction: Reaction) -> Path:
        """Publish a reaction that was not simulated; its file. Raises OutputFolderError if that cannot be written."""
        path = writable_folder(self.folder) / file_name(reaction.name, reaction.digest)
        publish_bytes(path, entry_bytes(reaction))
        return path

    def stream(
        self, requests: Sequence[ReactionRequest], how: str, chosen: Container[ReactionName] | None = None
    ) -> Iterator[Reaction | FailedReaction]:
        """The reactions one by one, all or those chosen, in the order of the requests, by the accuracy of each.

        `how` is the command that makes them, for the message. Raises MissingReactionsError if some are not there,
        before any is read; DamagedFileError for one that is not what was written.
        """
        wanted = [request for request in requests if chosen is None or request.name in chosen]
        for request, stored in zip(wanted, self.stored(wanted, how), strict=True):
            yield request.judged(stored)

    def stored(self, requests: Sequence[ReactionRequest], how: str) -> Iterator[Reaction | FailedReaction]:
        """As `stream`, but as they are stored, whatever the accuracy."""
        for request, path in zip(requests, self.paths(requests, how), strict=True):
            try:
                yield self._read_for(request, path)
            except (DamagedFileError, OtherVersionError) as error:
                raise DamagedFileError(f"{error} Run `{how}`: it sets the file aside and simulates again.") from error

    def paths(self, requests: Sequence[ReactionRequest], how: str) -> list[Path]:
        """The files of these reactions, found by digest. Raises MissingReactionsError as `stream`."""
        files = self._files_by_digest()
        missing = [request for request in requests if request.digest[:DIGEST_LENGTH] not in files]
        if missing:
            names = listed(request.name for request in missing)
            hint = f" Some are recorded: {REIMPORT}" if any(request.recorded for request in missing) else ""
            raise MissingReactionsError(
                f"{self.folder}: {len(missing)} of {len(requests)} reactions are not there: {names}. Run "
                f"`{how}` first. If they were there once, `fatplan cache why EXPERIMENT` says what has changed.{hint}"
            )
        return [files[request.digest[:DIGEST_LENGTH]][0] for request in requests]

    def complete(
        self, requests: Sequence[ReactionRequest], executor: Executor, progress: Callable[[Outcome], None]
    ) -> list[Outcome]:
        """Find or simulate every request; the outcomes in the order of the requests.

        `progress` hears of every outcome as it comes. Damaged files are set aside (see `damaged`), what they held is
        simulated again. Raises OutputFolderError if the folder cannot be written, MissingReactionsError if a recorded
        reaction is not there.
        """
        by_digest = {request.digest: request for request in requests}
        files = self._files_by_digest()
        known: dict[str, Outcome] = {}
        for digest, request in by_digest.items():
            stored = self._find(files.get(digest[:DIGEST_LENGTH], []), request)
            if stored is not None:
                quality = stored.quality if isinstance(stored, Reaction) else None
                reason = stored.reason if isinstance(stored, FailedReaction) else ""
                known[digest] = Outcome.of(request, quality, reason, found=True)
                progress(known[digest])
        missing = [request for digest, request in by_digest.items() if digest not in known]
        if gone := [f"{request.name} ({request.recorded.key})" for request in missing if request.recorded]:
            told = "".join(f" {damage}" for damage in self.damaged)
            raise MissingReactionsError(
                f"{self.folder}: recorded reactions are not there: {listed(gone)}. {REIMPORT}{told}"
            )
        if missing:
            writable_folder(self.folder)
        for index, made in executor.run(simulated, missing):
            request = missing[index]
            if isinstance(made, Lost):
                outcome = Outcome.of(request, None, made.reason, kept=False)
            else:
                outcome, content = made
                if not has_valid_checksum(content):
                    raise DamagedFileError(f"{request.name}: was damaged on its way from the worker. Run again.")
                publish_bytes(self.path(request), content)
            known[request.digest] = outcome
            progress(outcome)
        # several requests may have the same digest, with other names and accuracies
        return [
            Outcome.of(request, same.quality, same.failure, same.found, same.kept)
            for request in requests
            for same in [known[request.digest]]
        ]

    def _files_by_digest(self) -> dict[str, list[Path]]:
        """The files by the beginning of the digest in their names; several may have the same."""
        files: dict[str, list[Path]] = {}
        for path in self.files():
            files.setdefault(path.stem[-DIGEST_LENGTH:], []).append(path)
        return files

    def _find(self, paths: Sequence[Path], request: ReactionRequest) -> Reaction | FailedReaction | None:
        """The first undamaged reaction in some files; damaged ones before it are set aside."""
        for path in paths:
            try:
                return self._read_for(request, path)
            except (DamagedFileError, OtherVersionError) as error:
                aside = set_aside(path)
                self.damaged.append(f"{error} It is set aside as {aside.name}; what it held is simulated again.")
        return None

    def _read_for(self, request: ReactionRequest, path: Path) -> Reaction | FailedReaction:
        """As `read`, and the reaction is what was asked for, of the length its settings say."""
        stored = self.read(path)
        if stored.digest != request.digest:
            raise DamagedFileError(f"{path}: holds another reaction than its name says.")
        if isinstance(stored, Reaction):
            try:
                check_shape(request.motion, stored.motion)
            except MismatchError as error:
                raise DamagedFileError(f"{path}: {error}.") from error
        return stored


def simulated(request: ReactionRequest) -> tuple[Outcome, bytes]:
    """Simulate a reaction and measure it; the outcome and the content of its file."""
    made = simulate_and_measure(request.motion)
    if isinstance(made, str):
        return Outcome.of(request, None, made), entry_bytes(FailedReaction(request.name, request.key, made))
    motion, quality = made
    return Outcome.of(request, quality, ""), entry_bytes(Reaction(request.name, request.key, motion, quality))


def simulate_and_measure(request: MotionRequest) -> tuple[Motion, Quality] | str:
    """A motion and its quality, or why it cannot be performed."""
    try:
        motion = simulate(request)
    except FailedMotionError as error:
        return f"{error} {causes_of(request)}."
    if not all((np.abs(getattr(motion, name)) < MAX_MAGNITUDE).all() for name in ROWS):
        return f"the motion has values that are not finite, or beyond {MAX_MAGNITUDE:.0e}"
    quality = measure(request, motion)
    return motion, quality if on_target(motion) else replace(quality, tested_causes=causes_of(request))


def read_content(path: Path) -> bytes:
    """The bytes of a file that may be one of ours. Raises DamagedFileError if it cannot be."""
    try:
        # opens a pipe, too, without waiting for somebody to write to it
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

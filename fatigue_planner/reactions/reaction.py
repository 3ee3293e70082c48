"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.reactions.key import ReactionKey


class ReactionName(NamedTuple):
    """What names a reaction: who, where, how."""

    worker: str
    action: str
    preference: str

    def __str__(self) -> str:
        return "/".join(self)


@dataclass(frozen=True)
class Reaction:
    """A reaction whose motion could be simulated, under the name for which it was made."""

    name: ReactionName
    key: ReactionKey
    motion: Motion
    quality: Quality

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest


@dataclass(frozen=True)
class FailedReaction:
    """A reaction that cannot be performed, or not accurately enough, and why."""

    name: ReactionName
    key: ReactionKey
    reason: str

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest


@dataclass(frozen=True)
class ReactionRequest:
    """A reaction to be found in the cache or simulated, and the accuracy with which it may be used."""

    name: ReactionName
    motion: MotionRequest
    accuracy: Accuracy

    @cached_property
    def key(self) -> ReactionKey:
        """What decides the reaction."""
        return ReactionKey.of(self.motion)

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest

    def judged(self, stored: Reaction | FailedReaction) -> Reaction | FailedReaction:
        """A stored reaction under the name of the request; failed if its motion misses the accuracy."""
        if isinstance(stored, Reaction):
            faults = stored.quality.faults(self.accuracy)
            if faults:
                return FailedReaction(self.name, stored.key, "; ".join(faults))
        return replace(stored, name=self.name)


def file_name(name: ReactionName, digest: str) -> str:
    """How the file of a reaction is called; only the digest counts, the rest is for people."""
    return f"{'-'.join(name)}-{digest[:DIGEST_LENGTH]}.h5"


def digests(requests: Iterable[ReactionRequest]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(request.name): request.digest for request in requests}

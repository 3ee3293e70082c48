"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.reactions.key import ReactionKey, sources, versions


class ReactionName(NamedTuple):
    """What names a reaction: who, where, how."""

    worker: str
    action: str
    preference: str

    def __str__(self) -> str:
        return "/".join(self)


@dataclass(frozen=True)
class ReactionRequest:
    """A reaction to be found in the cache or simulated."""

    name: ReactionName
    motion: MotionRequest
    accuracy: Accuracy

    @cached_property
    def key(self) -> ReactionKey:
        """What decides the reaction."""
        # the name of a strength set, or the path of its file, decides nothing; its values are there
        worker = self.motion.worker.model_copy(update={"strength": "see maximum_torque"})
        parts = vars(self.motion) | {"worker": worker, "accuracy": self.accuracy}
        return ReactionKey({name: part.plain() for name, part in parts.items()}, sources(), versions())

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest


def request_of(name: ReactionName, settings: Mapping[str, Any]) -> ReactionRequest:
    """The request a reaction was made for, from its settings as plain data.

    Raises ValueError or KeyError if these are not the settings of a reaction of this version.
    """
    kinds = {field.name: field.type for field in fields(MotionRequest)}
    parts = {part: kind.model_validate(settings[part]) for part, kind in kinds.items()}  # type: ignore[union-attr]
    return ReactionRequest(name, MotionRequest(**parts), Accuracy.model_validate(settings["accuracy"]))


@dataclass(frozen=True)
class Reaction:
    """A reaction whose motion has passed its checks, under the name for which it was made."""

    name: ReactionName
    key: ReactionKey
    motion: Motion
    quality: Quality

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest


def file_name(name: ReactionName, digest: str) -> str:
    """How the file of a reaction is called; only the digest counts, the rest is for people."""
    return f"{'-'.join(name)}-{digest[:DIGEST_LENGTH]}.h5"


def digests(requests: Iterable[ReactionRequest]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(request.name): request.digest for request in requests}

"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.reactions.key import ReactionKey

if TYPE_CHECKING:
    import pandas as pd


class ReactionName(NamedTuple):
    """What names a reaction: who, where, how."""

    worker: str
    action: str
    preference: str

    def __str__(self) -> str:
        return "/".join(self)


@dataclass(frozen=True)
class Reaction:
    """A reaction whose motion could be simulated, under the name for which it was made.

    >>> reaction = reactions["average_man/high/arm"]
    >>> isinstance(reaction, fp.Reaction), reaction.angles_rad().shape
    (True, (1600, 39))
    """

    name: ReactionName
    key: ReactionKey
    motion: Motion
    quality: Quality

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest

    def torques_nm(self) -> "pd.DataFrame":
        """Joint torques in N.m over the cycle: a row per tick, indexed by time_s, a column per degree of freedom."""
        return self._frame(self.motion.torque_nm)

    def angles_rad(self) -> "pd.DataFrame":
        """Joint angles in rad over the cycle, indexed and named as the torques."""
        return self._frame(self.motion.configuration[:, BASE_DOF + 1 :])

    def _frame(self, table: NDArray[np.float64]) -> "pd.DataFrame":
        import pandas as pd  # noqa: PLC0415 - takes half a second, which `simulate` does without

        times_s = np.arange(len(table)) * self.motion.time_step_s
        return pd.DataFrame(table, columns=list(DEGREES_OF_FREEDOM), index=pd.Index(times_s, name="time_s"))


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

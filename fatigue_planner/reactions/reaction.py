"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, JOINTS
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.plausibility import Finding
from fatigue_planner.motion.quality import Quality, Verdict
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.recorded import RecordedQuality, RecordingAccuracy

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
    """A reaction whose motion could be simulated, or was recorded, under the name for which it was made.

    >>> reaction = reactions["average_man/high/arm"]
    >>> isinstance(reaction, fp.Reaction), reaction.angles_rad().shape
    (True, (1600, 39))
    """

    name: ReactionName
    key: ReactionKey
    motion: Motion
    quality: Quality | RecordedQuality

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest

    @property
    def findings(self) -> list[Finding]:
        """What no person would do, of a simulated motion; a recorded one is a person's."""
        return self.quality.plausibility.findings() if isinstance(self.quality, Quality) else []

    @property
    def assumed(self) -> NDArray[np.bool_]:
        """Which degrees of freedom (39,) have torques that nobody measured: those of joints that no marker shows."""
        joints = self.quality.assumed_joints if isinstance(self.quality, RecordedQuality) else ()
        return np.array([joint.name in joints for joint in JOINTS for _ in joint.degrees_of_freedom])

    def torques_nm(self) -> "pd.DataFrame":
        """Joint torques in N.m over the cycle: a row per tick, indexed by time_s, a column per degree of freedom.

        NaN where a recording does not show them.
        """
        return self._frame(np.where(self.assumed, np.nan, self.motion.torque_nm))

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


class Recorded(NamedTuple):
    """The key of the import that a reaction is, and the accuracy with which it may be used."""

    key: str
    accuracy: RecordingAccuracy


@dataclass(frozen=True)
class ReactionRequest:
    """A reaction to be found in the cache or simulated, and the accuracy with which it may be used.

    recorded: it is to be found, as it was recorded.
    """

    name: ReactionName
    motion: MotionRequest
    accuracy: Accuracy
    recorded: Recorded | None = None

    @cached_property
    def key(self) -> ReactionKey:
        """What decides the reaction."""
        if self.recorded is not None:
            return ReactionKey.of_recorded(self.motion, self.recorded.key)
        return ReactionKey.of(self.motion)

    @property
    def digest(self) -> str:
        """Digest of the key."""
        return self.key.digest

    @property
    def asked(self) -> tuple[str, Accuracy, Recorded | None]:
        """What is asked for, whatever it is called: equal for requests with the same answer."""
        return self.digest, self.accuracy, self.recorded

    def faults(self, quality: Quality | RecordedQuality) -> list[str]:
        """Why a reaction of this quality may not be used; empty if it may."""
        if isinstance(quality, Quality):
            return quality.faults(self.accuracy)
        return quality.faults(RecordingAccuracy() if self.recorded is None else self.recorded.accuracy)

    def verdict(self, quality: Quality | RecordedQuality) -> Verdict:
        """The verdict on a reaction of this quality."""
        return "failed" if self.faults(quality) else quality.kept_as()

    def judged(self, stored: Reaction | FailedReaction) -> Reaction | FailedReaction:
        """A stored reaction under the name of the request; failed if its motion misses the accuracy."""
        if isinstance(stored, Reaction):
            faults = self.faults(stored.quality)
            if faults:
                return FailedReaction(self.name, stored.key, "; ".join(faults))
        return replace(stored, name=self.name)


def file_name(name: ReactionName, digest: str) -> str:
    """How the file of a reaction is called; only the digest counts, the rest is for people."""
    return f"{'-'.join(name)}-{digest[:DIGEST_LENGTH]}.h5"


def digests(requests: Iterable[ReactionRequest]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(request.name): request.digest for request in requests}

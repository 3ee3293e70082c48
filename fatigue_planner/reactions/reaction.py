"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import DIGEST_LENGTH, digest_of, digests_of_package
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.human.model import BASE_DOF
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Accuracy

if TYPE_CHECKING:
    import pandas as pd

# What produces the numbers of a motion besides its settings: folders and modules of this package.
SOURCES = ("human", "motion", "core/settings.py", "core/yaml_reader.py", "core/jit.py")
# The QP solvers come with casadi.
NUMERICAL_LIBRARIES = ("pin", "casadi", "numpy", "numba", "scipy")


class ReactionName(NamedTuple):
    """What names a reaction: who, where, how."""

    worker: str
    action: str
    preference: str

    def __str__(self) -> str:
        return "/".join(self)


@dataclass(frozen=True)
class ReactionKey:
    """Everything that decides a reaction.

    settings: of the motion, as plain data, strengths written out; sources: SHA-256 of every file of this package that
    produces it; versions: of the numerical libraries, solvers included.
    """

    settings: Mapping[str, Any]
    sources: Mapping[str, str]
    versions: Mapping[str, str]

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all of it, in hex."""
        return digest_of(self.plain())

    @property
    def is_current(self) -> bool:
        """Whether this program, with these libraries, would make such a reaction."""
        return (self.sources, self.versions) == (sources(), versions())

    def plain(self) -> dict[str, Any]:
        """The key as JSON values."""
        return {"settings": self.settings, "sources": self.sources, "versions": self.versions}


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
    """A reaction whose motion has passed its checks, under the name for which it was made.

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


def file_name(name: ReactionName, digest: str) -> str:
    """How the file of a reaction is called; only the digest counts, the rest is for people."""
    return f"{'-'.join(name)}-{digest[:DIGEST_LENGTH]}.h5"


def digests(requests: Iterable[ReactionRequest]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(request.name): request.digest for request in requests}


def sources() -> dict[str, str]:
    """SHA-256 of every file of this package that decides the numbers of a motion."""
    return digests_of_package(*SOURCES)


def versions() -> dict[str, str]:
    """Versions of the libraries that decide the numbers of a motion."""
    return versions_of(*NUMERICAL_LIBRARIES)

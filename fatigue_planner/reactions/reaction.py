"""A postural reaction: what the worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version

from fatigue_planner.files import digest_of, digest_of_package
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.motion.simulator import MotionRequest
from fatigue_planner.motion.verification import Quality

# What produces the numbers of a motion besides its settings.
SOURCES = ("human", "motion")
NUMERICAL_LIBRARIES = ("pin", "casadi", "numpy")


@dataclass(frozen=True)
class ReactionName:
    """The pair that names a reaction."""

    action: str
    preference: str

    def __str__(self) -> str:
        return f"{self.action}/{self.preference}"


@dataclass(frozen=True)
class ReactionRequest:
    """A reaction to be found in the cache or simulated."""

    name: ReactionName
    motion: MotionRequest
    accuracy: Accuracy

    def settings(self) -> dict[str, object]:
        """Everything of an experiment that decides the reaction, as plain data, strengths written out."""
        parts = vars(self.motion) | {"accuracy": self.accuracy}
        positive, negative = maximum_torques(self.motion.worker.strength)
        strength = {"positive_nm": positive.tolist(), "negative_nm": negative.tolist()}
        return {name: part.plain() for name, part in parts.items()} | {"maximum_torque": strength}

    def digest(self) -> str:
        """Key of the reaction: settings, body data, sources and numerical libraries."""
        return digest_of({"settings": self.settings(), "sources": digest_of_package(*SOURCES), "versions": versions()})


@dataclass(frozen=True)
class Reaction:
    """A reaction whose motion has passed its checks."""

    name: ReactionName
    digest: str
    settings: Mapping[str, object]
    motion: Motion
    quality: Quality


def digests(reactions: Iterable[Reaction]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(reaction.name): reaction.digest for reaction in reactions}


def versions() -> dict[str, str]:
    """Versions of the libraries that decide the numbers of a motion."""
    return {library: version(library) for library in NUMERICAL_LIBRARIES}

"""A postural reaction: what a worker does for an action with a preference, and what it costs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from importlib.metadata import version
from typing import Any, NamedTuple

from fatigue_planner.files import digest_of, digest_of_package
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.motion.simulator import MotionRequest

# What produces the numbers of a motion besides its settings: folders and modules of this package.
SOURCES = ("human", "motion", "settings.py", "yaml_reader.py", "compiled.py")
NUMERICAL_LIBRARIES = ("pin", "casadi", "numpy", "numba")


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
    def settings(self) -> dict[str, Any]:
        """Everything of an experiment that decides the reaction, as plain data, strengths written out."""
        parts = vars(self.motion) | {"accuracy": self.accuracy}
        return {name: part.plain() for name, part in parts.items()}

    @cached_property
    def digest(self) -> str:
        """Key of the reaction: settings, body data, sources and numerical libraries."""
        return digest_of({"settings": self.settings, "sources": digest_of_package(*SOURCES), "versions": versions()})


def request_of(name: ReactionName, settings: Mapping[str, Any]) -> ReactionRequest:
    """The request a reaction was made for, from its settings as plain data.

    Raises ValueError or KeyError if these are not the settings of a reaction of this version.
    """
    kinds = {field.name: field.type for field in fields(MotionRequest)}
    parts = {part: kind.model_validate(settings[part]) for part, kind in kinds.items()}  # type: ignore[union-attr]
    return ReactionRequest(name, MotionRequest(**parts), Accuracy.model_validate(settings["accuracy"]))


@dataclass(frozen=True)
class Reaction:
    """A reaction whose motion has passed its checks."""

    name: ReactionName
    digest: str
    settings: Mapping[str, Any]
    motion: Motion
    quality: Quality


def digests(requests: Iterable[ReactionRequest]) -> dict[str, str]:
    """The digest of every reaction, by name."""
    return {str(request.name): request.digest for request in requests}


def versions() -> dict[str, str]:
    """Versions of the libraries that decide the numbers of a motion."""
    return {library: version(library) for library in NUMERICAL_LIBRARIES}

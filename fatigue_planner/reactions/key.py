"""The cache key of a reaction: everything that decides it, and the digest under which it is found."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

from fatigue_planner.core.files import digest_of, digests_of_package
from fatigue_planner.core.plugins import OF_PLUGINS, plugin_sources
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.settings import MAX_TICKS, Controller, Cycle
from fatigue_planner.motion.tasks.registry import Preference

# What produces the numbers of a motion besides its settings: folders and modules of this package.
SOURCES = ("human", "motion", "core/settings.py", "core/text.py", "core/yaml_reader.py", "core/jit.py")
# The QP solvers come with casadi.
NUMERICAL_LIBRARIES = ("pin", "casadi", "numpy", "numba", "scipy")
# The setting that names the recording that a recorded reaction is of.
RECORDED = "recorded"


@dataclass(frozen=True)
class ReactionKey:
    """Everything that decides a reaction.

    settings: of the motion, as plain data, strengths written out; sources: SHA-256 of every file of this package that
    produces it, and of the plug-ins of its tasks; versions: of the numerical libraries, solvers included. What only
    decides whether a motion may be used (`Accuracy`) has no part in it.

    Of a recorded reaction the settings hold the key of its import, in which sources, versions and the recording's data
    are already; what moves the digital human decides nothing then.
    """

    settings: Mapping[str, Any]
    sources: Mapping[str, str]
    versions: Mapping[str, str]

    @classmethod
    def of(cls, motion: MotionRequest) -> Self:
        """The key of a motion, made by this program with these libraries."""
        # the name of a strength set, or the path of its file, decides nothing; its values are there
        worker = motion.worker.model_copy(update={"strength": "see maximum_torque"})
        parts = vars(motion) | {"worker": worker}
        of_plugins = plugin_sources(*map(type, motion.preference.tasks))
        return cls({name: part.plain() for name, part in parts.items()}, sources() | of_plugins, versions())

    @classmethod
    def of_recorded(cls, motion: MotionRequest, recorded: str) -> Self:
        """The key of what a recording, by the key of its import, shows of a motion."""
        controller = Controller(time_step_s=motion.controller.time_step_s)
        cycle = motion.cycle.model_copy(update={"return_hand": Cycle().return_hand})
        moved = replace(motion, controller=controller, cycle=cycle, preference=Preference(tasks=()))
        return cls({**cls.of(moved).settings, RECORDED: recorded}, {}, {})

    @property
    def recorded(self) -> str:
        """The key of the import that it is of; empty for a simulated one."""
        return str(self.settings.get(RECORDED, ""))

    def motion_request(self) -> MotionRequest:
        """The motion it is the key of.

        Raises ValueError, KeyError or TypeError if its settings are not those of a motion of this version.
        """
        kinds = {field.name: field.type for field in fields(MotionRequest)}
        if self.settings.keys() - {*kinds, RECORDED}:
            raise ValueError("there are others than a motion's")
        parts = {part: kind.model_validate(self.settings[part]) for part, kind in kinds.items()}  # type: ignore[union-attr]
        motion = MotionRequest(**parts)
        if (ticks := motion.cycle.duration_s / motion.controller.time_step_s) > MAX_TICKS:
            raise ValueError(f"{ticks:.0f} ticks, more than {MAX_TICKS}")
        return motion

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all of it, in hex."""
        return digest_of(self.plain())

    @property
    def is_current(self) -> bool:
        """Whether this program, with these libraries and the plug-ins of then, would make or find such a reaction."""
        if self.recorded:
            return not self.sources and not self.versions
        own = {name: sha256 for name, sha256 in self.sources.items() if not name.startswith(OF_PLUGINS)}
        return (own, self.versions) == (sources(), versions())

    def plain(self) -> dict[str, Any]:
        """The key as JSON values."""
        return {"settings": self.settings, "sources": self.sources, "versions": self.versions}


def sources() -> dict[str, str]:
    """SHA-256 of every file of this package that decides the numbers of a motion."""
    return digests_of_package(*SOURCES)


def versions() -> dict[str, str]:
    """Versions of the libraries that decide the numbers of a motion."""
    return versions_of(*NUMERICAL_LIBRARIES)

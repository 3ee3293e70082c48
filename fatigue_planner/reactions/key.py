"""The cache key of a reaction: everything that decides it, and the digest under which it is found."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fatigue_planner.core.files import digest_of, digests_of_package
from fatigue_planner.core.provenance import versions_of

# What produces the numbers of a motion besides its settings: folders and modules of this package.
SOURCES = ("human", "motion", "core/settings.py", "core/yaml_reader.py", "core/jit.py")
# The QP solvers come with casadi.
NUMERICAL_LIBRARIES = ("pin", "casadi", "numpy", "numba", "scipy")


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


def sources() -> dict[str, str]:
    """SHA-256 of every file of this package that decides the numbers of a motion."""
    return digests_of_package(*SOURCES)


def versions() -> dict[str, str]:
    """Versions of the libraries that decide the numbers of a motion."""
    return versions_of(*NUMERICAL_LIBRARIES)

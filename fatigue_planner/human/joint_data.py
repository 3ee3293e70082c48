"""Ranges of motion, strengths and natural posture: one value per degree of freedom."""

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.errors import DataFileError
from fatigue_planner.human.data_files import DATA, load_data
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, without_side
from fatigue_planner.settings import Settings

Vector = NDArray[np.float64]

STRENGTHS = DATA / "strengths"


class Range(Settings):
    """Range of motion of a degree of freedom in degrees."""

    min: float
    max: float
    positive: str = ""
    source: str


class Strength(Settings):
    """Maximum isometric torque of a degree of freedom in both directions, in N.m."""

    positive: float = Field(gt=0)
    negative: float = Field(gt=0)
    source: str


class MaximumTorque(Settings):
    """Maximum torques of all degrees of freedom in both directions, each (39,) N.m."""

    positive_nm: tuple[float, ...]
    negative_nm: tuple[float, ...]

    def vectors(self) -> tuple[Vector, Vector]:
        """The torques as arrays (39,): positive, negative direction."""
        return np.array(self.positive_nm), np.array(self.negative_nm)


class StrengthTable(Settings):
    """Content of a file of data/strengths."""

    population: str
    degrees_of_freedom: dict[str, Strength]


def _complete(path: Path, names: set[str]) -> None:
    """Raise DataFileError unless `names` are the degrees of freedom of the skeleton (one side)."""
    needed = {without_side(name) for name in DEGREES_OF_FREEDOM}
    if names != needed:
        raise DataFileError(
            f"{path}: degrees of freedom missing: {sorted(needed - names) or 'none'}, "
            f"unknown: {sorted(names - needed) or 'none'}"
        )


@cache
def position_limits() -> tuple[Vector, Vector]:
    """Lower and upper joint limits, each (39,) rad, from data/ranges_of_motion.yaml."""
    path = DATA / "ranges_of_motion.yaml"
    ranges = load_data(path, dict[str, Range])
    _complete(path, set(ranges))
    rows = [ranges[without_side(name)] for name in DEGREES_OF_FREEDOM]
    return np.radians([row.min for row in rows]), np.radians([row.max for row in rows])


def strength_path(name: str) -> Path:
    """The file of a strength set: one that ships with the package, by name, or a user's, by path."""
    shipped = STRENGTHS / f"{name}.yaml"
    return shipped if shipped.exists() else Path(name)


def maximum_torque(name: str) -> MaximumTorque:
    """The maximum torques of a strength set. Raises DataFileError for an unknown, unreadable or incomplete set."""
    path = strength_path(name)
    if not path.exists():
        shipped = ", ".join(sorted(file.stem for file in STRENGTHS.glob("*.yaml")))
        raise DataFileError(f"strength set {name!r}: neither one of {shipped} nor a file ({path.absolute()}).")
    table = load_data(path, StrengthTable).degrees_of_freedom
    _complete(path, set(table))
    rows = [table[without_side(dof)] for dof in DEGREES_OF_FREEDOM]
    return MaximumTorque(
        positive_nm=tuple(row.positive for row in rows), negative_nm=tuple(row.negative for row in rows)
    )


def degrees_of_freedom(name: str) -> list[int]:
    """Places in a joint vector of a degree of freedom; without its side, of both sides; empty if unknown."""
    return [i for i, dof in enumerate(DEGREES_OF_FREEDOM) if name in {dof, without_side(dof)}]


def posture(angles_deg: dict[str, float], key: str) -> Vector:
    """Joint angles (39,) rad from degrees by name; a name without side sets both; the rest are 0.

    Raises DataFileError, naming the `key` of the experiment, for an unknown name or an angle outside the
    range of motion.
    """
    lower, upper = position_limits()
    angles = np.zeros(len(DEGREES_OF_FREEDOM))
    for name, degrees in angles_deg.items():
        places = degrees_of_freedom(name)
        if not places:
            raise DataFileError(f"{key}: unknown degree of freedom {name!r}; known: {', '.join(DEGREES_OF_FREEDOM)}")
        if not np.degrees(lower[places[0]]) <= degrees <= np.degrees(upper[places[0]]):
            raise DataFileError(
                f"{key}: {name} = {degrees} deg is outside its range of motion "
                f"[{np.degrees(lower[places[0]]):.0f}, {np.degrees(upper[places[0]]):.0f}] deg"
            )
        angles[places] = np.radians(degrees)
    return angles

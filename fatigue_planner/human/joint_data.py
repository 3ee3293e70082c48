"""Ranges of motion, strengths and natural posture: one value per degree of freedom."""

import difflib
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.skeleton import DATA, DEGREES_OF_FREEDOM, without_side
from fatigue_planner.human.strength_sets import load_strengths

Vector = NDArray[np.float64]


class Range(Settings):
    """Range of motion of a degree of freedom in degrees."""

    min: float
    max: float
    positive: str = ""
    source: str


class MaximumTorque(Settings):
    """Maximum torques of all degrees of freedom in both directions, each (39,) N.m, all > 0."""

    positive_nm: tuple[float, ...]
    negative_nm: tuple[float, ...]

    def vectors(self) -> tuple[Vector, Vector]:
        """The torques as arrays (39,): positive, negative direction."""
        return np.array(self.positive_nm), np.array(self.negative_nm)


@cache
def ranges_of_motion() -> dict[str, Range]:
    """Range of motion of every degree of freedom of one side, by name, from data/ranges_of_motion.yaml."""
    return load_data(DATA / "ranges_of_motion.yaml", dict[str, Range])


@cache
def position_limits() -> tuple[Vector, Vector]:
    """Lower and upper joint limits, each (39,) rad."""
    rows = [ranges_of_motion()[without_side(name)] for name in DEGREES_OF_FREEDOM]
    return np.radians([row.min for row in rows]), np.radians([row.max for row in rows])


def maximum_torque(strength: str) -> MaximumTorque:
    """The maximum torques of a strength set. Raises DataFileError for an unknown, unreadable or incomplete set."""
    entries = load_strengths(strength).entries
    return MaximumTorque(
        positive_nm=tuple(entries[freedom, "positive"].torque_nm for freedom in DEGREES_OF_FREEDOM),
        negative_nm=tuple(entries[freedom, "negative"].torque_nm for freedom in DEGREES_OF_FREEDOM),
    )


def degrees_of_freedom(name: str) -> list[int]:
    """Indices in a joint vector of a degree of freedom; without its side, of both sides; empty if unknown."""
    return [i for i, dof in enumerate(DEGREES_OF_FREEDOM) if name in {dof, without_side(dof)}]


def known_names(unknown: str) -> str:
    """The end of a message about an unknown joint: the nearest name, and all there are."""
    short = list(dict.fromkeys(without_side(dof) for dof in DEGREES_OF_FREEDOM))
    close = difflib.get_close_matches(unknown, [*short, *DEGREES_OF_FREEDOM], n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ";"
    return f"{hint} Known, with right_ or left_ before them for one side of arms and legs: {', '.join(short)}"


def posture(angles_deg: dict[str, float], key: str) -> Vector:
    """Joint angles (39,) rad from degrees by name; a name without side sets both; the rest are 0.

    Raises DataFileError, naming the `key` of the experiment, for an unknown name or an angle outside the
    range of motion.
    """
    lower, upper = position_limits()
    angles = np.zeros(len(DEGREES_OF_FREEDOM))
    for name, degrees in angles_deg.items():
        indices = degrees_of_freedom(name)
        if not indices:
            raise DataFileError(f"{key}: unknown degree of freedom {name!r}{known_names(name)}")
        if not lower[indices[0]] <= np.radians(degrees) <= upper[indices[0]]:
            raise DataFileError(
                f"{key}: {name} = {degrees} deg is outside its range of motion "
                f"[{np.degrees(lower[indices[0]]):.6g}, {np.degrees(upper[indices[0]]):.6g}] deg"
            )
        angles[indices] = np.radians(degrees)
    return angles

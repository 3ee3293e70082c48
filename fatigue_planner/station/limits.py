"""Limits that bind the robot: how long a worker may be in a posture. What breaks one is never recommended."""

from typing import Literal, NamedTuple

import numpy as np
from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion import posture_measures as posture
from fatigue_planner.motion.motion import Motion

Measure = Literal["upper_arm_elevation", "trunk_inclination"]


class Limit(Settings):
    """A posture that is not held longer than some time in a cycle, by any worker at any place."""

    measure: Measure = Field(
        description="What is limited. upper_arm_elevation: an upper arm against the vertical, the higher of both; "
        "trunk_inclination: the line from the hips to the neck against the vertical (ISO 11226)."
    )
    above_deg: float = Field(ge=0, le=180, description="Angle in degrees above which the posture counts.")
    at_most_s: float = Field(
        ge=0, le=1800, description="How long in s an operation may have the posture in a cycle, all its times together."
    )


class Breach(NamedTuple):
    """A limit that a motion breaks: its number in the file, and for how long in a cycle the posture is had, in s."""

    limit: int
    seconds: float


def breaches(limits: tuple[Limit, ...], person: Anthropometry, motion: Motion, times: int) -> tuple[Breach, ...]:
    """The limits that a motion breaks which is made so many times in a cycle."""
    if not limits:
        return ()
    poses = poses_of(tree_of(person), motion.configuration)
    angles = {
        "upper_arm_elevation": np.max([posture.upper_arm_elevation(poses, side) for side in SIDES], axis=0),
        "trunk_inclination": posture.lean(poses),
    }
    found = []
    for index, limit in enumerate(limits):
        seconds = float(np.count_nonzero(angles[limit.measure] > limit.above_deg)) * motion.time_step_s * times
        if seconds > limit.at_most_s + motion.time_step_s / 2:
            found.append(Breach(index, seconds))
    return tuple(found)

"""Where the hands work: an action of the robot, as an experiment describes it."""

import itertools
from typing import Annotated, Self

import numpy as np
import pinocchio as pin
from pydantic import Field, model_validator

from fatigue_planner.core.errors import shortened
from fatigue_planner.core.settings import Settings
from fatigue_planner.motion.minimum_jerk import Matrix, Pose, Vector
from fatigue_planner.motion.payload import Load
from fatigue_planner.motion.settings import Side


class Position(Settings):
    """A point in the world: x forward, y left, z up from the centre between the soles, in m."""

    x: float = Field(ge=-3, le=3, description="Distance in m forward from the centre between the soles.")
    y: float = Field(ge=-3, le=3, description="Distance in m to the left of the centre between the soles.")
    z: float = Field(ge=0, le=3, description="Height in m above the ground.")

    def vector(self) -> Vector:
        """The point as (3,) m."""
        return np.array([self.x, self.y, self.z])


class Orientation(Settings):
    """An orientation as rotations in degrees about the world's x, then y, then z axis.

    Zero is a body segment of the standing worker with hanging arms: for a hand, fingers down, palm
    inward, thumb forward.
    """

    x: float = Field(default=0, ge=-180, le=180, description="First rotation, in degrees about the world's x axis.")
    y: float = Field(default=0, ge=-180, le=180, description="Second rotation, in degrees about the world's y axis.")
    z: float = Field(default=0, ge=-180, le=180, description="Third rotation, in degrees about the world's z axis.")

    def rotation(self) -> Matrix:
        """The rotation matrix (3, 3)."""
        return np.asarray(pin.rpy.rpyToMatrix(np.radians([self.x, self.y, self.z])))


class Waypoint(Settings):
    """A pose on a hand's path, `work_time_s` after the beginning of the work phase."""

    work_time_s: float = Field(
        ge=0, le=600, description="Time in s since the beginning of the work phase; the first is 0."
    )
    position_m: Position = Field(description="Position of the fist's centre in m.")
    orientation_deg: Orientation | None = Field(
        default=None,
        description="Orientation of the hand in degrees; left out at all waypoints, the hand turns freely.",
    )

    def pose(self, otherwise: Pose) -> Pose:
        """The pose; where the orientation is free, that of `otherwise`."""
        turn = self.orientation_deg.rotation() if self.orientation_deg else otherwise.rotation
        return Pose(self.position_m.vector(), turn)


class HandGoal(Settings):
    """What a hand has to do during work: hold a pose, or follow waypoints from rest to rest.

    Without `orientation_deg` the hand may turn as it likes.
    """

    position_m: Position | None = Field(
        default=None, description="Position in m at which the fist's centre is held during work; or give waypoints."
    )
    orientation_deg: Orientation | None = Field(
        default=None, description="Orientation in degrees in which the hand is held; left out, it turns freely."
    )
    waypoints: tuple[Waypoint, ...] = Field(
        default=(), max_length=1000, description="A path instead of a pose to hold: each waypoint is reached at rest."
    )

    @model_validator(mode="after")
    def _check_path(self) -> Self:
        if (self.position_m is None) == (not self.waypoints):
            raise ValueError("give either position_m (a pose to hold) or waypoints (a path)")
        if self.waypoints:
            if self.orientation_deg is not None:
                raise ValueError("orientation_deg belongs to each waypoint of a path, not beside it")
            times = [point.work_time_s for point in self.waypoints]
            if times[0] != 0 or any(b - a < 0.1 for a, b in itertools.pairwise(times)):
                raise ValueError(
                    f"waypoints: work_time_s = {shortened(times)}; they start at 0 and follow each other by 0.1 s at "
                    "least"
                )
            if len({point.orientation_deg is None for point in self.waypoints}) > 1:
                raise ValueError("waypoints: give orientation_deg to all of them or to none")
        return self

    def path(self) -> tuple[Waypoint, ...]:
        """The waypoints; a pose to hold is a path of one waypoint."""
        if self.position_m is None:
            return self.waypoints
        return (Waypoint(work_time_s=0.0, position_m=self.position_m, orientation_deg=self.orientation_deg),)

    def turned(self) -> bool:
        """Whether the orientation is given."""
        return self.path()[0].orientation_deg is not None


class Action(Settings):
    """Where the robot presents the object, or how it moves it, for one hand or both; and the loads it brings."""

    right_hand: HandGoal | None = Field(
        default=None, description="What the right hand does; left out, it hangs freely."
    )
    left_hand: HandGoal | None = Field(default=None, description="What the left hand does; left out, it hangs freely.")
    loads: tuple[Annotated[Load, Field(discriminator="kind")], ...] = Field(
        default=(), max_length=50, description="What the hands carry or push against during this action."
    )

    @model_validator(mode="after")
    def _check_hands(self) -> Self:
        if not self.goals():
            raise ValueError("an action needs a goal for right_hand or left_hand")
        return self

    def goals(self) -> dict[Side, HandGoal]:
        """The goals of the hands that have one."""
        hands: dict[Side, HandGoal | None] = {"right": self.right_hand, "left": self.left_hand}
        return {side: goal for side, goal in hands.items() if goal is not None}

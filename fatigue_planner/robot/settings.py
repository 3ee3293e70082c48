"""What an experiment says of its robot: which arm, where it stands, how it holds what it presents."""

from pathlib import Path
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from fatigue_planner.core.errors import listed
from fatigue_planner.core.settings import Settings
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.settings import Side
from fatigue_planner.robot.arm import shipped_arms

Vector = NDArray[np.float64]

# What a pedestal is thick where nothing is said: about the flange of these robots' bases. An assumption.
PEDESTAL_RADIUS_M = 0.1
# Above this vertical part of a direction, its roll is counted from the world's x axis instead of from up.
_NEARLY_VERTICAL = 0.99


class RobotBase(Settings):
    """Where the robot stands: x forward, y to the left, z up from the centre between the worker's soles."""

    x: float = Field(ge=-5, le=5, description="Where the base is in m forward of the centre between the soles.")
    y: float = Field(default=0, ge=-5, le=5, description="Where the base is in m to the left of the worker's middle.")
    z: float = Field(default=0, ge=0, le=3, description="Height of the base in m: of the pedestal or table it is on.")
    yaw_deg: float = Field(
        default=180, ge=-360, le=360, description="How the base is turned, in degrees about the vertical."
    )

    @property
    def side(self) -> Side:
        """On which side of the worker it stands; the left, if in the middle."""
        return "right" if self.y < 0 else "left"

    def placement(self) -> Vector:
        """The frame (4, 4) of the base in the world."""
        frame = np.eye(4)
        frame[:3, :3] = turn_about_vertical(np.radians(self.yaw_deg))
        frame[:3, 3] = self.x, self.y, self.z
        return frame

    def pedestal(self) -> Vector:
        """The axis (k, 2, 3) m of the pedestal, k = 1, or none where the base is on the ground."""
        top = self.z - PEDESTAL_RADIUS_M
        if top <= 0:
            return np.empty((0, 2, 3))
        return np.array([[[self.x, self.y, 0.0], [self.x, self.y, top]]])


class Direction(Settings):
    """A direction in the world; its length does not matter."""

    x: float = Field(default=0, ge=-1, le=1, description="Forward part of the direction, without unit.")
    y: float = Field(default=0, ge=-1, le=1, description="Part of the direction to the left, without unit.")
    z: float = Field(default=0, ge=-1, le=1, description="Upward part of the direction, without unit.")

    def unit(self) -> Vector:
        """The direction (3,), of length 1."""
        vector = np.array([self.x, self.y, self.z])
        return np.asarray(vector / np.linalg.norm(vector))

    @model_validator(mode="after")
    def _check_length(self) -> Self:
        if not (self.x or self.y or self.z):
            raise ValueError("x, y and z are all 0; give one of them, such as {x: -1}")
        return self


class RobotHold(Settings):
    """How the flange holds the object on which the worker works."""

    distance_m: float = Field(
        default=0.1, ge=0, le=2, description="From the centre of the worker's fist to the flange, in m."
    )
    direction: Direction = Field(
        default=Direction(x=-1.0),
        description="Where the flange points, from itself to the fist. Default: straight back, at the worker.",
    )
    roll_deg: float | None = Field(
        default=None,
        ge=-360,
        le=360,
        description="How the flange is turned about that direction, in degrees from its x axis up. Default: as it "
        "likes.",
    )
    mass_kg: float = Field(default=0, ge=0, le=100, description="Gripper and object together, in kg.")


class RobotSettings(Settings):
    """The robot that presents the object."""

    arm: Annotated[str, Field(min_length=1, max_length=MAX_PATH_LENGTH)] = Field(
        description="The arm: ur3e, ur5e or ur10e, or the path of a URDF file."
    )
    base_m: RobotBase = Field(description="Where the robot stands, in m.")
    hold: RobotHold = Field(default=RobotHold(), description="How it holds what it presents.")
    clearance_m: float = Field(
        default=0.05,
        ge=0,
        le=1,
        description="How far the arm stays from the worker's body in m, the working hands left out. No safety "
        "distance: that is for a risk assessment.",
    )

    link_radius_m: float = Field(
        default=0.06,
        gt=0,
        le=0.5,
        description="Half the thickness in m of the links of an arm from a URDF file; those that ship have theirs.",
    )

    @field_validator("arm")
    @classmethod
    def _check_arm(cls, arm: str) -> str:
        if arm not in shipped_arms() and Path(arm).suffix != ".urdf":
            raise ValueError(f"should be one of {listed(shipped_arms())}, or the path of a .urdf file")
        return arm

    def flange_targets(self, action: Action) -> tuple[Vector, Vector]:
        """When in s of the work the flange has to be where for an action: times (n,) and frames (n, 4, 4).

        At every waypoint, between the hands where two work.
        """
        paths = [goal.path() for goal in action.goals().values()]
        times_s = np.unique([point.work_time_s for path in paths for point in path])
        fists = np.zeros((times_s.size, 3))
        for path in paths:
            points = np.array([point.position_m.vector() for point in path])
            own_s = [point.work_time_s for point in path]
            fists += np.array([np.interp(times_s, own_s, points[:, axis]) for axis in range(3)]).T / len(paths)
        return times_s, self.flanges_at(fists)

    def flanges_at(self, fists: Vector, turned_rad: float = 0.0) -> Vector:
        """The flange (n, 4, 4) for fists at (n, 3) m, for workers who are turned by so much to the left."""
        turned = turn_about_vertical(turned_rad)
        z = turned @ self.hold.direction.unit()
        up = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < _NEARLY_VERTICAL else turned[:, 0]
        x = up - (up @ z) * z
        x /= np.linalg.norm(x)
        turn = np.radians(self.hold.roll_deg or 0.0)
        x = np.cos(turn) * x + np.sin(turn) * np.cross(z, x)
        targets = np.tile(np.eye(4), (len(fists), 1, 1))
        targets[:, :3, :3] = np.column_stack([x, np.cross(z, x), z])
        targets[:, :3, 3] = fists - self.hold.distance_m * z
        return targets


def turn_about_vertical(angle_rad: float) -> Vector:
    """The rotation (3, 3) by an angle to the left."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

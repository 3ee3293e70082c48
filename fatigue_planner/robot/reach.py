"""Whether a robot reaches what it shall present, how easily, and what stops it where it does not."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.robot.arm import Arm
from fatigue_planner.robot.inverse import Freedom, Solution, Surroundings, solve
from fatigue_planner.robot.kinematics import capsule_ends, frames_of
from fatigue_planner.robot.settings import PEDESTAL_RADIUS_M, RobotBase, RobotSettings
from fatigue_planner.robot.shape import RobotShape

Vector = NDArray[np.float64]

# Starts of the search for a pose. Of 6,000 random poses of the three arms that ship, 32 missed one that 500 others
# found, and 48 none.
STARTS = 64
# Starts for a point that the flange shall be at however it points: so many of them, and where it came nearest.
POINT_STARTS = 15
NOBODY = (np.empty((0, 2, 3)), np.empty(0))


@dataclass(frozen=True)
class PoseReach:
    """What became of one pose of the flange.

    `reason` is empty where it is reached. Else it says what stops the arm, and `angles_rad` (n,) are those that come
    nearest. `joint_margin_rad` is how far the joint `tightest` is from its nearer limit. `ends_m` (c, 2, 3): the arm's
    capsules in the world.
    """

    reason: str
    angles_rad: Vector
    manipulability: float
    joint_margin_rad: float
    tightest: str
    ends_m: Vector

    @property
    def reached(self) -> bool:
        """Whether the flange can be there."""
        return not self.reason


@dataclass(frozen=True)
class Cell:
    """An arm in its place."""

    arm: Arm
    settings: RobotSettings

    def at(self, base: RobotBase) -> "Cell":
        """The same robot elsewhere."""
        return replace(self, settings=self.settings.model_copy(update={"base_m": base}))

    def overloaded(self) -> str:
        """Why the arm cannot carry what it holds, or nothing."""
        payload, mass = self.arm.payload_kg, self.settings.hold.mass_kg
        if payload is None or mass <= payload:
            return ""
        return f"{mass:g} kg to hold; it carries {payload:g} kg"

    def reach(self, target: Vector, worker: tuple[Vector, Vector] = NOBODY) -> PoseReach:
        """Whether the flange can be at a target (4, 4), as far as it can from a worker's capsules (k, 2, 3) and (k,).

        Equal inputs give equal results: the starts are always the same.
        """
        freedom = Freedom.ROLL if self.settings.hold.roll_deg is None else Freedom.NONE
        pedestal = self.settings.base_m.pedestal()
        around = Surroundings(pedestal, np.full(len(pedestal), PEDESTAL_RADIUS_M), *worker)
        starts = starts_within(self.arm.chain.lower, self.arm.chain.upper)
        found, joint = self._solved(target, freedom, around, starts), ""
        if not found.found and (stopped := starts[found.bound]).size:
            without = self._solved(target, freedom, around, stopped, limited=False, first=True)
            joint = self._beyond(without.angles) if without.found else ""
            found = without if without.found and not joint else found
        reason = self.overloaded() or ("" if found.free else self._reason(target, around, found, starts, joint))
        chain, angles = self.arm.chain, found.angles
        frames = np.empty((angles.size + 2, 4, 4))
        frames_of(chain, self.settings.base_m.placement(), angles, frames)
        margins = np.minimum(angles - chain.lower, chain.upper - angles)
        tightest = int(margins.argmin())
        return PoseReach(
            reason, angles, float(found.manipulability), float(margins[tightest]), self.arm.joints[tightest],
            capsule_ends(chain, frames),
        )  # fmt: skip

    def shape(self, poses: Sequence[PoseReach], flanges: Vector, times_s: Vector) -> RobotShape:
        """What is seen of the robot in these poses, with its flange at (w, 4, 4), at times (w,) of the work."""
        fists = flanges[:, :3, 3] + self.settings.hold.distance_m * flanges[:, :3, 2]
        pedestal = self.settings.base_m.pedestal()
        pedestal[:, 0, 2] = np.minimum(PEDESTAL_RADIUS_M, pedestal[:, 1, 2])  # so that its end is not in the ground
        return RobotShape(
            np.array([pose.ends_m for pose in poses]), self.arm.chain.radius,
            np.stack([flanges[:, :3, 3], fists], axis=1), pedestal, times_s,
        )  # fmt: skip

    def _solved(
        self,
        target: Vector,
        freedom: Freedom,
        around: Surroundings,
        starts: Vector,
        limited: bool = True,
        first: bool = False,
    ) -> Solution:
        chain = self.arm.chain
        if not limited:
            wide = np.full(chain.lower.size, 4 * np.pi)
            chain = chain._replace(lower=-wide, upper=wide)
        placement = self.settings.base_m.placement()
        return Solution(*solve(chain, placement, target, int(freedom), around, starts, first))

    def _beyond(self, angles: Vector) -> str:
        """The joint whose limit these angles (n,) exceed most, if any."""
        beyond = np.maximum(self.arm.chain.lower - angles, angles - self.arm.chain.upper)
        return self.arm.joints[int(beyond.argmax())] if beyond.max() > 0 else ""

    def _reason(self, target: Vector, around: Surroundings, found: Solution, starts: Vector, joint: str) -> str:
        """What stops the arm: found by taking away one obstacle after the other; `joint`: whose limits do."""
        if found.found:
            return "the arm would touch its pedestal" if found.on_solid else "the arm would touch itself or the ground"
        if joint:
            return f"the limits of {joint} are in the way"
        few = np.vstack([found.angles, starts[:POINT_STARTS]])
        anyhow = self._solved(target, Freedom.ALL, around, few, first=True)
        if anyhow.found:
            return "the flange gets there, but cannot point where it should"
        missed = "less than 1 cm" if anyhow.missed_m < 0.01 else f"{100 * anyhow.missed_m:.0f} cm"
        return f"out of reach by {missed}"


@cache
def _starts(n_joints: int) -> Vector:
    """Points (STARTS, n) that fill the unit cube evenly, without chance."""
    from scipy.stats import qmc  # noqa: PLC0415 - takes half a second

    return np.asarray(qmc.Halton(n_joints, scramble=False).random(STARTS + 1)[1:])


def starts_within(lower: Vector, upper: Vector) -> Vector:
    """Angles (STARTS, n) rad to start from, evenly within the limits, and within a turn where they are wider."""
    low, high = np.maximum(lower, -np.pi), np.minimum(upper, np.pi)
    return np.asarray(low + (high - low) * _starts(lower.size))

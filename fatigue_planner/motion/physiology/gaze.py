"""The head turns to the work, and stays level."""

import numpy as np
import pinocchio as pin

from fatigue_planner.core.jit import compiled
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.physiology.facing import heading
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, TimedTask, Vector
from fatigue_planner.motion.schedule import rise_of
from fatigue_planner.motion.tasks.task import Task

WEIGHT = 1.0
STIFFNESS_PER_S2 = 10.0
# What the eyes take of the direction to the work: so far down and up the head need not bend, and so far aside it need
# not turn in the chest (MIL-STD-1472G, as read in NUREG-0700: 15 degrees preferred, 35 the most).
EYES_DOWN_RAD, EYES_UP_RAD, EYES_ASIDE_RAD = np.radians(20), np.radians(10), np.radians(15)


class GazeTask(Task):
    """Turn the head to a point (3,) m of the world, less what the eyes take, without tilting it sideways.

    The error is the rotation vector from the head's axes to those wanted.
    """

    def __init__(self, weight: float, stiffness: float, frame: int, chest: int) -> None:
        super().__init__(3, weight, stiffness)
        self.frame, self.chest = frame, chest
        self.point_m: Vector = np.zeros(3)

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        placement = state.placement(self.frame)
        chest = heading(state.placement(self.chest).rotation)
        wanted = head_axes(self.point_m - placement.translation, chest)
        whole = state.jacobian(self.frame)
        jacobian[:] = whole[3:]
        _write_target(
            pin.log3(wanted @ placement.rotation.T), jacobian, state.velocity, state.drift(self.frame),
            self.stiffness, self.damping, target,
        )  # fmt: skip


@compiled
def head_axes(towards: Vector, chest_rad: float) -> Matrix:
    """The level axes (3, 3) of a head that looks along a vector (3,): forward, left, up.

    The chest faces chest_rad to the left of forward: if the work is not aside of it, so does the head.
    """
    aside = np.arctan2(towards[1], towards[0]) - chest_rad
    aside = np.arctan2(np.sin(aside), np.cos(aside))
    yaw = chest_rad + aside - min(max(aside, -EYES_ASIDE_RAD), EYES_ASIDE_RAD)
    elevation = np.arctan2(towards[2], np.hypot(towards[0], towards[1]))
    pitch = elevation - min(max(elevation, -EYES_DOWN_RAD), EYES_UP_RAD)
    c, s, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.array([[c * cp, -s, -c * sp], [s * cp, c, -s * sp], [sp, 0.0, cp]])


@compiled
def _write_target(
    turn: Vector, jacobian: Matrix, velocity: Vector, drift: Vector, stiffness: float, damping: float, target: Vector
) -> None:
    """Write desired - drift."""
    target[:] = stiffness * turn - damping * (jacobian @ velocity) - drift[3:]


class Gaze(Piece):
    """Look at the middle of the working hands' targets, from the beginning of the cycle to the end of the work.

    During the reach the eyes are already where the work will be.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.task = GazeTask(WEIGHT, STIFFNESS_PER_S2, scene.state.frame("head"), scene.state.frame("thorax"))
        self.points_m: Matrix = np.mean([path.position_m for path in scene.paths.values()], axis=0)
        reach, work, _ = scene.phases
        self.points_m[: reach.stop] = self.points_m[work.start]
        self.points_m[work.stop :] = self.points_m[work.stop - 1]

    def tasks(self) -> list[TimedTask]:
        """See Piece.tasks."""
        reach = self.scene.phases[0]
        share = np.ones(self.scene.phases[-1].stop)
        share[: reach.stop] = rise_of(reach, self.scene.time_step_s)
        return [TimedTask(self.task, share, aims=True)]

    def prepare(self, tick: int) -> None:
        """See Piece.prepare."""
        self.task.point_m = self.points_m[tick]

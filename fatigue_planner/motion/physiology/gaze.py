"""The head turns to the work, and stays level."""

import numpy as np
import pinocchio as pin

from fatigue_planner.core.jit import compiled
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, TimedTask, Vector
from fatigue_planner.motion.schedule import rise_of
from fatigue_planner.motion.tasks.task import Task

WEIGHT = 1.0
STIFFNESS_PER_S2 = 10.0
# What the eyes take of the direction to the work: so far down and up the head need not bend.
EYES_DOWN_RAD, EYES_UP_RAD = np.radians(20), np.radians(10)


class GazeTask(Task):
    """Turn the head to a point (3,) m of the world, less what the eyes take up and down, without tilting it sideways.

    The error is the rotation vector from the head's axes to those wanted.
    """

    def __init__(self, weight: float, stiffness: float, frame: int) -> None:
        super().__init__(3, weight, stiffness)
        self.frame = frame
        self.point_m: Vector = np.zeros(3)

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        placement = state.placement(self.frame)
        wanted = head_axes(self.point_m - placement.translation)
        whole = state.jacobian(self.frame)
        jacobian[:] = whole[3:]
        _write_target(
            pin.log3(wanted @ placement.rotation.T), jacobian, state.velocity, state.drift(self.frame),
            self.stiffness, self.damping, target,
        )  # fmt: skip


@compiled
def head_axes(towards: Vector) -> Matrix:
    """The level axes (3, 3) of a head that looks along a vector (3,): forward, left, up."""
    yaw, elevation = np.arctan2(towards[1], towards[0]), np.arctan2(towards[2], np.hypot(towards[0], towards[1]))
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
        self.task = GazeTask(WEIGHT, STIFFNESS_PER_S2, scene.state.frame("head"))
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

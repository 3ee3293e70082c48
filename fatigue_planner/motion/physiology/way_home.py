"""After the work the body returns as a whole: every joint from where it is to the stance, by minimum jerk."""

import numpy as np

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.motion.minimum_jerk import minimum_jerk
from fatigue_planner.motion.physiology.piece import Piece, Scene, Vector

# Over this time, and no more than a third of the way home, the aims of the work are given up.
LET_GO_S, LET_GO_SHARE = 1.0, 1 / 3
# So long before the end of the cycle the stance is reached.
EARLY_S, EARLY_SHARE = 0.2, 0.1
# Gain of following it; on a short way home more, so that what is left of the work has gone when it ends.
STIFFNESS_PER_S2, TIME_CONSTANTS = 16.0, 15.0


class WayHome(Piece):
    """Let go of hand, gaze and preferences, and follow minimum-jerk joint angles to the stance.

    With s a minimum-jerk rise from 0 to 1 over a second, the aims keep (1 - s)^4 of their weight and the joints are
    drawn to the accelerations (1 - s) x those of the posture + s x those that follow the angles.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.back = back = scene.phases[-1]
        duration_s = scene.duration_s(back)
        times_s = np.arange(back.stop - back.start) * np.float64(scene.time_step_s)
        self.given_up = minimum_jerk(times_s / min(LET_GO_S, LET_GO_SHARE * duration_s))[0]
        way_s = duration_s - min(EARLY_S, EARLY_SHARE * duration_s)
        share, rate, curvature = minimum_jerk(times_s / way_s)
        self.way = np.column_stack([share, rate / way_s, curvature / way_s**2])
        self.stiffness_per_s2 = max(STIFFNESS_PER_S2, (TIME_CONSTANTS / duration_s) ** 2)
        self.begin_rad, self.tick = scene.stance_rad, 0

    def aim(self) -> Vector:
        """See Piece.aim."""
        return np.concatenate([np.ones(self.back.start), (1 - self.given_up) ** 4])

    def prepare(self, tick: int) -> None:
        """See Piece.prepare."""
        self.tick = tick - self.back.start
        if self.tick == 0:
            self.begin_rad = self.scene.state.configuration[7:].copy()

    def draw(self, weight: Vector, target: Vector) -> None:
        """See Piece.draw."""
        if self.tick >= 0:
            state = self.scene.state
            _follow(
                state.configuration[7:], state.velocity[BASE_DOF:], self.begin_rad, self.scene.stance_rad,
                self.way[self.tick], self.given_up[self.tick], self.stiffness_per_s2, target,
            )  # fmt: skip


@compiled
def _follow(
    angles: Vector, speeds: Vector, begin: Vector, end: Vector, way: Vector, given_up: float, stiffness: float,
    target: Vector,
) -> None:  # fmt: skip
    """Blend the accelerations wanted with those that follow the way (share, rate, curvature)."""
    damping = 2 * np.sqrt(stiffness)
    for i in range(len(angles)):
        path = end[i] - begin[i]
        wanted = way[2] * path + damping * (way[1] * path - speeds[i])
        wanted += stiffness * (begin[i] + way[0] * path - angles[i])
        target[i] = (1 - given_up) * target[i] + given_up * wanted

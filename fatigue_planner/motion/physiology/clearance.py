"""Parts of the body do not pass through each other."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, Vector

# Pairs that are nearer than this are watched, the nearest ROWS of them.
WATCHED_M = 0.08
ROWS = 8
# Parts come no nearer than this, or than they are in the stance.
APART_M = 0.005
# How fast what is too near gives way: the distance decays to the least one like exp(-RATE t).
RATE_PER_S = 15.0


class Clearance(Piece):
    """Capsules around the parts of the body keep a distance d >= d_min, by a second-order exponential barrier.

        d'' >= -2 RATE d' - RATE^2 (d - d_min),   d'' = n . (J_1 - J_2) a,

    with n the normal between the nearest points of a pair and J their Jacobians (how the normal turns is left out).
    Form: exponential control barrier function, Nguyen & Sreenath, ACC 2016.
    """

    limits = ROWS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        human = scene.human
        self.tree, self.capsules = tree_of(human.anthropometry), capsules_of(human.anthropometry)
        self.moves = _moves(human)
        self.least_m = np.minimum(APART_M, self._distances()[0])

    def _distances(self) -> tuple[Vector, Vector, Vector, Vector]:
        ends = self.capsules.world_ends(poses_of(self.tree, self.scene.state.configuration[None]))[0]
        found: tuple[Vector, Vector, Vector, Vector] = capsule_distances(
            ends, self.capsules.radius_m, self.capsules.pairs
        )
        return found

    def limit(self, rows: Matrix, least: Vector) -> None:
        """See Piece.limit."""
        state = self.scene.state
        _write_rows(
            *self._distances(), self.capsules.pairs, self.least_m, self.moves, state.data.J, state.velocity, rows, least
        )


def _moves(human: Human) -> NDArray[np.bool_]:
    """Which generalised velocities (45,) move each body (17, 45)."""
    model = human.model
    moves = np.zeros((len(BODIES), model.nv), dtype=bool)
    for index, body in enumerate(BODIES):
        for joint in model.supports[model.frames[model.getFrameId(body)].parentJoint]:
            first = model.joints[joint].idx_v
            moves[index, first : first + model.joints[joint].nv] = joint > 0
    return moves


@compiled
def _write_rows(
    distance: Vector, normal: Matrix, first: Matrix, second: Matrix, pairs: NDArray[np.int64], least_m: Vector,
    moves: NDArray[np.bool_], jacobian: Matrix, velocity: Vector, rows: Matrix, least: Vector,
) -> None:  # fmt: skip
    """Write the rows of the nearest pairs; `jacobian` (6, 45): twists of all velocities at the world's origin."""
    rows[:], least[:] = 0.0, -np.inf
    order = np.argsort(distance)
    for row in range(len(rows)):
        pair = order[row]
        if distance[pair] > WATCHED_M:
            return
        n = normal[pair]
        turn_first, turn_second = np.cross(first[pair], n), np.cross(second[pair], n)
        approach = 0.0
        for k in range(rows.shape[1]):
            along = jacobian[0, k] * n[0] + jacobian[1, k] * n[1] + jacobian[2, k] * n[2]
            value = 0.0
            for side, turn in ((0, turn_first), (1, turn_second)):
                if moves[pairs[pair, side], k]:
                    about = jacobian[3, k] * turn[0] + jacobian[4, k] * turn[1] + jacobian[5, k] * turn[2]
                    value += (along + about) if side == 0 else -(along + about)
            rows[row, k] = value
            approach += value * velocity[k]
        least[row] = -2 * RATE_PER_S * approach - RATE_PER_S**2 * (distance[pair] - least_m[pair])

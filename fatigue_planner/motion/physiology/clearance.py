"""Parts of the body do not pass through each other."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.kinematics import Tree, poses, tree_of
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
        self.least_m = np.minimum(APART_M, self._nearest()[0])

    def _nearest(self) -> tuple[Vector, Vector, Vector, Vector]:
        capsules = self.capsules
        found: tuple[Vector, Vector, Vector, Vector] = _nearest(
            self.tree, self.scene.state.configuration, capsules.ends_m, capsules.radius_m, capsules.pairs
        )
        return found

    def limit(self, rows: Matrix, least: Vector) -> None:
        """See Piece.limit."""
        state = self.scene.state
        distance, normal, first, second = self._nearest()
        _write_rows(
            distance, normal, first, second, self.capsules.pairs, self.least_m, self.moves,
            state.data.J, state.velocity, rows, least,
        )  # fmt: skip


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
def _nearest(
    tree: Tree, configuration: Vector, ends_m: Vector, radii: Vector, pairs: NDArray[np.int64]
) -> tuple[Vector, Vector, Vector, Vector]:
    """See capsule_distances; everything in the world."""
    rotation, origin = poses(tree, configuration.reshape(1, -1))
    ends = np.empty_like(ends_m)
    for body in range(len(ends_m)):
        for end in range(2):
            for i in range(3):
                ends[body, end, i] = origin[0, body, i]
                for j in range(3):
                    ends[body, end, i] += rotation[0, body, i, j] * ends_m[body, end, j]
    return capsule_distances(ends, radii, pairs)


@compiled
def _write_rows(
    distance: Vector, normal: Matrix, first: Matrix, second: Matrix, pairs: NDArray[np.int64], least_m: Vector,
    moves: NDArray[np.bool_], jacobian: Matrix, velocity: Vector, rows: Matrix, least: Vector,
) -> None:  # fmt: skip
    """Write the rows of the nearest pairs; `jacobian` (6, 45): twists of all velocities at the world's origin."""
    previous, count = -np.inf, 0
    for row in range(len(rows)):
        # the nearest pair that is not written yet; equal distances are one after the other
        pair = -1
        for other in range(len(distance)):
            d = distance[other]
            if d > previous and d <= WATCHED_M and (pair < 0 or d < distance[pair]):
                pair = other
        if pair < 0:
            break
        previous = distance[pair]
        i, j = pairs[pair]
        nx, ny, nz = normal[pair]
        ax, ay, az = first[pair]
        bx, by, bz = second[pair]
        approach = 0.0
        for k in range(rows.shape[1]):
            value = 0.0
            if moves[i, k] != moves[j, k]:
                px, py, pz = (ax, ay, az) if moves[i, k] else (bx, by, bz)
                value = jacobian[0, k] * nx + jacobian[1, k] * ny + jacobian[2, k] * nz
                value += jacobian[3, k] * (py * nz - pz * ny)
                value += jacobian[4, k] * (pz * nx - px * nz) + jacobian[5, k] * (px * ny - py * nx)
                value = value if moves[i, k] else -value
            rows[row, k] = value
            approach += value * velocity[k]
        least[row] = -2 * RATE_PER_S * approach - RATE_PER_S**2 * (distance[pair] - least_m[pair])
        count += 1
    rows[count:], least[count:] = 0.0, -np.inf

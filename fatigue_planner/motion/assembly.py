"""Writing the quadratic program of a tick, and checking limits left out of it: plain sums of products, compiled."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.multibody import BASE_DOF

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@compiled
def assemble(
    H: Matrix,
    g: Vector,
    A: Matrix,
    row_lower: Vector,
    row_upper: Vector,
    torque_map: Matrix,
    mass: Matrix,
    bias: Vector,
    contact_jacobian: Matrix,
    required: Vector,
    task_jacobian: Matrix,
    task_target: Vector,
    task_weight: Vector,
    posture_weight: Vector,
    posture_target: Vector,
    torque_scale: Vector,
    wrench_scale: Vector,
) -> None:
    """Write objective and equalities of the program in (a, w), (n,), n = 45 + 12, and its torque map T (39, n).

    tau = T (a, w) + bias_a with T = [M_a, -J_a'];
    H = J' W J + T' S T + posture weight on joint accelerations + wrench scale on wrenches,
    g = -J' W target + T' S bias_a - posture weight x posture target;
    rows: M_b a - J_b' w = -bias_b (6) and J a = required (12), with b the pelvis' and a the joints' part.
    """
    nv, wrenches = len(mass), len(contact_jacobian)
    joints = nv - BASE_DOF
    torque_map[:, :nv] = mass[BASE_DOF:]
    A[:BASE_DOF, :nv] = mass[:BASE_DOF]
    A[BASE_DOF:, :nv] = contact_jacobian
    for i in range(wrenches):
        for j in range(BASE_DOF):
            A[j, nv + i] = -contact_jacobian[i, j]
        for j in range(joints):
            torque_map[j, nv + i] = -contact_jacobian[i, BASE_DOF + j]
    for i in range(BASE_DOF):
        row_lower[i] = row_upper[i] = -bias[i]
    row_lower[BASE_DOF:] = required
    row_upper[BASE_DOF:] = required
    scaled = np.empty_like(torque_map)
    for j in range(joints):
        scaled[j] = torque_scale[j] * torque_map[j]
    H[:] = torque_map.T @ scaled
    g[:] = bias[BASE_DOF:] @ scaled
    weighted = np.empty_like(task_jacobian)
    for row in range(len(task_jacobian)):
        weighted[row] = task_weight[row] * task_jacobian[row]
    H[:nv, :nv] += task_jacobian.T @ weighted
    g[:nv] -= task_target @ weighted
    for j in range(joints):
        H[BASE_DOF + j, BASE_DOF + j] += posture_weight[j]
        g[BASE_DOF + j] -= posture_weight[j] * posture_target[j]
    for i in range(wrenches):
        H[nv + i, nv + i] += wrench_scale[i]


@compiled
def within_limits(torque: Vector, lowest: Vector, highest: Vector, cone: Matrix, wrenches: Vector) -> bool:
    """Whether torques (39,) are between their limits and every wrench (6 per sole) is in its cone, G w <= 0."""
    for joint in range(len(torque)):
        if not lowest[joint] <= torque[joint] <= highest[joint]:
            return False
    rows, size = cone.shape
    for sole in range(len(wrenches) // size):
        for row in range(rows):
            total = 0.0
            for part in range(size):
                total += cone[row, part] * wrenches[sole * size + part]
            if not total <= 0:
                return False
    return True


@compiled
def without_tissue(mass: Matrix, bias: Vector, moments: Vector, slopes: Matrix) -> tuple[Matrix, Vector]:
    """Mass matrix (45, 45) and bias (45,) for what muscles exert beside tissue that exerts moments + slopes a.

    moments (39,) N.m and slopes (39, 39) N.m s^2/rad.
    """
    own_mass, own_bias = mass.copy(), bias.copy()
    own_mass[BASE_DOF:, BASE_DOF:] -= slopes
    own_bias[BASE_DOF:] -= moments
    return own_mass, own_bias


@compiled
def keeps(rows: Matrix, least: Vector, solution: Vector) -> bool:
    """Whether accelerations, the first of a solution (n,), keep limits rows (k, 45) a >= least (k,)."""
    for row in range(len(rows)):
        total = 0.0
        for k in range(rows.shape[1]):
            total += rows[row, k] * solution[k]
        if not total >= least[row]:
            return False
    return True

"""The posture that brings a body's markers nearest to where they were seen, in one frame: Gauss and Newton, compiled.

Least squares of distances, made robust by Cauchy's weights, so that a marker far from where the others put it hardly
counts (iteratively reweighted), with Gaussian priors on all angles and a wall behind the range of motion.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.kinematics import Tree, poses, tree_of
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, JOINTS, ROOT_BODY
from fatigue_planner.recordings.kinematics.measured import Measured

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

ROOT = 6
# A marker this far off counts half; skin moves over bones by 1 to 2 cm.
ROBUST_M = 0.03
# Where markers are farther from the start than this, in the mean, none counts less at first.
FAR_M, PLAIN_M = 0.03, 100.0
# A posture this far from its markers, in the mean, is none.
LOST_M = 0.02
# Beyond the range of motion an angle is drawn back as if its limit were known to within this.
LIMIT_SIGMA_RAD = 0.05
# Angles have a prior this many ranges of motion wide, which decides only what no marker shows. Where a body without
# markers is between others, as the abdomen is, two joints share what is seen: four deviations are a range of motion.
PRIOR_RANGES, SHARED_RANGES = 20.0, 0.25
MAX_STEPS, STEP_RAD, DONE = 60, 0.4, 1e-7


class FitProblem(NamedTuple):
    """What does not change from frame to frame.

    body (k,): index of each marker's body; local_m (k, 3): its place there; sigma_m (k,): how well it is known; moves
    (17, 39): whether an angle moves a body; prior, prior_sigma, lower, upper (39,) rad.
    """

    tree: Tree
    moves: NDArray[np.bool_]
    body: Indices
    local_m: Vector
    sigma_m: Vector
    prior: Vector
    prior_sigma: Vector
    lower: Vector
    upper: Vector


def fit_problem(
    person: Measured,
    bodies: list[str],
    local_m: Vector,
    sigma_m: Vector,
    prior: Vector,
    prior_sigma: Vector | None = None,
) -> FitProblem:
    """The problem of a person with markers on these bodies; `prior` (39,) rad is what unseen joints are at."""
    tree = tree_of(person)
    moves = np.zeros((len(BODIES), len(DEGREES_OF_FREEDOM)), dtype=np.bool_)
    for joint, (parent, child) in enumerate(zip(tree.parent, tree.child, strict=True)):
        moves[child] = moves[parent]
        moves[child, tree.first[joint] : tree.first[joint + 1]] = True
    lower, upper = position_limits()
    if prior_sigma is None:
        prior_sigma = np.where(_shared(set(bodies)), SHARED_RANGES, PRIOR_RANGES) * (upper - lower)
    index = np.array([BODIES.index(body) for body in bodies], dtype=np.int64)
    return FitProblem(tree, moves, index, local_m, sigma_m, prior, prior_sigma, lower, upper)


def _shared(marked: set[str]) -> NDArray[np.bool_]:
    """Which angles (39,) are of joints beside a body without markers, with bodies beyond that have some."""
    beyond = set(marked)
    for joint in reversed(JOINTS):
        if joint.child in beyond:
            beyond.add(joint.parent)
    between = beyond - marked - {ROOT_BODY}
    return np.array(
        [
            not between.isdisjoint((joint.parent, joint.child)) and joint.child in beyond
            for joint in JOINTS
            for _ in joint.degrees_of_freedom
        ]
    )


@compiled
def fit_frame(problem: FitProblem, start: Vector, target_m: Vector) -> tuple[Vector, Vector]:
    """The configuration (46,) nearest to markers (k, 3) m, NaN where unseen, and the distances (k,) m that are left.

    From a start that is far away it goes by plain least squares first: to Cauchy's weights all markers would be astray.
    """
    _, _, _, distance = normal_equations(problem, start, target_m, PLAIN_M)
    configuration = start
    if np.nanmean(distance) > FAR_M:
        configuration, _ = _descend(problem, configuration, target_m, PLAIN_M)
    return _descend(problem, configuration, target_m, ROBUST_M)


@compiled
def _descend(problem: FitProblem, start: Vector, target_m: Vector, robust_m: float) -> tuple[Vector, Vector]:
    """Gauss and Newton's steps, damped where they lead upwards, until they are tiny."""
    configuration = start.copy()
    damping = 1e-12
    cost, matrix, side, distance = normal_equations(problem, configuration, target_m, robust_m)
    for _ in range(MAX_STEPS):
        damped = matrix.copy()
        for i in range(len(side)):
            damped[i, i] *= 1 + damping
        step = np.linalg.solve(damped, side)
        largest = np.abs(step[3:]).max()
        if largest > STEP_RAD:
            step *= STEP_RAD / largest
        trial = _moved(configuration, step)
        found = normal_equations(problem, trial, target_m, robust_m)
        if found[0] <= cost * (1 + 1e-12):
            configuration = trial
            cost, matrix, side, distance = found
            damping = max(damping / 10, 1e-12)
        else:
            damping = max(10 * damping, 1e-6)
        if np.abs(step).max() < DONE:
            break
    return configuration, distance


@compiled
def fit_frames(problem: FitProblem, start: Vector, targets_m: Vector) -> tuple[Vector, Vector]:
    """Configurations (n, 46) and distances (n, k) of frames (n, k, 3), each begun at the one before.

    Where that leads nowhere, it is begun again at the prior's angles, and the better one is kept.
    """
    found, distances = np.empty((len(targets_m), len(start))), np.empty(targets_m.shape[:2])
    configuration = start
    for frame in range(len(targets_m)):
        configuration, distance = fit_frame(problem, configuration, targets_m[frame])
        if np.nanmean(distance) > LOST_M:
            again = configuration.copy()
            again[7:] = problem.prior
            other, left = fit_frame(problem, again, targets_m[frame])
            if np.nanmean(left) < np.nanmean(distance):
                configuration, distance = other, left
        found[frame], distances[frame] = configuration, distance
    return found, distances


@compiled
def normal_equations(
    problem: FitProblem, configuration: Vector, target_m: Vector, robust_m: float
) -> tuple[float, Vector, Vector, Vector]:
    """Half the weighted squares, Gauss and Newton's matrix (45, 45) and right-hand side (45,), the distances (k,) m.

    The unknowns are the root's shift and turn in the world, then the angles.
    """
    cost, distance = 0.0, np.full(len(target_m), np.nan)
    place, off, arm = np.empty(3), np.empty(3), np.empty(3)
    size = ROOT + len(problem.prior)
    matrix, side = np.zeros((size, size)), np.zeros(size)
    rotation, origin = poses(problem.tree, configuration.reshape(1, -1))
    axes = _axes(problem.tree, rotation[0], configuration)
    centre = np.empty((len(problem.prior), 3))
    for joint in range(problem.tree.child.size):
        for dof in range(problem.tree.first[joint], problem.tree.first[joint + 1]):
            centre[dof] = origin[0, problem.tree.child[joint]]
    columns, index = np.empty((size, 3)), np.empty(size, dtype=np.int64)
    for k in range(len(target_m)):
        body, square = problem.body[k], 0.0
        for i in range(3):
            place[i] = origin[0, body, i]
            for j in range(3):
                place[i] += rotation[0, body, i, j] * problem.local_m[k, j]
            off[i], arm[i] = target_m[k, i] - place[i], place[i] - origin[0, 0, i]
            square += off[i] * off[i]
        if not np.isfinite(square):
            continue
        distance[k] = np.sqrt(square)
        cost += 0.5 * (robust_m / problem.sigma_m[k]) ** 2 * np.log1p(square / robust_m**2)
        weight = 1 / (problem.sigma_m[k] ** 2 * (1 + square / robust_m**2))
        count = _columns(problem, body, place, arm, axes, centre, columns, index)
        for a in range(count):
            along = columns[a, 0] * off[0] + columns[a, 1] * off[1] + columns[a, 2] * off[2]
            side[index[a]] += weight * along
            for b in range(a + 1):
                product = columns[a, 0] * columns[b, 0] + columns[a, 1] * columns[b, 1] + columns[a, 2] * columns[b, 2]
                matrix[index[a], index[b]] += weight * product
    cost += _add_priors(problem, configuration, matrix, side)
    for a in range(size):
        for b in range(a):
            matrix[b, a] = matrix[a, b]
    return cost, matrix, side, distance


@compiled
def _columns(
    problem: FitProblem,
    body: int,
    place: Vector,
    arm: Vector,
    axes: Vector,
    centre: Vector,
    columns: Vector,
    index: Indices,
) -> int:
    """Write how a marker moves with each unknown that moves its body, and which unknowns they are; their number."""
    count = 0
    for i in range(3):
        columns[count] = 0.0
        columns[count, i] = 1.0
        index[count] = count
        count += 1
    for i in range(3):  # e_i x arm
        one, two = (i + 1) % 3, (i + 2) % 3
        columns[count] = 0.0
        columns[count, two] = arm[one]
        columns[count, one] = -arm[two]
        index[count] = count
        count += 1
    for dof in range(len(problem.prior)):
        if problem.moves[body, dof]:
            for i in range(3):
                one, two = (i + 1) % 3, (i + 2) % 3
                columns[count, i] = axes[dof, one] * (place[two] - centre[dof, two]) - axes[dof, two] * (
                    place[one] - centre[dof, one]
                )
            index[count] = ROOT + dof
            count += 1
    return count


@compiled
def _add_priors(problem: FitProblem, configuration: Vector, matrix: Vector, side: Vector) -> float:
    """Add the priors and the walls behind the ranges of motion; half their weighted squares."""
    cost = 0.0
    for dof in range(len(problem.prior)):
        j, angle = ROOT + dof, configuration[7 + dof]
        matrix[j, j] += 1 / problem.prior_sigma[dof] ** 2
        side[j] += (problem.prior[dof] - angle) / problem.prior_sigma[dof] ** 2
        cost += 0.5 * ((angle - problem.prior[dof]) / problem.prior_sigma[dof]) ** 2
        if angle < problem.lower[dof] or angle > problem.upper[dof]:
            limit = min(max(angle, problem.lower[dof]), problem.upper[dof])
            matrix[j, j] += 1 / LIMIT_SIGMA_RAD**2
            side[j] += (limit - angle) / LIMIT_SIGMA_RAD**2
            cost += 0.5 * ((limit - angle) / LIMIT_SIGMA_RAD) ** 2
    return cost


@compiled
def _axes(tree: Tree, rotation: Vector, configuration: Vector) -> Vector:
    """The axes (39, 3) of all angles in the world."""
    axes = np.empty((tree.axis.size, 3))
    for joint in range(tree.child.size):
        turned = rotation[tree.parent[joint]].copy()
        for dof in range(tree.first[joint], tree.first[joint + 1]):
            axis = tree.axis[dof]
            for i in range(3):
                axes[dof, i] = tree.sign[dof] * turned[i, axis]
            angle = tree.sign[dof] * configuration[7 + dof]
            cosine, sine = np.cos(angle), np.sin(angle)
            one, two = (axis + 1) % 3, (axis + 2) % 3
            for i in range(3):
                a, b = turned[i, one], turned[i, two]
                turned[i, one] = cosine * a + sine * b
                turned[i, two] = cosine * b - sine * a
    return axes


@compiled
def _moved(configuration: Vector, step: NDArray[np.floating[Any]]) -> Vector:
    """The configuration after a step (45,): shift and turn of the root in world axes, and angles."""
    moved = configuration.copy()
    moved[:3] += step[:3]
    moved[7:] += step[6:]
    angle = np.sqrt((step[3:6] ** 2).sum())
    half = np.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    a, b, c, d = half * step[3], half * step[4], half * step[5], np.cos(angle / 2)
    x, y, z, w = configuration[3:7]
    moved[3] = d * x + a * w + b * z - c * y
    moved[4] = d * y - a * z + b * w + c * x
    moved[5] = d * z + a * y - b * x + c * w
    moved[6] = d * w - a * x - b * y - c * z
    moved[3:7] /= np.sqrt((moved[3:7] ** 2).sum())
    return moved

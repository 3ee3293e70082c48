"""The most likely motion behind postures that were found frame by frame: a Kalman smoother's, solved at once.

Every angle's jerk is taken for noise, as strong as the motion itself says and stronger where it changes, and every
frame's posture for known as well as its markers tell it, with what they confuse: where one joint's error is another's,
a smoother of single angles would take them for motion. The estimate is that of the smoothers of De Groote et al. (2008,
J Biomech 41:3390), with the strengths of noise and jerk by generalised maximum likelihood (Wahba 1985, Ann Stat
13:1378).
"""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded, solveh_banded
from scipy.optimize import minimize_scalar

from fatigue_planner.recordings.kinematics.frame_fit import ROBUST_M, ROOT, FitProblem, normal_equations
from fatigue_planner.recordings.kinematics.markers import SKIN_M

Vector = NDArray[np.float64]

# The third difference, and its products with itself shifted by 0 to 3 frames.
THIRD = np.array([-1.0, 3.0, -3.0, 1.0])
PRODUCTS = np.array([20.0, -15.0, 6.0, -1.0])
# Jerk against noise, as a decimal logarithm: from nothing but noise to none.
LOWEST, HIGHEST = -11, 6
# Cameras see markers no better than this (precision of a Vicon system: Windolf 2008, J Biomech 41:2776).
CAMERA_M = 1.5e-5
# Frames are smoothed in blocks, each with so many on both sides beside it.
BLOCK, BESIDE = 1000, 200
# Distances that are left of markers follow each other by less than this (lag-one correlation) if they are noise.
FOLLOWS = 0.5


def moves_on_skin(distance_m: Vector) -> bool:
    """Whether distances (n, k) m that are left of markers come from skin over bones, or lengths, not from noise."""
    off = distance_m - np.nanmean(distance_m, axis=0)
    seen = np.isfinite(off[1:]) & np.isfinite(off[:-1])
    products = np.where(seen, off[1:] * off[:-1], 0.0).sum(axis=0)
    squares = np.where(seen, (off[1:] ** 2 + off[:-1] ** 2) / 2, 0.0).sum(axis=0)
    visible = np.sqrt(squares / np.maximum(seen.sum(axis=0), 1)) > CAMERA_M
    return bool(visible.any() and np.median(products[visible] / squares[visible]) > FOLLOWS)


def smoothed(problem: FitProblem, configuration: Vector, targets_m: Vector) -> Vector:
    """The most likely configurations (n, 46), from those of single frames and their markers (n, k, 3) m."""
    if len(configuration) < 2 * len(THIRD):
        return configuration
    coordinates, middle = _coordinates(configuration)
    known = np.array(
        [normal_equations(problem, *one, ROBUST_M)[1] for one in zip(configuration, targets_m, strict=True)]
    )
    turn = np.tile(np.eye(known.shape[1]), (len(known), 1, 1))
    turn[:, 3:ROOT, 3:ROOT] = [pin.Jexp3(vector).T for vector in coordinates[:, 3:ROOT]]
    known = turn.transpose(0, 2, 1) @ known @ turn
    jerk, noise = np.array([jerk_and_noise(column) for column in coordinates.T]).T
    spread = np.linalg.inv(known).diagonal(axis1=1, axis2=2).mean(axis=0)
    scale = max(float(np.median(noise / spread)), (CAMERA_M / SKIN_M) ** 2)
    known = known / scale
    jerk = np.maximum(jerk, 10.0**LOWEST * scale * spread)
    found = np.empty_like(coordinates)
    for start in range(0, len(found), BLOCK):
        first, end = max(0, start - BESIDE), min(len(found), start + BLOCK + BESIDE)
        own = slice(start - first, min(start + BLOCK, len(found)) - first)
        steady = np.tile(jerk, (end - first - len(THIRD) + 1, 1))
        part = _solved(known[first:end], steady, coordinates[first:end])
        # once more, with Cauchy's weights, as motions change in jerks; in more rounds noise is taken for them
        sudden = (steady + np.diff(part, len(THIRD) - 1, axis=0) ** 2) / 2
        found[start : start + BLOCK] = _solved(known[first:end], sudden, coordinates[first:end])[own]
    return _configurations(found, middle)


def jerk_and_noise(series: Vector) -> tuple[float, float]:
    """The variances of a series' (n,) third differences and of the white noise on it that make it most likely."""
    third = np.diff(series, len(THIRD) - 1)
    unit, count = float(third.std()), len(third)
    if unit == 0:
        return 0.0, 0.0
    third = third / unit
    bands = np.tile(PRODUCTS[:, None], (1, count))

    def squares(ratio: float) -> tuple[float, float]:
        own = bands.copy()
        own[0] += 10**ratio
        factor = cholesky_banded(own, lower=True, check_finite=False)
        mean = float(third @ cho_solve_banded((factor, True), third, check_finite=False)) / count
        return mean, count * np.log(mean) + 2 * float(np.log(factor[0]).sum())

    tried = range(LOWEST, HIGHEST + 1)
    best = min(tried, key=lambda ratio: squares(ratio)[1])
    ratio = minimize_scalar(
        lambda x: squares(x)[1], bounds=(best - 1, best + 1), method="bounded", options={"xatol": 0.05}
    ).x
    noise = squares(ratio)[0] * unit**2
    return float(10**ratio * noise), noise


def _solved(known: Vector, jerk: Vector, coordinates: Vector) -> Vector:
    """Coordinates (n, m) between frames, known (n, m, m), and the least third differences, by jerk (n - 3, m)."""
    count, size = coordinates.shape
    bands = np.zeros((3 * size + 1, count * size))
    for column in range(size):
        for row in range(column, size):
            bands[row - column, column::size] += known[:, row, column]
    third = np.diff(coordinates, len(THIRD) - 1, axis=0) / jerk
    side = np.zeros_like(coordinates)
    for i in range(len(THIRD)):
        side[i : count - 3 + i] -= THIRD[i] * third
        for k in range(i, len(THIRD)):
            lag = np.zeros_like(coordinates)
            lag[i : count - 3 + i] = THIRD[i] * THIRD[k] / jerk
            bands[(k - i) * size] += lag.ravel()
    off = solveh_banded(bands, side.ravel(), lower=True, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return np.asarray(coordinates + off.reshape(count, size))


def _coordinates(configuration: Vector) -> tuple[Vector, pin.Quaternion]:
    """Position, turn from the middle frame's (a rotation vector, unbroken up to a whole turn) and angles (n, 45)."""
    turns = configuration[:, 3:7].copy()
    signs = np.sign(np.einsum("ij,ij->i", turns[1:], turns[:-1]))
    turns[1:] *= np.cumprod(np.where(signs < 0, -1.0, 1.0))[:, None]
    middle = pin.Quaternion(turns[len(turns) // 2].copy())
    vectors = np.empty((len(turns), 3))
    for frame, turn in enumerate(turns):
        x, y, z, w = (pin.Quaternion(turn.copy()) * middle.conjugate()).coeffs()
        sine = np.sqrt(x * x + y * y + z * z)
        vectors[frame] = np.array([x, y, z]) * (2 * np.arctan2(sine, w) / sine if sine > 1e-12 else 2.0)
    return np.concatenate([configuration[:, :3], vectors, configuration[:, 7:]], axis=1), middle


def _configurations(coordinates: Vector, middle: pin.Quaternion) -> Vector:
    """Configurations (n, 46) of coordinates (n, 45)."""
    turns = [(pin.Quaternion(pin.exp3(vector)) * middle).coeffs() for vector in coordinates[:, 3:ROOT]]
    return np.concatenate([coordinates[:, :3], np.array(turns), coordinates[:, ROOT:]], axis=1)

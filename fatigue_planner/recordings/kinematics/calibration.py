"""A person's own lengths, and where on him the markers are: postures and places in turns, over some frames.

With the postures fixed, every marker's position is linear in the lengths, in its place on its body and in the root's
shift; one linear least-squares problem with Gaussian priors finds all of them, then the postures are found again.
A static trial, in which the person stands as in his stance, decides where the angles are zero.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.human.joint_data import posture
from fatigue_planner.human.kinematics import Tree, poses_of, tree_of
from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import BODIES, JOINTS, without_side
from fatigue_planner.recordings.kinematics.frame_fit import FitProblem, fit_frames, fit_problem
from fatigue_planner.recordings.kinematics.markers import SKIN_M, Markers
from fatigue_planner.recordings.kinematics.measured import SEGMENTS, STRETCHED, Measured

Vector = NDArray[np.float64]

FRAMES, STATIC_FRAMES, ROUNDS = 40, 5, 12
# Lengths differ from those of the stature by so much (SD of segments as shares of stature, about 5 %).
FACTOR_SIGMA = 0.05
# In a static trial angles are those of the stance to within this.
STATIC_SIGMA_RAD = np.radians(4.0)
DONE_M = 1e-5


@dataclass(frozen=True)
class Calibration:
    """A person's lengths, the markers on him, and what distance was left in the frames used, RMS in m."""

    person: Measured
    markers: Markers
    stance: Vector
    rms_m: float

    def problem(self, markers: Markers | None = None) -> FitProblem:
        """The problem of fitting a frame with these of the markers; all, if not given."""
        own = markers or self.markers
        return fit_problem(self.person, list(own.bodies), own.local_m, own.sigma_m, self.stance)


def calibrate(worker: Worker, markers: Markers, targets_m: Vector, static_m: Vector | None = None) -> Calibration:
    """The calibration from frames (n, k, 3) m of a motion and, if there is one, of a static trial, of the same markers.

    Raises RecordingError if too little is seen.
    """
    stance = posture(worker.natural_posture_deg, "natural_posture_deg")
    chosen = _spread(targets_m, FRAMES)
    frames = targets_m[chosen]
    still = np.empty((0, *frames.shape[1:])) if static_m is None else static_m[_spread(static_m, STATIC_FRAMES)]
    person = Measured(worker.height_m, worker.mass_kg, worker.sex, worker.human)
    nominal, own = markers, markers
    root = first_root(markers, frames[0] if not len(still) else still[0])
    start = np.concatenate([root, stance])
    last = np.inf
    rms = 0.0
    for _ in range(ROUNDS):
        anchored = _problem(person, own, stance, np.full(len(stance), STATIC_SIGMA_RAD))
        standing, left = fit_frames(anchored, start, still)
        fitted, distance = fit_frames(_problem(person, own, stance, None), standing[0] if len(still) else start, frames)
        fitted, distance = np.concatenate([standing, fitted]), np.concatenate([left, distance])
        rms = float(np.sqrt(np.nanmean(distance**2)))
        if last - rms < DONE_M:
            break
        last, start = rms, fitted[0]
        good = np.nanmean(distance, axis=1) <= 2 * np.median(np.nanmean(distance, axis=1))  # the others went astray
        person, own = _linear(person, own, nominal, fitted[good], np.concatenate([still, frames])[good])
    if "c7" in own.landmarks:
        above = own.local_m[own.landmarks.index("c7"), 2]
        person = replace(person, cervicale_m=float(person.above_hip("thorax") + above))
    return Calibration(person, own.at(own.local_m), stance, rms)


def _problem(person: Measured, markers: Markers, stance: Vector, sigma: Vector | None) -> FitProblem:
    return fit_problem(person, list(markers.bodies), markers.local_m, markers.sigma_m, stance, sigma)


def _spread(targets_m: Vector, most: int) -> list[int]:
    """Frames spread evenly over those in which most markers are seen. Raises RecordingError if there is none."""
    seen = np.isfinite(targets_m).all(axis=2).mean(axis=1)
    good = np.flatnonzero(seen >= min(0.8, seen.max(initial=0.0)))
    if not len(good) or seen.max() == 0:
        raise RecordingError("no frame shows enough markers to calibrate.")
    return [int(good[i]) for i in np.unique(np.linspace(0, len(good) - 1, most).round().astype(int))]


def first_root(markers: Markers, target_m: Vector) -> Vector:
    """Position and quaternion (7,) of the pelvis where its markers are, upright (the person faces x)."""
    own = [i for i, body in enumerate(markers.bodies) if body == "pelvis" and np.isfinite(target_m[i]).all()]
    own = own or [i for i in range(len(markers.bodies)) if np.isfinite(target_m[i]).all()]
    middle = target_m[own].mean(axis=0) - markers.local_m[own].mean(axis=0)
    return np.concatenate([middle, [0.0, 0.0, 0.0, 1.0]])


def _linear(
    person: Measured, own: Markers, nominal: Markers, configurations: Vector, targets_m: Vector
) -> tuple[Measured, Markers]:
    """Lengths and places that are best for given orientations of all bodies."""
    usual = replace(person, factors=(1.0,) * len(SEGMENTS))
    by_factor, fixed = _positions(usual, own, configurations)
    rotation = poses_of(tree_of(person), configurations).rotation
    frames, count = targets_m.shape[:2]
    size = len(SEGMENTS) + 3 * count + 3 * frames
    matrix, side = np.zeros((size, size)), np.zeros(size)
    index = [BODIES.index(body) for body in own.bodies]
    for frame in range(frames):
        shift = len(SEGMENTS) + 3 * count + 3 * frame
        for k in range(count):
            off = targets_m[frame, k] - fixed[frame, k]
            if not np.isfinite(off).all():
                continue
            columns = np.concatenate([by_factor[frame, k], rotation[frame, index[k]], np.eye(3)], axis=1)
            place = len(SEGMENTS) + 3 * k
            where = [*range(len(SEGMENTS)), *range(place, place + 3), *range(shift, shift + 3)]
            matrix[np.ix_(where, where)] += columns.T @ columns / SKIN_M**2
            side[where] += columns.T @ off / SKIN_M**2
    prior = np.concatenate([np.ones(len(SEGMENTS)), nominal.local_m.ravel(), np.zeros(3 * frames)])
    sigma = np.concatenate(
        [np.full(len(SEGMENTS), FACTOR_SIGMA), np.repeat(nominal.place_sigma_m, 3), np.full(3 * frames, 1.0)]
    )
    matrix[np.diag_indices(size)] += sigma**-2.0
    found = np.linalg.solve(matrix, side + prior / sigma**2)
    factors = tuple(float(value) for value in found[: len(SEGMENTS)])
    local = found[len(SEGMENTS) : len(SEGMENTS) + 3 * count].reshape(-1, 3)
    return replace(person, factors=factors), own.at(local)


def _positions(usual: Measured, markers: Markers, configurations: Vector) -> tuple[Vector, Vector]:
    """What every factor adds to each body's origin, (n, k, 3, 7), and the part that none decides, (n, k, 3)."""
    tree: Tree = tree_of(usual)
    rotation = poses_of(tree, configurations).rotation
    by_factor = np.zeros((len(configurations), len(BODIES), 3, len(SEGMENTS)))
    fixed = np.zeros((len(configurations), len(BODIES), 3))
    fixed[:, 0] = configurations[:, :3]
    for index, joint in enumerate(JOINTS):
        parent, child = tree.parent[index], tree.child[index]
        by_factor[:, child], fixed[:, child] = by_factor[:, parent], fixed[:, parent]
        stretched = dict(STRETCHED[without_side(joint.name)])
        for axis in range(3):
            along = rotation[:, parent, :, axis] * tree.centre_m[index, axis]
            if axis in stretched:
                by_factor[:, child, :, SEGMENTS.index(stretched[axis])] += along
            else:
                fixed[:, child] += along
    bodies = [BODIES.index(body) for body in markers.bodies]
    return by_factor[:, bodies], fixed[:, bodies]

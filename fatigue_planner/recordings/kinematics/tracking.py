"""The posture of every frame of a recording, with short gaps bridged and every frame's error kept."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM
from fatigue_planner.recordings.inference.gaps import BRIDGED_S
from fatigue_planner.recordings.kinematics.calibration import Calibration, first_root
from fatigue_planner.recordings.kinematics.frame_fit import fit_frames
from fatigue_planner.recordings.kinematics.markers import Markers
from fatigue_planner.recordings.kinematics.smoothing import moves_on_skin, smoothed

Vector = NDArray[np.float64]

# Zero-lag Butterworth filter of what is not noise, but skin that moves over bones; the field's cut-off (Winter 2009).
SKIN_HZ = 6.0
# Frames on both sides of a gap that a curve through it follows.
AROUND = 3


@dataclass(frozen=True)
class Track:
    """Postures over time: configurations (n, 46) as of a `Human`, and what distance is left of every marker.

    distance_m (n, k): NaN where a marker was not seen; unseen_s: for how long, at most, each body with markers had
    none, after gaps were bridged; cutoff_hz: what the motion is still to be filtered with (see `dynamics.movement`):
    None where markers are noisy only, as the postures are then the smoother's (see `kinematics.smoothing`).
    """

    rate_hz: float
    configuration: Vector
    labels: tuple[str, ...]
    distance_m: Vector
    bridged: int
    unseen_s: dict[str, float]
    cutoff_hz: float | None = SKIN_HZ

    @property
    def rms_m(self) -> Vector:
        """Root mean square of the distances in every frame, (n,) m; NaN where no marker was seen."""
        seen = np.isfinite(self.distance_m).sum(axis=1)
        squares = np.nansum(self.distance_m**2, axis=1)
        return np.asarray(np.sqrt(np.where(seen > 0, squares, np.nan) / np.maximum(seen, 1)))

    @property
    def marker_rms_m(self) -> dict[str, float]:
        """Root mean square over the frames, by label."""
        seen = np.maximum(np.isfinite(self.distance_m).sum(axis=0), 1)
        return dict(zip(self.labels, np.sqrt(np.nansum(self.distance_m**2, axis=0) / seen).tolist(), strict=True))


def track(calibration: Calibration, markers: Markers, points_m: Vector, rate_hz: float) -> Track:
    """The postures of frames (n, k, 3) m of calibrated markers."""
    bridged, count = _bridged(points_m, rate_hz)
    start = np.concatenate([first_root(markers, bridged[_first(bridged)]), calibration.stance])
    problem = calibration.problem(markers)
    configuration, distance = fit_frames(problem, start, bridged)
    skin = moves_on_skin(distance)
    if not skin:
        configuration = smoothed(problem, configuration, bridged)
    if not {"neck", "head"} & set(markers.bodies):
        configuration = _looking_ahead(calibration, configuration)
    distance[~np.isfinite(points_m).all(axis=2)] = np.nan
    seen = np.asarray(np.isfinite(bridged).all(axis=2))
    unseen = {
        body: longest_run(~seen[:, [own == body for own in markers.bodies]].any(axis=1)) / rate_hz
        for body in BODIES
        if body in markers.bodies
    }
    return Track(rate_hz, configuration, markers.labels, distance, count, unseen, SKIN_HZ if skin else None)


def _looking_ahead(calibration: Calibration, configuration: Vector) -> Vector:
    """With an unmarked head upright, as far as neck and head go: people keep it so while the trunk leans (Pozzo 1990).

    It is turned to where the chest is; both joints take half of what the trunk leans.
    """
    own = configuration.copy()
    turn = poses_of(tree_of(calibration.person), own).rotation[:, BODIES.index("thorax")]
    # turn = Rz(heading) Ry(lean) Rx(side), which head and neck undo
    lean, side = -np.arcsin(np.clip(turn[:, 2, 0], -1, 1)), np.arctan2(turn[:, 2, 1], turn[:, 2, 2])
    lower, upper = position_limits()
    for way, off in (("flexion", lean), ("lateral", side)):
        neck, head = (DEGREES_OF_FREEDOM.index(f"{part}_{way}") for part in ("neck", "head"))
        own[:, 7 + head] = np.clip(-off / 2, lower[head], upper[head])
        own[:, 7 + neck] = np.clip(-off - own[:, 7 + head], lower[neck], upper[neck])
    return own


def longest_run(flags: Any) -> int:
    """The length of the longest run of True in flags (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _first(points_m: Vector) -> int:
    """The first frame in which as many markers are seen as in any."""
    return int(np.isfinite(points_m).all(axis=2).sum(axis=1).argmax())


def _bridged(points_m: Vector, rate_hz: float) -> tuple[Vector, int]:
    """Points with gaps of up to 0.2 s filled by cubic curves through what is around them, and how many positions."""
    filled, count = points_m.copy(), 0
    most = int(BRIDGED_S * rate_hz + 1e-9)
    for k in range(points_m.shape[1]):
        seen = np.flatnonzero(np.isfinite(points_m[:, k]).all(axis=1))
        for before in np.flatnonzero((np.diff(seen) > 1) & (np.diff(seen) <= most + 1)):
            own = seen[max(0, before + 1 - AROUND) : before + 1 + AROUND]
            gap = np.arange(seen[before] + 1, seen[before + 1])
            filled[gap, k] = CubicSpline(own, points_m[own, k])(gap)
            count += len(gap)
    return filled, count

"""Plates: which way they push, in which axes, and the mass of who stands on them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.text import counted
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.recordings.content import Plate, Remark
from fatigue_planner.recordings.inference.finding import Finding
from fatigue_planner.recordings.inference.units import METRES
from fatigue_planner.recordings.recording import GroundForce

Vector = NDArray[np.float64]

# Somebody stands still on the plates if their sum stays within this share for so long, and moves on the spot if its
# means over so long do. A change of speed by 0.5 m/s in 2 s is 2.5 % of the weight.
STILL_SHARE, STILL_S = 0.02, 0.5
ON_THE_SPOT_SHARE, ON_THE_SPOT_S = 0.05, 2.0
LEAST_WEIGHT_N = 300.0  # less is somebody who sits or leans on something
# Forces below are nobody's; a mean beyond the other limit while nobody is there is a plate that drifts.
IDLE_N, DRIFT_N = 20.0, 3.0
# A mass given and the plates' may differ by this share.
MASS_AGREES = 0.03


def ground_forces(
    plates: Sequence[Plate], rotation: Vector, metres: float
) -> tuple[tuple[GroundForce, ...], list[Finding], list[Remark]]:
    """What plates do to the person about the world's origin, z up; all are turned round if they show what he does.

    rotation (3, 3): from the file's axes; metres: of the file's unit of length.
    """
    scale = [METRES.get((plate.unit or "").lower(), metres) for plate in plates]
    force = [plate.force_n @ rotation.T for plate in plates]
    moment = [
        (plate.moment + np.cross(plate.origin, plate.force_n)) * own @ rotation.T
        for plate, own in zip(plates, scale, strict=True)
    ]
    corners = [
        None if plate.corners is None else plate.corners * own @ rotation.T
        for plate, own in zip(plates, scale, strict=True)
    ]
    kinds = [plate.kind for plate in plates if plate.kind is not None]
    findings = [Finding("plates", str(len(plates)), f"types {sorted(kinds)}" if kinds else "columns of forces")]
    remarks = []
    up = np.nansum([one[:, 2] for one in force])
    loaded = max(float(np.nanmax(abs(one[:, 2]), initial=0.0)) for one in force) > IDLE_N
    if not loaded:
        remarks.append(Remark(10, "nobody presses on the plates."))
    elif up < 0:
        force, moment = [-one for one in force], [-one for one in moment]
        remarks.append(Remark(10, "plates show the person's push, downwards; they are turned round."))
    for number, one in enumerate(force, 1):
        if not np.isfinite(one).all():
            remarks.append(
                Remark(
                    10, f"plate {number} has no force at {counted(int((~np.isfinite(one)).any(1).sum()), 'sample')}."
                )
            )
        idle = abs(one[:, 2]) < IDLE_N
        if loaded and idle.mean() > 0.05 and abs(drift := float(one[idle, 2].mean())) > DRIFT_N:
            remarks.append(Remark(11, f"plate {number} shows {drift:+.1f} N while nobody is on it."))
    return tuple(map(GroundForce, force, moment, corners)), findings, remarks


def body_mass(
    ground: Sequence[GroundForce], rate_hz: float, given_kg: float | None
) -> tuple[list[Finding], list[Remark]]:
    """The mass of who stands still on the plates, with nothing else to lean on, and whether it is the one given."""
    total = np.sum([plate.force_n[:, 2] for plate in ground], axis=0)
    weight, source = _weight(total, rate_hz)
    if weight is None:
        told = "unknown" if given_kg is None else f"{given_kg:g} kg"
        return [Finding("mass", told, source if given_kg is None else "given")], []
    mass = weight / GRAVITY_MPS2
    if given_kg is None:
        return [Finding("mass", f"{mass:.1f} kg", f"the plates, {source}")], []
    off = mass / given_kg - 1
    told = (
        f"the plates show {mass:.1f} kg, {100 * off:+.0f} %: something else carries or is carried, or a mass is wrong."
    )
    return [Finding("mass", f"{given_kg:g} kg", "given")], [Remark(11, told)] if abs(off) > MASS_AGREES else []


def _weight(total: Vector, rate_hz: float) -> tuple[float | None, str]:
    """The weight that the plates carry, N, and how it is known, or why it is not."""
    still = [
        window for window in _windows(total, STILL_S, rate_hz) if np.ptp(window) < STILL_SHARE * abs(window.mean())
    ]
    means = np.array([window.mean() for window in still])
    if means.size and (highest := float(np.percentile(means, 90))) > LEAST_WEIGHT_N:
        # where a chair or a hand carries a part, less is shown
        return float(np.median(means[means > (1 - STILL_SHARE) * highest])), "standing still"
    means = np.array([window.mean() for window in _windows(total, ON_THE_SPOT_S, rate_hz)])
    if means.size and total.min() > 0 and np.ptp(means) < 2 * ON_THE_SPOT_SHARE * means.mean():
        return float(total.mean()), "mean over a motion on the spot"
    return None, "nobody stands on them, still or on the spot"


def _windows(total: Vector, duration_s: float, rate_hz: float) -> Vector:
    width = max(2, round(duration_s * rate_hz))
    if len(total) < width:
        return np.empty((0, width))
    return np.lib.stride_tricks.sliding_window_view(total, width)[:: max(1, width // 4)]

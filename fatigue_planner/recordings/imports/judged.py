"""How good a recording is, phase by phase, and what is to be known of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.text import listing, percent
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.schedule import phases_of, runs_of
from fatigue_planner.reactions.recorded import MAX_LABEL, PhaseQuality, RecordedQuality, largest_load
from fatigue_planner.recordings.content import Remark
from fatigue_planner.recordings.dynamics import Movement, Torques
from fatigue_planner.recordings.imports import contacts
from fatigue_planner.recordings.imports.contacts import on_one_plate, planted, soles_m
from fatigue_planner.recordings.imports.phases import Bounds
from fatigue_planner.recordings.kinematics.markers import Markers, unmarked_joints
from fatigue_planner.recordings.kinematics.measured import Measured
from fatigue_planner.recordings.kinematics.tracking import Track, longest_run
from fatigue_planner.recordings.recording import GroundForce, Recording

Vector = NDArray[np.float64]
Flags = NDArray[np.bool_]

# What a filter makes of the ends of a recording is no motion.
ENDS_S = 0.2
# Loads that plates show and that are given may differ by so much.
LOAD_KG = 1.0


@dataclass(frozen=True)
class Evidence:
    """What a recording is judged by, frame by frame: postures, markers, forces."""

    person: Measured
    track: Track
    markers: Markers
    torques: Torques
    ground: Sequence[GroundForce]
    other: Flags  # where something unmeasured carries


def quality_of(evidence: Evidence, request: MotionRequest, motion: Motion, bounds: Bounds) -> RecordedQuality:
    """How good the recording is within its bounds, and what that makes of the motion."""
    assumed = unmarked_joints(evidence.markers.shown)
    held = {
        side: max(
            run.right_kg if side == "right" else run.left_kg
            for run in runs_of(request.tool, request.action, motion.phases)
        )
        for side in SIDES
        if f"{side}_wrist" in assumed
    }
    share, joint = largest_load(request.maximum_torque, motion)
    return RecordedQuality(
        phases=tuple(
            _phase(evidence, phase, bounds.of(index), motion.time_step_s) for index, phase in enumerate(motion.phases)
        ),
        work_hand_error_m=float(motion.hand_error_m[motion.phase("work")].mean()),
        assumed_joints=assumed,
        wrist_load_kg=max(held.values(), default=0.0),
        largest_load_share=share,
        largest_load_joint=joint,
        length_factors=evidence.person.factors,
    )


def remarks_of(
    recording: Recording,
    evidence: Evidence,
    request: MotionRequest,
    movement: Movement,
    found: Sequence[contacts.Contact],
    bounds: Bounds,
    plate_lag_s: float,
) -> list[Remark]:
    """What a user should know of contacts (faults 12 and 13), loads (11), and of lags and ends (15)."""
    remarks = []
    if bounds.begin_s < ENDS_S or bounds.end_s > recording.duration_s - ENDS_S:
        remarks.append(
            Remark(
                15, f"a phase comes within {ENDS_S:g} s of an end of the recording, where a filter bends what moves."
            )
        )
    ground, torques = evidence.ground, evidence.torques
    if not ground:
        return remarks
    soles = contacts.soles_m(evidence.person, movement.configuration)
    remarks += contacts.plate_remarks(ground, torques, contacts.planted(soles))
    shown = np.sum([plate.force_n[:, 2] for plate in ground], axis=0)
    lag = contacts.lag_s(shown, shown + torques.residual_force_n[:, 2], movement.rate_hz)
    if lag is not None and abs(lag) > max(contacts.LEAST_LAG_S, 0.5 / movement.rate_hz):
        remarks.append(
            Remark(
                15,
                f"the plates are {1000 * abs(lag):.0f} ms {'late' if lag > 0 else 'early'}; --plate-lag "
                f"{plate_lag_s + lag:.3f} sets that right.",
            )
        )
    phases = phases_of(request.cycle, request.controller.time_step_s)
    for index, phase in enumerate(phases):
        begin, end = (int(time * movement.rate_hz) for time in bounds.of(index))
        own = slice(begin, end + 1)
        other = evidence.other[own]
        if other.any():
            force = float(torques.residual_force_n[own][other, 2].mean())
            share = percent(float(other.mean()), 0)
            near = listing(
                sorted({one.body.replace("_", " ") for one in found if one.start <= end and one.stop > begin})
            )
            if force < 0:
                told = (
                    f"the plates show {-force / GRAVITY_MPS2:+.1f} kg beside body, tool and loads, near {near}, "
                    f"{share} of the time; what hands hold has to be said as a tool or a load"
                )
            else:
                told = f"something unmeasured near {near} carries {force:.0f} N on average, {share} of the time"
            remarks.append(Remark(13, f"{phase.name}: {told}; the phase counts as unmeasured."))
        elif abs(extra := -float(torques.residual_force_n[own, 2].mean()) / GRAVITY_MPS2) > LOAD_KG:
            remarks.append(Remark(11, f"{phase.name}: the plates show {extra:+.1f} kg beside body, tool and loads."))
    return remarks


def _phase(evidence: Evidence, phase: Phase, ends_s: tuple[float, float], time_step_s: float) -> PhaseQuality:
    track, torques, ground = evidence.track, evidence.torques, evidence.ground
    frames = slice(int(np.floor(ends_s[0] * track.rate_hz)), int(np.ceil(ends_s[1] * track.rate_hz)) + 1)
    distance = track.distance_m[frames]
    each = np.sqrt(_mean(distance**2, axis=0))
    worst = int(np.nan_to_num(each).argmax())
    gone = {
        body: longest_run(~np.isfinite(distance[:, [own == body for own in evidence.markers.bodies]]).any(axis=1))
        for body in dict.fromkeys(evidence.markers.bodies)
    }
    body = max(gone, key=lambda name: gone[name])
    soles = soles_m(evidence.person, track.configuration)
    on_ground = planted(soles)
    force = moment = carried = shared = None
    if ground:
        other = evidence.other[frames]
        own = ~other
        weight = evidence.person.mass_kg * GRAVITY_MPS2
        force = _rms(torques.residual_force_n[frames][own]) / weight
        moment = _rms(torques.residual_moment_nm[frames][own])
        carried, shared = float(other.mean()), float(on_one_plate(ground, on_ground)[frames].mean())
    pace = (phase.stop - phase.start) * time_step_s / (ends_s[1] - ends_s[0])
    return PhaseQuality(
        name=phase.name,
        from_s=float(ends_s[0]),
        to_s=float(ends_s[1]),
        marker_rms_m=float(np.sqrt(_mean(distance**2, axis=None))),
        worst_marker_m=float(np.nan_to_num(each)[worst]),
        worst_marker=track.labels[worst][:MAX_LABEL] if track.labels[worst].isprintable() else "",
        unseen_s=gone[body] / track.rate_hz,
        unseen_body=body if gone[body] else "",
        residual_force_share=force,
        residual_moment_nm=moment,
        unmeasured_share=carried,
        one_plate_share=shared,
        foot_slide_m=_slide(soles[frames], on_ground[frames]),
        stretch=float(max(pace, 1 / pace)),
    )


def _mean(values: Vector, axis: int | None) -> Vector:
    """The mean of what is finite; 0 where nothing is."""
    there = np.isfinite(values)
    return np.asarray(np.where(there, values, 0.0).sum(axis=axis) / np.maximum(there.sum(axis=axis), 1))


def _rms(vectors: Vector) -> float:
    """Root mean square of the lengths of vectors (n, 3); 0 of none."""
    return float(np.sqrt((vectors**2).sum(axis=1).mean())) if len(vectors) else 0.0


def _slide(soles: Vector, on_ground: Flags) -> float:
    """How far a foot (n, 2, 3) m goes from its usual place while it is on the ground, at most."""
    farthest = 0.0
    for foot in range(len(SIDES)):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], on_ground[:, foot].astype(int), [0]])))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            own = soles[start:stop, foot, :2]
            farthest = max(farthest, float(np.linalg.norm(own - np.median(own, axis=0), axis=1).max()))
    return farthest

"""`fatplan record import`: a recording of one reaction of an experiment, to be stored beside the simulated ones."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.core.files import DIGEST_LENGTH, digest_of, digests_of_package
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.payload import HandForce
from fatigue_planner.motion.schedule import phases_of, runs_of
from fatigue_planner.reactions import key as reaction_key
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.reactions.recorded import RecordedQuality
from fatigue_planner.recordings import dynamics
from fatigue_planner.recordings.content import Remark
from fatigue_planner.recordings.dynamics import Movement, Torques
from fatigue_planner.recordings.imports import contacts
from fatigue_planner.recordings.imports.judged import Evidence, quality_of, remarks_of
from fatigue_planner.recordings.imports.on_ticks import Course, fists_m, loaded, motion_of, origin_m
from fatigue_planner.recordings.imports.phases import Bounds, bounds_of, given_bounds
from fatigue_planner.recordings.inference.finding import Finding
from fatigue_planner.recordings.inference.interpret import Interpreted
from fatigue_planner.recordings.kinematics.calibration import Calibration, calibrate
from fatigue_planner.recordings.kinematics.markers import Markers, markers_of
from fatigue_planner.recordings.kinematics.measured import SEGMENTS, Measured
from fatigue_planner.recordings.kinematics.tracking import Track, track
from fatigue_planner.recordings.mapping import load_mapping
from fatigue_planner.recordings.recording import GroundForce, Recording

Vector = NDArray[np.float64]

# What makes a reaction of a recording, besides what makes a motion of settings.
SOURCES = (
    *reaction_key.SOURCES, "recordings/kinematics", "recordings/imports", "recordings/data", "recordings/dynamics.py",
    "recordings/mapping.py", "recordings/recording.py", "recordings/inference/gaps.py",
)  # fmt: skip


@dataclass(frozen=True)
class Imported:
    """A recorded reaction, the key by which an experiment names it, and all that was found on the way.

    origin_m: where the world's origin of the reaction is in the recording's world.
    """

    reaction: Reaction
    key: str
    bounds: Bounds
    calibration: Calibration
    track: Track
    torques: Torques
    movement: Movement
    ground: tuple[GroundForce, ...]
    origin_m: Vector
    findings: tuple[Finding, ...]
    remarks: tuple[Remark, ...]

    @property
    def quality(self) -> RecordedQuality:
        """How good the recording is."""
        assert isinstance(self.reaction.quality, RecordedQuality)
        return self.reaction.quality


def import_recording(
    name: ReactionName,
    request: MotionRequest,
    found: Interpreted,
    static: Interpreted | None = None,
    phases_s: Sequence[float] | None = None,
    plate_lag_s: float = 0.0,
) -> Imported:
    """The reaction that a recording shows, of the worker, the action and the cycle of a request.

    The hands hold what the request's tool and action say. Raises RecordingError if there is no posture, no reach or no
    return in it, or it cannot be used for such an action.
    """
    recording = found.recording
    _check_usable(recording, request)
    assert recording.points_m is not None
    calibration, own = _tracked(recording, found.mapping, request, static)
    person = calibration.person
    hands = [index for index, side in enumerate(SIDES) if side in request.action.goals()]
    if phases_s is None:
        bounds, source = (
            bounds_of(fists_m(person, own.configuration)[:, hands], own.rate_hz),
            "the working hand's speed",
        )
    else:
        bounds, source = given_bounds(phases_s, recording.duration_s), "given"
    movement = dynamics.movement(person.model(), own.configuration, own.rate_hz, own.cutoff_hz)
    plates = contacts.later(recording.ground, recording.ground_rate_hz, plate_lag_s)
    ground = dynamics.ground_at(plates, recording.ground_rate_hz, recording.frames, own.rate_hz, own.cutoff_hz)
    torques, wrench = _torques(person, request, movement, ground, bounds)
    origin = origin_m(person, own.configuration)
    motion = motion_of(person, request, Course(movement, torques.torque_nm, wrench), bounds, origin)
    found_contacts = contacts.unmeasured_contacts(person.model(), movement, torques)
    other = contacts.carried(found_contacts, recording.frames)
    evidence = Evidence(person, own, calibration.markers, torques, ground, other)
    quality = quality_of(evidence, request, motion, bounds)
    key = _key(found, static, bounds, plate_lag_s)
    findings = [
        Finding("calibration", f"markers within {1000 * calibration.rms_m:.1f} mm", _lengths(person)),
        Finding("phases", ", ".join(f"{time:.2f}" for time in bounds) + " s", source),
    ]
    remarks = remarks_of(recording, evidence, request, movement, found_contacts, bounds, plate_lag_s)
    reaction = Reaction(name, ReactionKey.of_recorded(request, key), motion, quality)
    return Imported(
        reaction,
        key,
        bounds,
        calibration,
        own,
        torques,
        movement,
        tuple(ground),
        origin,
        tuple(findings),
        tuple(remarks),
    )


def _check_usable(recording: Recording, request: MotionRequest) -> None:
    if recording.points_m is None:
        raise RecordingError("has no points in space; a reaction needs markers or segments, not angles alone.")
    if any(isinstance(load, HandForce) for load in request.action.loads):
        raise RecordingError(
            "the action has loads of kind force, which a recording does not show; say them as masses, or simulate it."
        )


def _tracked(
    recording: Recording, mapping: str | None, request: MotionRequest, static: Interpreted | None
) -> tuple[Calibration, Track]:
    worker = request.worker
    markers = markers_of(recording, mapping, worker.height_m)
    targets = _targets(recording, markers)
    still = None if static is None else _targets(static.recording, markers)
    if still is not None and not np.isfinite(still).any():
        raise RecordingError("the static trial has none of the motion's markers.")
    calibration = calibrate(worker, markers, targets, still)
    if static is not None and still is not None and static.recording.ground:
        calibration = _balanced(calibration, static.recording, still)
    return calibration, track(calibration, calibration.markers, targets, recording.rate_hz)


def _balanced(calibration: Calibration, static: Recording, still: Vector) -> Calibration:
    """The calibration with the trunk's mass where the plates of the static trial, with empty hands, show it."""
    stands = track(calibration, calibration.markers, still, static.rate_hz)
    motion = dynamics.movement(calibration.person.model(), stands.configuration, static.rate_hz, stands.cutoff_hz)
    ground = dynamics.ground_at(static.ground, static.ground_rate_hz, static.frames, static.rate_hz, stands.cutoff_hz)
    return replace(calibration, person=dynamics.balanced(calibration.person, motion, ground))


def _targets(recording: Recording, markers: Markers) -> Vector:
    """Where the markers are (n, k, 3) m; NaN for those that the recording does not have."""
    if recording.points_m is None:
        raise RecordingError("has no points in space.")
    missing = np.full((recording.frames, 1, 3), np.nan)
    points = np.concatenate([recording.points_m, missing], axis=1)
    return points[:, [recording.labels.index(one) if one in recording.labels else -1 for one in markers.labels]]


def _torques(
    person: Measured, request: MotionRequest, movement: Movement, ground: Sequence[GroundForce], bounds: Bounds
) -> tuple[Torques, Vector]:
    """Torques of all frames, and the wrenches on the soles, with what the hands hold in each phase."""
    phases = phases_of(request.cycle, request.controller.time_step_s)
    runs = runs_of(request.tool, request.action, phases)
    starts = {phase.start: bounds.of(index)[0] for index, phase in enumerate(phases)}
    frames = len(movement.configuration)
    begins = [0, *(int(np.ceil(starts[run.start] * movement.rate_hz)) for run in runs[1:]), frames]
    parts, wrenches = [], []
    for run, begin, end in zip(runs, begins[:-1], begins[1:], strict=True):
        own = slice(begin, end)
        model = loaded(person, run)
        moved = Movement(
            movement.rate_hz, movement.configuration[own], movement.velocity[own], movement.acceleration[own]
        )
        under = [GroundForce(plate.force_n[own], plate.moment_nm[own], plate.corners_m) for plate in ground]
        parts.append(dynamics.inverse_dynamics(model, moved, under))
        wrenches.append(contacts.sole_wrenches(model, moved, under, parts[-1]))
    joined = [np.concatenate([getattr(part, name) for part in parts]) for name in Torques.__dataclass_fields__]
    return Torques(*joined), np.concatenate(wrenches)


def _lengths(person: Measured) -> str:
    own = ", ".join(
        f"{name.replace('_', ' ')} {factor:.2f}" for name, factor in zip(SEGMENTS, person.factors, strict=True)
    )
    forward = person.trunk_forward_m
    balanced = f"; the trunk's mass {100 * forward:+.1f} cm forward, by the static trial's plates" if forward else ""
    return f"lengths as multiples of the stature's: {own}{balanced}"


def _key(found: Interpreted, static: Interpreted | None, bounds: Bounds, plate_lag_s: float) -> str:
    """The key of an import: the data of the files, what was said of them, and the program; nothing of a header."""
    parts = {
        "recording": found.recording.digest,
        "static": None if static is None else static.recording.digest,
        "mapping": None if found.mapping is None else load_mapping(found.mapping).plain(),
        "bounds_s": list(bounds),
        "plate_lag_s": plate_lag_s,
        "sources": digests_of_package(*SOURCES),
        "versions": reaction_key.versions(),
    }
    return digest_of(parts)[:DIGEST_LENGTH]

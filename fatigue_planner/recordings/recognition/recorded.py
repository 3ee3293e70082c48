"""Labelled repetitions from recordings: a table says who does what, how, in which file, and when.

Angles are taken where a file has those of the digital human's degrees of freedom, and found from markers otherwise.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed, shortened
from fatigue_planner.core.files import digest_of_bytes
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.formats.text import named_rows
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.kinematics.calibration import Calibration, calibrate
from fatigue_planner.recordings.kinematics.markers import markers_of
from fatigue_planner.recordings.kinematics.tracking import track
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, Growing, Repetitions
from fatigue_planner.recordings.recording import Recording

Array = NDArray[np.float64]

NEEDED = ("file", "person", "action", "preference")
INSTANTS = ("begins_s", "reached_s", "left_s", "ends_s")
OPTIONAL = (*INSTANTS, "static", "mapping")
MAX_ROWS = 10_000
# Markers this far from the body that was fitted to them, RMS, are no posture (OpenSim's evaluation checklist).
MAX_RMS_M = 0.02
# A marker that a radian moves by less than this is on the angle's axis, and says nothing of it: a centimetre is what
# skin moves over bones (assumed). Looked at in about so many postures, by differences of this step.
LEAST_MOVED_M, POSTURES, STEP_RAD = 0.01, 20, 1e-4


@dataclass(frozen=True)
class Label:
    """What a row says: somebody (a pseudonym) reacts to an action by a preference in a file.

    instants_s: of the file, when the reach begins, the target is reached, it is left, and the cycle ends. static: a
    file in which the person stands; mapping: of the labels of markers, by name or file.
    """

    line: int
    file: Path
    person: str
    action: str
    preference: str
    instants_s: tuple[float, float, float, float]
    static: Path | None
    mapping: str | None

    @property
    def name(self) -> str:
        """Who does what how."""
        return f"{self.person}/{self.action}/{self.preference}"


def read_labels(path: Path, actions: Sequence[str], preferences: Sequence[str], cycle: Cycle) -> list[Label]:
    """The rows of a table (CSV); files are named from its folder, and without instants the cycle's durations hold.

    Raises RecordingError: file, line, value, what is allowed.
    """
    labels = []
    for line, row in named_rows(path, NEEDED, OPTIONAL):
        for column, known in (("action", actions), ("preference", preferences)):
            if row[column] not in known:
                raise RecordingError(
                    f"{path}, line {line}: {column} = {shortened(row[column])}: should be one of {listed(known)}."
                )
        for column in ("file", "person"):
            if not row[column]:
                raise RecordingError(f"{path}, line {line}: {column} is empty.")
        given = [_number(path, line, name, row.get(name, "")) for name in INSTANTS]
        begins_s = given[0] or 0.0
        usual = begins_s + np.cumsum([0.0, cycle.reach_s, cycle.work_s, cycle.return_s])
        instants = [usual[i] if value is None else value for i, value in enumerate(given)]
        if any(later <= earlier for earlier, later in pairwise(instants)):
            raise RecordingError(
                f"{path}, line {line}: {', '.join(INSTANTS)} are {listed(f'{one:g}' for one in instants)}; each should "
                "be later than the one before."
            )
        static = row.get("static")
        labels.append(
            Label(
                line, path.parent / row["file"], row["person"], row["action"], row["preference"],
                (instants[0], instants[1], instants[2], instants[3]), path.parent / static if static else None,
                row.get("mapping") or None,
            )
        )  # fmt: skip
    if not labels:
        raise RecordingError(f"{path}: has no rows.")
    if len(labels) > MAX_ROWS:
        raise RecordingError(f"{path}: has {len(labels)} rows; at most {MAX_ROWS}.")
    return labels


def recorded(
    path: Path, labels: Sequence[Label], workers: Mapping[str, Worker], cycle: Cycle
) -> tuple[Repetitions, dict[str, str]]:
    """The repetitions of a table's labels, and the digest of the angles of each by who does what how and its number.

    workers: the bodies of those whose angles must be found from markers. Phases are stretched to the cycle's. Raises
    RecordingError, which names the table's line.
    """
    found: dict[tuple[Path, Path | None, str | None, str], tuple[Recording, Array]] = {}
    angles, digests = [], {}
    for number, label in enumerate(labels, 1):
        where = f"{path}, line {label.line}"
        key = label.file, label.static, label.mapping, label.person
        try:
            if key not in found:
                found[key] = _measured(label, workers)
            recording, measured = found[key]
            angles.append(_parts(recording, measured, label, cycle))
        except RecordingError as error:
            raise RecordingError(f"{where}: {error}") from error
        digests[f"{label.name}/{number}"] = digest_of_bytes(angles[-1].tobytes())
    people, actions, preferences = np.array([(one.person, one.action, one.preference) for one in labels]).T
    return Repetitions(people, actions, preferences, np.array(angles)), digests


def _measured(label: Label, workers: Mapping[str, Worker]) -> tuple[Recording, Array]:
    """The recording of a row, and its angles (frames, all degrees of freedom) in degrees, NaN where none was seen."""
    found = read_recording(label.file, given=Given(mapping=label.mapping))[1]
    recording = found.recording
    angles = np.full((recording.frames, len(DEGREES_OF_FREEDOM)), np.nan)
    if recording.angles is not None:
        own = dict(zip(recording.angles.names, recording.angles.value.T, strict=True))
        known = [name for name in DEGREES_OF_FREEDOM if name in own]
        if not known:
            raise RecordingError(
                f"{label.file}: its angles are {listed(own)}; should be degrees of freedom of the digital human: "
                f"{listed(DEGREES_OF_FREEDOM)}."
            )
        for name in known:
            angles[:, DEGREES_OF_FREEDOM.index(name)] = np.degrees(own[name])
        return recording, angles
    if label.person not in workers:
        raise RecordingError(
            f"person = {shortened(label.person)}: angles are found from markers of a body that is known; the "
            f"experiment's workers are {listed(workers)}."
        )
    if recording.points_m is None:
        raise RecordingError(f"{label.file}: holds neither markers nor angles.")
    return recording, _from_markers(label, recording, found.mapping, workers[label.person])


def _from_markers(label: Label, recording: Recording, mapping: str | None, worker: Worker) -> Array:
    """Angles (frames, all degrees of freedom) in degrees of somebody with this body, by inverse kinematics."""
    markers, still = markers_of(recording, mapping, worker.height_m), None
    if label.static is not None:
        standing = read_recording(label.static, given=Given(mapping=label.mapping))[1].recording
        markers, own = markers.of(standing.labels)
        still = None if standing.points_m is None else standing.points_m[:, own]
    markers, own = markers.of(recording.labels)
    assert recording.points_m is not None
    targets = recording.points_m[:, own]
    calibration = calibrate(worker, markers, targets, still)
    found = track(calibration, calibration.markers, targets, recording.rate_hz)
    rms_m = float(np.sqrt(np.nanmean(found.distance_m**2)))
    if rms_m > MAX_RMS_M:
        raise RecordingError(
            f"{label.file}: markers are {100 * rms_m:.1f} cm (RMS) from the body that was fitted to them; at most "
            f"{100 * MAX_RMS_M:.0f} cm. Are mapping and person right?"
        )
    angles = np.degrees(found.configuration[:, 7:])
    is_seen = np.isfinite(found.distance_m)
    postures = found.configuration[:: max(1, recording.frames // POSTURES)]
    moved_m = moved_by_angles_m(calibration, postures)
    angles[~(is_seen @ (moved_m > LEAST_MOVED_M))] = np.nan  # no marker that was seen is moved by this angle
    return angles


def moved_by_angles_m(calibration: Calibration, configurations: Array) -> Array:
    """How far each marker (k) is moved by each angle, in m per rad, in that of the postures where it is moved most."""
    tree, markers = tree_of(calibration.person), calibration.markers

    def positions(postures: Array) -> Array:
        poses = poses_of(tree, postures)
        places = zip(markers.bodies, markers.local_m, strict=True)
        return np.stack([poses.points(body, at) for body, at in places], axis=1)

    before, moved = positions(configurations), []
    for dof in range(len(DEGREES_OF_FREEDOM)):
        turned = configurations.copy()
        turned[:, 7 + dof] += STEP_RAD
        moved.append(np.linalg.norm(positions(turned) - before, axis=2).max(axis=0) / STEP_RAD)
    return np.stack(moved, axis=1)


def _parts(recording: Recording, angles_deg: Array, label: Label, cycle: Cycle) -> Array:
    """The mean angles (N_PARTS, J) of a repetition, whose phases are stretched to those of the cycle."""
    times = np.arange(recording.frames) / recording.rate_hz
    begins, ends = label.instants_s[0], label.instants_s[-1]
    if begins < 0 or ends > times[-1] + 1.5 / recording.rate_hz:
        raise RecordingError(f"{label.file}: lasts {times[-1]:g} s; the cycle is from {begins:g} to {ends:g} s.")
    inside = (times >= begins) & (times < ends)
    of_cycle = np.cumsum([0.0, cycle.reach_s, cycle.work_s, cycle.return_s])
    growing = Growing(cycle, angles_deg.shape[1])
    growing.add(np.interp(times[inside], label.instants_s, of_cycle), angles_deg[inside])
    parts = growing.parts(of_cycle[-1])
    assert len(parts) == N_PARTS
    if not np.isfinite(parts).all(axis=0).any():
        raise RecordingError(f"{label.file}: of no angle was every part of the cycle measured.")
    return parts


def _number(path: Path, line: int, column: str, text: str) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordingError(f"{path}, line {line}: {column} = {shortened(text)}: should be a time in s.")
    return value

"""From what a file says to a recording: everything it leaves open is inferred, told, and refused if it contradicts."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed, shortened
from fatigue_planner.recordings.content import Content, Points, Remark, Segments
from fatigue_planner.recordings.inference import axes
from fatigue_planner.recordings.inference.finding import Finding, Given
from fatigue_planner.recordings.inference.gaps import gap_remarks, jump_remarks, without_zeros
from fatigue_planner.recordings.inference.labels import named_points
from fatigue_planner.recordings.inference.plates import body_mass, ground_forces
from fatigue_planner.recordings.inference.rate import frame_rate
from fatigue_planner.recordings.inference.units import unit_of_length
from fatigue_planner.recordings.mapping import Mapping, Place, choose_mapping, landmark_table, load_mapping, plain_label
from fatigue_planner.recordings.recording import GroundForce, Recording

Vector = NDArray[np.float64]

MAX_NEAREST = 10
# The first frame of an animation is a T-pose if the body is this much farther from it than in any other step.
CALIBRATION_JUMP = 10.0


@dataclass(frozen=True)
class Interpreted:
    """A recording, what was found of it, what a user should know, and the mapping that knows its labels, if any."""

    recording: Recording
    findings: tuple[Finding, ...]
    remarks: tuple[Remark, ...]
    mapping: str | None


def interpret(content: Content, given: Given) -> Interpreted:
    """The recording that a file's content is.

    Raises RecordingError if it contradicts itself or what is given, or leaves open what cannot be inferred.
    """
    remarks, findings = list(content.remarks), []
    content, dropped = _without_calibration(content)
    rate, finding = frame_rate(content.times_s, content.stated_rate_hz, given.rate_hz)
    findings.append(finding)
    points = _all_points(content)
    mapping_name, places = None, {}
    if points is not None:
        points, found, told = named_points(points, given.prefix)
        findings, remarks = findings + found, remarks + dropped + told
        points, told = without_zeros(points)
        remarks += told
        if not points.labels:
            raise RecordingError("no point is ever seen.")
        mapping_name, found, told = _mapped(points, given.mapping)
        findings, remarks = findings + found, remarks + told
        if given.exchange_sides:
            points = _exchanged(points, mapping_name)
            findings.append(Finding("sides", "left and right of all labels exchanged", "given"))
        places = _places(points, mapping_name)
    axis = _long_axis(points, places)
    metres = 1.0  # of OpenSim's own tables
    if points is not None or given.units is not None:
        stature = None if axis is None else axis[1] * landmark_table().stature_m
        metres, finding = unit_of_length(content.unit, given.units, stature)
        findings.append(finding)
    up, found = _up(content, axis, given.up)
    findings += found
    turn = axes.upright(up)
    if points is not None:
        points = Points(points.labels, points.position * metres @ turn.T)
        heading, found = _heading(points, places, rate, given.heading_deg)
        findings += found
        turn = _about_z(-heading) @ turn
        points = Points(points.labels, points.position @ _about_z(-heading).T)
        remarks += gap_remarks(points, rate) + jump_remarks(points, rate)
    ground: tuple[GroundForce, ...] = ()
    ground_rate = 0.0
    if content.plates:
        ground, found, told = ground_forces(content.plates, turn, metres)
        samples = content.plate_times_s
        ground_rate = rate if len(samples) == len(content.times_s) else (len(samples) - 1) / float(np.ptp(samples))
        mass, warned = body_mass(ground, ground_rate, given.mass_kg)
        findings, remarks = findings + found + mass, remarks + told + warned
    recording = Recording(
        rate_hz=rate,
        frames=len(content.times_s),
        labels=() if points is None else points.labels,
        points_m=None if points is None else points.position,
        segments=None if content.segments is None else _turned(content.segments, turn, metres),
        angles=content.angles,
        ground=ground,
        ground_rate_hz=ground_rate,
    )
    return Interpreted(recording, tuple(findings), tuple(remarks), mapping_name)


def _all_points(content: Content) -> Points | None:
    """The origins of segments, and the points on them."""
    if content.segments is None:
        return content.points
    origins = Points(content.segments.names, content.segments.position)
    if (on := content.points) is None:
        return origins
    return Points(origins.labels + on.labels, np.concatenate([origins.position, on.position], axis=1))


def _without_calibration(content: Content) -> tuple[Content, list[Remark]]:
    """The content without a first frame in which the figure stands in a pose far from all others (BVH)."""
    if content.segments is None or content.format != "BVH" or len(content.times_s) < 3:
        return content, []
    relative = content.segments.position - content.segments.position[:, :1]
    step = np.linalg.norm(np.diff(relative, axis=0), axis=2).mean(axis=1)
    if step[0] <= CALIBRATION_JUMP * max(step[1:].max(), 1e-9):
        return content, []
    segments = content.segments
    rest = replace(segments, position=segments.position[1:], rotation=segments.rotation[1:])
    return replace(content, segments=rest, times_s=content.times_s[1:]), [
        Remark(8, "the first frame is a pose of calibration; it is left out.")
    ]


def _mapped(points: Points, given: str | None) -> tuple[str | None, list[Finding], list[Remark]]:
    """The mapping that knows the labels, and those it does not know with the nearest that it does."""
    name = given or choose_mapping(points.labels)
    if name is None:
        told = f"no mapping that ships knows its labels, such as {listed(points.labels[:3])}; see --mapping."
        return None, [], [Remark(3, told)]
    mapping = load_mapping(name)
    unknown = [label for label in points.labels if mapping.place(label) is None]
    source = f"knows {len(points.labels) - len(unknown)} of {len(points.labels)} labels"
    findings = [Finding("mapping", name, f"given; {source}" if given else source)]
    remarks = []
    if unknown:
        near = [f"{shortened(label)}{_hint(mapping, label)}" for label in unknown[:MAX_NEAREST]]
        more = f", … ({len(unknown)} in all)" if len(unknown) > MAX_NEAREST else ""
        remarks.append(Remark(3, f"labels that the mapping does not know: {', '.join(near)}{more}."))
    if missing := mapping.missing(points.labels):
        remarks.append(Remark(5, f"no point is on {listed(missing)}."))
    return name, findings, remarks


def _hint(mapping: Mapping, label: str) -> str:
    near = mapping.nearest(label)
    return f" (like {near}?)" if near else ""


def _places(points: Points, mapping: str | None) -> dict[int, Place]:
    if mapping is None:
        return {}
    known = load_mapping(mapping)
    return {index: place for index, label in enumerate(points.labels) if (place := known.place(label))}


def _exchanged(points: Points, mapping: str | None) -> Points:
    """The points by the labels of the other side. Raises RecordingError if no mapping says which those are."""
    if mapping is None:
        raise RecordingError(
            "no mapping knows its labels, so none says which is on which side; say one with --mapping."
        )
    known = load_mapping(mapping)
    spelt = {plain_label(label): label for label in points.labels}
    twins = [known.across(label) for label in points.labels]
    return Points(tuple(spelt.get(twin, twin) for twin in twins), points.position)


def _up(content: Content, axis: tuple[Vector, float] | None, given: str | None) -> tuple[str, list[Finding]]:
    """The axis that is up. Raises RecordingError if it is unknown, or the body is upside down."""
    shown = None if axis is None else axes.axis_name(axis[0])
    said = given or content.up
    if said is not None:
        if said.lower() not in axes.AXES:
            raise RecordingError(f"the axis {shortened(said)} is none; say which is up with --up, such as +y.")
        source = "given" if given else "the file"
        if shown is not None and shown != said.lower():
            raise RecordingError(
                f"{said} is up ({source}), but by its labels the body stands along {shown}. Say which is right with "
                "--up, or check the mapping."
            )
        return said.lower(), [Finding("up", said.lower(), source + (", and the body" if shown else ""))]
    if shown is not None:
        return shown, [Finding("up", shown, "from feet to head")]
    push = np.sum([np.nansum(plate.force_n, axis=0) for plate in content.plates], axis=0)
    if content.plates and (shown := axes.axis_name(push)):
        return f"+{shown[1]}", [Finding("up", f"+{shown[1]}", "the plates")]
    if content.points is None and content.segments is None:
        return "+z", []  # nothing to turn
    raise RecordingError("does not say which axis is up, and no body shows it. Say it with --up, such as +y.")


def _long_axis(points: Points | None, places: dict[int, Place]) -> tuple[Vector, float] | None:
    if points is None or len(places) < axes.LEAST_POINTS:
        return None
    return axes.long_axis(points.position[:, list(places)], axes.standing_m(list(places.values())))


def _heading(
    points: Points, places: dict[int, Place], rate_hz: float, given_deg: float | None
) -> tuple[float, list[Finding]]:
    found = axes.facing(points.position[:, list(places)], list(places.values()), rate_hz) if places else None
    if given_deg is not None:
        return float(np.radians(given_deg)), [Finding("heading", f"{given_deg:g}° from x, turned to x", "given")]
    if found is None:
        return 0.0, [Finding("heading", "unknown", "no point has its twin on the other side")]
    heading, confirmed = found
    source = "left is left, and fronts are in front" if confirmed else "left is left; nothing shows the front"
    return heading, [Finding("heading", f"{np.degrees(heading):.0f}° from x, turned to x", source)]


def _about_z(angle: float) -> Vector:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _turned(segments: Segments, turn: Vector, metres: float) -> Segments:
    rest = None if segments.rest is None else segments.rest * metres @ turn.T
    return Segments(segments.names, segments.position * metres @ turn.T, turn @ segments.rotation, rest)

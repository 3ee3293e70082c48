"""MVNX: the poses of an Xsens suit's segments and the bony points on them, as XML of versions 3 and 4."""

import io
import math
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, shortened
from fatigue_planner.recordings.content import Content, Points, Remark, Segments
from fatigue_planner.recordings.formats.text import number

Vector = NDArray[np.float64]
MAX_SEGMENTS, MAX_POINTS = 200, 500  # MVN has 23 and, of bony points, some 70
# Poses that are no part of the motion: N-pose, T-pose and identity, as the suit was calibrated.
_CALIBRATION = {"npose", "tpose", "identity", "tpose-isb"}


def _check_plain(content: bytes) -> None:
    """Raise RecordingError for XML that could stand for more than it is."""
    if b"\0" in content[:1000] or content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise RecordingError("is not in UTF-8, as MVNX files are.")
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise RecordingError("declares a document type or entities; MVNX files have none.")


def read_mvnx(content: bytes) -> Content:
    """The segments of an MVNX file and their bony points, if it has any; x forward, z up, m. Raises RecordingError."""
    _check_plain(content)
    names: list[str] = []
    fixed: list[tuple[str, int, list[float]]] = []  # points: label, segment, place in the segment's frame
    times: list[float] = []
    rows: list[tuple[list[float], list[float]]] = []
    rate, dropped = math.nan, 0
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(content)):
            match element.tag.rpartition("}")[2]:
                case "segment" if element.get("label"):
                    fixed += [(label, len(names), place) for label, place in _bony_points(element)]
                    names.append(str(element.get("label")))
                case "subject":
                    rate = number(element.get("frameRate", ""), 0)
                case "frame":
                    if _number(element, "index") < 0 or (element.get("type") or "normal").lower() in _CALIBRATION:
                        dropped += 1
                    else:
                        times.append(_number(element, "time") / 1000)  # in ms
                        rows.append((_numbers(element, "orientation"), _numbers(element, "position")))
                    element.clear()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise RecordingError(f"is not well-formed XML ({error}).") from error
    if not names or not rows:
        raise RecordingError(f"has {len(names)} segments and {len(rows)} frames of a motion.")
    if len(names) > MAX_SEGMENTS or len(set(names)) < len(names):
        raise RecordingError(f"names {len(names)} segments, some of them twice, or more than {MAX_SEGMENTS}.")
    if len(fixed) > MAX_POINTS:
        raise RecordingError(f"names {len(fixed)} points; more than {MAX_POINTS} are too many.")
    turns, places = (_array(rows, which, per, len(names)) for which, per in ((0, 4), (1, 3)))
    found = np.array(times)
    if np.isnan(found).any():
        if not rate > 0:
            raise RecordingError("says neither the times of its frames nor subject frameRate.")
        found = np.arange(len(rows)) / rate
    remarks = (Remark(8, f"{dropped} frames of calibration poses are left out."),) if dropped else ()
    segments = Segments(tuple(names), places, _rotation(turns))
    points = _moved(segments, fixed) if fixed else None
    return Content("MVNX", found, rate if rate > 0 else None, "m", "+z", points, segments, remarks=remarks)


def _bony_points(segment: ElementTree.Element) -> Iterator[tuple[str, list[float]]]:
    """The label and the place of each point of a segment but joints (j...), which are the origins of other segments."""
    for point in segment.iter():
        label = point.get("label", "")
        if point.tag.rpartition("}")[2] != "point" or label.startswith("j"):
            continue
        try:
            place = [number(word, 0) for word in _text(point, "pos_b", "pos_s").split()]
        except RecordingError:
            place = []
        if len(place) != 3 or not all(map(math.isfinite, place)):
            raise RecordingError(f"point {shortened(label)}: its place should be three numbers.")
        yield label, place


def _moved(segments: Segments, fixed: list[tuple[str, int, list[float]]]) -> Points:
    """Where points that are fixed to segments are in the world."""
    own = [segment for _, segment, _ in fixed]
    place = np.array([place for *_, place in fixed])
    return Points(
        tuple(label for label, *_ in fixed),
        segments.position[:, own] + np.einsum("nkij,kj->nki", segments.rotation[:, own], place),
    )


def _number(element: ElementTree.Element, key: str) -> float:
    try:
        return number(element.get(key, ""), 0)
    except RecordingError:
        raise RecordingError(f"frame {key} = {shortened(element.get(key))} is not a number.") from None


def _numbers(frame: ElementTree.Element, key: str) -> list[float]:
    text, where = _text(frame, key), f"frame {frame.get('index')}: {key}"
    if not text:
        raise RecordingError(f"{where} is missing.")
    try:
        return [number(word, 0) for word in text.split()]
    except RecordingError:
        raise RecordingError(f"{where} has what is not a number.") from None


def _text(element: ElementTree.Element, *names: str) -> str:
    """The text of an element's first child that is called so; empty if there is none."""
    found = (child.text for child in element if child.tag.rpartition("}")[2] in names)
    return next(found, None) or ""


def _array(rows: list[tuple[list[float], list[float]]], which: int, per: int, segments: int) -> Vector:
    lengths = {len(row[which]) for row in rows}
    if lengths != {per * segments}:
        raise RecordingError(f"a frame has {sorted(lengths)[0]} numbers, not {per} for each of {segments} segments.")
    return np.array([row[which] for row in rows]).reshape(len(rows), segments, per)


def _rotation(quaternion: Vector) -> Vector:
    """Rotations (n, s, 3, 3) from quaternions (n, s, 4), w first. Raises RecordingError where one is none."""
    length = np.linalg.norm(quaternion, axis=-1)
    if not (abs(length - 1) < 0.01).all():
        frame = int((~(abs(length - 1) < 0.01)).any(axis=1).argmax())
        raise RecordingError(f"the orientations of frame {frame + 1} are not unit quaternions.")
    w, x, y, z = np.moveaxis(quaternion / length[..., None], -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

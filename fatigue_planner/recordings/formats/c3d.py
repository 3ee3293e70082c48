"""C3D: markers and plates of motion laboratories, read by ezc3d or, where that refuses, by c3d; both are compared."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import MissingExtraError, RecordingError, listed, shortened
from fatigue_planner.core.reading_process import ReadingProcess, UnreadableError
from fatigue_planner.core.text import counted
from fatigue_planner.recordings.content import Content, Plate, Points, Remark

# CPU time to read a file: at least, and for every byte; sound files take a hundredth of it.
LEAST_SECONDS, SECONDS_PER_BYTE = 3.0, 5e-7
# What a C3D file has as its second byte, after the block at which its parameters begin.
MARK = 0x50

Vector = NDArray[np.float64]
Reader = Literal["ezc3d", "c3d"]
_PROCESS = ReadingProcess(Path(__file__).with_name("c3d_script.py"), "C3D files")


def read_c3d(content: bytes, reader: Reader | None = None) -> Content:
    """The points and plates of a C3D file, by `reader` or by the one that can read it.

    Raises RecordingError if neither can, or if they differ and none is chosen; MissingExtraError without them.
    """
    if find_spec("ezc3d") is None or find_spec("c3d") is None:
        raise MissingExtraError("C3D files need ezc3d and c3d: pip install 'fatigue-planner[recordings]'.")
    if len(content) < 512 or content[1] != MARK:
        raise RecordingError("does not begin as a C3D file does.")
    request = {"reader": reader, "most_seconds": LEAST_SECONDS + SECONDS_PER_BYTE * len(content)}
    try:
        answer, arrays = _PROCESS.read(content, request)
    except UnreadableError as error:
        raise RecordingError(f"{error}.") from error
    about = answer["about"]
    if difference := about.get("difference"):
        raise RecordingError(f"{_told(difference)} Look which is right, and choose it with --reader.")
    position, *of_plates = arrays
    remarks = [Remark(14, f"{name} refuses it ({why}).") for name, why in about["refused"].items()]
    points = _points(about, position, remarks)
    types = about["plate_types"] if len(about["plate_types"]) == len(about["plates"]) else [None] * len(about["plates"])
    plates = tuple(
        Plate(
            force,
            moment,
            np.tile(corners.mean(axis=0), (len(force), 1)),
            told["moment_unit"][1:] or None,
            corners,
            kind,
        )
        for told, kind, force, moment, corners in zip(
            about["plates"], types, of_plates[::3], of_plates[1::3], of_plates[2::3], strict=True
        )
        if len(force)
    )
    if about["no_plates"]:
        remarks.append(Remark(10, f"the plates are not read ({about['no_plates']})."))
    rate = about["rate"] if 0 < about["rate"] < 1e6 else None
    if rate is None:
        raise RecordingError("says no frame rate (POINT:RATE); a C3D file has no times.")
    count = len(position)
    samples = {len(plate.force_n) for plate in plates}
    if len(samples) > 1:
        raise RecordingError(f"its plates have different numbers of samples: {sorted(samples)}.")
    per_frame = samples.pop() / count if samples else 1.0
    return Content(
        format=f"C3D ({about['reader']})",
        times_s=np.arange(count) / rate,
        stated_rate_hz=rate,
        unit=about["unit"] or None,
        up=about["up"].lower() or None,
        points=points,
        plates=plates,
        plate_times_s=np.arange(round(count * per_frame)) / (rate * per_frame) if plates else np.empty(0),
        remarks=tuple(remarks),
    )


def _told(difference: dict[str, float]) -> str:
    if "apart" in difference:
        how = f"by up to {difference['apart']:.3g} in the file's unit"
    elif "missing" in difference:
        how = f"in what is missing, at {difference['missing']:.1%} of the points"
    else:
        how = "in how many points and frames there are"
    return f"two readers, ezc3d and c3d, read it without complaint and differ {how}."


def _points(about: dict[str, Any], position: Vector, remarks: list[Remark]) -> Points:
    """The points that are points, every one with a label of its own."""
    labels, count = about["labels"], position.shape[1]
    if len(labels) != count:
        remarks.append(Remark(4, f"{counted(len(labels), 'label')} for {counted(count, 'point')}."))
    labels = [*labels[:count], *("" for _ in range(count - len(labels)))]
    labels = [label or f"point {index + 1}" for index, label in enumerate(labels)]
    kinds = {label: kind for kind, named in about["no_points"].items() for label in named if label}
    if dropped := [label for label in labels if label in kinds]:
        named = listed(f"{shortened(label)} ({kinds[label].lower()})" for label in dropped)
        remarks.append(Remark(7, f"no points in space, left out: {named}."))
    keep = [index for index, label in enumerate(labels) if label not in kinds]
    return Points(tuple(labels[index] for index in keep), position[:, keep])

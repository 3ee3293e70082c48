"""Recordings for tests: a small figure with known truth, written in every format; and the folder of real files."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fatigue_planner.recordings.inference.axes import standing_m
from fatigue_planner.recordings.mapping import Place, load_mapping

Vector = NDArray[np.float64]

# Labels of Plug-in Gait, enough for all inferences.
LABELS = (
    "C7", "CLAV", "STRN", "LSHO", "RSHO", "LELB", "RELB", "LASI", "RASI", "LPSI", "RPSI", "LKNE", "RKNE", "LANK",
    "RANK", "LHEE", "RHEE", "LTOE", "RTOE",
)  # fmt: skip
HIP_HEIGHT_M = 0.94
Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # from z up: y up, z to the right


def real(name: str) -> Path:
    """A real file; the test is skipped where `FATPLAN_RECORDINGS` names no folder of them."""
    folder = os.environ.get("FATPLAN_RECORDINGS", "")
    path = Path(folder) / name
    if not folder or not path.exists():
        pytest.skip("FATPLAN_RECORDINGS names no folder of recordings")
    return path


def places() -> list[Place]:
    found = [load_mapping("plug_in_gait").place(label) for label in LABELS]
    return [place for place in found if place is not None]


def figure(frames: int = 40, heading: float = 0.0) -> Vector:
    """Markers (n, k, 3) m, z up, of somebody who stands, sways and bobs a little, facing `heading` rad from x."""
    phase = np.linspace(0, 2 * np.pi, frames)[:, None, None]
    body = standing_m(places()) + np.array([0, 0, HIP_HEIGHT_M])
    sway = 0.02 * np.sin(phase) * body[:, 2:] * np.array([1.0, 0.5, 0])
    moved = body + sway + 0.03 * (1 - np.cos(phase)) * np.array([0, 0, 1.0])
    c, s = np.cos(heading), np.sin(heading)
    return np.asarray(moved @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))


def trc(
    position: Vector,
    labels: Sequence[str] = LABELS,
    rate: float = 100.0,
    unit: str | None = "m",
    header: Mapping[str, object] | None = None,
    end: str = "\n",
) -> bytes:
    """A TRC file; what `header` says replaces its own."""
    count = len(position)
    keys: dict[str, object] = {"DataRate": rate, "CameraRate": rate, "NumFrames": count, "NumMarkers": len(labels)}
    keys |= {"Units": unit or "", "OrigDataRate": rate, "OrigDataStartFrame": 1, "OrigNumFrames": count}
    keys |= header or {}
    lines = ["PathFileType\t4\t(X/Y/Z)\ttest.trc", "\t".join(keys), "\t".join(map(str, keys.values()))]
    lines += ["Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t", "\t\t" + "\t".join(f"X{i}\tY{i}\tZ{i}" for i in range(len(labels)))]  # fmt: skip  # noqa: E501
    for frame, row in enumerate(position.reshape(count, -1)):
        cells = ["" if np.isnan(value) else repr(float(value)) for value in row]
        lines.append("\t".join([str(frame + 1), f"{frame / rate:.6f}", *cells]))
    return end.join([*lines, ""]).encode()


def csv_markers(position: Vector, labels: Sequence[str] = LABELS, rate: float = 100.0, unit: str = "m") -> bytes:
    head = ",".join(["time_s", *(f"{label}_{axis}_{unit}" for label in labels for axis in "xyz")])
    rows = [
        ",".join([f"{frame / rate:.6f}", *("" if np.isnan(value) else repr(float(value)) for value in row)])
        for frame, row in enumerate(position.reshape(len(position), -1))
    ]
    return "\n".join([head, *rows, ""]).encode()


def c3d_file(
    path: Path,
    position: Vector,
    labels: Sequence[str] = LABELS,
    rate: float = 100.0,
    unit: str = "mm",
    groups: Mapping[str, Sequence[str]] | None = None,
    subject: str = "",
) -> Path:
    """A C3D file, written by ezc3d; `groups` are parameters of POINT such as ANGLES."""
    ezc3d = pytest.importorskip("ezc3d")
    written = ezc3d.c3d()
    written["parameters"]["POINT"]["RATE"]["value"] = [rate]
    written["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    written["parameters"]["POINT"]["UNITS"]["value"] = [unit] if unit else []
    for name, listed in (groups or {}).items():
        written.add_parameter("POINT", name, list(listed))
    if subject:
        written.add_parameter("SUBJECTS", "NAMES", [subject])
        written.add_parameter("SUBJECT", "DATE_OF_BIRTH", ["1970-01-02"])
    points = np.ones((4, position.shape[1], len(position)))
    points[:3] = position.transpose(2, 1, 0)
    written["data"]["points"] = points
    written.write(str(path.with_suffix(".c3d")))
    return path.with_suffix(".c3d").rename(path)


def mot(columns: Mapping[str, Vector], rate: float = 100.0, header: Sequence[str] = ("inDegrees=yes",)) -> bytes:
    count = len(next(iter(columns.values())))
    lines = ["test", "version=1", f"nRows={count}", f"nColumns={len(columns) + 1}", *header, "endheader"]
    lines.append("\t".join(["time", *columns]))
    table = np.column_stack([np.arange(count) / rate, *columns.values()])
    lines += ["\t".join("" if np.isnan(value) else repr(float(value)) for value in row) for row in table]
    return "\n".join([*lines, ""]).encode()


def plate_columns(vertical_n: Vector, sign: float = 1.0, at: Sequence[float] = (0.1, 0.0, -0.2)) -> dict[str, Vector]:
    """Columns of a plate, y up, that carries these forces."""
    flat = np.zeros_like(vertical_n)
    force = {"vx": flat, "vy": sign * vertical_n, "vz": flat}
    point = {f"p{axis}": np.full_like(flat, value) for axis, value in zip("xyz", at, strict=True)}
    moment = {f"m{axis}": flat for axis in "xyz"}
    return {f"ground_force_1_{name}": values for name, values in (force | point | moment).items()}


BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
%s
}
MOTION
Frames: %d
Frame Time: 0.01
%s
"""


def bvh(frames: int = 6, order: str = "Zrotation Xrotation Yrotation", values: Sequence[float] = (10, 20, 30)) -> bytes:
    """A figure in cm, y up, that faces z; its left knee turns by `values` in this order."""

    def limb(side: str, sign: float, channels: str) -> str:
        knee = f"JOINT {side}Leg {{\n OFFSET 0 -43 0\n CHANNELS 3 {channels}\n JOINT {side}Foot {{\n OFFSET 0 -43 0\n CHANNELS 3 {order}\n JOINT {side}ToeBase {{\n OFFSET 0 -5 14\n CHANNELS 3 {order}\n End Site\n {{\n OFFSET 0 0 5\n }}\n }}\n }}\n }}"  # noqa: E501
        return f"JOINT {side}UpLeg {{\n OFFSET {9 * sign} 0 0\n CHANNELS 3 {order}\n {knee}\n }}"

    spine = f"JOINT Spine {{\n OFFSET 0 10 0\n CHANNELS 3 {order}\n JOINT Neck {{\n OFFSET 0 40 0\n CHANNELS 3 {order}\n JOINT Head {{\n OFFSET 0 10 0\n CHANNELS 3 {order}\n End Site\n {{\n OFFSET 0 20 0\n }}\n }}\n }}\n }}"  # noqa: E501
    body = "\n".join([limb("Left", 1, order), limb("Right", -1, order), spine]).replace(" {", "\n{")
    row = [0.0, 94.0, 0.0, 0.0, 0.0, 0.0] + [0.0] * 3 + list(map(float, values)) + [0.0] * (3 * 9)
    return (BVH % (body, frames, "\n".join([" ".join(map(str, row))] * frames))).encode()


def mvnx(
    position: Vector,
    names: Sequence[str],
    rate: float = 60.0,
    version: int = 4,
    turns: Vector | None = None,
    points: Mapping[str, tuple[str, Vector]] | None = None,
) -> bytes:
    """An MVNX file after one frame of calibration; turns (n, s, 4), w first: none, if not given.

    points: of each label the segment and the place there (3,) m.
    """
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(position), len(names), 1))
    key = "pos_b" if version >= 4 else "pos_s"
    segments = ""
    for index, name in enumerate(names):
        own = "".join(
            f'<point label="{label}"><{key}>{words(place)}</{key}></point>'
            for label, (segment, place) in (points or {}).items()
            if segment == name
        )
        joint = f'<point label="j{name}"><{key}>0 0 0</{key}></point>'
        segments += f'<segment label="{name}" id="{index + 1}"><points>{joint}{own}</points></segment>'
    frames = [frame_of("npose", "", "0", upright[0], np.zeros_like(position[0]))]
    frames += [
        frame_of("normal", str(index), f"{1000 * index / rate:.3f}", turn, row)
        for index, (turn, row) in enumerate(zip(upright if turns is None else turns, position, strict=True))
    ]
    return (
        f'<?xml version="1.0"?><mvnx xmlns="http://www.xsens.com/mvn/mvnx" version="{version}">'
        f'<subject label="Jane Doe" frameRate="{rate:g}"><segments>{segments}</segments>'
        f"<frames>{''.join(frames)}</frames></subject></mvnx>"
    ).encode()


def words(values: Vector) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def frame_of(kind: str, index: str, time_ms: str, turn: Vector, position: Vector) -> str:
    return (
        f'<frame time="{time_ms}" index="{index}" type="{kind}"><orientation>{words(turn)}</orientation>'
        f"<position>{words(position)}</position></frame>"
    )

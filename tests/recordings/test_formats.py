"""Every format gives the numbers that were written; every fault of a file has its message."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from recorded import LABELS, bvh, c3d_file, csv_markers, figure, mot, mvnx, plate_columns, trc

from fatigue_planner.core.errors import MissingExtraError, RecordingError
from fatigue_planner.recordings.content import Content, Remark
from fatigue_planner.recordings.formats import c3d
from fatigue_planner.recordings.formats.bvh import read_bvh
from fatigue_planner.recordings.formats.csv_table import read_csv
from fatigue_planner.recordings.formats.mot import read_mot
from fatigue_planner.recordings.formats.mvnx import read_mvnx
from fatigue_planner.recordings.formats.registry import read_content
from fatigue_planner.recordings.formats.trc import read_trc
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import interpret

POSITION = figure(12)
POSITION[3:5, 2] = np.nan


def text(content: bytes) -> str:
    return content.decode()


def points(content: Content) -> tuple[tuple[str, ...], np.ndarray]:
    assert content.points is not None
    return content.points.labels, content.points.position


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_trc(end: str) -> None:
    found = read_trc(trc(POSITION, end=end))
    labels, position = points(found)
    assert (labels, found.unit, found.stated_rate_hz, found.remarks) == (LABELS, "m", 100.0, ())
    np.testing.assert_array_equal(position, POSITION)


@pytest.mark.parametrize("spelled", ["NaN", "nan", "-NAN", "1.#QNAN", "-1.#IND000", "nan(ind)", " "])
def test_all_spellings_of_nothing_are_missing_points(spelled: str) -> None:
    lines = text(trc(POSITION)).split("\n")
    cells = lines[5].split("\t")
    lines[5] = "\t".join([*cells[:2], spelled, spelled, spelled, *cells[5:]])
    _, position = points(read_trc("\n".join(lines).encode()))
    assert np.isnan(position[0, 0]).all() and np.isfinite(position[0, 1:]).all()


def test_numbers_with_exponents_and_names_two_columns_apart() -> None:
    lines = text(trc(POSITION)).split("\n")
    lines[3] = "Frame#\tTimes\t\t" + "\t\t".join(LABELS)  # as some programs write them
    lines[5] = "\t".join(f"{float(cell):.6E}" for cell in lines[5].split("\t"))
    labels, position = points(read_trc("\n".join(lines).encode()))
    assert labels == LABELS
    np.testing.assert_allclose(position[0], POSITION[0], rtol=1e-5)


def test_csv_of_markers_and_of_angles() -> None:
    found = read_csv(csv_markers(POSITION, unit="mm"))
    assert points(found)[0] == LABELS and found.unit == "mm"
    np.testing.assert_array_equal(points(found)[1], POSITION)
    angles = read_csv(
        b"time_s;knee_flexion_deg;hip_flexion_rad;pelvis_m\n0;90;1;0.9\n0.1;45;;1\n".replace(b"_z_m", b"_m")
    )
    assert angles.angles is not None and angles.angles.names == ("knee_flexion", "hip_flexion", "pelvis")
    np.testing.assert_allclose(angles.angles.value, [[np.pi / 2, 1, 0.9], [np.pi / 4, np.nan, 1]])


def test_c3d(tmp_path: Path) -> None:
    angles = ("LKneeAngles",)
    stored = np.concatenate([POSITION * 1000, np.full((12, 1, 3), 30.0)], axis=1)
    path = c3d_file(tmp_path / "walk.C3D", stored, [*LABELS, *angles], groups={"ANGLES": angles}, subject="Jane Doe")
    found = read_content(path)
    labels, position = points(found)
    assert (labels, found.unit, found.stated_rate_hz) == (LABELS, "mm", 100.0)
    np.testing.assert_allclose(position, POSITION * 1000, atol=1e-3)
    (remark,) = found.remarks
    assert remark.fault == 7 and "LKneeAngles' (angles)" in remark.text
    assert "Jane" not in repr(found) and "1970" not in repr(found)  # nor anything else of SUBJECT


def test_labels_and_points_that_do_not_match() -> None:
    for count, last, told in (
        (17, ("point 18", "point 19"), "17 labels for 19 points"),
        (25, LABELS[-2:], "25 labels for"),
    ):
        remarks: list[Remark] = []
        labels = [*LABELS, *"abcdef"][:count]
        found = c3d._points({"labels": labels, "no_points": {}}, POSITION, remarks)
        assert found.labels[-2:] == last and told in remarks[0].text and remarks[0].fault == 4


def test_c3d_needs_its_libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = c3d_file(tmp_path / "walk.c3d", POSITION * 1000)
    monkeypatch.setattr(c3d, "find_spec", lambda _: None)
    with pytest.raises(MissingExtraError, match=r"pip install 'fatigue-planner\[recordings\]'"):
        read_content(path)


def test_a_c3d_file_that_takes_long_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = c3d_file(tmp_path / "long.c3d", np.tile(POSITION * 1000, (400, 1, 1)))
    monkeypatch.setattr(c3d, "LEAST_SECONDS", 1e-3)
    monkeypatch.setattr(c3d, "SECONDS_PER_BYTE", 0.0)
    with pytest.raises(RecordingError, match=r"long\.c3d: takes too long to read"):
        read_content(path)
    monkeypatch.undo()
    assert len(read_content(path).times_s) == 4800


def test_bvh_turns_in_the_order_of_its_channels() -> None:
    """Against rotation matrices multiplied by hand: the foot hangs 43 cm below a knee that is turned."""
    x, y, z = np.radians([20.0, 30.0, 10.0])
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    orders = {
        "Zrotation Xrotation Yrotation": ((10, 20, 30), about_z @ about_x @ about_y),
        "Xrotation Yrotation Zrotation": ((20, 30, 10), about_x @ about_y @ about_z),
        "Yrotation Zrotation Xrotation": ((30, 10, 20), about_y @ about_z @ about_x),
    }
    for order, (values, turn) in orders.items():
        found = read_bvh(bvh(order=order, values=values)).segments
        assert found is not None
        knee, foot = (found.names.index(name) for name in ("LeftLeg", "LeftFoot"))
        np.testing.assert_allclose(found.position[0, knee], [9, 94 - 43, 0], atol=1e-9)
        np.testing.assert_allclose(found.position[0, foot], found.position[0, knee] + turn @ [0, -43, 0], atol=1e-9)
        np.testing.assert_allclose(found.rotation[0, knee], turn, atol=1e-12)


@pytest.mark.parametrize("version", [3, 4])
def test_mvnx_leaves_out_calibration_and_the_name(version: int) -> None:
    found = read_mvnx(mvnx(POSITION[:3, :4], ("Pelvis", "L5", "T8", "Head"), version=version))
    assert found.segments is not None and found.segments.names[0] == "Pelvis"
    np.testing.assert_array_equal(found.segments.position, POSITION[:3, :4])
    np.testing.assert_allclose(found.times_s, np.arange(3) / 60, atol=1e-6)
    assert found.remarks[0].fault == 8 and "Jane" not in repr(found)


@pytest.mark.parametrize("version", [3, 4])
def test_mvnx_moves_bony_points_with_their_segments(version: int) -> None:
    place, quarter = np.array([0.1, 0.2, 0.3]), np.sqrt([0.5, 0.0, 0.0, 0.5])  # a quarter turn about z
    turns = np.tile([1.0, 0, 0, 0], (2, 2, 1))
    turns[1, 1] = quarter
    found = read_mvnx(
        mvnx(POSITION[:2, :2], ("T8", "Head"), version=version, turns=turns, points={"pNose": ("Head", place)})
    )
    assert found.points is not None and found.points.labels == ("pNose",)  # joints are the origins of segments
    np.testing.assert_allclose(found.points.position[0, 0], POSITION[0, 1] + place)
    np.testing.assert_allclose(found.points.position[1, 0], POSITION[1, 1] + [-0.2, 0.1, 0.3])
    whole = interpret(found, Given()).recording
    assert whole.labels == ("T8", "Head", "pNose")


def test_mot_of_angles_and_of_forces() -> None:
    columns = {"knee_angle_r": np.array([90.0, 45]), "pelvis_ty": np.array([0.9, 1.0])}
    degrees = read_mot(mot(columns)).angles
    assert degrees is not None and degrees.lengths == {"pelvis_ty"}
    np.testing.assert_allclose(degrees.value, [[np.pi / 2, 0.9], [np.pi / 4, 1.0]])
    radians = read_mot(mot(columns, header=("inDegrees=no",))).angles
    assert radians is not None and radians.value[0, 0] == 90
    (plate,) = read_mot(mot(plate_columns(np.array([700.0, 0])))).plates
    np.testing.assert_array_equal(plate.force_n[:, 1], [700, 0])
    np.testing.assert_array_equal(plate.origin, [[0.1, 0, -0.2], [0, 0, 0]])


def changed(content: bytes, *pairs: tuple[str, str]) -> bytes:
    told = text(content)
    for old, new in pairs:
        assert old in told
        told = told.replace(old, new)
    return told.encode()


TRC, MOT = trc(POSITION), mot({"knee_angle_r": np.array([90.0, 45])})
MVNX = mvnx(POSITION[:2, :4], "abcd")
WRONG: dict[str, tuple[Callable[[bytes], Content], bytes, str]] = {
    "TRC, not text": (read_trc, TRC + b"\0", "is not a text file"),
    "TRC, other beginning": (read_trc, TRC[4:], "line 1: should begin with PathFileType"),
    "TRC, no data": (read_trc, b"\n".join(TRC.split(b"\n")[:5]), "has no frames"),
    "TRC, decimal comma": (read_trc, TRC.replace(b".", b","), "decimal points, not commas"),
    "TRC, word": (read_trc, changed(TRC, ("0.010000", "soon")), "line 7: 'soon' is not a number"),
    "TRC, no time": (read_trc, changed(TRC, ("0.010000", "")), "line 7: has no time"),
    "TRC, infinite": (read_trc, changed(TRC, ("0.010000", "1e999")), "larger than any number"),
    "TRC, long row": (read_trc, changed(TRC, ("0.010000", "0.01\t1\t2\t3")), "line 7: 62 columns; the header names 59"),
    "TRC, no names": (read_trc, changed(TRC, ("Frame#", "Number")), "line 4: should begin with Frame# and Time"),
    "MOT, no header": (read_mot, changed(MOT, ("endheader", "")), "has no line endheader"),
    "MOT, degrees?": (read_mot, mot({"knee": np.zeros(2)}, header=()), "--angles"),
    "MOT, half a force": (
        read_mot, changed(mot(plate_columns(np.ones(2))), ("force_1_px", "force_1_qx")), "no columns ground_force_1_px",
    ),
    "MOT, twice": (read_mot, changed(MOT, ("time\t", "time\tknee_angle_r\t")), "named twice: knee_angle_r"),
    "CSV, no time": (read_csv, b"a_x_m,a_y_m\n1,2\n", "the first column should be time_s"),
    "CSV, no z": (read_csv, b"time_s,a_x_m,a_y_m\n1,2,3\n", "columns are missing: a_z"),
    "CSV, what?": (read_csv, b"time_s,a\n1,2\n", "a: should end in _x, _y or _z"),
    "CSV, units": (read_csv, b"time_s,a_x_m,a_y_mm,a_z_m\n1,2,3,4\n", "different units: m, mm"),
    "BVH, no end": (read_bvh, changed(bvh(), ("MOTION", "")), "is not expected here"),
    "BVH, no joint": (read_bvh, b"HIERARCHY\x0bROOT Hips\n{\n", "line 2: '{' is not expected here"),
    "BVH, rows": (read_bvh, changed(bvh(), ("Frames: 6", "Frames: 7")), "has 6 rows after Frame Time; Frames says 7"),
    "BVH, channel": (read_bvh, changed(bvh(), ("Xposition", "Xplace")), "'Xplace' is not a channel"),
    "BVH, still": (read_bvh, changed(bvh(), ("Time: 0.01", "Time: 0")), "should be a positive number of seconds"),
    "MVNX, cut": (read_mvnx, MVNX[:-40], "is not well-formed XML"),
    "MVNX, entities": (read_mvnx, b"<!DOCTYPE x>" + MVNX, "declares a document type"),
    "MVNX, point": (read_mvnx, changed(MVNX, ("0 0 0<", "0 0 x<"), ("ja", "pa")), "point 'pa': its place should be"),
    "MVNX, few": (read_mvnx, changed(MVNX, ("1.0 0.0 0.0 0.0 1.0 0.0", "1 0")), "not 4 for each of 4"),
    "C3D, other": (c3d.read_c3d, b"x" * 600, "does not begin as a C3D file does"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(case: str) -> None:
    read, content, message = WRONG[case]
    with pytest.raises(RecordingError) as raised:
        read(content)
    assert message in str(raised.value)


def test_what_is_no_file_is_refused(no_files: dict[str, Path], tmp_path: Path) -> None:
    for path in no_files.values():
        with pytest.raises(RecordingError):
            read_content(path.parent / (path.name + ".trc"))
    os.mkfifo(tmp_path / "pipe.trc")
    (tmp_path / "empty.csv").touch()
    for name, why in (("pipe.trc", "is not a file"), ("empty.csv", "is empty"), ("a.txt", "is of no known format")):
        with pytest.raises(RecordingError, match=why):
            read_content(tmp_path / name)

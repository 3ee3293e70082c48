"""What is inferred is right, can be overruled, and contradictions are refused: the faults of docs/recordings.md."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from recorded import LABELS, Y_UP, bvh, c3d_file, csv_markers, figure, mot, plate_columns, trc

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.formats.bvh import read_bvh
from fatigue_planner.recordings.formats.mot import read_mot
from fatigue_planner.recordings.formats.trc import read_trc
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import Interpreted, interpret
from fatigue_planner.recordings.mapping import choose_mapping, load_mapping, shipped

POSITION = figure()
NOTHING = Given()
MASSES = ("71.3 kg", "71.4 kg")  # of 700 N, with noise
TIPPED = np.diag([1.0, -1, -1])


def of_trc(position: np.ndarray, given: Given = NOTHING, labels: Sequence[str] = LABELS, **more: object) -> Interpreted:
    return interpret(read_trc(trc(position, labels, **more)), given)  # type: ignore[arg-type]


def value(found: Interpreted, what: str) -> str:
    (finding,) = [one for one in found.findings if one.what == what]
    return finding.value


def remarks(found: Interpreted, fault: int) -> str:
    return " ".join(remark.text for remark in found.remarks if remark.fault == fault)


def points(found: Interpreted) -> np.ndarray:
    assert found.recording.points_m is not None
    return found.recording.points_m


def test_encodings_of_one_motion_are_one_recording(tmp_path: Path) -> None:
    """y up or z up, mm or m, prefix or none, heading anywhere."""
    want = points(of_trc(POSITION))
    np.testing.assert_allclose(want, POSITION, atol=1e-9)
    turned = figure(heading=2.0)
    files = {
        "yup.trc": trc(POSITION @ Y_UP.T),
        "mm.trc": trc(POSITION * 1000, unit="mm"),
        "prefix.trc": trc(POSITION, [f"Jane:{label}" for label in LABELS]),
        "turned.csv": csv_markers(turned @ Y_UP.T * 100, unit="cm"),
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        found = read_recording(tmp_path / name)[1].recording
        assert found.labels == LABELS and found.rate_hz == 100
        np.testing.assert_allclose(found.points_m, want, atol=1e-9, err_msg=name)
    c3d = c3d_file(tmp_path / "walk.c3d", turned * 1000, [f"Jane:{label}" for label in LABELS])
    np.testing.assert_allclose(points(read_recording(c3d)[1]), want, atol=1e-6)


def test_where_he_faces_can_be_given() -> None:
    found = of_trc(figure(heading=2.0), Given(heading_deg=float(np.degrees(2.0)) - 90))
    assert value(found, "heading") == "24.5916° from x, turned to x"
    np.testing.assert_allclose(points(found), POSITION @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]), atol=1e-9)


def test_units_are_inferred_given_or_demanded() -> None:  # fault 1
    found = of_trc(POSITION * 1000, unit=None)
    assert value(found, "unit") == "mm" and "1.75 m tall" in str(found.findings)
    np.testing.assert_allclose(points(found), POSITION, atol=1e-9)
    with pytest.raises(RecordingError, match=r"in m \(the file\) the body would be 1.75e\+03 m tall. .*--units"):
        of_trc(POSITION * 1000)
    assert value(of_trc(POSITION * 1000, Given(units="mm")), "unit") == "mm"
    with pytest.raises(RecordingError, match=r"unit 'inch' is unknown; say it with --units"):
        of_trc(POSITION, unit="inch")
    with pytest.raises(RecordingError, match="says no unit of length"):
        of_trc(POSITION[:, :3], labels=("a", "b", "c"), unit=None)


def test_upwards_is_inferred_and_contradictions_are_refused() -> None:  # fault 2
    for up, turn in (
        ("+z", np.eye(3)),
        ("+y", Y_UP),
        ("-z", np.diag([1.0, -1, -1])),
        ("-y", np.diag([1.0, -1, -1]) @ Y_UP),
    ):
        found = of_trc(POSITION @ turn.T)
        assert value(found, "up") == up
        np.testing.assert_allclose(points(found), POSITION, atol=1e-9)
    with pytest.raises(RecordingError, match=r"\+y is up \(given\), but by its labels the body stands along \+z"):
        of_trc(POSITION, Given(up="+y"))
    with pytest.raises(RecordingError, match="does not say which axis is up"):
        of_trc(POSITION[:, :3], labels=("a", "b", "c"))
    assert value(of_trc(POSITION[:, :3], Given(up="-x"), labels=("a", "b", "c")), "up") == "-x"


def test_points_in_one_place_are_no_body() -> None:  # as a damaged file had them
    with pytest.raises(RecordingError, match="does not say which axis is up"):
        of_trc(np.full_like(POSITION, 100.0))


def test_exchanged_sides_and_mirrors_are_refused_and_labels_can_be_set_right() -> None:  # fault 2
    known = load_mapping("plug_in_gait")
    exchanged = [known.across(label).upper() for label in LABELS]
    assert (LABELS[3], exchanged[3]) == ("LSHO", "RSHO") and exchanged[:3] == ["C7", "CLAV", "STRN"]
    right = of_trc(POSITION, Given(exchange_sides=True), labels=exchanged)
    assert right.recording.labels == LABELS and value(right, "sides").startswith("left and right of all")
    np.testing.assert_allclose(points(right), POSITION, atol=1e-9)
    assert load_mapping("opencap").across("L_thigh2_study") == "rthigh2study" and known.across("a#1") == "a#1"
    with pytest.raises(RecordingError, match="no mapping knows its labels, so none says"):
        of_trc(POSITION[:, :3], Given(up="+z", units="m", exchange_sides=True), labels=("a", "b", "c"))
    for position, labels in ((POSITION, exchanged), (POSITION * [1, -1, 1], LABELS)):
        with pytest.raises(RecordingError, match="left and right are exchanged, or the file is mirrored"):
            of_trc(position, labels=labels)


def test_labels_are_understood_or_the_nearest_is_named() -> None:  # fault 3
    labels = ["RKNNE" if label == "RKNE" else label for label in LABELS]
    found = of_trc(np.concatenate([POSITION, POSITION[:, :2]], axis=1), labels=[*labels, "*52", "Unlabeled 1800"])
    assert found.recording.labels == tuple(labels) and found.mapping == "plug_in_gait"
    assert "2 points that nobody named are left out" in remarks(found, 3)
    assert "'RKNNE' (like rkne?)" in remarks(found, 3)
    assert value(of_trc(POSITION, labels=[label.lower().replace("r", "R.") for label in LABELS]), "mapping")


def test_two_people_are_two_recordings() -> None:  # fault 3
    both = np.concatenate([POSITION, POSITION + 1], axis=1)
    labels = [f"{name}:{label}" for name in ("Ann", "Bob") for label in LABELS]
    with pytest.raises(RecordingError, match=r"several people or things: Ann, Bob. Choose one with --prefix"):
        of_trc(both, labels=labels)
    np.testing.assert_allclose(points(of_trc(both, Given(prefix="Bob"), labels)), POSITION + 1, atol=1e-9)
    with pytest.raises(RecordingError, match=r"no label begins with the prefix 'Cleo'; prefixes are Ann, Bob"):
        of_trc(both, Given(prefix="Cleo"), labels)


def test_the_most_complete_of_labels_given_twice_is_kept() -> None:  # fault 4
    twice = np.concatenate([POSITION[:, :1], POSITION], axis=1)
    twice[:5, 0] = np.nan
    found = of_trc(twice, labels=["C7", *LABELS])
    np.testing.assert_allclose(points(found)[:, 0], POSITION[:, 0], atol=1e-9)
    assert "labels given several times; the first most complete is kept: 'C7' (2)" in remarks(found, 4)
    assert "NumMarkers says 7; there are 19" in remarks(of_trc(POSITION, header={"NumMarkers": 7}), 4)


def test_missing_points_are_counted() -> None:  # fault 5
    gone = POSITION.copy()
    gone[5:30, 3] = np.nan
    gone[:10, 4] = 0
    gone[:, 5] = np.nan
    found = of_trc(gone)
    assert "10 positions at 0, 0, 0 taken as missing" in remarks(found, 5)
    assert "never seen, left out: LELB" in remarks(found, 5)
    assert "1 point has gaps over 0.2 s: LSHO 0.25 s" in remarks(found, 5)
    with pytest.raises(RecordingError, match="no point is ever seen"):
        of_trc(np.full_like(POSITION, np.nan))


def test_points_that_change_places_or_jump_are_named_and_left() -> None:  # fault 6
    swapped = POSITION.copy()
    left, right = LABELS.index("LHEE"), LABELS.index("RHEE")
    swapped[20:, [left, right]] = POSITION[20:, [right, left]]
    found = of_trc(swapped)
    assert "points change places: LHEE and RHEE before frame 21 (1 times)" in remarks(found, 6)
    np.testing.assert_allclose(points(found)[30, left], POSITION[30, right], atol=0.05)
    ghost = POSITION.copy()
    ghost[11, 0] += 0.4
    assert "points jump 2 times as no body moves (the first: C7, before frame 12)" in remarks(of_trc(ghost), 6)
    assert remarks(of_trc(POSITION), 6) == ""


def test_the_rate_must_agree_with_the_times() -> None:  # fault 8
    exact = of_trc(POSITION, rate=119.88012)
    assert exact.recording.rate_hz == 119.88012
    with pytest.raises(RecordingError, match=r"the header says 30 frames a second, the times 120. .*--rate"):
        of_trc(POSITION, rate=120.0, header={"DataRate": 30})
    assert of_trc(POSITION, Given(rate_hz=120.0), rate=120.0, header={"DataRate": 30}).recording.rate_hz == 120
    lines = trc(POSITION).decode().split("\n")
    with pytest.raises(RecordingError, match="times do not increase at frame 4"):
        interpret(read_trc("\n".join([*lines[:7], lines[8], lines[7], *lines[9:]]).encode()), NOTHING)
    with pytest.raises(RecordingError, match=r"frames are not evenly spaced|the header says"):
        interpret(read_trc("\n".join([*lines[:10], *lines[22:]]).encode()), NOTHING)


def test_a_first_frame_of_calibration_is_left_out() -> None:  # fault 8
    lines = bvh(frames=8).decode().rstrip("\n").split("\n")
    still = " ".join(["0", "94", "0", *["0"] * (len(lines[-1].split()) - 3)])
    found = interpret(read_bvh("\n".join([*lines[:-8], still, *lines[-7:], ""]).encode()), NOTHING)
    assert found.recording.frames == 7 and "a pose of calibration" in remarks(found, 8)


def test_plates_push_the_person_up() -> None:  # fault 10
    weight = np.full(300, 700.0)
    for sign in (1.0, -1.0):
        found = interpret(read_mot(mot(plate_columns(weight, sign))), NOTHING)
        (plate,) = found.recording.ground
        np.testing.assert_allclose(plate.force_n, np.tile([0, 0, 700.0], (300, 1)), atol=1e-9)
        # y up to z up: x forward stays at index 1, z to the right becomes x
        np.testing.assert_allclose(plate.centre_m(), np.tile([-0.2, 0.1], (300, 1)), atol=1e-9)
        assert ("they are turned round" in remarks(found, 10)) == (sign < 0)


def test_the_mass_is_the_plates_or_is_doubted() -> None:  # fault 11
    rng = np.random.default_rng(1)
    weight = 700 + 2 * rng.standard_normal(500)
    assert value(interpret(read_mot(mot(plate_columns(weight))), NOTHING), "mass") in MASSES
    given = interpret(read_mot(mot(plate_columns(weight))), Given(mass_kg=75.0))
    assert value(given, "mass") == "75 kg" and "kg, -5 %" in remarks(given, 11)
    assert remarks(interpret(read_mot(mot(plate_columns(weight))), Given(mass_kg=72.0)), 11) == ""
    leaning = weight.copy()
    leaning[:200] *= 0.6  # sits first
    assert value(interpret(read_mot(mot(plate_columns(leaning))), NOTHING), "mass") in MASSES
    walking = 700 + 500 * np.sin(np.arange(500) / 9)
    assert value(interpret(read_mot(mot(plate_columns(walking.clip(0)))), NOTHING), "mass") == "unknown"
    drifting = np.where(np.arange(500) < 200, 12.0, weight)
    assert "plate 1 shows +12.0 N while nobody is on it" in remarks(
        interpret(read_mot(mot(plate_columns(drifting))), NOTHING), 11
    )


def test_plates_may_be_in_another_file(tmp_path: Path) -> None:
    """OpenSim's way: markers in mm, plates in m; both in the same axes, y up."""
    (tmp_path / "walk.trc").write_bytes(trc(POSITION @ Y_UP.T * 1000, unit="mm"))
    (tmp_path / "walk.mot").write_bytes(mot(plate_columns(np.full(40, 700.0), at=(0.1, 0.0, -0.2))))
    (tmp_path / "late.mot").write_bytes(mot(plate_columns(np.full(40, 700.0))).replace(b"\n0.0\t", b"\n-0.1\t"))
    formats, found = read_recording(tmp_path / "walk.trc", tmp_path / "walk.mot")
    assert formats == "TRC + MOT"
    np.testing.assert_allclose(points(found), POSITION, atol=1e-9)
    np.testing.assert_allclose(found.recording.ground[0].centre_m(), np.tile([0.1, 0.2], (40, 1)), atol=1e-9)
    for others, why in (
        (("late.mot",), "begin at different times: 0 s and, the plates, -0.1 s"),
        (("walk.mot", "walk.mot"), "have plates in more than one file"),
        (("walk.trc",), "are several motions"),
    ):
        with pytest.raises(RecordingError, match=why):
            read_recording(tmp_path / "walk.trc", *(tmp_path / other for other in others))


def test_mappings_know_what_they_are_for() -> None:
    assert shipped() == ["cmu", "opencap", "plug_in_gait", "xsens"]
    assert choose_mapping(LABELS) == "plug_in_gait"
    assert choose_mapping(["r.ASIS_study", "L.ASIS_study", "r_knee_study", "C7_study"]) == "opencap"
    assert choose_mapping(["RightUpperLeg", "LeftUpperArm", "Pelvis", "T8"]) == "xsens"
    assert choose_mapping(["Hips", "LeftUpLeg", "RightUpLeg", "LeftArm"]) == "cmu"
    assert choose_mapping(["a", "b"]) is None
    for name in shipped():
        for label, place in load_mapping(name).places.items():
            said = "left" if label.startswith(("l", "pl")) else "right"
            assert place.side in ("", said) and (place.side == "left") <= (place.at_m[1] >= 0 or "medial" in place.landmark or place.landmark == "metatarsal_1"), label  # fmt: skip  # noqa: E501


def test_a_mapping_of_ones_own(tmp_path: Path) -> None:
    own = tmp_path / "mine.yaml"
    own.write_text(
        "about: Mine.\nsides: {right: [re_], left: [li_]}\nlandmarks:\n  asis: ['{s}becken']\n  c7: [Hals]\n"
    )
    place = load_mapping(str(own)).place("LI Becken")
    assert place is not None and (place.side, place.body) == ("left", "pelvis")
    own2 = tmp_path / "wrong.yaml"
    own2.write_text("about: Mine.\nsides: {}\nlandmarks:\n  asos: [x]\n")
    with pytest.raises(RecordingError, match=r"landmarks.asos is no landmark; did you mean asis\?"):
        load_mapping(str(own2))
    own3 = tmp_path / "sideless.yaml"
    own3.write_text("about: Mine.\nsides: {}\nlandmarks:\n  asis: [x]\n")
    with pytest.raises(RecordingError, match="x does not say the side"):
        load_mapping(str(own3))
    with pytest.raises(RecordingError, match="neither a file nor a mapping that ships: cmu, opencap"):
        load_mapping("nonsense")

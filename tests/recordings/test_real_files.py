"""Real recordings: each is read, or refused with a named reason; what is known of some of them is found."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
from commands import fatplan
from recorded import real

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.formats.registry import FORMATS, Choices
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import Interpreted

pytestmark = pytest.mark.slow

MAX_SECONDS = 5.0  # CPU of this process, so that a busy machine fails no file; the other's has its own limit
# Why files are refused; all others are read.
REFUSED = {
    "sample_11_evart.c3d": r"\+z is up \(the file\), but by its labels the body stands along -x",
    "sample_16_basketball.c3d": "no point is ever seen",
    "sample_18_bad_parameter_section.c3d": "cannot be read as C3D",
    "sample_20_phasespace.c3d": "says no unit of length",
    "sample_28_standing.C3D": r"two readers, ezc3d and c3d, .* differ in what is missing, at 22.2% of the points",
    "sample_30_admarche2.c3d": r"two readers, ezc3d and c3d, .* differ in what is missing, at 98.0% of the points",
    "dataWithEformat.trc": "does not say which axis is up",
    "dataWithNaNsOfDifferentCases.trc": "does not say which axis is up",
    "exampleFormat.trc": "does not say which axis is up",
    "sinusoidal.bvh": "says no unit of length",
}
MAPPINGS = {
    "squat.c3d": "cmu", "squats1.trc": "opencap", "STS1.trc": "opencap", "walking5.c3d": "plug_in_gait",
    "BMC_Gait.c3d": "plug_in_gait", "test_freebvh.bvh": "cmu", "weird_format_markers.trc": "plug_in_gait",
}  # fmt: skip


def read(name: str, given: Given | None = None, choices: Choices | None = None) -> Interpreted:
    return read_recording(real(name), given=given, choices=choices)[1]


def value(found: Interpreted, what: str) -> str:
    (finding,) = [one for one in found.findings if one.what == what]
    return finding.value


def test_every_file_is_read_or_refused_for_a_reason() -> None:
    files = [path for path in sorted(real(".").rglob("*.*")) if path.suffix.lower() in FORMATS]
    assert len(files) > 30
    for path in files:
        before = time.process_time()
        try:
            found = read_recording(path)[1]
        except RecordingError as error:
            assert path.name in REFUSED and re.search(REFUSED[path.name], str(error)), error
            assert str(error).startswith(f"{path}: ")
        else:
            assert path.name not in REFUSED
            assert found.mapping == MAPPINGS.get(path.name, found.mapping)
            assert found.recording.rate_hz > 0
        assert time.process_time() - before < MAX_SECONDS


def test_three_encodings_of_a_walk_are_one_motion() -> None:
    found = [read(f"hostile_c3d/sample_02_{kind}.c3d").recording for kind in ("pc_real", "dec_int", "sgi_real")]
    for other in found[1:]:
        assert other.labels == found[0].labels and other.rate_hz == found[0].rate_hz
        np.testing.assert_allclose(other.points_m, found[0].points_m, atol=2e-7)


def test_plates_of_two_types_say_the_same() -> None:
    """One recording stored with plates of types 2 and 4."""
    one, other = (read(f"hostile_c3d/sample_10_TYPE-{kind}.C3D").recording.ground[0] for kind in (2, 4))
    loaded = one.force_n[:, 2] > 50
    assert loaded.sum() > 100
    np.testing.assert_allclose(other.force_n[loaded, 2], one.force_n[loaded, 2], rtol=0.02, atol=3)
    np.testing.assert_allclose(other.centre_m()[loaded], one.centre_m()[loaded], atol=0.025)  # calibrated otherwise


def test_the_push_is_where_ezc3d_says() -> None:
    """The centre from force and moment about the origin, against the one that ezc3d computes in the plate."""
    ezc3d = pytest.importorskip("ezc3d")
    path = real("gait_plates/walking5.c3d")
    found = read("gait_plates/walking5.c3d", Given(up="+z"))
    heading = np.radians(float(value(found, "heading").split("°")[0]))
    for plate, own in zip(ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"], found.recording.ground, strict=True):  # fmt: skip  # noqa: E501
        loaded = own.force_n[:, 2] > 100
        want = plate["center_of_pressure"][:2, loaded].T / 1000
        assert loaded.any()
        np.testing.assert_allclose(
            np.linalg.norm(own.centre_m()[loaded], axis=1), np.linalg.norm(want, axis=1), atol=1e-6
        )
        angle = np.arctan2(*own.centre_m()[loaded].T[::-1]) - np.arctan2(*want.T[::-1]) + heading
        assert abs(np.angle(np.exp(1j * angle))).max() < 0.02  # the heading is told in whole degrees


def test_the_mass_on_the_plates() -> None:
    assert value(read("squat_sit_plates/static1_grf.mot"), "mass") == "60.0 kg"
    assert value(read("squat_sit_plates/squats1_grf.mot"), "mass") == "60.1 kg"
    assert value(read("squat_sit_plates/STS1_grf.mot"), "mass") == "unknown"  # a chair carries the rest
    told = read("squat_sit_plates/static1_grf.mot", Given(mass_kg=62.6)).remarks
    assert [remark.fault for remark in told] == [11]


def test_a_reader_can_be_chosen_where_two_differ() -> None:
    path = "hostile_c3d/sample_30_admarche2.c3d"
    assert read(path, Given(up="+z"), Choices(reader="ezc3d")).recording.frames == 159
    with pytest.raises(RecordingError, match="no point is ever seen"):
        read(path, Given(up="+z"), Choices(reader="c3d"))


def test_faults_of_real_files_are_told() -> None:
    def told(name: str, fault: int) -> str:
        return " ".join(remark.text for remark in read(name).remarks if remark.fault == fault)

    assert "75 labels for 36 points" in told("hostile_c3d/sample_02_pc_real.c3d", 4)
    assert "'RKNE' (2), 'RANK' (2)" in told("gait_plates/BMC_Gait.c3d", 4)
    assert "60.2 % of the positions are missing" in told("gait_plates/BMC_Gait.c3d", 5)
    assert "10 points have gaps over 0.2 s: STRN 1.72 s" in told("markers_only/squat.c3d", 5)
    assert "71 positions at 0, 0, 0" in told("hostile_trc/weird_format_markers.trc", 5)
    assert "they are turned round" in told("hostile_c3d/sample_15_FP1.C3D", 10)
    assert "ezc3d refuses it" in told("hostile_c3d/sample_02_sgi_real.c3d", 14)


def test_the_command_on_real_files() -> None:
    files = [real("markers_only/squat.c3d"), real("hostile_trc/exampleFormat.trc"), Path("none.trc")]
    done = fatplan("record", "check", *files)
    assert done.returncode == 3 and "Traceback" not in done.stdout + done.stderr
    assert "squat.c3d: C3D (ezc3d), 2539 frames, 21.15 s, 53 points\n  rate: 120 Hz" in done.stdout
    assert "  prefix: SehoonVSK35 (the same before all labels)\n" in done.stdout
    assert "none.trc: is not there.\n  refused" in done.stdout

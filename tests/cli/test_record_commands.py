"""`fatplan record`: files checked, in words and as JSON."""

from pathlib import Path

import pytest
from commands import fatplan, refused
from recorded import LABELS, figure, trc
from test_cli_json import document


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "walk.trc"
    path.write_bytes(trc(figure()))
    return path


def test_what_a_file_holds_is_said(file: Path) -> None:
    done = fatplan("record", "check", file)
    assert done.returncode == 0
    assert done.stdout == (
        f"{file}: TRC, 40 frames, 0.39 s, 19 points\n"
        "  rate: 100 Hz (the header, and the times)\n"
        "  mapping: plug_in_gait (knows 19 of 19 labels)\n"
        "  unit: m (the file; the body is about 1.75 m tall)\n"
        "  up: +z (from feet to head)\n"
        "  heading: 0° from x, turned to x (left is left, and fronts are in front)\n"
        "  fault 5: no point is on abdomen, neck, head, right_forearm, right_hand, left_forearm, left_hand.\n"
    )


def test_the_document(file: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("time_s\n")
    found = document("record check", file, tmp_path / "bad.csv", code=3)
    good, bad = found["files"]
    assert (good["refused"], good["format"], good["frames"], good["points"]) == (None, "TRC", 40, list(LABELS))
    assert {"what": "up", "value": "+z", "source": "from feet to head"} in good["findings"]
    assert bad == {"file": str(tmp_path / "bad.csv"), "refused": f"{tmp_path / 'bad.csv'}: has no rows."}
    assert found["refused"] == 1


def test_what_is_inferred_can_be_overruled(file: Path) -> None:
    assert "rate: 50 Hz (given)" in fatplan("record", "check", file, "--rate", "50").stdout
    wrong = fatplan("record", "check", file, "--up", "+y")
    assert wrong.returncode == 3 and "by its labels the body stands along +z" in wrong.stdout
    assert "nonsense: neither a file nor a mapping" in refused(2, "record", "check", file, "--mapping", "nonsense")
    for option in ("--rate", "--mass"):
        assert f"Invalid value for '{option}'" in refused(2, "record", "check", file, option, "nan")

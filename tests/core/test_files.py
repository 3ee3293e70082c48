"""Publishing whole files."""

from pathlib import Path

import pytest

from fatigue_planner.core.errors import OutputFolderError
from fatigue_planner.core.files import canonical_json, digest_of, publish, publish_text


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    publish_text(path, "old\n")

    def fail_half_way(temporary: Path) -> None:
        temporary.write_text("ne")
        raise OSError(28, "No space left on device")

    with pytest.raises(OutputFolderError, match=r"table\.csv: cannot be written \(No space left on device\)"):
        publish(path, fail_half_way)
    assert path.read_text() == "old\n" and list(tmp_path.iterdir()) == [path]


def test_digest_does_not_depend_on_the_order_of_keys() -> None:
    assert digest_of({"a": 1, "b": [1.5, None]}) == digest_of({"b": [1.5, None], "a": 1})
    assert digest_of({"a": 1}) != digest_of({"a": 1.0000000000000002})
    assert canonical_json({"b": 0.1, "a": "é"}) == '{"a":"é","b":0.1}'

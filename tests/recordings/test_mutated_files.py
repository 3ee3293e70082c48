"""Damaged files of every format: refused with a reason, or read; nothing hangs, nothing crashes the program.

`FATPLAN_MUTATIONS` says how many files of each format, 10,000 for the whole proof; CI tries the part stated here.
"""

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mutations import damaged
from recorded import LABELS, bvh, c3d_file, csv_markers, figure, mot, mvnx, plate_columns, trc

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.content import Content
from fatigue_planner.recordings.formats.registry import FORMATS, Choices
from fatigue_planner.recordings.inference.axes import standing_m
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import interpret
from fatigue_planner.recordings.mapping import load_mapping

POSITION = figure(6)
MAX_SECONDS = 5.0
EXAMPLES = int(os.environ.get("FATPLAN_MUTATIONS", "0"))
PIECES = st.sampled_from([b"", b"nan", b"1e300", b"-1", b"0", b"\xff\xff\xff\x7f", b"\x00\x80", b"\t", b"\n", b"<", b"{", b"99999999"])  # fmt: skip  # noqa: E501


def tried(content: bytes, read: Callable[[bytes, Choices], Content]) -> bool:
    """Whether it is read; refused in words if not, and soon in either case."""
    before = time.process_time()
    try:
        found = interpret(read(content, Choices(degrees=True)), Given())
    except RecordingError as error:
        assert str(error) and "Traceback" not in str(error)
        return False
    finally:
        assert time.process_time() - before < MAX_SECONDS
    assert found.recording.frames > 0 and np.isfinite(found.recording.rate_hz)
    assert found.recording.digest
    return True


def whole(suffix: str, folder: Path) -> list[bytes]:
    if suffix == ".c3d":
        return [c3d_file(folder / "whole.c3d", POSITION * 1000).read_bytes()]
    names = ("Pelvis", "L5", "T8", "Head", "RightFoot")
    body = [place for name in names if (place := load_mapping("xsens").place(name))]
    points = {"pTopOfHead": ("Head", np.array([0.0, 0.0, 0.18]))}
    return {
        ".trc": [trc(POSITION)],
        ".mot": [mot(plate_columns(np.full(9, 700.0))), mot({"knee_angle_r": np.arange(9.0), "pelvis_ty": np.ones(9)})],
        ".sto": [mot({"knee_angle_r": np.arange(9.0)})],
        ".bvh": [bvh()],
        ".mvnx": [mvnx(np.tile(standing_m(body), (6, 1, 1)), names, points=points)],
        ".csv": [csv_markers(POSITION, LABELS)],
    }[suffix]


def run(suffix: str, folder: Path, examples: int) -> tuple[int, int]:
    counts = [0, 0]
    for content in whole(suffix, folder):
        assert tried(content, FORMATS[suffix])
        # C3D has what decides its reading in the first kilobytes; text everywhere
        most = min(len(content) - 1, 3000 if suffix == ".c3d" else len(content))
        positions = st.integers(0, most)

        @settings(max_examples=examples)
        @given(damaged(content, positions, PIECES))
        def check(mutated: bytes) -> None:
            counts[tried(mutated, FORMATS[suffix])] += 1

        check()
    return counts[0], counts[1]


@pytest.mark.parametrize("suffix", [suffix for suffix in FORMATS if suffix != ".c3d"])  # its processes take seconds
def test_damaged_files_are_read_or_refused(suffix: str, tmp_path: Path) -> None:
    run(suffix, tmp_path, 8)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", FORMATS)
def test_many_damaged_files_are_read_or_refused(suffix: str, tmp_path: Path) -> None:
    refused, read = run(suffix, tmp_path, EXAMPLES or 300)
    print(f"{suffix}: {refused} refused, {read} read")
    assert refused and read

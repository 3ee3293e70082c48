"""The page of a recogniser: what it says is what the recogniser does, and everybody can read it."""

import re
from pathlib import Path

import numpy as np
import pytest
from browser import chromium, needs_chromium
from test_recognition import CYCLE, repetitions

from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import REPORT_FILE
from fatigue_planner.output.reports.recognition.page import FLOOR, Judged, recognition_report
from fatigue_planner.recordings.recognition.recogniser import train
from fatigue_planner.recordings.recognition.repetitions import CaptureError, Repetitions
from fatigue_planner.recordings.recognition.stored import StoredRecogniser

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def judged() -> Judged:
    """Two actions: of one b and c are one, of the other all are told apart."""
    rng = np.random.default_rng(3)
    parts = [repetitions(rng, 8, 10), repetitions(rng, 8, 10, {"a": 0, "b": 20, "c": 60}, "high")]
    shown = Repetitions(*(np.concatenate([getattr(one, name) for one in parts]) for name in vars(parts[0])))
    recogniser, held_out = train(shown, CYCLE, 0.75)
    stored = StoredRecogniser.of(recogniser, "task", {"a": "0"}, CaptureError(), 0.75)
    return Judged(stored, recogniser, held_out)


@pytest.fixture(scope="module")
def folder(judged: Judged, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    recognition_report(judged, FigureFolder(folder), "fatplan record recognise task.yaml")
    return folder


def words(folder: Path) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", (folder / REPORT_FILE).read_text()))


def test_the_page_says_what_the_recogniser_does(judged: Judged, folder: Path) -> None:
    text = words(folder)
    assert "low : b and c are one reaction to the robot" in text and "high : b and c are one" not in text
    for action, known in judged.recogniser.actions.items():
        probability, (lower, upper) = known.confusion.probability(), known.confusion.interval()
        for at, value in np.ndenumerate(probability):
            assert f"{value:.2f} ({lower[at]:.2f} to {upper[at]:.2f})" in text
        since = judged.known_from_s()[action]
        assert since is None or f"{since:.1f} s of the cycle" in text
    assert FLOOR in text and "fatplan record recognise task.yaml" in text
    assert {path.name for path in folder.iterdir()} >= {"confusion.csv", "early.csv", "pairs.csv", "calibration.csv"}


def test_nothing_is_loaded_and_the_bytes_are_the_same_again(judged: Judged, folder: Path, tmp_path: Path) -> None:
    page = (folder / REPORT_FILE).read_text()
    assert "<script" not in page and not re.search(r"(src|href)=\"(?!#|data:|[\w.-]+\.(csv|png|svg)\")", page)
    recognition_report(judged, FigureFolder(tmp_path), "fatplan record recognise task.yaml")
    assert {one.name: one.read_bytes() for one in tmp_path.iterdir()} == {
        one.name: one.read_bytes() for one in folder.iterdir()
    }


@needs_chromium
def test_everybody_can_read_it(folder: Path, tmp_path: Path) -> None:
    with chromium(tmp_path) as tab:
        for width, scheme in ((1400, "light"), (390, "light"), (1400, "dark"), (390, "dark")):
            tab.open((folder / REPORT_FILE).as_uri(), width, scheme)
            tab.until("document.querySelectorAll('figure img').length == 3")
            assert tab.faults() == []
            assert tab.value("document.documentElement.scrollWidth <= window.innerWidth")
            assert all(address.startswith(("file:", "data:", "about:")) for address in tab.requests)

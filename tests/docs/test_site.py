"""The documentation is built offline without a warning; what is generated from the sources says what is there."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import layers
import pytest
from conftest import ROOT


def test_floors_and_direct_imports() -> None:
    graph: dict[str, set[str]] = {"base": set(), "left": {"base"}, "right": {"base"}, "top": {"left", "base"}}
    assert layers.floors(graph) == [["base"], ["left", "right"], ["top"]]
    assert layers.direct(graph) == {"base": set(), "left": {"base"}, "right": {"base"}, "top": {"left"}}


def test_the_picture_has_every_room_above_those_it_imports() -> None:
    found = [path for path in layers.PACKAGE.iterdir() if path.is_dir() or path.suffix == ".py"]
    rooms = {path.stem for path in found if not path.stem.startswith("_")}
    heights = {name: float(y) for y, name in re.findall(r'<text x="[^"]+" y="([^"]+)">(\w+)</text>', layers.picture())}
    assert set(heights) == rooms
    for room, named in layers.imports_between_rooms().items():
        assert all(heights[room] < heights[below] for below in named)  # y points down
    table = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)` \|", table, re.M)) == rooms


@pytest.mark.parametrize("url", ["", "https://example.org/files/"])
def test_what_a_package_index_shows(monkeypatch: pytest.MonkeyPatch, url: str) -> None:
    """No picture or link that leads nowhere: there is no file beside the text."""
    setuptools = pytest.importorskip("setuptools")
    told: dict[str, str] = {}
    monkeypatch.setattr(setuptools, "setup", lambda **settings: told.update(settings))
    monkeypatch.setenv("FATPLAN_FILES_URL", url)
    runpy.run_path(str(ROOT / "setup.py"))
    text = told["long_description"]
    assert "fp.load" in text and "<!--" not in text
    links = re.findall(r"(!?)\[[^\]]*\]\(([^)]*)\)", text)
    assert all(target.startswith("https://") for _, target in links)
    assert [target for picture, target in links if picture] == (
        [f"{url}docs/images/{name}.png" for name in ("reactions", "figure5a", "line_worth")] if url else []
    )


@pytest.mark.slow
def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--fresh-env", "--quiet"]
    done = subprocess.run([*command, ROOT / "docs", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = {page.stem: page.read_text(encoding="utf-8") for page in tmp_path.glob("*.html")}
    assert not [name for name, page in pages.items() if re.search(r'(src|srcset)="(https?:)?//', page)]
    pages = {name: re.sub(r"<[^>]+>", "", page) for name, page in pages.items()}
    assert "fatplan cache verify" in pages["command-line"] and "natural_posture_deg" in pages["experiment-file"]
    assert "FatiguePomdp" in pages["api"] and "expected_rewards" in pages["api"]

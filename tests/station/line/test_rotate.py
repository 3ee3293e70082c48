"""`fatplan rotate`: what a line's file may say, and a small line from its file to its rota."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from commands import fatplan

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.station.line.loader import load_line

STATION = """\
name: {name}
workers: {{nobody: {{percentile: 50, sex: male}}}}
tools: {{driver: 1.2 kg, gun: 3 kg}}
places: {{there: {{x: 0.35, y: -0.15, z: {height}, tool: {tool}}}}}
operations: {{fit: {{places: there, seconds: 5, coupling: good}}}}
cycle: {{duration_s: 20}}
ways: [arm]
binding: []
"""
LINE = """\
name: two
stations:
  high: {file: high.yaml}
  low: {file: low.yaml, cycles_per_hour: 150}
crew:
  P5: {percentile: 50, sex: male}
  P95: {percentile: 60, sex: male}
shift: {hours: 4.5, breaks: [{at_min: 120, minutes: 30}]}
slots: 4
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "high.yaml").write_text(STATION.format(name="high", height=1.5, tool="driver"))
    (tmp_path / "low.yaml").write_text(STATION.format(name="low", height=1.0, tool="gun"))
    (tmp_path / "line.yaml").write_text(LINE)
    return tmp_path


@pytest.mark.parametrize(("changed", "said"), [
    ({"crew": {"a": {"percentile": 5, "sex": "female"}}}, "crew: 1 workers cannot man 2 stations all the time"),
    ({"slots": 9}, "slots = 9"),
    ({"measure": "pulse"}, "measure = 'pulse'"),
    ({"stations": {"high": {"file": "none.yaml"}}}, "none.yaml"),
    ({"stations": {"low": {"file": "low.yaml", "cycles_per_hour": 400}}},
     "stations.low.cycles_per_hour = 400: the operations take 12 s with their ways; at most 300"),
    ({"speed": 3}, "speed"),
])  # fmt: skip
def test_mistakes_are_told_before_anything_is_simulated(folder: Path, changed: dict[str, Any], said: str) -> None:
    (folder / "line.yaml").write_text(yaml.safe_dump({**yaml.safe_load(LINE), **changed}))
    with pytest.raises(ExperimentError) as refused:
        load_line(folder / "line.yaml")
    assert said in str(refused.value)


def test_who_may_work_nowhere_and_a_station_for_nobody_are_told(folder: Path) -> None:
    content = yaml.safe_load(LINE)
    for worker in content["crew"].values():
        worker["not_at"] = ["low", "middle"]
    (folder / "line.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(ExperimentError) as refused:
        load_line(folder / "line.yaml")
    message = str(refused.value)
    assert "crew.P5.not_at: middle: not among the stations high, low" in message
    assert "stations.low: nobody of the crew may work there (not_at)" in message


@pytest.mark.slow
def test_a_line_from_its_file_to_its_rota(folder: Path) -> None:
    where = ("--cache", folder / "cache", "--output", folder / "out")
    done = fatplan("rotate", folder / "line.yaml", *where, "--json", "--jobs", "1")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    advice = document["advice"]
    assert document["cannot"] == {"P5": [], "P95": []}
    assert advice["exact"] and advice["largest"] <= min(advice["staying"], advice["usual"]) * (1 + 1e-9)
    assert advice["largest"] == max(
        value for regions in advice["ratios"].values() for value in regions["acceptable_effort"].values()
    )
    assert len(advice["without_pause"]) == 1 and advice["without_pause"][0] > 0
    rows = list(csv.DictReader((folder / "out" / "rota.csv").read_text().splitlines()))
    for slot in "1234":
        assert sorted(row["station"] for row in rows if row["slot"] == slot) == ["high", "low"]
    stored = json.loads((folder / "out" / "rotation.json").read_text())
    assert stored["advice"] == advice
    again = fatplan("rotate", folder / "line.yaml", *where, "--jobs", "1")
    assert again.returncode == 0 and f"of a worker: {advice['largest']:.2f}" in again.stdout

"""`fatplan rotate`: what a line's file may say, and a small line from its file to its rota."""

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from commands import fatplan
from conftest import ROOT

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.loader import editor_schema
from fatigue_planner.station.line.demands import Demand
from fatigue_planner.station.line.loader import load_line
from fatigue_planner.station.line.posts import Post
from fatigue_planner.station.line.rotate import Lifting, lifting_of
from fatigue_planner.station.line.schema import Line
from fatigue_planner.station.loader import load_station
from fatigue_planner.station.schema import Break

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
NOTHING = Demand(60.0, np.zeros((0, 0)), {}, {})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "high.yaml").write_text(STATION.format(name="high", height=1.5, tool="driver"))
    (tmp_path / "low.yaml").write_text(STATION.format(name="low", height=1.0, tool="gun"))
    (tmp_path / "line.yaml").write_text(LINE)
    return tmp_path


@pytest.mark.parametrize(("changed", "said"), [
    ({"crew": {"a": {"percentile": 5, "sex": "female"}}}, "crew: 1 worker cannot man 2 stations all the time"),
    ({"slots": 9}, "slots = 9"),
    ({"measure": "pulse"}, "measure = 'pulse'"),
    ({"stations": {"high": {"file": "none.yaml"}}}, "line.yaml: stations.high.file = 'none.yaml': "),
    ({"forbidden": "warn"}, "forbidden = 'warn'"),
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


def test_a_crew_that_cannot_man_all_stations_at_the_same_time_is_told(folder: Path) -> None:
    content = yaml.safe_load(LINE)
    content["stations"]["third"] = {"file": "low.yaml"}
    content["crew"] |= {"free": {"percentile": 50, "sex": "female"}}
    for worker in ("P5", "P95"):
        content["crew"][worker]["not_at"] = ["high", "low"]
    (folder / "line.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(ExperimentError, match="by not_at, at most 2 of 3 stations can have a worker at the same time"):
        load_line(folder / "line.yaml")


def test_stations_of_other_populations_are_told(folder: Path) -> None:
    people = "population: {male: {stature_m: {mean: 1.8, sd: 0.07}}}\n"
    (folder / "low.yaml").write_text((folder / "low.yaml").read_text() + people)
    with pytest.raises(ExperimentError, match=r"stations\.low\.file: its population is not that of high"):
        load_line(folder / "line.yaml")


def test_stations_have_the_pace_of_the_line_and_who_may_work_there(folder: Path) -> None:
    content = yaml.safe_load(LINE)
    content["stations"]["low"]["cycles_per_hour"] = 85
    content["crew"] |= {"third": {"percentile": 50, "sex": "female", "not_at": ["low"]}}
    (folder / "line.yaml").write_text(yaml.safe_dump(content))
    found = load_line(folder / "line.yaml")
    assert found.cycle_s("low") == pytest.approx(3600 / 85)
    assert found.stations["low"].cycle.duration_s == 42.36 and found.cycle_s("high") == 20
    assert [*found.stations["low"].workers] == ["P5", "P95"] and [*found.stations["high"].workers] == [*content["crew"]]
    assert load_station(folder / "low.yaml").workers.keys() == {"nobody"}


def test_slots_share_the_time_of_work_and_breaks_divide_them(folder: Path) -> None:
    """4.5 h with 30 min of break at 120 min: four slots of 60 min, the third after it; the break may fall into one."""
    found = load_line(folder / "line.yaml").line
    assert found.slot_times() == [[(0, 60)], [(60, 120)], [(150, 210)], [(210, 270)]]
    shift = found.shift.model_copy(update={"breaks": (Break(at_min=90, minutes=20), Break(at_min=110, minutes=10))})
    divided = found.model_copy(update={"shift": shift}).slot_times()
    assert divided == [[(0, 60)], [(60, 90), (120, 150)], [(150, 210)], [(210, 270)]]
    uneven = found.model_copy(update={"slots": 7}).slot_times()
    assert [sum(end - begin for begin, end in spans) for spans in uneven] == pytest.approx([240 / 7] * 7)
    assert uneven[-1][-1][1] == 270


def test_hours_of_lifting_have_the_duration_class_of_their_order(folder: Path) -> None:
    """Two hours in a row are moderate; half an hour's break between them is too short to part them."""
    found = load_line(folder / "line.yaml")
    none, lifts = Post(NOTHING), Post(replace(NOTHING, lifts=True))
    posts = {worker: {"high": lifts, "low": none} for worker in ("P5", "P95")}
    assert lifting_of(found, posts, np.array([[0, 0, 1, 1], [1, 1, 0, 0]])) == {
        "P5": Lifting(2.0, "moderate"), "P95": Lifting(2.0, "moderate"),
    }  # fmt: skip
    assert lifting_of(found, posts, np.array([[0, 1, 1, 0], [1, 0, 0, 1]]))["P5"] == Lifting(2.0, "short")
    nothing = {worker: {"high": none, "low": none} for worker in posts}
    assert lifting_of(found, nothing, np.array([[0, 0, 0, 0], [1, 1, 1, 1]])) == {}


@pytest.mark.slow
def test_lifting_is_judged_by_the_hours_of_the_rota(folder: Path) -> None:
    """8 kg three times a minute: who lifts for more than 2 h has the frequency multiplier of that, 0.55."""
    station = yaml.safe_load(STATION.format(name="low", height=0.9, tool="gun"))
    station["tools"]["gun"], station["ways"] = "8 kg", ["back"]
    station["places"]["there"] |= {"x": 0.4, "y": 0}
    station["operations"]["fit"] |= {
        "hand": "both", "handling": "lift", "end_height_m": 1.3, "placed_carefully": False, "seconds": 4,
    }  # fmt: skip
    (folder / "low.yaml").write_text(yaml.safe_dump(station))
    content = yaml.safe_load(LINE)
    content["crew"]["P95"]["not_at"] = ["low"]
    content["stations"]["low"].pop("cycles_per_hour")
    (folder / "line.yaml").write_text(yaml.safe_dump(content))
    done = fatplan("rotate", folder / "line.yaml", "--cache", folder / "cache", "--output", folder / "out", "--json")
    assert done.returncode == 0, done.stderr
    lifting = json.loads(done.stdout)["advice"]["lifting"]
    assert lifting.keys() == {"P5"} and (lifting["P5"]["hours"], lifting["P5"]["duration"]) == (4, "long")
    judged = lifting["P5"]["judged"]["low"]
    limit_kg = 23 * math.prod(judged["parts"][name] for name in ("HM", "VM", "DM", "AM", "CM")) * 0.55
    assert judged["value"]["low"] == judged["value"]["high"] == pytest.approx(8 / limit_kg, rel=1e-9)
    assert judged["parts"]["height_cm"] >= 75 and judged["parts"]["lifts_per_minute"] == 3
    assert "NIOSH lifting index" in (folder / "out" / "rota.html").read_text(encoding="utf-8")


def test_what_init_writes_is_a_line(tmp_path: Path) -> None:
    assert fatplan("init", "mine", "--line", cwd=tmp_path).returncode == 0
    done = fatplan("validate", "mine.yaml", cwd=tmp_path)
    assert done.stdout == "mine.yaml: ok; a line with 3 stations, a crew of 3.\n"
    both = fatplan("init", "other", "--line", "--station", cwd=tmp_path)
    assert both.returncode == 2 and both.stderr == "Error: --station and --line: give one of them.\n"


def test_every_key_of_a_line_is_described() -> None:
    printed = editor_schema(Line)
    kinds = [printed, *printed["$defs"].values()]
    keys = [(kind.get("title"), key, each) for kind in kinds for key, each in kind.get("properties", {}).items()]
    assert len(keys) > 20 and all(each.get("description") for _, _, each in keys)


@pytest.mark.slow
def test_the_line_that_ships_rotates_as_its_page_says(tmp_path: Path) -> None:
    done = fatplan("rotate", "trim_line", "--cache", tmp_path / "cache", "--output", tmp_path / "out", "--jobs", "1")
    assert done.returncode == 0, done.stderr
    shown = (ROOT / "docs" / "rotation.md").read_text(encoding="utf-8").split("```text\n")[1].split("```")[0]
    assert done.stdout.startswith(shown)


@pytest.mark.slow
def test_a_line_from_its_file_to_its_rota(folder: Path) -> None:
    where = ("--cache", folder / "cache", "--output", folder / "out")
    done = fatplan("rotate", folder / "line.yaml", *where, "--json", "--jobs", "1")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    advice = document["advice"]
    assert document["cannot"] == {"P5": {}, "P95": {}}
    assert document["not_acceptable"] == []
    assert advice["lifting"] == {}
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
    # nothing binds the stations so far
    for name in ("high", "low"):
        (folder / f"{name}.yaml").write_text((folder / f"{name}.yaml").read_text().replace("binding: []\n", ""))
    again = fatplan("rotate", folder / "line.yaml", *where, "--jobs", "1")
    assert again.returncode == 0 and f"of a worker is {advice['largest']:.2f}" in again.stdout
    forbids = "the work is not acceptable by EN 1005-4 (right upper arm raised far, "
    assert f"  P5 at high: {forbids}" in again.stdout
    (folder / "line.yaml").write_text(LINE + "forbidden: left_out\n")
    left_out = fatplan("rotate", folder / "line.yaml", *where, "--jobs", "1")
    assert left_out.returncode == 0 and f"  P5 does not work at high: {forbids}" in left_out.stdout
    assert "  Nobody of the crew can work at high." in left_out.stdout and "at low" not in left_out.stdout

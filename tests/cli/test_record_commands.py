"""`fatplan record`: files checked, reactions recognised, in words and as JSON."""

import json
import os
import shutil
from pathlib import Path

import pytest
import yaml
from browser import HAS_CHROMIUM, chromium
from commands import fatplan, refused
from conftest import PAPER
from recorded import LABELS, figure, trc
from simulated_recording import record
from test_cli_json import document

from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.recognition.stored import load_recogniser


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


def test_a_worker_is_learnt(tmp_path: Path, cache_folder: Path) -> None:
    cycles, labelled, worker = (tmp_path / name for name in ("cycles.csv", "labelled.csv", "learnt.yaml"))
    cycles.write_text("action,reaction,time_s\nhigh,arm,0\nlow,back,15\nhigh,,31\nlow,arm,50\n")
    labelled.write_text("preference,recognised,count\narm,arm,9\narm,back,1\nback,back,10\n")
    command = ("record", "learn", cycles, "--experiment", "paper", "--labelled", labelled, "--cache", cache_folder)
    done = fatplan(*command, "--write", worker)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("4 cycles, of which 3 seen. With 95 % intervals:\n  beta: ")
    assert "The data cannot tell beta from 0: " in done.stdout
    assert set(yaml.safe_load(worker.read_text())) <= {"hidden_workers", "choice_models"}


def test_a_reaction_that_is_none_is_named(tmp_path: Path, cache_folder: Path) -> None:
    cycles = tmp_path / "cycles.csv"
    cycles.write_text("action,reaction\nhigh,leg\n")
    message = f"{cycles}, line 2: reaction = 'leg': not one of arm, back."
    assert message in refused(2, "record", "learn", cycles, "--experiment", "paper", "--cache", cache_folder)


PEOPLE = """
name: people
human: natural
cycle: {reach_s: 2.5, work_s: 1, return_s: 2.5}
workers:
  ann: {height_m: 1.6, mass_kg: 58, sex: female}
  ben: {height_m: 1.72, mass_kg: 75, sex: male}
  tom: {height_m: 1.84, mass_kg: 82, sex: male}
actions:
  low: {right_hand: {position_m: {x: 0.4, y: -0.15, z: 0.7}, orientation_deg: {y: -90}}}
"""


def test_one_worker_is_too_few_people(cache_folder: Path, tmp_path: Path) -> None:
    message = refused(2, "record", "recognise", "paper", "--cache", cache_folder, "--results", tmp_path)
    assert "high/arm: repetitions of 1 people; at least 3 are needed" in message
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_command_writes_what_it_says(tmp_path: Path) -> None:
    (tmp_path / "people.yaml").write_text(PEOPLE)
    folders = ("--cache", tmp_path / "cache")
    assert fatplan("simulate", tmp_path / "people.yaml", *folders).returncode == 0
    command = ("record", "recognise", tmp_path / "people.yaml", *folders, "--results", tmp_path / "results")
    found = document(" ".join(map(str, command[:2])), *command[2:])
    folder = Path(found["folder"])
    assert {path.name for path in folder.iterdir()} == set(found["files"])
    matrices = yaml.safe_load((folder / "recognition.yaml").read_text())["recognition_by_action"]
    assert matrices == found["recognition_by_action"]
    assert all(sum(line.values()) == pytest.approx(1, abs=1e-12) for line in matrices["low"].values())
    stored = load_recogniser(folder / "recogniser.json")
    assert stored.key == found["key"] and len(stored.reactions) == 6
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    text = fatplan(*command)
    assert text.returncode == 0 and "low: 95 % are recognised" in text.stdout
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


MIXED = """
benchmark:
  conditions: {novice: {initial_belief: single, expertise: 0}}
  n_cycles: [3]
  trials: 2
  policies: {random: {kind: random}, greedy: {kind: greedy}}
statistics: {}
figures: {}
"""


@pytest.fixture(scope="module")
def recorded(cache_folder: Path, reactions: tuple[Reaction, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the paper's cache and experiment, and a recording of its first reaction."""
    folder = tmp_path_factory.mktemp("recorded")
    shutil.copytree(cache_folder, folder / "cache")
    record(load_experiment(PAPER), reactions[0], folder)
    content = yaml.safe_load(PAPER.read_text()) | yaml.safe_load(MIXED)
    (folder / "mixed.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    return folder


def imported(folder: Path, *more: object) -> tuple[object, ...]:
    stem = "average_man-high-arm"
    files, about = (f"{stem}.trc", f"{stem}_plates.mot"), ("--subject", "average_man.yaml")
    return (*files, *about, "--experiment", "mixed.yaml", "--action", "high", "--preference", "arm", *more)


def test_what_cannot_be_imported_is_said_before_anything_is_read(recorded: Path) -> None:
    def message(*changed: object) -> str:
        done = fatplan("record", "import", *imported(recorded, *changed), cwd=recorded)
        assert done.returncode == 2 and not done.stdout
        return done.stderr

    assert "--action higher: not in the experiment; available: high, low." in message("--action", "higher")
    assert "--preference leg: not in the experiment; available: arm, back." in message("--preference", "leg")
    assert "--phases 'now': four times in s with commas between" in message("--phases", "now")
    assert "no.yaml" in message("--subject", "no.yaml")
    assert "nonsense: neither a file nor a mapping" in message("--mapping", "nonsense")
    assert (
        "no.trc: is not there." in fatplan("record", "import", "no.trc", *imported(recorded)[2:], cwd=recorded).stderr
    )


def test_what_cannot_be_fitted_is_said() -> None:
    assert "--preference leg: not in the experiment; available: arm, back." in refused(
        2, "record", "fit", "paper", "--preference", "leg"
    )
    assert "--preference 'arm': no recorded reaction can be used: `recorded` names none." in refused(
        2, "record", "fit", "paper", "--preference", "arm"
    )


def check_pages(folder: Path, key: str) -> None:
    """What one looks at before believing a torque: nothing is loaded from elsewhere, anybody can use it."""
    text = (folder / "report.html").read_text()
    assert "Verdict: <code>ok</code>" in text and f"&#39;{key}&#39;" in text
    assert all(
        f">{title}</a>" in text for title in ("Markers", "What no plate explains", "Joint angles", "Joint torques")
    )
    assert {"markers.csv", "residuals.csv", "angles.csv", "torques.csv"} <= {file.name for file in folder.iterdir()}
    view = (folder / "view.html").read_text()
    assert "a marker of the recording" in view
    if not HAS_CHROMIUM:
        return
    with chromium(folder / "profile") as page:
        for width in (1400, 390):
            page.open((folder / "report.html").as_uri(), width)
            page.until("document.readyState == 'complete' && document.querySelectorAll('figure').length == 4")
            assert page.faults() == []
            assert page.value("document.documentElement.scrollWidth <= window.innerWidth")
        assert all(address.startswith(("file:", "data:", "about:")) for address in page.requests)


@pytest.mark.slow
def test_a_mixed_experiment_runs(recorded: Path) -> None:
    """One reaction recorded, three simulated: simulate, benchmark, report, schedule, view, and the cache's commands."""

    def done(*words: object) -> str:
        ended = fatplan(*words, cwd=recorded)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    before = Path.cwd()
    os.chdir(recorded)
    try:
        found = document("record import", *imported(recorded, "--phases", "0.5,5.5,11.5,16.5"))
    finally:
        os.chdir(before)
    assert (found["verdict"], found["name"]) == ("ok", "average_man/high/arm")
    check_pages(recorded / found["folder"], found["key"])
    mixed = yaml.safe_load((recorded / "mixed.yaml").read_text())
    mixed["recorded"] = {"average_man": {"high": {"arm": found["key"]}}}
    (recorded / "mixed.yaml").write_text(yaml.safe_dump(mixed, sort_keys=False))
    os.chdir(recorded)
    try:  # what was recorded is what was simulated, so that nothing is closer
        fitted = document("record fit", "mixed.yaml", "--preference", "arm", "--evaluations", "10", "--write", "f.yaml")
    finally:
        os.chdir(before)
    assert fitted["after_deg"] <= fitted["before_deg"] < 1 and fitted["helps"] is fitted["others_deg"] is None
    assert [one["name"] for one in fitted["recordings"]] == ["average_man/high/arm"]
    assert yaml.safe_load((recorded / "f.yaml").read_text()) == {"preferences": {"arm": fitted["preference"]}}
    assert "average_man/high/arm             recorded, ok; hand within" in done("simulate", "mixed.yaml")
    done("benchmark", "mixed.yaml", "--jobs", "1")
    done("report", "mixed.yaml")
    page = (recorded / "results" / "paper" / "report.html").read_text()
    assert "1 reaction was recorded, not simulated" in page and found["key"] in page
    done("schedule", "mixed.yaml", "--trials", "2")
    done("view", "mixed.yaml", "--save", "poses.png")
    assert "recorded" not in done("cache", "why", "mixed.yaml")
    assert json.loads(done("cache", "verify", "--json"))["counts"] == {"ok": 1, "implausible": 4}
    done("cache", "export", "mixed.yaml", "all.zip")
    assert "4 taken" in done("cache", "import", "all.zip", "--cache", "other")
    wrong = {"recorded": {"average_man": {"high": {"arm": "0" * 16}}}}
    (recorded / "wrong.yaml").write_text(yaml.safe_dump(mixed | wrong, sort_keys=False))
    gone = fatplan("simulate", "wrong.yaml", cwd=recorded)
    assert gone.returncode == 2 and "recorded reactions are not there: average_man/high/arm" in gone.stderr

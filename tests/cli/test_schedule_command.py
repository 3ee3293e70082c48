"""`fatplan schedule`: its numbers against runs and schedules made without it, its card, and its refusals."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from commands import fatplan
from conftest import PAPER
from test_cli_json import document, documented_keys

import fatigue_planner as fp
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.schedules.cost import schedule_cost
from fatigue_planner.planners.schedules.search import best_schedule
from fatigue_planner.reactions.reaction import Reaction

CONDITIONS = ("single_novice", "single_expert")
OPTIONS = ("--conditions", CONDITIONS[0], "--conditions", CONDITIONS[1], "--cycles", 12, "--trials", 4, "--jobs", 1)


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.slow
def test_the_numbers_are_those_of_the_same_runs_made_otherwise(
    paper: Experiment, reactions: tuple[Reaction, ...], cache_folder: Path, tmp_path: Path
) -> None:
    where = ("--cache", cache_folder, "--results", tmp_path)
    found = document("schedule", PAPER, *where, *OPTIONS, "--longest", 4, "--bound")
    tasks = {name: fp.scenario(paper, {str(r.name): r for r in reactions}, name) for name in CONDITIONS}
    actions = tuple(found["schedule"])
    policies = {
        "schedule": {"kind": "periodic", "sequence": actions},
        "best_fixed": {"kind": "periodic", "longest": 1},
        "greedy": "greedy",
    }
    for entry in found["conditions"]:
        assert list(entry) == documented_keys("schedule: conditions")
        task = tasks[entry["condition"]]
        runs = fp.run_trials(task, policies, n_cycles=12, trials=4, seed=paper.benchmark.seed)
        cost = -runs.groupby("policy")["discounted_return"].mean()
        assert entry["cost"] == pytest.approx(cost["schedule"], rel=1e-12)
        saved = {saving["over"]: saving for saving in entry["savings"]}
        for other in ("best_fixed", "greedy"):
            share = 1 - cost["schedule"] / cost[other]
            assert saved[other]["share"] == pytest.approx(share, rel=1e-9)
            assert saved[other]["low"] <= saved[other]["share"] <= saved[other]["high"]
        start = task.initial_belief("prior", task.model, np.random.default_rng(0))
        numbers = np.array([[task.model.actions.index(name) for name in actions]])
        own = best_schedule(schedule_cost(start), 2, 4)
        assert [task.model.actions[a] for a in own.actions] == entry["own_schedule"]
        loss = schedule_cost(start).costs(numbers)[0] / own.cost - 1
        assert entry["loss_to_own_schedule"] == pytest.approx(loss, abs=1e-12)
        assert entry["gap_to_bound"] == pytest.approx(entry["cost"] / entry["cost_bound"] - 1)
        assert all(0 <= loss < 0.1 for loss in entry["loss_if_misjudged"].values())
        peaks = entry["peak_fatigue"]["right_shoulder_flexion:positive"]
        course = [
            fp.run(task, {"kind": "fixed", "action": entry["best_fixed"]}, 12, paper.benchmark.seed, t).fatigue
            for t in range(4)
        ]
        shoulder = np.mean([one["right_shoulder_flexion:positive"] for one in course], axis=0).max()
        assert peaks["best_fixed"] == pytest.approx(shoulder, rel=1e-12)
        assert peaks["schedule"] < peaks["best_fixed"]


@pytest.mark.slow
def test_the_card_has_a_step_for_every_cycle_and_is_the_same_again(cache_folder: Path, tmp_path: Path) -> None:
    where = ("--cache", cache_folder, "--results", tmp_path)
    said = fatplan("schedule", PAPER, *where, *OPTIONS)
    assert said.returncode == 0, said.stderr
    lines = said.stdout.splitlines()
    steps = lines[0].removeprefix("Schedule, repeated for ever: ").partition(" (")[0].split(", ")
    folder = tmp_path / "paper" / "schedule"
    first = files_of(folder)
    assert set(first) == {"schedule_card.png", "schedule_card.svg", "schedule_card.csv"}
    rows = list(csv.DictReader(first["schedule_card.csv"].decode().splitlines()))
    assert [row["action"] for row in rows] == steps
    heights = {"high": "right hand 120 cm high, 50 cm ahead", "low": "right hand 50 cm high, 40 cm ahead"}
    assert [row["where"] for row in rows] == [heights[step] for step in steps]
    assert fatplan("schedule", PAPER, *where, *OPTIONS).stdout == said.stdout
    assert files_of(folder) == first


def test_what_a_schedule_cannot_be_made_of_is_refused(cache_folder: Path, tmp_path: Path) -> None:
    where = ("--cache", cache_folder, "--results", tmp_path / "results")
    endless = tmp_path / "endless.yaml"
    text = PAPER.read_text().replace("discount: 0.95", "discount: 1")
    endless.write_text(re.sub(r"\{kind: (robust_)?periodic.*\}", "{kind: greedy}", text))
    for arguments, message in (
        ((PAPER, "--conditions", "nobody"), "--conditions nobody: not in the experiment"),
        ((PAPER, "--longest", 9), "Invalid value for '--longest'"),
        ((PAPER, "--cycles", 0), "Invalid value for '--cycles'"),
        ((endless,), "discount = 1: a schedule repeats for ever"),
    ):
        done = fatplan("schedule", *arguments, *where)
        assert done.returncode == 2 and message in done.stderr, done.stderr
    assert not (tmp_path / "results").exists()
    missing = fatplan("schedule", PAPER, "--cache", tmp_path / "empty", "--results", tmp_path / "results")
    assert missing.returncode == 2 and "fatplan simulate" in missing.stderr


@pytest.mark.slow
def test_a_policy_that_names_what_a_worker_cannot_do_is_refused_before_work(tmp_path: Path) -> None:
    text = PAPER.read_text()
    far = text.replace(
        "actions:                        #", "actions:\n  far: {right_hand: {position_m: {x: 1.2, y: 0, z: 1.2}}}\n  #"
    )
    far = far.replace(
        "    greedy: {kind: greedy}\n", "    greedy: {kind: greedy}\n    away: {kind: fixed, action: far}\n"
    )
    file = tmp_path / "far.yaml"
    file.write_text(far)
    made = fatplan("simulate", file, "--cache", tmp_path / "cache", "--jobs", 1)
    assert made.returncode == 3, made.stderr
    done = fatplan("benchmark", file, "--cache", tmp_path / "cache", "--results", tmp_path)
    assert done.returncode == 2
    assert "benchmark.policies.away.action: far: the worker of single_novice cannot perform it" in done.stderr
    assert "choose among high, low" in done.stderr

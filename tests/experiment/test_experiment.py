"""The paper's experiment file has the paper's numbers, however they are spelt."""

from pathlib import Path

import pytest
import yaml
from conftest import PAPER

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.benchmark_settings import paper_policies
from fatigue_planner.experiment.loader import load_experiment, read_content
from fatigue_planner.experiment.schema import Experiment


def test_the_papers_numbers_are_the_papers(paper: Experiment) -> None:
    """What sections III and IV fix."""
    assert paper.cycle.duration_s == 16 and paper.cycle.work_s == 6 and paper.tool.mass_kg == 5
    high, low = (paper.actions[name].right_hand.position_m for name in ("high", "low"))
    assert (high.x, high.y, high.z) == (0.5, -0.25, 1.2) and (low.x, low.y, low.z) == (0.4, -0.15, 0.5)
    turns = [paper.actions[name].right_hand.orientation_deg for name in ("high", "low")]
    assert turns[0] == turns[1] is not None
    weights = paper.controller.weights
    assert (weights.centre_of_mass, weights.hand, weights.posture) == (1000, 10, 1)
    tasks = {name: [(t.segment, t.weight) for t in p.tasks] for name, p in paper.preferences.items()}
    assert tasks == {"arm": [("thorax", 1)], "back": [("right_upper_arm", 10)]}
    fatigue = paper.fatigue
    assert (fatigue.fatigue_rate_per_s, fatigue.recovery_rate_per_s, fatigue.threshold) == (0.01667, 0.04, 0.1)
    assert paper.discount == 0.95 and paper.statistics.significance_level == 0.05
    assert [s.probability for s in paper.initial_beliefs["multiple"]] == [0.2, 0.4, 0.4]
    grid = paper.benchmark
    assert grid.n_cycles == (5, 20, 100) and grid.trials == 100
    assert paper.statistics.policies == tuple(grid.policies)[:7] == tuple(paper_policies())
    assert [c.expertise for c in grid.conditions.values()] == [0, float("inf"), 0]
    searches = [p for p in grid.policies.values() if p.kind == "pomcp"]
    assert {(p.backup, p.exploration_constant) for p in searches} == {
        (backup, c) for backup in ("mean", "max") for c in (0.1, 0.001)
    }
    assert {p.descents for p in searches} == {5000}


def test_numbers_with_exponents_are_numbers(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        PAPER.read_text().replace("discount: 0.95", "discount: 95e-2").replace("mass_kg: 75 ", "mass_kg: 075 ")
    )
    assert load_experiment(path).discount == 0.95 and load_experiment(path).workers["average_man"].mass_kg == 75
    assert yaml.safe_load("95e-2") == "95e-2"  # why the reader has its own rule


def test_aliases_and_merge_keys_are_written_out(tmp_path: Path, paper: Experiment) -> None:
    """A key of its own goes before a merged one; what two keys share is not the same object."""
    path = tmp_path / "mine.yaml"
    text = (
        PAPER.read_text().replace("_deg: {y: -90} #", "_deg: &fist {y: -90} #").replace("_deg: {y: -90}", "_deg: *fist")
    )
    path.write_text(text)
    assert "*fist" in text and load_experiment(path) == paper
    other = "  anna: {<<: *man, height_m: 1.65}\n"
    path.write_text(text.replace("average_man:\n", "average_man: &man\n").replace("\ntool:", f"{other}\ntool:"))
    workers = read_content(path)["workers"]
    man, anna = workers["average_man"], workers["anna"]
    assert anna == man | {"height_m": 1.65} and anna["natural_posture_deg"] is not man["natural_posture_deg"]


def test_a_decimal_comma_in_a_strength_file_is_named(tmp_path: Path) -> None:
    strengths = tmp_path / "anna.yaml"
    strengths.write_text(
        "population: Anna\nbased_on: average_woman\ndegrees_of_freedom:\n  elbow_flexion:\n    positive: 44,5\n"
        "    source: measured\n"
    )
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER.read_text().replace("strength: average_man", f"strength: {strengths}", 1))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    message = str(caught.value)
    assert "elbow_flexion.positive = '44,5': " in message and "write 44.5, with a decimal point" in message

"""Experiment files: every mistake gives one message that names the place, the value and what is allowed."""

from pathlib import Path

import pytest
import yaml
from conftest import PAPER

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.loader import load_experiment
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
    assert grid.n_cycles == (5, 20, 100) and grid.trials == 100 and len(grid.policies) == 7
    assert [c.expertise for c in grid.conditions.values()] == [0, float("inf"), 0]
    searches = [p for p in grid.policies.values() if p.kind == "pomcp"]
    assert {(p.backup, p.exploration_constant) for p in searches} == {
        (backup, c) for backup in ("mean", "max") for c in (0.1, 0.001)
    }
    assert {p.descents for p in searches} == {5000}


def fault(tmp_path: Path, old: str, new: str) -> str:
    """The message for the paper's file with one thing changed."""
    text = PAPER.read_text()
    assert old in text
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("height_m: 1.75", "height_m: 17.5", "workers.average_man.height_m = 17.5: input should be less than"),
        ("height_m: 1.75", "height_m: .nan", "workers.average_man.height_m = nan: "),
        ("height_m: 1.75", "height_m: tall", "workers.average_man.height_m = 'tall': input should be a valid"),
        ("height_m: 1.75", 'height_m: "1.75"', "workers.average_man.height_m = '1.75': input should be a valid"),
        ("height_m: 1.75", "hight_m: 1.75", "workers.average_man.hight_m: unknown key; did you mean 'height_m'?"),
        ("sex: male", "sex: m", "workers.average_man.sex = 'm': input should be 'female' or 'male'."),
        ("strength: average_man", "strength: hulk", "workers.average_man: strength set 'hulk': neither one of "),
        ("knee_flexion: 5 ", "knee: 5 ", "natural_posture_deg: unknown degree of freedom 'knee'"),
        ("knee_flexion: 5 ", "knee_flexion: -5 ", "natural_posture_deg: knee_flexion = -5.0 deg is outside its range"),
        ("ankle_flexion: 2.5", "ankle_flexion: -10", "natural_posture_deg: the body leans, its centre of mass is "),
        ("knee_flexion: 5 ", "right_knee_flexion: 40 ", "natural_posture_deg: the right sole does not lie flat"),
        ("reach_s: 5", "reach_s: 1e9", "cycle.reach_s = 1000000000.0: input should be less than or equal to 600."),
        ("n_cycles: [5, 20, 100]", "n_cycles: [5, 5]", "benchmark.n_cycles: 5 stands twice."),
        ("figure5b: [mul", "trials: [mul", "figures.trials: begins like another file's name; taken are trials, "),
        ("held: cycle", "held: never", "tool.held = 'never': input should be 'cycle' or 'work'."),
        ("reach_s: 5", "reach_s: 0", "cycle.reach_s = 0: input should be greater than or equal to 0.1."),
        ("x: 0.5, y: -0.25, z: 1.2", "x: 2.5, y: -0.25, z: 1.2", "actions.high.right_hand.position_m: 2.78 m from"),
        ("x: 0.5, y: -0.25, z: 1.2", "x: 0.5, y: -0.25", "actions.high.right_hand.position_m.z: is missing."),
        ("segment: thorax", "segment: back", "preferences.arm.tasks.0.segment = 'back': input should be 'pelvis', "),
        ("solver: daqp", "solver: osqp", "controller.solver = 'osqp': input should be 'daqp' or 'qpoases'."),
        ("time_step_s: 0.01", "time_step_s: 5", "controller.time_step_s = 5: input should be less than or equal"),
        ("friction_coefficient: 0.5", "friction_coefficient: -1", "controller.friction_coefficient = -1: "),
        ("threshold: 0.1 ", "threshold: 10 ", "fatigue.threshold = 10: input should be less than 1."),
        ("discount: 0.95", "discount: 1.5", "discount = 1.5: input should be less than or equal to 1."),
        ("{probability: 0.2}", "{probability: 0.3}", "initial_beliefs.multiple: probabilities sum to 1.1, not to 1."),
        ("lumbar_flexion: 0.5", "back: 0.5", "initial_beliefs.multiple.1.fatigue: unknown joint 'back'"),
        ("lumbar_flexion: 0.5", "lumbar_flexion: 1.5", "initial_beliefs.multiple.1.fatigue.lumbar_flexion = 1.5: "),
        ("expertise: .inf", "expertise: -1", "benchmark.conditions.single_expert.expertise = -1: "),
        ("expertise: .inf", "expertise: .nan", "benchmark.conditions.single_expert.expertise = nan: "),
        ("{initial_belief: single, expertise: 0}", "{initial_belief: none, expertise: 0}",
         "benchmark.conditions.single_novice.initial_belief: 'none' is not one of single, multiple."),
        ("exploration_constant: 0.1,", "exploration_constant: -0.1,",
         "benchmark.policies.pomcp_0.1.exploration_constant = -0.1: input should be greater than or equal to 0."),
        ("exploration_constant: 0.1,", "exploration_konstant: 0.1,",
         "benchmark.policies.pomcp_0.1.exploration_konstant: unknown key; did you mean 'exploration_constant'?"),
        ("random: {kind: random}", "random: {kind: random, c: 1}", "benchmark.policies.random.c: unknown key"),
        ("random: {kind: random}", "random: {kind: dice}", "benchmark.policies.random"),
        ("n_cycles: [5, 20, 100]", "n_cycles: []", "benchmark.n_cycles = []: should have at least 1 of them"),
        ("n_cycles: [5, 20, 100]", "n_cycles: [5.5]", "benchmark.n_cycles.0 = 5.5: input should be a valid integer."),
        ("trials: 100", "trials: yes", "benchmark.trials = True: input should be a valid integer."),
        ("figure5b: [multiple_novice]", "figure5b: [none]", "figures.figure5b: none; known conditions: single_nov"),
        ("name: paper", "name: ../paper", "name = '../paper': should begin with a letter"),
        ("name: paper", "name: paper\nname: paper", "line 6, column 1: key 'name' stands twice."),
        ("name: paper", "name: &n paper\nother: *n", "line 6, column 8: aliases (*name) are not allowed."),
        ("name: paper", "name: !!python/object:os.system {}", "line 5, column 7: tags (here "),
        ("name: paper", "name: [", "line "),
        ("mass_kg: 75 ", "mass_kg: 0x4B ", "workers.average_man.mass_kg = '0x4B': input should be a valid number."),
        ("reach_s: 5", "reach_s: 1:30", "cycle.reach_s = '1:30': input should be a valid number."),
        ("name: paper", "1: paper", "line 5, column 1: key 1 is not text; put it in quotes"),
    ],
)  # fmt: skip
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert expected in fault(tmp_path, old, new)


def test_all_mistakes_are_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER.read_text().replace("height_m: 1.75", "height_m: 9").replace("sex: male", "sex: x"))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert len(str(caught.value).splitlines()) == 2


@pytest.mark.parametrize("content", ["", "- 1", "text", "\x00", "name: a\n\tb: c"])
def test_files_that_are_no_experiment(tmp_path: Path, content: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(content)
    with pytest.raises(ExperimentError, match=r"mine\.yaml: "):
        load_experiment(path)


def test_missing_file_folder_and_binary(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="No such file"):
        load_experiment(tmp_path / "none.yaml")
    with pytest.raises(ExperimentError, match="is not a file"):
        load_experiment(tmp_path)
    (tmp_path / "b.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ExperimentError, match="UTF-8"):
        load_experiment(tmp_path / "b.yaml")


def test_numbers_with_exponents_are_numbers(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        PAPER.read_text().replace("discount: 0.95", "discount: 95e-2").replace("mass_kg: 75 ", "mass_kg: 075 ")
    )
    assert load_experiment(path).discount == 0.95 and load_experiment(path).workers["average_man"].mass_kg == 75
    assert yaml.safe_load("95e-2") == "95e-2"  # why the reader has its own rule

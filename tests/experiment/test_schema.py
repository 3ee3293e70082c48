"""What a file may leave out, and what the schema tells of every key."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from commands import fatplan, refused

from fatigue_planner.core.errors import ExperimentError, SelectionError
from fatigue_planner.core.settings import Settings
from fatigue_planner.experiment.loader import complete_content, editor_schema, load_experiment, parse_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.anthropometry import Anthropometry, HumanKind
from fatigue_planner.human.stance import stance_deg
from fatigue_planner.station.schema import Station
from fatigue_planner.study.benchmark.selection import Selection, selected
from fatigue_planner.study.benchmark.worth import Role, roles_of
from fatigue_planner.study.claims.schema import ClaimsFile
from fatigue_planner.study.sensitivity.settings import StudySettings

SMALLEST = """\
name: mine
actions:
  shelf: {right_hand: {position_m: {x: 0.45, y: -0.2, z: 1.2}}}
  bench: {right_hand: {position_m: {x: 0.4, y: -0.2, z: 0.9}}}
"""
# What the description of a number has: its unit, or that it has none.
UNIT = re.compile(
    r"\bin (m|s|kg|N|N\.m|rad|rad/s|rad/s\^2|degrees|1/s|1/s\^2|1 / cost|SI units|the unit|the keys' unit)\b"
    r"|without unit|fraction|Level of|Probability|the unit is that of"
)
POINT = {"position_m": {"x": 0.4, "y": 0.0, "z": 1.0}}
ANNA = {"height_m": 1.65, "mass_kg": 60.0, "sex": "female"}


def smallest(**more: Any) -> Experiment:
    return parse_experiment({**yaml.safe_load(SMALLEST), **more}, "mine")


def keys(schema: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    """Every key of every mapping in a schema, with what the schema says of it."""
    if isinstance(schema, dict):
        for name, said in schema.get("properties", {}).items():
            yield f"{above}.{name}", said
        for name, inside in schema.items():
            yield from keys(inside, name if above == "$defs" else f"{above}.{name}" if above else name)
    elif isinstance(schema, list):
        for inside in schema:
            yield from keys(inside, above)


@pytest.mark.parametrize("kind", [Experiment, ClaimsFile, StudySettings, Station])
def test_every_key_is_described(kind: type[Settings]) -> None:
    described = dict(keys(editor_schema(kind)))
    assert len(described) > 8
    assert [key for key, said in described.items() if not said.get("description", "").strip().endswith(".")] == []
    numbers = {key: said for key, said in described.items() if _is_number(said)}
    assert [key for key, said in numbers.items() if not UNIT.search(said["description"])] == []


def _is_number(schema: dict[str, Any]) -> bool:
    return schema.get("type") == "number" or any(map(_is_number, schema.get("anyOf", [])))


def test_only_the_task_is_needed_and_the_rest_is_the_papers(paper: Experiment) -> None:
    mine = smallest(human="paper")
    same = ("workers", "cycle", "preferences", "controller", "accuracy", "fatigue", "discount")
    assert [key for key in same if getattr(mine, key) != getattr(paper, key)] == []
    seven = {name: paper.benchmark.policies[name] for name in paper.statistics.policies or ()}
    unplanned = ("fixed", "threshold_0.1", "threshold_0.2", "best_fixed", "periodic")
    assert mine.benchmark.policies == seven | {name: paper.benchmark.policies[name] for name in unplanned}
    assert not {Role.FIXED, Role.REACTIVE, Role.SCHEDULE, Role.GREEDY, Role.PLANNING} - roles_of(mine).keys()
    endless = smallest(discount=1).benchmark.policies  # the best schedule would have no value
    assert [name for name in mine.benchmark.policies if name not in endless] == ["best_fixed", "periodic"]
    same = ("n_cycles", "trials", "seed", "reference")
    assert [key for key in same if getattr(mine.benchmark, key) != getattr(paper.benchmark, key)] == []
    own = {"families": paper.statistics.families, "policies": paper.statistics.policies}
    assert mine.statistics.model_copy(update=own) == paper.statistics
    assert mine.tool.mass_kg == 0  # what is not mentioned is not in the hand
    assert mine.initial_beliefs["rested"] == paper.initial_beliefs["single"]
    assert {name: condition.expertise for name, condition in mine.benchmark.conditions.items()} == {
        "novice": 0, "expert": float("inf"),
    }  # fmt: skip
    assert mine.figures == {"returns": ("novice", "expert")}


def test_workers_are_the_human_of_the_experiment_unless_they_name_one() -> None:
    workers = {"anna": ANNA, "bob": ANNA | {"human": "paper"}}
    assert smallest().human == "natural"
    humans: tuple[HumanKind, HumanKind] = ("natural", "paper")
    for mine, expected in (
        (smallest(workers=workers), humans),
        (smallest(human="paper", workers=workers), ("paper",) * 2),
    ):
        found = tuple((worker.human, worker.natural_posture_deg) for worker in mine.workers.values())
        assert found == tuple((human, stance_deg(Anthropometry(1.65, 60, "female", human))) for human in expected)
        assert parse_experiment(complete_content(mine), "again") == mine


def test_defaults_follow_what_the_file_says() -> None:
    left = smallest(actions={"a": {"left_hand": POINT}})
    both = smallest(actions={"a": {"left_hand": POINT}, "b": {"right_hand": POINT}})
    assert [task.segment for task in left.preferences["back"].tasks] == ["left_upper_arm"]
    assert [task.segment for task in both.preferences["back"].tasks] == ["right_upper_arm", "left_upper_arm"]
    beliefs = {"rested": ({"probability": 1},), "tired": ({"probability": 1, "fatigue": {"elbow_flexion": 0.5}},)}
    several = smallest(
        workers={"anna": ANNA, "bert": ANNA | {"sex": "male"}}, initial_beliefs=beliefs, benchmark={"trials": 7}
    )
    assert several.workers["anna"].strength == "average_woman" and several.workers["bert"].strength == "average_man"
    assert several.benchmark.trials == 7 and len(several.benchmark.conditions) == 8
    condition = several.benchmark.conditions["bert_tired_expert"]
    assert (condition.worker, condition.initial_belief, condition.expertise) == ("bert", "tired", float("inf"))


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"actions": None}, "mine: actions = None: should be a mapping of keys and values."),
        ({"workers": {"anna": {}}}, "mine: workers.anna.height_m: is missing.\n"
         "mine: workers.anna.mass_kg: is missing.\nmine: workers.anna.sex: is missing."),
        ({"workers": {"a": ANNA | {"sex": "f"}}}, "mine: workers.a.sex = 'f': input should be 'female' or 'male'."),
        ({"tool": {}}, "mine: tool.mass_kg: is missing."),
        ({"benchmark": {"conditions": {}}}, "mine: benchmark.conditions = {}: should have at least 1 of them."),
        ({"benchmark": None}, "mine: benchmark = None: should be a mapping of keys and values."),
    ],
)  # fmt: skip
def test_what_is_missing_is_said_and_nothing_that_follows_from_it(more: dict[str, Any], expected: str) -> None:
    with pytest.raises(ExperimentError) as caught:
        smallest(**more)
    assert str(caught.value) == expected


def test_a_file_without_actions_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\n")
    assert refused(2, "validate", file) == f"Error: {file}: actions: is missing.\n"


def test_what_is_left_to_defaults_is_said_and_can_be_written_out(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(SMALLEST + "workers: {anna: {height_m: 1.65, mass_kg: 60, sex: female}}\ncycle: {work_s: 8}\n")
    said = fatplan("validate", file).stdout.splitlines()[1]
    assert said.startswith(
        "Left to defaults: human, workers.anna.strength, workers.anna.natural_posture_deg, tool, cycle.reach_s"
    )
    whole = tmp_path / "whole.yaml"
    whole.write_text(fatplan("validate", file, "--resolved").stdout)
    assert load_experiment(whole) == load_experiment(file)
    assert len(fatplan("validate", whole).stdout.splitlines()) == 1


def test_fewer_descents_than_actions_are_refused(paper: Experiment) -> None:
    search = {"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 1}
    with pytest.raises(ExperimentError, match=r"policies\.mine\.descents = 1: 2 actions need at least 2 descents"):
        smallest(benchmark={"policies": {"mine": search}})
    assert smallest(benchmark={"policies": {"mine": search | {"descents": 2}}})
    with pytest.raises(SelectionError, match="--descents 1: 2 actions need at least 2 descents, one for each"):
        selected(paper, Selection(None, None, None, None, 1, None))


def test_the_best_schedule_needs_a_discount() -> None:
    for policy in ({"kind": "periodic"}, {"kind": "robust_periodic"}):
        with pytest.raises(ExperimentError, match=r"policies\.mine: the best schedule is that of a task without end"):
            smallest(discount=1, benchmark={"policies": {"mine": policy}})
    names = tuple(smallest().actions)
    assert smallest(discount=1, benchmark={"policies": {"mine": {"kind": "periodic", "sequence": names}}})


def test_a_file_to_begin_with_is_valid_and_never_overwritten(tmp_path: Path) -> None:
    assert fatplan("init", "no", cwd=tmp_path).returncode == 0  # a name that YAML reads as false
    file = tmp_path / "no.yaml"
    assert load_experiment(file).name == "no" and len(file.read_text().splitlines()) < 40
    assert fatplan("init", "mine", "--json", cwd=tmp_path).stdout == '{\n "file": "mine.yaml",\n "name": "mine"\n}\n'
    file.write_text("mine")
    assert fatplan("init", "other.yaml", cwd=tmp_path).returncode == 0 and (tmp_path / "other.yaml").exists()
    done = fatplan("init", "no", cwd=tmp_path)
    assert done.returncode == 2 and "no.yaml: exists already" in done.stderr and file.read_text() == "mine"
    assert fatplan("init", "../mine", cwd=tmp_path).returncode == 2 and not (tmp_path.parent / "mine.yaml").exists()


@pytest.mark.slow
def test_a_file_to_begin_with_can_be_simulated(tmp_path: Path) -> None:
    assert fatplan("init", "mine", cwd=tmp_path).returncode == 0
    done = fatplan("simulate", "mine.yaml", cwd=tmp_path)
    assert done.returncode == 0 and "4 simulated" in done.stdout, done.stderr


@pytest.mark.slow
def test_which_human_moves_is_said_where_the_file_does_not(tmp_path: Path) -> None:
    brisk = "cycle: {reach_s: 0.1, work_s: 0.1, return_s: 0.1}\n"  # too fast for anybody, and over at once
    said = {}
    for name, human in (("silent", ""), ("named", "human: natural\n")):
        file = tmp_path / f"{name}.yaml"
        file.write_text(SMALLEST + brisk + human)
        said[name] = fatplan("simulate", file, "--cache", tmp_path / "cache", "--jobs", 1).stderr
    assert said["silent"].count("human: natural") == 1 and "names no human" in said["silent"]
    assert "names no human" not in said["named"]

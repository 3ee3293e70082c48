"""Environments: Gymnasium's own check passes, episodes are trials of the benchmark, many at once are as one by one."""

import ast
import math
from pathlib import Path
from typing import Any

import crying_baby  # examples/crying_baby.py
import light_dark  # examples/light_dark.py
import numpy as np
import pytest
import rock_sample  # examples/rock_sample.py
import tiger  # examples/tiger.py
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import SyncVectorEnv
from small_problems import NOISY, SEVERAL, STARTS, hidden, known

import fatigue_planner as fp
from fatigue_planner.core.errors import ExitCode, MissingExtraError, ProblemError, SelectionError
from fatigue_planner.core.files import PACKAGE
from fatigue_planner.planners.registry import policy
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import replay
from fatigue_planner.study.environments.vector import VectorEnvironment


def imported(path: Path) -> set[str]:
    """The packages that a file imports."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    names = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    names += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return {name.partition(".")[0] for name in names}


PROBLEMS: dict[str, Any] = {
    "novice": known(0.0, SEVERAL[:1]), "some expertise": known(25.0, SEVERAL), "expert": known(math.inf, STARTS),
    "misrecognised": known(0.0, SEVERAL, NOISY), "hidden": hidden(), "tiger": tiger.NO_IDEA,
    "baby": crying_baby.JUST_FED,
}  # fmt: skip
N_CYCLES = 6


@pytest.mark.parametrize("name", PROBLEMS)
def test_gymnasiums_check_passes(name: str) -> None:
    check_env(fp.environment(PROBLEMS[name], N_CYCLES), skip_render_check=True)  # a warning is an error


@pytest.mark.parametrize("name", [name for name in PROBLEMS if name not in ("tiger", "baby")])
def test_episodes_are_the_trials_of_a_benchmark(name: str) -> None:
    scenario = PROBLEMS[name]
    cell = Cell(scenario.name, N_CYCLES, "random", policy("random"), scenario, seed=11, trials=3)
    task = fp.environment(scenario, N_CYCLES)
    first = task.reset(seed=11)
    for trial, result in cell.run_one_by_one(range(3)).items():
        observation, info = first if trial == 0 else task.reset()
        assert observation == len(scenario.model.observations) and set(info) == {"fatigue"}
        total, costs, cut = 0.0, [], []
        course = replay(cell, trial, result.actions)
        for cycle, action in enumerate(result.actions):
            observation, reward, terminated, truncated, info = task.step(action)
            total += scenario.model.discount**cycle * reward
            costs.append(-reward)
            cut.append(truncated)
            assert not terminated and set(info) == {"fatigue", "reaction"}
            assert np.mean(info["fatigue"] ** 2) == pytest.approx(-reward, rel=1e-12)
            assert observation == course.observations[cycle]
            assert scenario.model.outcomes[info["reaction"]] == course.reactions[cycle][1]
            np.testing.assert_array_equal(info["fatigue"], course.fatigue[cycle])
        assert total == pytest.approx(result.discounted_return, rel=1e-12)
        assert (costs[-1], max(costs)) == (result.final_cost, result.peak_cost)  # bit for bit
        assert cut == [False] * (N_CYCLES - 1) + [True]


@pytest.mark.parametrize("name", PROBLEMS)
def test_many_at_once_are_gymnasiums_own_of_single_ones(name: str) -> None:
    """Every number of reset and step, through the automatic resets, and after a second reset without a seed."""
    count = 5
    ours = fp.vector_environment(PROBLEMS[name], count, N_CYCLES)
    theirs = SyncVectorEnv([lambda: fp.environment(PROBLEMS[name], N_CYCLES)] * count)
    assert (ours.action_space, ours.observation_space) == (theirs.action_space, theirs.observation_space)
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    rng, seen = np.random.default_rng(3), set()
    for seed in (2023, None, [1, 2, 3, 4, 5]):
        assert data_equivalence(ours.reset(seed=seed), theirs.reset(seed=seed), exact=True)  # type: ignore[arg-type]
        for _ in range(3 * N_CYCLES):
            actions = rng.integers(len(ours.model.actions), size=count)
            found = ours.step(actions)
            assert data_equivalence(found, theirs.step(actions), exact=True)
            seen |= {*found[1].tolist()}
    assert len(seen) > (3 if name in ("tiger", "baby") else 10)


def test_an_episode_ends_where_the_problem_does_and_nothing_forbidden_is_done() -> None:
    belief = rock_sample.start(rock_sample.rock_sample(3, [(0, 0)]), (0, 1))
    ours, count = fp.vector_environment(belief, 3, 10), 3
    theirs = SyncVectorEnv([lambda: fp.environment(belief, 10)] * count)
    assert data_equivalence(ours.reset(seed=1), theirs.reset(seed=1), exact=True)
    ended = []
    for _ in range(9):
        found = ours.step(["east"] * count)
        numbers = np.full(count, belief.model.actions.index("east"))
        assert data_equivalence(found, theirs.step(numbers), exact=True)
        ended.append(found[2].tolist())
    assert ended == ([[False] * 3] * 2 + [[True] * 3] + [[False] * 3]) * 2 + [[False] * 3]
    task = fp.environment(belief, 10)
    task.reset(seed=1)
    with pytest.raises(SelectionError, match="action 'west': forbidden in the state"):
        task.step("west")
    with pytest.raises(ProblemError, match="one of finitely many observations"):
        fp.environment(light_dark.NO_IDEA)


def test_what_is_returned_is_not_changed_later() -> None:
    many = fp.vector_environment(PROBLEMS["novice"], 3, N_CYCLES)
    kept = [many.reset(seed=1), many.step([0, 1, 0])]
    before = repr(kept)
    many.step([1, 1, 1])
    many.reset()
    assert repr(kept) == before


def test_an_action_is_a_number_or_a_name() -> None:
    results = []
    for actions in ([0, 1], ["a", "b"], [np.int64(0), np.array(1)]):
        task = fp.environment(PROBLEMS["novice"], 2)
        task.reset(seed=1)
        results.append([task.step(action)[1] for action in actions])
    assert results[0] == results[1] == results[2]
    many = fp.vector_environment(PROBLEMS["novice"], 2, 2)
    rewards = []
    for many_actions in ([0, 1], ["a", "b"], np.array(["a", "b"])):
        many.reset(seed=1)
        rewards.append(many.step(many_actions)[1].tolist())
    assert rewards[0] == rewards[1] == rewards[2]


@pytest.mark.parametrize("action", [2, -1, 0.0, "c", None, True, [0], np.array([0, 1])])
def test_what_is_no_action_is_refused(action: Any) -> None:
    task, many = fp.environment(PROBLEMS["novice"], 2), fp.vector_environment(PROBLEMS["novice"], 3, 2)
    task.reset()
    many.reset()
    with pytest.raises(SelectionError, match=r"action .*: must be a, b, or a number from 0 to 1\.$"):
        task.step(action)
    with pytest.raises(SelectionError, match=r"must be 3 of a, b, or a number from 0 to 1\.$"):
        many.step([0, action, 0] if not isinstance(action, np.ndarray) else action)


def test_an_episode_must_have_begun_and_not_be_over() -> None:
    task, many = fp.environment(PROBLEMS["novice"], 1), fp.vector_environment(PROBLEMS["novice"], 2, 1)
    for one in (task.step, many.step):
        with pytest.raises(ResetNeeded, match="call reset"):
            one(0)
    task.reset()
    assert task.step(0)[3]
    with pytest.raises(ResetNeeded, match="call reset"):
        task.step(0)


def test_what_cannot_be_built_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for cycles, count in ((0, 1), (1, 0)):
        with pytest.raises(SelectionError, match="there must be at least one of each"):
            fp.vector_environment(PROBLEMS["novice"], count, cycles)
    many = fp.vector_environment(PROBLEMS["novice"], 3, 2)
    assert isinstance(many, VectorEnvironment)
    with pytest.raises(SelectionError, match="2 seeds: there are 3 environments"):
        many.reset(seed=[1, 2])
    monkeypatch.setattr("fatigue_planner.api.find_spec", lambda _: None)
    for make in (lambda: fp.environment(PROBLEMS["novice"]), lambda: fp.vector_environment(PROBLEMS["novice"], 2)):
        with pytest.raises(MissingExtraError, match=r"pip install 'fatigue-planner\[gymnasium\]'") as refused:
            make()
        assert refused.value.exit_code == ExitCode.BAD_INPUT


def test_without_a_seed_episodes_differ() -> None:
    returns = set()
    for _ in range(3):
        task, many = fp.environment(PROBLEMS["some expertise"], 20), fp.vector_environment(PROBLEMS["novice"], 4, 20)
        task.reset()
        many.reset()
        returns |= {sum(task.step(0)[1] for _ in range(20))}
        returns |= set(np.sum([many.step([0] * 4)[1] for _ in range(20)], axis=0).tolist())
    assert len(returns) == 15


def test_only_environments_import_gymnasium() -> None:
    importing = [path for path in PACKAGE.rglob("*.py") if "gymnasium" in imported(path)]
    assert {path.parent.name for path in importing} == {"environments"} and len(importing) == 2

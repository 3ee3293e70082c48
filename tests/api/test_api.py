"""Scripts and notebooks get the same numbers as the command line, with names instead of indices."""

from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER

import fatigue_planner as fp
from fatigue_planner.planners.policy import plain_decision
from fatigue_planner.study.benchmark.cell import Cell

CYCLES, SEED = 6, 3


@pytest.fixture(scope="module")
def scenario(cache_folder: Path):
    experiment = fp.load(PAPER)
    return fp.scenario(experiment, fp.simulate(experiment, cache_folder), "multiple_novice")


class ByName:
    """Low, then high, then low ..., by name; knows how often it was asked."""

    def __init__(self) -> None:
        self.seen: list[int] = []

    def act(self, belief: fp.Belief, rng: np.random.Generator) -> str:
        return ("low", "high")[len(self.seen) % 2]

    def observe(self, action: int, observation: int) -> None:
        self.seen.append(observation)


class ByIndex(fp.Policy):
    def act(self, belief: fp.Belief, rng: np.random.Generator) -> fp.Decision:
        return plain_decision(1, np.full(2, np.nan), 0, 0.0, "always the second", belief)


POMCP_MAX = {"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 50}


@pytest.mark.parametrize("kind", ["random", "greedy", POMCP_MAX], ids=str)
def test_runs_have_the_numbers_of_a_benchmark(scenario, kind) -> None:
    cell = Cell(scenario.name, CYCLES, "mine", fp.policy(kind), scenario, SEED, 3)
    table = fp.run_trials(scenario, {"mine": kind}, CYCLES, 3, SEED)
    results = cell.run(range(3))
    assert table["discounted_return"].tolist() == [results[trial].discounted_return for trial in range(3)]
    assert table["final_cost"].tolist() == [results[trial].final_cost for trial in range(3)]


def test_your_own_object_is_a_policy(scenario) -> None:
    mine = ByName()
    found = fp.run(scenario, mine, CYCLES, SEED)
    assert found.cycles["action"].tolist() == ["low", "high"] * 3
    assert mine.seen == []  # every run has a copy
    assert set(found.cycles["reaction"]) <= {"arm", "back"} and found.cycles["observed"].equals(
        found.cycles["reaction"]
    )
    assert fp.run(scenario, ByIndex(), CYCLES, SEED).cycles["action"].unique().tolist() == ["low"]
    alternating = fp.run(scenario, "alternating", CYCLES, SEED)
    assert alternating.cycles["action"].tolist() == ["high", "low"] * 3
    assert np.isclose(found.discounted_return, -(found.cycles["cost"] * 0.95**found.cycles.index).sum(), rtol=1e-12)
    assert np.isclose(found.cycles["cost"].iloc[-1], (found.fatigue.iloc[-1] ** 2).mean(), rtol=1e-12)


@pytest.mark.parametrize("chosen", ["middle", 2, -1, None, 0.5])
def test_a_choice_that_is_not_an_action_is_refused(scenario, chosen: object) -> None:
    class Wrong:
        def act(self, belief: fp.Belief, rng: np.random.Generator) -> object:
            return chosen

    with pytest.raises(fp.FatplanError, match=r"Wrong\.act: .* is not one of high, low"):
        fp.decide(scenario, Wrong())


@pytest.mark.parametrize(
    ("settings", "message"),
    [("gredy", "gredy"), ({"kind": "pomcp"}, "backup"), ({"kind": "greedy", "c": 1}, "c")],
)
def test_wrong_settings_are_reported(settings: object, message: str) -> None:
    with pytest.raises(fp.FatplanError, match=message):
        fp.policy(settings)


def test_an_unknown_condition_is_reported(cache_folder: Path) -> None:
    experiment = fp.load(PAPER)
    with pytest.raises(fp.FatplanError, match="'nobody': not in the experiment; available: single_novice"):
        fp.scenario(experiment, {}, "nobody")


def test_torques_and_angles_are_tables(cache_folder: Path) -> None:
    reactions = fp.simulate(fp.load(PAPER), cache_folder)
    reaction = reactions["average_man/high/arm"]
    torques, angles = reaction.torques_nm(), reaction.angles_rad()
    assert torques.shape == angles.shape == (1600, 39) and torques.index.name == "time_s"
    column = torques.columns.get_loc("right_elbow_flexion")
    assert (torques["right_elbow_flexion"].to_numpy() == reaction.motion.torque_nm[:, column]).all()
    assert angles["right_elbow_flexion"].max() > 0.5
    with pytest.raises(KeyError):
        _ = reactions["average_man/high/leg"]

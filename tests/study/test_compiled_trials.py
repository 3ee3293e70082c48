"""Trials run at once in compiled loops are the trials run one by one, bit for bit."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from small_problems import NOISY, SEVERAL, hidden, known

from fatigue_planner.core.errors import PluginError
from fatigue_planner.experiment.build import cycle_profiles
from fatigue_planner.experiment.build import scenario as scenario_of
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import AlternatingPolicy, AlternatingSettings, GreedyPolicy, GreedySettings
from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.beliefs.registry import ParticleSettings
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark import cell as cell_module
from fatigue_planner.study.benchmark.cell import Cell

TRIALS = range(3, 9)


SCENARIOS = {
    "novice": known(0.0, SEVERAL[:1]), "some expertise": known(25.0, SEVERAL), "expert": known(math.inf, SEVERAL),
    "misrecognised": known(0.0, SEVERAL, NOISY), "hidden": hidden(),
}  # fmt: skip
RULES: dict[str, Any] = {
    "greedy": "greedy", "lookahead_2": {"kind": "lookahead", "depth": 2},
    "lookahead_1_bound": {"kind": "lookahead", "depth": 1, "leaf_value": "bound"},
}  # fmt: skip
AHEAD: dict[str, Any] = {
    "random": "random", "alternating": "alternating", "fixed": "fixed",
    "given": {"kind": "periodic", "sequence": ("b", "a", "a")}, "periodic": {"kind": "periodic", "longest": 3},
}  # fmt: skip
ORDINARY: dict[str, Any] = {
    "threshold": {"kind": "threshold", "fatigue_threshold": 0.1},
    "lookahead_random": {"kind": "lookahead", "depth": 1, "leaf_value": "random_rollout"},
    "pomcp": {"kind": "pomcp", "backup": "mean", "exploration_constant": 0.1, "descents": 20},
}


def cell_of(scenario: Scenario, name: str, settings: PolicySettings) -> Cell:
    return Cell("c", 12, name, settings, scenario, seed=5, trials=20)


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(
    "name", ["greedy", *AHEAD, *(pytest.param(name, marks=pytest.mark.slow) for name in RULES if name != "greedy")]
)
def test_they_are_those_that_are_run_one_by_one(scenario: str, name: str) -> None:
    cell = cell_of(SCENARIOS[scenario], name, policy((RULES | AHEAD)[name]))
    at_once = name in AHEAD or scenario not in ("misrecognised", "hidden")
    assert (cell.trials_at_once > 1) is at_once
    if at_once:
        found = cell.run(TRIALS)
        assert found == cell.run_one_by_one(TRIALS)  # equal but for the planning times
        assert cell.run([7]) == {7: found[7]}
        assert all(type(value) is not np.float64 for value in vars(found[7]).values())


@pytest.mark.parametrize("expertise", [0.0, 500.0])
def test_beliefs_that_decide_are_the_same(expertise: float, paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """In the paper's task, with three possible starts, what is believed changes what is done from run to run."""
    condition = paper.benchmark.conditions["multiple_novice"].model_copy(update={"expertise": expertise})
    one = scenario_of(paper, cycle_profiles(paper, reactions), condition)
    cell = Cell("c", 40, "greedy", policy("greedy"), one, seed=5, trials=20)
    found = cell.run(range(10))
    assert found == cell.run_one_by_one(range(10)) and len({result.actions for result in found.values()}) > 5


@pytest.mark.parametrize("name", ORDINARY)
def test_others_are_asked_every_cycle(name: str) -> None:
    assert cell_of(SCENARIOS["novice"], name, policy(ORDINARY[name])).trials_at_once == 1


def test_particles_and_policies_that_know_the_truth_are_asked_every_cycle() -> None:
    particles = replace(SCENARIOS["novice"], belief=ParticleSettings(kind="particles", count=5))
    assert cell_of(particles, "alternating", policy("alternating")).trials_at_once == 1
    truth = policy({"kind": "alternating", "knows": "truth"})
    assert cell_of(SCENARIOS["hidden"], "a", truth).trials_at_once == 1
    assert cell_of(SCENARIOS["novice"], "a", truth).trials_at_once > 1


class Contrary(GreedyPolicy):
    """Acts otherwise than the class whose rule it has."""

    def act(self, belief: Any, rng: Any) -> Any:
        decision = super().act(belief, rng)
        return replace(decision, action=1 - decision.action)


class Listening(AlternatingPolicy):
    """Observes what the class that looks ahead does not."""

    def observe(self, action: int, observation: int) -> None:
        self._cycle = observation


@pytest.mark.parametrize(("kind", "derived"), [(GreedySettings, Contrary), (AlternatingSettings, Listening)])
def test_a_policy_derived_from_one_that_is_compiled_is_asked(
    kind: type[PolicySettings], derived: type[Policy], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kind, "build", lambda _: derived())
    cell = cell_of(SCENARIOS["novice"], "x", policy(kind.model_fields["kind"].annotation.__args__[0]))  # type: ignore[union-attr]
    assert cell.trials_at_once == 1 and cell.run(TRIALS) == cell.run_one_by_one(TRIALS)


@pytest.mark.parametrize("actions", [np.zeros(11, int), np.full(12, 2), np.full(12, -1), np.zeros(12), None])
def test_actions_ahead_that_are_none_are_refused(actions: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(AlternatingPolicy, "ahead", lambda *_: actions)
    with pytest.raises(PluginError, match=r"AlternatingPolicy: ahead returned .*, not 12 actions from 0 to 1"):
        cell_of(SCENARIOS["novice"], "x", policy("alternating")).run(TRIALS)


def test_they_are_the_same_in_parts_of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is compiled draws only what it needs, from the same streams."""
    for scenario in ("some expertise", "hidden"):
        cell = cell_of(SCENARIOS[scenario], "random", policy("random"))
        whole = cell.run(range(8))
        assert whole == {**cell.run(range(3)), **cell.run(range(3, 8))}
        monkeypatch.setattr(cell_module, "can_be_compiled", lambda *_: False)
        assert cell.run(range(8)) == whole
        monkeypatch.undo()

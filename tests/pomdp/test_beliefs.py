"""The exact belief: Bayes' rule by enumeration, and observations that are impossible under the model."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from small_problems import (
    EXPERTISES,
    NOISY,
    belief_in,
    pomcp,
    relaxed,
    small_model,
    table_belief,
    table_problem,
    two_workers,
)
from tree_checks import assert_bayes

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import GreedyPolicy
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.reactions.reaction import Reaction

RNG = np.random.default_rng(0)  # exact beliefs draw nothing


@pytest.mark.parametrize("recognition", [None, NOISY])
@pytest.mark.parametrize("expertise", EXPERTISES[:2])
def test_belief_is_bayes_rule_over_whole_histories(expertise: float, recognition: np.ndarray | None) -> None:
    model = small_model(expertise, recognition)
    start = belief_in(model, np.random.default_rng(9).uniform(0, 0.8, (3, 3)), [0.2, 0.5, 0.3])
    assert_bayes(start, [0, 1, 0], [0, 0, 1])


@pytest.mark.parametrize("recognition", [None, NOISY])
def test_belief_in_two_workers_is_bayes_rule_too(recognition: np.ndarray | None) -> None:
    assert_bayes(two_workers(recognition), [1, 0, 1], [1, 0, 0])


def test_exact_observation_never_grows_the_belief(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    task = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions["multiple_novice"])
    belief = task.initial_belief("prior", task.model, RNG)
    for cycle in range(30):
        belief = belief.update(cycle % 2, cycle // 3 % 2, RNG)
    assert belief.states.shape[0] == 3
    np.testing.assert_allclose(belief.weights, [0.2, 0.4, 0.4])  # a novice's choice reveals nothing


def test_an_expert_choice_tells_the_states_apart() -> None:
    """A state from which the expert would have chosen otherwise is ruled out."""
    model = small_model(math.inf)
    fatigue = np.random.default_rng(0).uniform(0, 1, (40, 3))
    belief = belief_in(model, fatigue, np.full(40, 1 / 40))
    choices = np.array([model.probabilities(state, 0).argmax() for state in belief.states])
    assert 0 < choices.sum() < 40
    after = belief.update(0, 1, RNG)
    assert len(after.weights) == choices.sum() and not after.surprised


def test_histories_that_meet_are_counted_as_one_state() -> None:
    """Where the tables lead all states together, a belief of two states stays a belief of two."""
    problem = table_problem(np.full((1, 2, 2), 0.5), np.zeros((1, 2, 2)), np.full((1, 2, 2), 0.5), 9, 1.0)
    belief = table_belief(problem, [0.2, 0.8])
    for _ in range(3):
        belief = belief.update(0, 1, RNG)
        np.testing.assert_allclose(belief.weights, [0.5, 0.5])
        assert belief.states[:, 0].tolist() == [0, 1]


def unexpected(case: str) -> tuple[ExactBelief, int, np.ndarray]:
    """A belief, an observation after action 0 that is impossible for it, and the mean state that follows nevertheless.

    outcome: an expert chooses what he never would, and it is recognised without error
    noisy: the same, but another observation tells nothing of it
    never: no preference is ever recognised so
    """
    matrix = {
        "outcome": None,
        "noisy": np.array([[1.0, 0, 0], [0, 0.6, 0.4]]),
        "never": np.array([[1.0, 0, 0], [1, 0, 0]]),
    }
    model = small_model(math.inf, matrix[case])
    if case != "outcome":
        model = replace(model, observations=("x", "y", "unclear"))
    belief = relaxed(model)
    chosen = int(model.probabilities(belief.states[0], 0).argmax())
    forced = model.transition(belief.states[0], 0, 1 - chosen)[0]
    usual = model.transition(belief.states[0], 0, chosen)[0]
    if case == "never":
        return belief, 1, usual
    return belief, 1 - chosen, forced


@pytest.mark.parametrize("case", ["outcome", "noisy", "never"])
def test_an_impossible_observation_never_raises_and_is_reported(case: str) -> None:
    """The worker must have chosen an impossible outcome, or it is ignored; every policy says so."""
    belief, observation, expected = unexpected(case)
    after = belief.update(0, observation, RNG)
    assert after.surprised and after.weights.sum() == pytest.approx(1)
    np.testing.assert_allclose(after.weights @ after.states, expected, rtol=1e-12)
    lookahead = LookaheadPolicy(LookaheadSettings(kind="lookahead", depth=2))
    for policy in (GreedyPolicy(), lookahead, PomcpPolicy(pomcp(20))):
        assert "the last observation was impossible under the model" in policy.act(after, RNG).reason
        assert "impossible" not in policy.act(belief, RNG).reason
    usual = int(belief.model.probabilities(after.states[0], 0).argmax())
    assert not after.update(0, 0 if case == "never" else usual, RNG).surprised


def test_any_sequence_of_observations_keeps_a_belief() -> None:
    for matrix in (None, np.array([[1.0, 0], [1, 0]])):
        for seen in product((0, 1), repeat=4):
            belief = relaxed(small_model(math.inf, matrix))
            for action, observation in zip((0, 1, 1, 0), seen, strict=True):
                belief = belief.update(action, observation, RNG)
                assert belief.weights.sum() == pytest.approx(1) and np.isfinite(belief.states).all()

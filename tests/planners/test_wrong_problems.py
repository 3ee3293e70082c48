"""A problem or belief whose probabilities are not probabilities is refused before anything is planned."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter
from tiger import PROBLEM

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import compiled
from fatigue_planner.planners.registry import AnyPolicy
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief

STATES = np.array([[0.0], [1.0]])
POLICIES = [
    {"kind": "greedy"},
    {"kind": "lookahead", "depth": 2},
    {"kind": "pomcp", "backup": "mean", "exploration_constant": 1.0, "descents": 10},
]


@compiled
def seven_tenths(_arrays, _state, action, chances):
    for side in range(2):
        chances[side] = 0.35 if action == 2 else 0.5


@compiled
def below_zero(_arrays, _state, _action, chances):
    chances[0], chances[1] = 1.5, -0.5


@compiled
def seen_twice(_arrays, _state, _action, _outcome, _observation):
    return 0.6


WRONG = {
    r"outcomes of action 'listen' in state \[0.0\] sum to 0.7": {"outcome_probabilities": seven_tenths},
    r"\[1.5, -0.5\] of the outcomes of action 'open left' in state \[0.0\]": {"outcome_probabilities": below_zero},
    r"observations after action 'open left' and outcome 'left' in state \[0.0\] sum to 1.2": {
        "observation_probability": seen_twice
    },
}


@pytest.mark.parametrize("settings", POLICIES, ids=lambda settings: settings["kind"])
@pytest.mark.parametrize("message", WRONG)
def test_chances_that_do_not_sum_to_one_are_refused(settings, message) -> None:
    problem = replace(PROBLEM, dynamics=replace(PROBLEM.dynamics, **WRONG[message]))
    policy = TypeAdapter(AnyPolicy).validate_python(settings).build()
    with pytest.raises(ProblemError, match=message):
        policy.act(ExactBelief(problem, STATES, np.array([0.5, 0.5])), np.random.default_rng(0))


@pytest.mark.parametrize("kind", [ExactBelief, lambda *given: ParticleBelief(*given, log_weights=np.zeros(2))])
@pytest.mark.parametrize(
    ("weights", "message"),
    [([1.0, 1.0], "sum to 2, not to 1"), ([1.5, -0.5], "negative"), ([np.nan, 1.0], "nan"), ([1.0], "shape")],
)
def test_weights_that_are_not_probabilities_are_refused(kind, weights, message) -> None:
    with pytest.raises(ProblemError, match=message):
        kind(PROBLEM, STATES, np.array(weights))

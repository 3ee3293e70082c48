"""A problem or belief whose probabilities are not probabilities is refused before anything is planned."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from pydantic import TypeAdapter
from tiger import PROBLEM

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import compiled
from fatigue_planner.planners.registry import AnyPolicy, policy
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
    actor = TypeAdapter(AnyPolicy).validate_python(settings).build()
    with pytest.raises(ProblemError, match=message):
        actor.act(ExactBelief(problem, STATES, np.array([0.5, 0.5])), np.random.default_rng(0))


@pytest.mark.parametrize("kind", [ExactBelief, lambda *given: ParticleBelief(*given, log_weights=np.zeros(2))])
@pytest.mark.parametrize(
    ("weights", "message"),
    [([1.0, 1.0], "sum to 2, not to 1"), ([1.5, -0.5], "negative"), ([np.nan, 1.0], "nan"), ([1.0], "shape")],
)
def test_weights_that_are_not_probabilities_are_refused(kind, weights, message) -> None:
    with pytest.raises(ProblemError, match=message):
        kind(PROBLEM, STATES, np.array(weights))


# --- functions that cannot be compiled, told in their author's terms ----------------------------------------------


@compiled
def unknown_name(_arrays, state, action, side):
    state[0] = side
    return REWARD[action]  # noqa: F821 - that is the mistake


@compiled
def number_of_a_truth(_arrays, state, _action, chances):
    chances[0] = float(state[0] == 0.0)
    chances[1] = 1.0 - chances[0]


@compiled
def no_such_array(arrays, _state, _action, _side):
    return arrays.gold


def undecorated_helper(x):
    return x + 1.0


@compiled
def calls_undecorated(_arrays, _state, _action, _side):
    return undecorated_helper(1.0)


@compiled
def not_a_number(_arrays, _state, _action, _side):
    return np.nan


@compiled
def array_made_in_a_step(_arrays, _state, _action, _scratch, _rng):
    chances = np.array([0.5, 0.5])
    return 0, chances[0]


@compiled
def nothing_returned(_arrays, state, _action, side):
    state[0] = side


TOLD = [
    ("advance", unknown_name, r"advance: your function unknown_name \(test_wrong_problems.py, line \d+\) cannot be "
     r"compiled.* REWARD is not defined"),
    ("outcome_probabilities", number_of_a_truth, r"number_of_a_truth .*At line \d+, 'chances\[0\] = float\(state\[0\] "
     r"== 0.0\)': a truth value is no number: write 1.0 if x else 0.0"),
    ("advance", no_such_array, r"no_such_array .*the problem's arrays are None: they have no gold"),
    ("advance", calls_undecorated, r"calls_undecorated .*undecorated_helper .*decorate it with fp.compiled"),
    ("advance", nothing_returned, r"nothing_returned .* must return the reward, a number; it returned None"),
    ("advance", not_a_number, r"not_a_number .* must return the reward, a number; it returned nan"),
    ("step", array_made_in_a_step, r"array_made_in_a_step .*it makes a new array; write into the arrays it is given"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "function", "message"), TOLD, ids=[function.__name__ for _, function, _ in TOLD])
def test_what_numba_cannot_compile_is_told_in_the_authors_terms(name, function, message) -> None:
    problem = replace(PROBLEM, dynamics=replace(PROBLEM.dynamics, **{name: function}))
    belief, rng = ExactBelief(problem, STATES, np.array([0.5, 0.5])), np.random.default_rng(0)
    with pytest.raises(ProblemError, match=message) as told:
        policy({"kind": "pomcp", "backup": "mean", "exploration_constant": 1.0, "descents": 10}).build().act(
            belief, rng
        )
    assert "\n" not in str(told.value) and "Traceback" not in str(told.value) and "nopython" not in str(told.value)
    assert told.value.__cause__ is None
    assert told.value.__suppress_context__ or told.value.__context__ is None
    with pytest.raises(ProblemError, match=message):
        problem.sample_step(STATES[0], 2, rng)


def test_functions_that_only_a_search_calls_are_told_too() -> None:
    """What is found when a whole kernel is compiled; the author's line is named all the same."""
    dynamics = replace(PROBLEM.dynamics, is_legal=lambda _arrays, state, action: state.colour == action)
    belief = ExactBelief(replace(PROBLEM, dynamics=dynamics), STATES, np.array([0.5, 0.5]))
    with pytest.raises(
        ProblemError, match=r"is_legal: your function <lambda> \(test_wrong_problems.py, line \d+\).*colour"
    ):
        belief.legal_actions()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"advance": lambda _arrays, _state: 1.0}, r"advance: your function <lambda> .* takes 2 arguments; it must "
         r"take 4: \(arrays, state, action, outcome\)"),
        ({"prior": lambda *_: (0, 0)}, r"prior: your function .* takes 0 arguments; it must take 3"),
        ({"rollout": "east"}, r"rollout: 'east' is no function; write one with def"),
    ],
    ids=["few", "any", "text"],
)  # fmt: skip
def test_functions_of_another_form_are_refused(given, message) -> None:
    with pytest.raises(ProblemError, match=message):
        replace(PROBLEM.dynamics, **given)


def test_a_function_need_not_be_decorated() -> None:
    dynamics = replace(PROBLEM.dynamics, bound=lambda _arrays, state: state[0])
    assert dynamics.bound is not None and hasattr(dynamics.bound, "py_func")


class Lists(NamedTuple):
    """What numba crashes on."""

    rocks: object
    size: int


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"arrays": Lists([[1.0, 2.0], [3.0]], 7)}, r"arrays.rocks: list; it must be a number, a NumPy array"),
        ({"arrays": {"size": 7}}, "arrays: dict; it must be a number"),
        ({"arrays": Lists(np.array(["a"]), 7)}, "arrays.rocks: an array of <U1; it must be one of numbers"),
        ({"discount": 2.0}, "discount: 2.0; it lies between 0 and 1"),
        ({"actions": "listen"}, "actions: 'listen' are no names"),
    ],
)
def test_a_problem_that_compiled_code_cannot_get_is_refused(given, message) -> None:
    with pytest.raises(ProblemError, match=message):
        replace(PROBLEM, **given)
    assert replace(PROBLEM, actions=["a", "b", "c"]).actions == ("a", "b", "c")


def test_states_are_a_table_of_numbers() -> None:
    with pytest.raises(ProblemError, match=r"states have shape \(2,\); give one row for each"):
        ExactBelief(PROBLEM, np.array([0.0, 1.0]), np.array([0.5, 0.5]))
    belief = ExactBelief(PROBLEM, [[0], [1]], [0.5, 0.5])
    assert belief.states.dtype == belief.weights.dtype == np.float64


def test_a_step_is_asked_for_by_numbers_and_with_a_generator() -> None:
    with pytest.raises(IndexError, match="action 'listen': actions are numbered from 0"):
        PROBLEM.sample_step(STATES[0], "listen", np.random.default_rng(0))
    with pytest.raises(ProblemError, match="rng: None is no random generator"):
        PROBLEM.sample_step(STATES[0], 2, None)

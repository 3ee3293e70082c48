"""A problem with every optional function, small enough to be solved by recursion; and searches run as plain Python."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from plain_python import interpreted

from fatigue_planner.core import jit
from fatigue_planner.core.jit import compiled
from fatigue_planner.planners import lookahead
from fatigue_planner.planners.pomcp.sparse import policy
from fatigue_planner.pomdp import dynamics, problem
from fatigue_planner.pomdp.beliefs import belief, exact
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.problem import Dynamics, Pomdp

# A ferry that may be out of order lies beyond a bridge. A state: place (0 home, 1 bridge, 2 gone), whether it is out.
BACK, ON, ASK, TURN_BACK = range(4)
DISCOUNT, TOLD_RIGHTLY = 0.9, 0.8


@compiled
def ferry_outcomes(_arrays: Any, _state: np.ndarray, _action: int, probabilities: np.ndarray) -> None:
    probabilities[0] = 1.0


@compiled
def ferry_legal(_arrays: Any, state: np.ndarray, action: int) -> bool:
    """Nobody goes back from home, turns back on the bridge, or asks there."""
    return state[0] == 1 if action == BACK else action == ON or state[0] == 0


@compiled
def ferry_advance(_arrays: Any, state: np.ndarray, action: int, _outcome: int) -> float:
    """It is noticed if something forbidden is tried, or goes on after the end."""
    assert state[0] < 2
    assert ferry_legal(None, state, action)
    if action == ASK:
        return -0.5
    if action == TURN_BACK:
        state[0] = 2.0
        return 1.0
    state[0] += 1.0 if action == ON else -1.0
    if state[0] == 2:
        return 10.0 if state[1] == 0 else -8.0
    return -0.1


@compiled
def ferry_see(_arrays: Any, state: np.ndarray, action: int, _outcome: int, observation: int) -> float:
    return 0.5 if action != ASK else TOLD_RIGHTLY if observation == state[1] else 1 - TOLD_RIGHTLY


@compiled
def ferry_gone(_arrays: Any, state: np.ndarray) -> bool:
    return state[0] == 2


@compiled
def ferry_prior(_arrays: Any, _state: np.ndarray, action: int) -> tuple[float, float]:
    return (4.0, 3.0) if action == ON else (0.0, 0.0)


@compiled
def ferry_rollout(_arrays: Any, _state: np.ndarray, _rng: np.random.Generator) -> int:
    return ON


@compiled
def ferry_bound(_arrays: Any, state: np.ndarray) -> float:
    return 2.0 + state[0]


RULES = {"is_legal": ferry_legal, "is_terminal": ferry_gone}
HELP = {"prior": ferry_prior, "rollout": ferry_rollout, "bound": ferry_bound}


def ferry(**functions: Any) -> ExactBelief:
    """At home; the ferry is out of order with probability 0.4."""
    made = Pomdp(
        ("back", "on", "ask", "turn back"), ("sure",), ("works", "out"), DISCOUNT, None,
        Dynamics(ferry_outcomes, ferry_advance, ferry_see, **{**RULES, **functions}),
    )  # fmt: skip
    return ExactBelief(made, np.array([[0.0, 0.0], [0.0, 1.0]]), np.array([0.6, 0.4]))


@cache
def ferry_values(out: float, place: int, steps: int) -> dict[int, float]:
    """Independent of the package: the exact values of the legal actions, by recursion over the belief."""

    def best(chance: float, where: int) -> float:
        return max(ferry_values(round(chance, 14), where, steps - 1).values()) if steps > 1 else 0.0

    told = [TOLD_RIGHTLY * out + 0.2 * (1 - out), 0.2 * out + TOLD_RIGHTLY * (1 - out)]
    after = [TOLD_RIGHTLY * out / told[0], 0.2 * out / told[1]]
    if place == 1:
        return {BACK: -0.1 + DISCOUNT * best(out, 0), ON: 10 * (1 - out) - 8 * out}
    ask = -0.5 + DISCOUNT * sum(chance * best(now, 0) for chance, now in zip(told, after, strict=True))
    return {ON: -0.1 + DISCOUNT * best(out, 1), ASK: ask, TURN_BACK: 1.0}


# Light at 0: a place is seen the better, the nearer it is. A state: the place.
@compiled
def line_advance(_arrays: Any, state: np.ndarray, action: int, outcome: int) -> float:
    state[0] += (-1.0, 0.0, 1.0)[action] + 0.5 * outcome
    return -abs(state[0])


@compiled
def line_outcomes(_arrays: Any, _state: np.ndarray, _action: int, probabilities: np.ndarray) -> None:
    probabilities[0], probabilities[1] = 0.75, 0.25


@compiled
def line_see(
    _arrays: Any, state: np.ndarray, _action: int, _outcome: int, seen: np.ndarray, rng: np.random.Generator
) -> None:
    seen[0] = rng.normal(state[0], 0.5 + abs(state[0]))
    seen[1] = rng.random()


@compiled
def line_density(_arrays: Any, state: np.ndarray, _action: int, _outcome: int, seen: np.ndarray) -> float:
    deviation = 0.5 + abs(state[0])
    return math.exp(-0.5 * ((seen[0] - state[0]) / deviation) ** 2) / deviation


def line(**functions: Any) -> ExactBelief:
    """Somewhere between -2 and 2, with continuous observations of two numbers."""
    given = {"observation_probability": line_density, "draw_observation": line_see} | functions
    dynamics_of_line = Dynamics(line_outcomes, line_advance, **given)
    made = Pomdp(("left", "stay", "right"), ("still", "drifts"), ("place", "noise"), 0.9, None, dynamics_of_line)
    return ExactBelief(made, np.arange(-2.0, 3.0)[:, None], np.full(5, 0.2))


def run_plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let problems made from now on, their beliefs and their sparse searches run as plain Python."""

    def plain(template: Any, *compiler: Any, **parts: Any) -> Any:
        return interpreted(jit.specialised(template, *compiler, **parts))

    monkeypatch.setattr(dynamics, "checked", lambda _name, function, _arguments: getattr(function, "py_func", function))
    for module in (problem, belief, exact):
        monkeypatch.setattr(module, "specialised", plain)
    kernels = {policy: "search_kernel", lookahead: "lookahead_kernel"}
    for module, name in kernels.items():
        made = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *which, made=made: _with_attributes(interpreted(made(*which))))


def _with_attributes(kernel: Any) -> Any:
    """The kernel with the fields of nodes as attributes, as in compiled code."""

    def run(*values: Any) -> Any:
        return kernel(
            *(
                value._replace(nodes=value.nodes.view(np.recarray))
                if hasattr(value, "nodes") and hasattr(value, "used")
                else value
                for value in values
            )
        )

    return run

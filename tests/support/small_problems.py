"""Problems small enough to be solved exactly, and searches of them, for the tests of the planners."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fatigue_planner.core.jit import compiled
from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings
from fatigue_planner.planners.pomcp.policy import PomcpPolicy, PomcpSettings
from fatigue_planner.planners.pomcp.tree import Tree
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.boltzmann import normalise_choice
from fatigue_planner.pomdp.choices.choice_model import ChoiceModel
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, build_pomdp, one_worker
from fatigue_planner.pomdp.hidden_worker import HiddenWorker, WorkerPrior
from fatigue_planner.pomdp.problem import Dynamics, Pomdp
from fatigue_planner.pomdp.scenario import Scenario, average_worker

# --- artificial fatigue -------------------------------------------------------------------------------------------

NOISY = np.array([[0.8, 0.2], [0.3, 0.7]])
STARTS = np.array([[0.1, 0.6, 0.2], [0.4, 0.1, 0.3]])
SEVERAL = np.array([[0.0, 0.0, 0.0], *STARTS])


def choice_probabilities(costs: np.ndarray, expertise: float) -> np.ndarray:
    """Eq. 4 for costs (U,)."""
    probabilities = costs.copy()
    normalise_choice(probabilities, expertise, np.ones((1, costs.size)), 0)
    return probabilities


def small_profiles() -> dict[tuple[str, str], CycleProfile]:
    """Two actions, two preferences, three entries, all of which tire and rest in every reaction."""
    rng = np.random.default_rng(3)
    rates = np.full(3, 0.01667), np.full(3, 0.04)
    zeros = np.zeros((1, 3))
    return {
        name: DoseProfile(rng.uniform(5, 60, (1, 3)), zeros, zeros, rng.uniform(2, 15, 3), *rates)
        for name in product("ab", "xy")
    }


def small_model(
    expertise: float, recognition: np.ndarray | None = None, choices: ChoiceModel | None = None
) -> FatiguePomdp:
    """The made-up task; its worker's choices are random unless he is an expert."""
    odds = None if choices is None else choices.log_odds("xy")
    worker = one_worker(expertise)
    return build_pomdp("ab", "xy", small_profiles(), np.zeros((1, 3)), worker, 0.95, recognition, log_odds=odds)


def belief_in(model: FatiguePomdp, fatigue: np.ndarray, weights: Any) -> ExactBelief:
    """The exact belief in fatigues (n, entries)."""
    return ExactBelief(model, np.array([model.state(levels) for levels in fatigue]), np.asarray(weights, float))


def two_starts(model: FatiguePomdp) -> ExactBelief:
    return belief_in(model, STARTS, [0.3, 0.7])


def relaxed(model: FatiguePomdp) -> ExactBelief:
    return belief_in(model, np.zeros((1, model.entries)), [1.0])


def two_workers(recognition: np.ndarray | None = None) -> ExactBelief:
    """Two hidden workers, a novice that tires fast and one of some expertise, in two states each."""
    workers = Workers(np.array([1.5, 0.8]), np.array([0.9, 1.1]), np.array([0.0, 25.0]))
    model = small_model(0.0, recognition).for_workers(workers)
    states = np.array([model.state(fatigue, worker) for fatigue in STARTS for worker in (0, 1)])
    return ExactBelief(model, states, np.array([0.1, 0.2, 0.3, 0.4]))


def known(expertise: float, starts: np.ndarray, recognition: np.ndarray | None = None) -> Scenario:
    """A task whose worker is known."""
    belief = belief_in(small_model(expertise, recognition), starts, np.full(len(starts), 1 / len(starts)))
    return Scenario(belief.model, belief.states, belief.weights, None, ExactSettings(kind="exact"))


def hidden() -> Scenario:
    """One of four workers, who are novices or of some expertise."""
    choice = {"kind": "choice", "values": [0.7, 1.4], "probabilities": [0.5, 0.5]}
    prior = WorkerPrior(
        HiddenWorker.model_validate({"fatigue_rate_factor": choice, "recovery_rate_factor": choice}, strict=False), 25.0
    )
    one = known(0.0, SEVERAL)
    return replace(one, model=one.model.for_workers(average_worker(prior)), prior=prior)


# --- problems given as tables, with a last cycle -----------------------------------------------------------------


class Tables(NamedTuple):
    """move (A, S, S'): P(s' | s, a); reward (A, S, S'); see (A, S', O): P(o | s', a); nothing after `horizon`."""

    move: np.ndarray
    reward: np.ndarray
    see: np.ndarray
    horizon: int


@compiled
def table_outcomes(tables: Tables, state: np.ndarray, action: int, probabilities: np.ndarray) -> None:
    for outcome in range(probabilities.size):
        probabilities[outcome] = tables.move[action, int(state[0]), outcome]


@compiled
def table_advance(tables: Tables, state: np.ndarray, action: int, outcome: int) -> float:
    reward = tables.reward[action, int(state[0]), outcome] if state[1] < tables.horizon else 0.0
    state[0] = outcome
    state[1] += 1
    return reward


@compiled
def table_see(tables: Tables, state: np.ndarray, action: int, _outcome: int, observation: int) -> float:
    return tables.see[action, int(state[0]), observation]


@compiled
def table_bound(tables: Tables, state: np.ndarray) -> float:
    """A number that depends on the state (for the tests it need not be a bound)."""
    return -0.5 * state[0] - state[1]


TABLES = Dynamics(table_outcomes, table_advance, table_see, bound=table_bound)


def table_problem(move: np.ndarray, reward: np.ndarray, see: np.ndarray, horizon: int, discount: float) -> Pomdp:
    """A problem whose outcome is the next state; a state is (s, cycle)."""
    names = [
        tuple(f"{kind}{i}" for i in range(n)) for kind, n in zip("aso", (*move.shape[:2], see.shape[2]), strict=True)
    ]
    observation_reveals_outcome = see.shape[1:] == (see.shape[1],) * 2 and bool((see == np.eye(see.shape[1])).all())
    return Pomdp(
        *names,
        discount,
        Tables(move, reward, see, horizon),
        TABLES,
        observation_reveals_outcome=observation_reveals_outcome,
    )


def table_belief(problem: Pomdp, weights: Any) -> ExactBelief:
    """The belief at the first cycle with probabilities (S,) of the states."""
    weights = np.asarray(weights, float)
    states = np.array([[s, 0.0] for s in range(weights.size)])
    return ExactBelief(problem, states[weights > 0], weights[weights > 0])


def table_value(problem: Pomdp, belief: np.ndarray, cycle: int = 0) -> np.ndarray:
    """Independent of the package's kernels: exact values (A,) of a belief (S,) by recursion over reachable beliefs."""
    move, reward, see, horizon = problem.arrays
    values = np.zeros(len(move))
    if cycle < horizon:
        for action in range(len(move)):
            joint = belief[:, None] * move[action]
            values[action] = (joint * reward[action]).sum()
            for observation in range(see.shape[2]):
                after = joint.sum(axis=0) * see[action, :, observation]
                if after.sum() > 0:
                    best = table_value(problem, after / after.sum(), cycle + 1).max()
                    values[action] += problem.discount * after.sum() * best
    return values


def tiger_with_an_end(horizon: int, hears_right: float = 0.85) -> Pomdp:
    """The tiger problem (examples/tiger.py) as tables, with a last cycle."""
    again, even = np.full((2, 2), 0.5), np.full((2, 2), 0.5)
    move = np.array([again, again, np.eye(2)])
    doors = np.array([[-100.0, 10.0], [10.0, -100.0], [-1.0, -1.0]])
    hears = np.array([[hears_right, 1 - hears_right], [1 - hears_right, hears_right]])
    return table_problem(move, np.repeat(doors[:, :, None], 2, axis=2), np.array([even, even, hears]), horizon, 0.95)


def random_tables(seed: int, actions: int, states: int, horizon: int, revealed: bool) -> Pomdp:
    """A problem made of random tables; `revealed`: the state is always seen."""
    rng = np.random.default_rng(seed)
    move = rng.dirichlet(np.ones(states), (actions, states))
    reward = rng.uniform(-1, 0, (actions, states, states))
    see = np.repeat(np.eye(states)[None], actions, axis=0) if revealed else rng.dirichlet(np.ones(2), (actions, states))
    return table_problem(move, reward, see, horizon, 0.9)


# --- searches ----------------------------------------------------------------------------------------------------


def pomcp(descents: int, c: float = 0.1, backup: str = "mean", **others: Any) -> PomcpSettings:
    return PomcpSettings(kind="pomcp", backup=backup, exploration_constant=c, descents=descents, **others)


# The nodes in use of a search tree; their fields are its attributes.
Nodes = Any


def nodes_of(tree: Tree) -> Nodes:
    return tree.nodes[: tree.size[0]].view(np.recarray)


def tree_of(belief: Belief, settings: PomcpSettings, seed: int = 1) -> Nodes:
    """The nodes of a fresh search."""
    return nodes_of(PomcpPolicy(settings).tree(belief, np.random.default_rng(seed), 0.0))


def lookahead(belief: Belief, depth: int, **others: Any) -> np.ndarray:
    """The values (A,) of a lookahead."""
    settings = LookaheadSettings(kind="lookahead", depth=depth, **others)
    return LookaheadPolicy(settings).values(belief, np.random.default_rng(1))


def expectimax(belief: Belief, action: int, depth: int) -> float:
    """Exact value of an action with `depth` cycles to go by plain enumeration, one belief update after the other."""
    value = float(belief.expected_rewards()[action])
    if depth == 1:
        return value
    model, rng = belief.model, np.random.default_rng(0)
    chances = np.zeros(len(model.observations))
    for state, weight in zip(belief.states, belief.weights, strict=True):
        for outcome, probability in enumerate(model.probabilities(state, action)):
            after, _ = model.transition(state, action, outcome)
            chances += weight * probability * model.observation_probabilities(after, action, outcome)
    for o in np.flatnonzero(chances):
        following = belief.update(action, int(o), rng)
        best = max(expectimax(following, a, depth - 1) for a in range(len(model.actions)))
        value += model.discount * chances[o] * best
    return value


def nodes_with_tried(tree: Nodes) -> Iterator[tuple[int, int]]:
    """All chance nodes."""
    yield from map(tuple, np.argwhere(tree.tried > 0).tolist())


def with_discount(belief: ExactBelief, discount: float) -> ExactBelief:
    return replace(belief, model=replace(belief.model, discount=discount))


EXPERTISES = (0.0, 25.0, math.inf)

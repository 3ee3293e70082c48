"""The POMDP: preference choice, reward, live entries, and Bayes' rule by enumeration."""

import math
from itertools import product

import numpy as np
import pytest
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp, build_pomdp

from fatigue_planner.experiment.resolve import cycle_maps, problem
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.cycle_map import CycleMap, cycle_map
from fatigue_planner.fatigue.parameters import fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.pomdp.preference_choice import preference_probabilities
from fatigue_planner.reactions.reaction import Reaction


def small_model(expertise: float, observation: np.ndarray | None = None) -> FatiguePomdp:
    """Two actions, two preferences, three entries, made up."""
    rng = np.random.default_rng(3)
    maps = {}
    for a, u in product("ab", "xy"):
        gain = rng.uniform(0.5, 0.9, 3)
        maps[a, u] = CycleMap(gain, rng.uniform(0, 1, 3) * (1 - gain))
    model = build_pomdp("ab", "xy", maps, np.zeros((1, 3)), expertise, 0.95)
    if observation is None:
        return model
    from dataclasses import replace

    return replace(model, observation=observation)


COSTS = np.array([0.2, 0.1, 0.4])


@pytest.mark.parametrize("expertise", [0, 1e-300, 0.5, 10, 1e3, 1e308, math.inf])
def test_choice_is_a_distribution_that_prefers_the_cheap(expertise: float) -> None:
    p = preference_probabilities(COSTS, expertise)
    assert p.sum() == pytest.approx(1, abs=1e-15) and (p >= 0).all()
    assert p[1] >= p[0] >= p[2]


def test_choice_is_equation_4() -> None:
    weights = np.exp(-7 * COSTS)
    np.testing.assert_allclose(preference_probabilities(COSTS, 7), weights / weights.sum(), rtol=1e-14)


def test_choice_at_both_ends_and_ties() -> None:
    np.testing.assert_array_equal(preference_probabilities(COSTS, 0), np.full(3, 1 / 3))
    np.testing.assert_array_equal(preference_probabilities(COSTS, math.inf), [0, 1, 0])
    tied = np.array([0.3, 0.1, 0.1])
    np.testing.assert_array_equal(preference_probabilities(tied, math.inf), [0, 0.5, 0.5])
    np.testing.assert_array_equal(preference_probabilities(np.zeros(2), 1e308), [0.5, 0.5])


def test_choice_does_not_depend_on_a_common_cost() -> None:
    np.testing.assert_allclose(preference_probabilities(COSTS + 1e6, 3), preference_probabilities(COSTS, 3), rtol=1e-8)


def test_live_entries_change_nothing(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Cost and choice from the live entries are those from all 78."""
    condition = paper.benchmark.conditions["multiple_novice"].model_copy(update={"expertise": 50.0})
    model, belief = problem(paper, cycle_maps(paper, reactions), condition)
    assert model.entries == 78 and len(model.live) < 40
    parameters = fatigue_parameters(paper.fatigue, maximum_torque("average_man"))
    maps = {str(r.name): cycle_map(r.motion.torque_nm, r.motion.time_step_s, parameters) for r in reactions}
    full = np.zeros(78)
    full[model.live] = belief.states[1]
    for a, action in enumerate(model.actions):
        after = np.array([maps[f"average_man/{action}/{u}"].apply(full) for u in model.preferences])
        costs = (after**2).sum(axis=1) / 78
        np.testing.assert_allclose(model.cost(model.next_fatigue(belief.states[1], a)), costs, rtol=1e-12)
        np.testing.assert_allclose(model.choice(belief.states[1], a), preference_probabilities(costs, 50.0), rtol=1e-9)


def test_a_task_that_tires_nobody_can_be_planned() -> None:
    """Loads below every threshold: no entry ever becomes non-zero, and every policy still answers."""
    from fatigue_planner.planners.pomcp import PomcpPolicy

    maps = {(a, u): CycleMap(np.full(3, 0.5), np.zeros(3)) for a, u in product("ab", "xy")}
    model = build_pomdp("ab", "xy", maps, np.zeros((1, 3)), 0.0, 0.95)
    belief = Belief(np.zeros((1, model.live.size)), np.ones(1))
    decision = PomcpPolicy(model, 20, 0.1, False).act(belief, np.random.default_rng(0))
    assert decision.action == 0 and not decision.values.any()


def test_initial_beliefs_are_the_papers(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    model, belief = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions["multiple_novice"])
    np.testing.assert_allclose(belief.weights, [0.2, 0.4, 0.4])
    np.testing.assert_allclose(belief.states.sum(axis=1), [0, 1, 1])  # both entries of one joint at 0.5
    _, single = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions["single_expert"])
    assert single.weights.tolist() == [1] and not single.states.any()
    assert model.discount == 0.95


NOISY = np.array([[0.8, 0.2], [0.3, 0.7]])


@pytest.mark.parametrize("observation", [None, NOISY])
@pytest.mark.parametrize("expertise", [0.0, 20.0])
def test_belief_is_bayes_rule_over_whole_histories(expertise: float, observation: np.ndarray | None) -> None:
    """Filtering step by step equals summing over all states and all sequences of hidden preferences."""
    model = small_model(expertise, observation)
    rng = np.random.default_rng(9)
    start = Belief(rng.uniform(0, 0.8, (3, 3)), np.array([0.2, 0.5, 0.3]))
    actions, seen = [0, 1, 0], [0, 0, 1]
    belief = start
    for action, o in zip(actions, seen, strict=True):
        belief = belief.update(model, action, o)
    mass, mean = 0.0, np.zeros(3)
    for i, path in product(range(3), product(range(2), repeat=3)):
        state, weight = start.states[i], start.weights[i]
        for action, u, o in zip(actions, path, seen, strict=True):
            weight = weight * model.choice(state, action)[u] * model.observation[u, o]
            state = model.next_fatigue(state, action)[u]
        mass, mean = mass + weight, mean + weight * state
    assert belief.weights.sum() == pytest.approx(1)
    np.testing.assert_allclose(belief.weights @ belief.states, mean / mass, rtol=1e-12)


def test_exact_observation_never_grows_the_belief(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    model, belief = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions["multiple_novice"])
    for cycle in range(30):
        belief = belief.update(model, cycle % 2, cycle // 3 % 2)
    assert belief.states.shape[0] == 3
    np.testing.assert_allclose(belief.weights, [0.2, 0.4, 0.4])  # a novice's choice tells nothing


def test_an_expert_choice_tells_the_states_apart() -> None:
    """A state from which the expert would have chosen otherwise is ruled out."""
    model = small_model(math.inf)
    rng = np.random.default_rng(0)
    states = rng.uniform(0, 1, (40, 3))
    choices = np.array([model.choice(state, 0).argmax() for state in states])
    assert 0 < choices.sum() < 40
    belief = Belief(states, np.full(40, 1 / 40)).update(model, 0, 1)
    assert len(belief.weights) == choices.sum()


def test_an_impossible_observation_keeps_the_weights() -> None:
    model = small_model(math.inf)
    state = np.zeros((1, 3))
    impossible = 1 - int(model.choice(state[0], 0).argmax())
    belief = Belief(state, np.ones(1)).update(model, 0, impossible)
    np.testing.assert_allclose(belief.states[0], model.next_fatigue(state[0], 0)[impossible])


def test_expected_cost_averages_states_and_preferences() -> None:
    model = small_model(0.0)
    belief = Belief(np.array([[0.1, 0.2, 0.3], [0.5, 0.0, 0.1]]), np.array([0.25, 0.75]))
    by_hand = sum(
        w * 0.5 * ((model.gain[1, u] * s + model.offset[1, u]) ** 2).sum() / 3
        for w, s in zip(belief.weights, belief.states, strict=True)
        for u in range(2)
    )
    assert belief.expected_cost(model, 1) == pytest.approx(by_hand)

"""The fatigue POMDP: preference choice, reward, active entries, initial beliefs."""

import math
from itertools import product

import numpy as np
import pytest
from small_problems import (
    NOISY,
    STARTS,
    belief_in,
    choice_probabilities,
    pomcp,
    relaxed,
    small_model,
    small_profiles,
    tree_of,
    two_starts,
    two_workers,
)

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile, cycle_profile
from fatigue_planner.fatigue.parameters import fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.pomdp.fatigue_pomdp import LANES, build_pomdp, one_worker
from fatigue_planner.reactions.reaction import Reaction

COSTS = np.array([0.2, 0.1, 0.4])


@pytest.mark.parametrize("expertise", [0, 1e-300, 0.5, 10, 1e3, 1e308, math.inf])
def test_choice_is_a_distribution_that_prefers_the_cheap(expertise: float) -> None:
    p = choice_probabilities(COSTS, expertise)
    assert p.sum() == pytest.approx(1, abs=1e-15) and (p >= 0).all()
    assert p[1] >= p[0] >= p[2]


def test_choice_is_equation_4() -> None:
    weights = np.exp(-7 * COSTS)
    np.testing.assert_allclose(choice_probabilities(COSTS, 7), weights / weights.sum(), rtol=1e-14)


def test_choice_at_both_ends_and_ties() -> None:
    np.testing.assert_array_equal(choice_probabilities(COSTS, 0), np.full(3, 1 / 3))
    np.testing.assert_array_equal(choice_probabilities(COSTS, math.inf), [0, 1, 0])
    tied = np.array([0.3, 0.1, 0.1])
    np.testing.assert_array_equal(choice_probabilities(tied, math.inf), [0, 0.5, 0.5])
    np.testing.assert_array_equal(choice_probabilities(np.zeros(2), 1e308), [0.5, 0.5])


def test_choice_does_not_depend_on_a_common_cost() -> None:
    np.testing.assert_allclose(choice_probabilities(COSTS + 1e6, 3), choice_probabilities(COSTS, 3), rtol=1e-8)


def test_active_entries_change_nothing(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Cost, reward and choice from the active entries are those from all 78."""
    condition = paper.benchmark.conditions["multiple_novice"].model_copy(update={"expertise": 50.0})
    task = scenario(paper, cycle_profiles(paper, reactions), condition)
    model, state = task.model, task.states[1]
    assert model.entries == 78 and len(model.active_entries) < 50
    assert state.size == len(model.active_entries) + -len(model.active_entries) % LANES + 1
    parameters = fatigue_parameters(paper.fatigue, maximum_torque("average_man"))
    maps = {
        str(r.name): cycle_profile(r.motion.torque_nm, r.motion.time_step_s, parameters).cycle_map() for r in reactions
    }
    full = np.zeros(78)
    full[model.active_entries] = state[: len(model.active_entries)]
    np.testing.assert_array_equal(model.state(full), state)
    for a, action in enumerate(model.actions):
        after = np.array([maps[f"average_man/{action}/{u}"].apply(full) for u in model.outcomes])
        costs = (after**2).sum(axis=1) / 78
        moved, rewards = zip(*(model.transition(state, a, u) for u in range(len(model.outcomes))), strict=True)
        np.testing.assert_allclose(rewards, -costs, rtol=1e-12)
        np.testing.assert_allclose(moved, [model.state(fatigue) for fatigue in after], rtol=1e-12)
        np.testing.assert_allclose(model.probabilities(state, a), choice_probabilities(costs, 50.0), rtol=1e-9)


def test_a_task_that_tires_nobody_can_be_planned() -> None:
    """Loads below every threshold: no entry ever becomes non-zero, and every policy still answers."""
    none, rates = np.zeros((1, 3)), (np.ones(3), np.ones(3))
    profiles = {(a, u): CycleProfile(none, none, none, np.full(3, 9.0), *rates) for a, u in product("ab", "xy")}
    model = build_pomdp("ab", "xy", profiles, np.zeros((1, 3)), one_worker(0.0), 0.95)
    assert model.active_entries.size == 0
    decision = PomcpPolicy(pomcp(20)).act(relaxed(model), np.random.default_rng(0))
    assert decision.action == 0 and not decision.values.any()


def test_initial_beliefs_are_the_papers(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    profiles = cycle_profiles(paper, reactions)
    multiple = scenario(paper, profiles, paper.benchmark.conditions["multiple_novice"])
    belief = multiple.initial_belief("prior", multiple.model, np.random.default_rng(0))
    np.testing.assert_allclose(belief.weights, [0.2, 0.4, 0.4])
    np.testing.assert_allclose(belief.states.sum(axis=1), [0, 1, 1])  # both entries of one joint at 0.5
    single = scenario(paper, profiles, paper.benchmark.conditions["single_expert"])
    assert single.weights.tolist() == [1] and not single.states.any()
    assert multiple.model.discount == 0.95


def test_no_entry_that_is_never_loaded_changes_anything() -> None:
    """Such entries are left out; kept in, padded to other lengths, they give the same tree."""
    extra = np.zeros((1, LANES))
    wider = {
        name: CycleProfile(
            *(np.hstack([runs, extra]) for runs in (p.dose_s, p.later_dose_s, p.later_rest_s)),
            *(np.append(values, np.ones(LANES)) for values in (p.rest_s, p.fatigue_rate, p.recovery_rate)),
        )
        for name, p in small_profiles().items()
    }
    loaded, all_tired = np.zeros((1, 3 + LANES)), np.ones((1, 3 + LANES))
    dropped, kept = (build_pomdp("ab", "xy", wider, f, one_worker(10.0), 0.95) for f in (loaded, all_tired))
    assert dropped.arrays.gain.shape == (4, LANES) and kept.arrays.gain.shape == (4, 2 * LANES)
    fatigue = np.hstack([STARTS, np.zeros((2, LANES))])
    trees = [tree_of(belief_in(model, fatigue, [0.3, 0.7]), pomcp(300)) for model in (dropped, kept)]
    for name in trees[0].dtype.names:
        np.testing.assert_allclose(trees[0][name], trees[1][name], rtol=1e-12, err_msg=name)


def test_the_maps_of_one_worker_and_of_two_have_the_same_layout() -> None:
    """Row by row, as the kernels read them: another order would be slower, and compiled again."""
    for model in (small_model(0.0), two_workers().model):
        assert model.arrays.gain.flags.c_contiguous and model.arrays.offset.flags.c_contiguous


def test_recognition_is_as_the_matrix_says() -> None:
    belief = two_starts(small_model(5.0, NOISY))
    for state, action, preference in product(belief.states, range(2), range(2)):
        seen = belief.model.observation_probabilities(state, action, preference)
        np.testing.assert_array_equal(seen, NOISY[preference])


@pytest.mark.parametrize("recognition", [None, NOISY])
def test_expected_rewards_average_states_and_preferences(recognition: np.ndarray | None) -> None:
    model = small_model(0.0, recognition)
    belief = two_starts(model)
    maps = {name: profile.cycle_map() for name, profile in small_profiles().items()}
    for action, name in enumerate("ab"):
        by_hand = -sum(
            weight * 0.5 * (maps[name, u].apply(state[:3]) ** 2).sum() / 3
            for weight, state in zip(belief.weights, belief.states, strict=True)
            for u in "xy"
        )
        assert belief.expected_rewards()[action] == pytest.approx(by_hand, rel=1e-12)

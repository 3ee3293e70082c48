"""The particle filter: its posterior against enumeration, resampling, log weights, and what it does when surprised.

Random tests compare at five standard errors of the mean: a false alarm in 6e-7 per number compared.
"""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, build_pomdp, one_worker

FALSE_ALARM = 5.0  # standard errors
NOISY = np.array([[0.8, 0.2], [0.3, 0.7]])
BLIND = np.full((2, 2), 0.5)
STARTS = np.random.default_rng(9).uniform(0, 0.8, (3, 3))
ENTRIES = 3


def small_model(workers: Workers, recognition: np.ndarray | None = None) -> FatiguePomdp:
    """Two actions with two preferences each, which tire and rest three entries at random, twice per cycle."""
    rng = np.random.default_rng(4)
    profiles = {}
    for pair in product("ab", "xy"):
        dose, rest = rng.uniform(0, 0.4, (2, ENTRIES)), rng.uniform(0, 0.4, (3, ENTRIES))
        later_dose = np.array([dose[1], np.zeros(ENTRIES)])
        later_rest = np.array([rest[1] + rest[2], rest[2]])
        profiles[pair] = DoseProfile(dose, later_dose, later_rest, rest.sum(axis=0), np.ones(3), np.full(3, 0.8))
    return build_pomdp("ab", "xy", profiles, np.zeros((1, ENTRIES)), workers, 0.95, recognition, "xy")


def starts(model: FatiguePomdp) -> np.ndarray:
    return np.array([model.state(fatigue) for fatigue in STARTS])


def particles(model: FatiguePomdp, weights: np.ndarray) -> ParticleBelief:
    states = np.repeat(starts(model)[:1], weights.size, axis=0)
    states[:, 0] = np.linspace(0, 1, weights.size)
    with np.errstate(divide="ignore"):
        return replace(ParticleBelief.begin(model, states), weights=weights, log_weights=np.log(weights))


def z_scores(estimates: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """By how many standard errors the means of independent estimates (runs, quantities) are off."""
    return np.abs(estimates.mean(axis=0) - truth) / (estimates.std(axis=0, ddof=1) / math.sqrt(len(estimates)))


@pytest.mark.parametrize("recognition", [None, NOISY])
def test_posterior_is_the_exact_one(recognition: np.ndarray | None) -> None:
    """Means and second moments of fatigue after seven cycles, of 60 filters with 400 particles each."""
    model = small_model(one_worker(15.0), recognition)
    chances = np.array([0.2, 0.5, 0.3])
    exact = ExactBelief(model, starts(model), chances)
    rng = np.random.default_rng(0)
    seen = list(zip([0, 1, 0, 0, 1, 1, 0], [1, 1, 0, 1, 0, 1, 1], strict=True))
    for action, observation in seen:
        exact = exact.update(action, observation, rng)
    estimates = []
    for _ in range(60):
        belief = ParticleBelief.begin(model, starts(model)[rng.choice(3, 400, p=chances)])
        for action, observation in seen:
            belief = belief.update(action, observation, rng)
        estimates.append(np.concatenate([belief.weights @ belief.states**power for power in (1, 2)]))
    truth = np.concatenate([exact.weights @ exact.states**power for power in (1, 2)])
    moving = np.array(estimates).std(axis=0) > 0
    assert moving.sum() == 2 * ENTRIES
    assert z_scores(np.array(estimates)[:, moving], truth[moving]).max() < FALSE_ALARM
    assert len(exact.states) == (3 if recognition is None else 3 * 2**7)


def test_effective_size_by_hand() -> None:
    model = small_model(one_worker(0.0))
    assert particles(model, np.array([0.5, 0.25, 0.25])).effective_size() == pytest.approx(1 / 0.375)
    assert particles(model, np.full(8, 1 / 8)).effective_size() == pytest.approx(8)
    assert particles(model, np.array([1.0, 0, 0])).effective_size() == pytest.approx(1)


def test_systematic_resampling_is_unbiased_and_even() -> None:
    """A particle of weight w has n w offspring on average, and never differs from that by 1 or more."""
    weights = np.array([0.0, 0.05, 0.3, 0.0, 0.41, 0.24, 0.0])
    belief = particles(small_model(one_worker(0.0)), weights)
    rng = np.random.default_rng(1)
    offspring = np.array([
        (belief.resampled(rng).states[:, None, 0] == belief.states[:, 0]).sum(axis=0) for _ in range(4000)
    ])  # fmt: skip
    assert (np.abs(offspring - 7 * weights) < 1).all()
    assert not offspring[:, weights == 0].any()
    drawn = weights > 0
    assert z_scores(offspring[:, drawn], 7 * weights[drawn]).max() < FALSE_ALARM
    resampled = belief.resampled(rng)
    assert resampled.effective_size() == pytest.approx(7) and not resampled.log_weights.any()


def test_long_histories_of_unlikely_observations_do_not_underflow() -> None:
    """Likelihoods of 1e-200 per cycle count by their ratios: 60 cycles amount to 1e-12000."""
    unlikely = np.array([[1.0, 1e-200], [1.0, 3e-200]])
    likely = np.array([[0.8, 0.2], [0.4, 0.6]])  # the same ratio of the probabilities of y
    beliefs = []
    for recognition in (unlikely, likely):
        model, rng = small_model(one_worker(10.0), recognition), np.random.default_rng(3)
        belief = ParticleBelief.begin(model, starts(model)[rng.choice(3, 50)])
        for cycle in range(60):
            belief = belief.update(cycle % 2, 1, rng)
            assert not belief.surprised
        beliefs.append(belief)
    np.testing.assert_allclose(beliefs[0].weights, beliefs[1].weights, rtol=1e-9)
    np.testing.assert_allclose(beliefs[0].states, beliefs[1].states)


def test_a_weight_too_small_for_a_float_comes_back_when_the_others_are_ruled_out() -> None:
    """An expert and a particle whose weight is exp(-2000): the expert's wrong choice leaves the particle."""
    workers = Workers(np.ones(2), np.ones(2), np.array([math.inf, 0.0]))
    model = small_model(workers)
    states = np.array([model.state(STARTS[0], worker) for worker in (0, 1)])
    likely = int(model.probabilities(states[0], 0).argmax())
    belief = replace(
        ParticleBelief.begin(model, states), weights=np.array([1.0, 0.0]), log_weights=np.array([0.0, -2000.0])
    )
    after = belief.update(0, 1 - likely, np.random.default_rng(0))
    assert not after.surprised and after.weights.tolist() == [0, 1]


def test_one_particle_is_enough_to_run() -> None:
    model = small_model(one_worker(10.0), NOISY)
    belief, rng = ParticleBelief.begin(model, starts(model)[:1]), np.random.default_rng(0)
    for cycle in range(10):
        belief = belief.update(cycle % 2, cycle % 2, rng)
    assert belief.weights.tolist() == [1.0] and belief.effective_size() == 1


@pytest.mark.parametrize("expertise", [math.inf, 1e9])
def test_impossible_reactions_never_raise(expertise: float) -> None:
    """The worker did what an expert never does: all particles follow, and the weights stay."""
    model = small_model(one_worker(expertise))
    states = np.repeat(starts(model)[:1], 20, axis=0)
    impossible = 1 - int(model.probabilities(states[0], 0).argmax())
    rng = np.random.default_rng(0)
    for belief in (ParticleBelief.begin(model, states), ExactBelief(model, states[:1], np.ones(1))):
        after = belief.update(0, impossible, rng)
        assert after.surprised and after.weights.sum() == pytest.approx(1)
        expected, _ = model.transition(states[0], 0, impossible)
        np.testing.assert_allclose(after.states, np.tile(expected, (len(after.states), 1)))
        assert not after.update(0, int(model.probabilities(expected, 0).argmax()), rng).surprised


def test_an_observation_no_reaction_leads_to_is_ignored() -> None:
    """An impossible recognition: the belief is what it would be without an observation."""
    never = np.array([[0.7, 0.3, 0.0], [0.2, 0.8, 0.0]])
    model = small_model(one_worker(5.0), never)
    model = replace(model, observations=("x", "y", "never"))
    rng = np.random.default_rng(0)
    exact = ExactBelief(model, starts(model), np.full(3, 1 / 3)).update(1, 2, rng)
    assert exact.surprised and len(exact.states) == 6
    blind = ExactBelief(small_model(one_worker(5.0), BLIND), starts(model), np.full(3, 1 / 3)).update(1, 0, rng)
    np.testing.assert_allclose(exact.weights, blind.weights)
    filtered = ParticleBelief.begin(model, starts(model)).update(1, 2, rng)
    assert filtered.surprised and np.isfinite(filtered.weights).all()


def test_an_impossible_reaction_noisily_recognised_widens_the_belief() -> None:
    """The sensor is sure of y, the expert would have done x: whatever may be recognised as y is possible."""
    sure_of_y = np.array([[1.0, 0.0], [0.5, 0.5]])
    model = small_model(one_worker(math.inf), sure_of_y)
    state = starts(model)[0]
    action = next(a for a in range(2) if model.probabilities(state, a)[0] == 1)
    after = ExactBelief(model, state[None], np.ones(1)).update(action, 1, np.random.default_rng(0))
    assert after.surprised
    np.testing.assert_allclose(after.states, model.transition(state, action, 1)[0][None])


def test_exact_belief_forgets_no_state_that_is_possible() -> None:
    """2000 choices of an expert give a novice a probability of 2^-2000; the first other choice reveals a novice."""
    model = small_model(Workers(np.ones(2), np.ones(2), np.array([math.inf, 0.0])))
    states = np.array([model.state(STARTS[0], worker) for worker in (0, 1)])
    belief, rng = ExactBelief(model, states, np.array([0.5, 0.5])), np.random.default_rng(0)
    for cycle in range(2000):
        belief = belief.update(cycle % 2, int(model.probabilities(belief.states[0], cycle % 2).argmax()), rng)
    assert 0 < belief.weights[1] < 1e-290
    belief = belief.update(0, int(model.probabilities(belief.states[0], 0).argmin()), rng)
    assert not belief.surprised and belief.states[:, -1].tolist() == [1] and belief.weights.tolist() == [1]


def test_states_that_coincide_are_one() -> None:
    """Two reactions with the same effect, seen through noise: one state, with both their weights."""
    still = DoseProfile(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3)), np.ones(3), np.ones(3), np.ones(3))
    profiles = dict.fromkeys(product("ab", "xy"), still)
    model = build_pomdp("ab", "xy", profiles, STARTS, one_worker(0.0), 0.95, NOISY, "xy")
    belief, rng = ExactBelief(model, starts(model), np.array([0.2, 0.5, 0.3])), np.random.default_rng(0)
    for _ in range(5):
        belief = belief.update(0, 1, rng)
    assert len(belief.states) == 3
    np.testing.assert_allclose(np.sort(belief.weights), [0.2, 0.3, 0.5])

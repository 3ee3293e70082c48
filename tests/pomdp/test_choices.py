"""Choice models: their chances by hand, the choice before as a part of the state, and all that plans with them."""

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER
from small_problems import (
    EXPERTISES,
    NOISY,
    STARTS,
    belief_in,
    expectimax,
    lookahead,
    pomcp,
    relaxed,
    small_model,
    small_profiles,
    tree_of,
)
from tree_checks import assert_bayes

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.history import relive
from fatigue_planner.pomdp.choices.boltzmann import BoltzmannChoice
from fatigue_planner.pomdp.choices.choice_model import ChoiceModel
from fatigue_planner.pomdp.choices.inertia import InertiaChoice
from fatigue_planner.pomdp.choices.offset import OffsetChoice
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, fingerprint
from fatigue_planner.pomdp.hidden_worker import HiddenWorker, WorkerPrior
from fatigue_planner.reactions.reaction import Reaction

LIKED = OffsetChoice(kind="offset", offsets={"y": 0.7})
HABIT = InertiaChoice(kind="inertia", inertia=1.3, offsets={"x": -0.4})
KINDS: dict[str, ChoiceModel] = {"boltzmann": BoltzmannChoice(kind="boltzmann"), "offset": LIKED, "inertia": HABIT}
BY_ACTION = np.array([NOISY, [[0.6, 0.4], [0.05, 0.95]]])
RNG = np.random.default_rng(0)  # exact beliefs draw nothing
BLIND = HiddenWorker.model_validate({"fatigue_rate_factor": {"kind": "lognormal", "median": 1.0, "sigma": 0.4}})


def chances(model: FatiguePomdp, fatigue: np.ndarray, action: int, kind: str, last: int | None) -> np.ndarray:
    """The softmax of the utilities, written out."""
    maps = [small_profiles()["ab"[action], u].cycle_map() for u in "xy"]
    costs = np.array([(cycle.apply(fatigue) ** 2).sum() / 3 for cycle in maps])
    utility = np.array({"boltzmann": [0, 0], "offset": [0, 0.7], "inertia": [-0.4, 0]}[kind], float)
    if kind == "inertia" and last is not None:
        utility[last] += 1.3
    beta = float(model.workers.expertise[0])
    if math.isinf(beta):
        return (costs == costs.min()) / (costs == costs.min()).sum()
    weights = np.exp(utility - beta * costs)
    return np.asarray(weights / weights.sum())


def remembering(model: FatiguePomdp, fatigue: np.ndarray, last: int | None) -> np.ndarray:
    state = model.state(fatigue)
    if model.remembers:
        state[-2] = 0 if last is None else 1 + last
    return state


@pytest.mark.parametrize("expertise", EXPERTISES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_chances_are_those_of_the_utilities(kind: str, expertise: float) -> None:
    model = small_model(expertise, choices=KINDS[kind])
    for fatigue, action, last in product(STARTS, range(2), (None, 0, 1)):
        state = remembering(model, fatigue, last)
        expected = chances(model, fatigue, action, kind, last)
        np.testing.assert_allclose(model.probabilities(state, action), expected, rtol=1e-12)
        reward = sum(p * model.transition(state, action, u)[1] for u, p in enumerate(expected))
        belief = belief_in(model, fatigue[None], [1.0])
        belief.states[0] = state
        assert belief.expected_rewards()[action] == pytest.approx(reward, rel=1e-12)


def test_among_equal_costs_an_expert_takes_what_he_likes() -> None:
    model = small_model(math.inf, choices=LIKED)
    model.arrays.gain[1], model.arrays.offset[1] = model.arrays.gain[0], model.arrays.offset[0]
    liked = math.exp(0.7) / (1 + math.exp(0.7))
    np.testing.assert_allclose(model.probabilities(model.state(STARTS[0]), 0), [1 - liked, liked], rtol=1e-12)


def test_a_cycle_remembers_its_choice_and_changes_fatigue_as_ever() -> None:
    plain, habit = small_model(25.0), small_model(25.0, choices=HABIT)
    for fatigue, action, preference, last in product(STARTS, range(2), range(2), (None, 1)):
        after, reward = habit.transition(remembering(habit, fatigue, last), action, preference)
        expected, as_ever = plain.transition(plain.state(fatigue), action, preference)
        assert after[-2] == 1 + preference
        assert reward == pytest.approx(as_ever, rel=1e-12)
        np.testing.assert_array_equal(habit.fatigue(after), plain.fatigue(expected))


def test_boltzmann_is_what_there_was_to_the_bit() -> None:
    plain, named = small_model(25.0), small_model(25.0, choices=KINDS["boltzmann"])
    assert fingerprint(plain) == fingerprint(named)
    assert "factors" not in fingerprint(plain)["arrays"] and np.shape(fingerprint(plain)["arrays"]["observation"]) == (
        2,
        2,
    )
    assert fingerprint(small_model(25.0, choices=LIKED)) != fingerprint(plain)


def test_who_has_no_habit_remembers_nothing() -> None:
    none = small_model(25.0, choices=InertiaChoice(kind="inertia", inertia=0, offsets=LIKED.offsets))
    assert not none.remembers and fingerprint(none) == fingerprint(small_model(25.0, choices=LIKED))


def seen_as(recognition: np.ndarray | None) -> np.ndarray:
    """P(o | u) by action (A, U, O)."""
    return np.broadcast_to(np.eye(2) if recognition is None else recognition, (2, 2, 2))


@pytest.mark.parametrize("recognition", [None, NOISY, BY_ACTION])
@pytest.mark.parametrize("kind", ["offset", "inertia"])
def test_beliefs_are_bayes_rule_over_whole_histories(kind: str, recognition: np.ndarray | None) -> None:
    model = small_model(25.0, recognition, KINDS[kind])
    start = belief_in(model, np.random.default_rng(9).uniform(0, 0.8, (3, 3)), [0.2, 0.5, 0.3])
    assert_bayes(start, [0, 1, 0], [0, 0, 1])
    soft = hard = start
    for action, seen in ((0, 0), (1, 0), (0, 1)):
        likelihood = seen_as(recognition)[action, :, seen]
        soft, hard = soft.weigh(action, likelihood, RNG), hard.update(action, seen, RNG)
    np.testing.assert_allclose(soft.weights @ soft.states, hard.weights @ hard.states, rtol=1e-9)


@pytest.mark.parametrize("recognition", [None, NOISY, BY_ACTION])
@pytest.mark.parametrize("kind", ["offset", "inertia"])
def test_lookaheads_see_habits(kind: str, recognition: np.ndarray | None) -> None:
    belief = belief_in(small_model(25.0, recognition, KINDS[kind]), STARTS, [0.3, 0.7])
    values = lookahead(belief, 3)
    np.testing.assert_allclose(values, [expectimax(belief, action, 3) for action in range(2)], rtol=1e-10)


@pytest.mark.parametrize("recognition", [None, BY_ACTION])
def test_a_search_comes_to_the_lookaheads_values(recognition: np.ndarray | None) -> None:
    """The mean backup of what a search tries most is near the value of an exact lookahead to the same depth."""
    belief = belief_in(small_model(0.0, recognition, HABIT), STARTS, [0.3, 0.7])
    tree = tree_of(belief, pomcp(2000, 0.02, "exact"))
    assert tree.tried[0].sum() >= 1999
    best = max(lookahead(belief, 5))
    assert tree.value[0].max() <= best * 0.9  # further cycles cost more
    chance = tree.chance[0, 0]
    outcomes = sum(w * belief.model.probabilities(s, 0) for w, s in zip(belief.weights, belief.states, strict=True))
    seen = outcomes if recognition is None else outcomes @ recognition[0]
    np.testing.assert_allclose(chance, seen, rtol=1e-12)


def test_what_hidden_workers_lived_through_is_lived_again_with_its_habits() -> None:
    model, rng = small_model(25.0, BY_ACTION, HABIT), np.random.default_rng(1)
    states = np.repeat(relaxed(model).states, 50, axis=0)
    belief = HiddenWorkerBelief.start(model, states, WorkerPrior(BLIND, 25.0), rng)
    for action, seen in ((0, 0), (1, 1), (0, 1), (1, 1)):
        belief = belief.update(action, seen, rng)
    again = belief.history.start.copy()
    log_likelihood = relive(belief.model, again, belief.history)
    np.testing.assert_allclose(again, belief.states, rtol=1e-12)
    np.testing.assert_allclose(log_likelihood, belief.history.log_likelihood, rtol=1e-9)
    assert set(belief.states[:, -2]) <= {1.0, 2.0}


CHOICES = """
choice_models:
  habit: {kind: inertia, inertia: 1.5, offsets: {arm: -0.5}}
recognition_by_action:
  low: {arm: {arm: 0.8, back: 0.2}, back: {back: 0.9, unclear: 0.1}}
"""


def written(folder: Path, more: str) -> Path:
    file = folder / "mine.yaml"
    text = PAPER.read_text(encoding="utf-8").replace("expertise: 0}", "expertise: 0, choice_model: habit}", 1)
    file.write_text(text + more, encoding="utf-8")
    return file


def test_an_experiment_names_them(tmp_path: Path, reactions: tuple[Reaction, ...]) -> None:
    experiment = load_experiment(written(tmp_path, CHOICES))
    model = scenario(
        experiment, cycle_profiles(experiment, reactions), experiment.benchmark.conditions["single_novice"]
    ).model
    assert model.observations == ("arm", "back", "unclear")
    low, high = (model.actions.index(name) for name in ("low", "high"))
    np.testing.assert_array_equal(model.arrays.observation[low], [[0.8, 0.2, 0], [0, 0.9, 0.1]])
    np.testing.assert_array_equal(model.arrays.observation[high], [[1, 0, 0], [0, 1, 0]])
    state, _ = model.transition(model.state(np.zeros(78)), low, 1)
    odds = model.probabilities(state, high)
    assert math.log(odds[0] / odds[1]) == pytest.approx(-0.5 - 1.5)

"""The lower bound on the cost: below the optimum by enumeration, close to it, and never beaten."""

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
from plain_python import interpreted
from scipy.stats import t as student
from small_problems import choice_probabilities

from fatigue_planner.core.random_streams import draw_random_numbers
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.planners.bounds import sub_solution
from fatigue_planner.planners.bounds.cost_bound import ROUNDING, CostBound, bound_of, cost_lower_bound
from fatigue_planner.planners.bounds.lookahead import look_ahead
from fatigue_planner.planners.bounds.quadratics import Quadratics
from fatigue_planner.planners.bounds.sub_solution import below_all, reaction_extremes
from fatigue_planner.planners.bounds.task import ClassStates, HistoryClasses, Task, hidden_state
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.fatigue_pomdp import build_pomdp, one_worker
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.trial import run_trial

EXPERTISE = [0.0, 2.0, 30.0, math.inf]
SMALL = {"classes": 16, "leaves": 1}  # enumerates no more than it must


@dataclass(frozen=True)
class Model:
    """The fatigue problem in plain NumPy, so that the optimum does not depend on the package's kernels."""

    gain: np.ndarray
    offset: np.ndarray
    expertise: float
    discount: float = 0.9
    entries: int = 8
    factors: np.ndarray | None = None

    def transition(self, state: np.ndarray, action: int) -> np.ndarray:
        return self.gain[action] * state + self.offset[action]

    def cost(self, state: np.ndarray) -> np.ndarray:
        return np.square(state).sum(axis=-1) / self.entries

    def costs(self, state: np.ndarray, action: int) -> np.ndarray:
        return self.cost(self.transition(state, action))

    def choice(self, state: np.ndarray, action: int, last: int = -1) -> np.ndarray:
        """By the last preference, -1 for none."""
        chances = choice_probabilities(self.costs(state, action), self.expertise)
        if self.factors is None:
            return chances
        chances = chances * self.factors[0 if len(self.factors) == 1 else 1 + last]
        return chances / chances.sum()


@dataclass(frozen=True)
class Start:
    """Weighted states."""

    states: np.ndarray
    weights: np.ndarray


def small_model(expertise: float, actions: int = 2, preferences: int = 2, entries: int = 4, seed: int = 5) -> Model:
    """Actions that tire different entries, as in the paper; made up."""
    rng = np.random.default_rng(seed)
    shape = (actions, preferences, 4)
    tired = rng.random(shape) < 0.6
    gain = np.where(tired, rng.uniform(0.6, 0.9, shape), 0.5)
    offset = np.where(tired, rng.uniform(0.2, 0.9, shape) * (1 - gain), 0)
    return Model(gain, offset, expertise)


SINGLE = Start(np.array([[0.0, 0.3, 0.0, 0.1]]), np.array([1.0]))
SEVERAL = Start(np.array([[0.0, 0.0, 0.0, 0.1], [0.8, 0.0, 0.0, 0.1], [0.0, 0.6, 0.9, 0.1]]), np.array([0.2, 0.3, 0.5]))
BELIEFS = {"single": SINGLE, "several": SEVERAL}


def bound(model: Model, belief: Start, n_cycles: int, **effort: int) -> CostBound:
    return cost_lower_bound(
        model.gain, model.offset, model.expertise, belief.states, belief.weights, model.discount, model.entries,
        n_cycles, factors=model.factors, **effort,
    )  # fmt: skip


def known(model: Model, expertise: float) -> Task:
    """The task of whoever knows that the worker starts as in SINGLE."""
    weight, no_posture = np.full(4, 1 / 8), np.zeros(model.gain.shape[:2])
    factors = np.ones((1, model.gain.shape[1])) if model.factors is None else model.factors
    return Task(model.gain, model.offset, SINGLE.states[0], weight, no_posture, expertise, 0.9, factors)


def optimum(model: Model, belief: Start, n_cycles: int, last: int = -1) -> float:
    """The least expected cost, over every history of actions and observed reactions."""
    if n_cycles == 0:
        return 0.0
    costs = []
    for action in range(len(model.gain)):
        choice = np.array([model.choice(state, action, last) for state in belief.states])
        total = float(belief.weights @ [p @ model.costs(s, action) for p, s in zip(choice, belief.states, strict=True)])
        for seen in range(model.gain.shape[1]):
            weights = belief.weights * choice[:, seen]
            if weights.sum() > 0:
                moved = np.array([model.transition(state, action)[seen] for state in belief.states])
                following = Start(moved[weights > 0], weights[weights > 0] / weights.sum())
                total += model.discount * weights.sum() * optimum(model, following, n_cycles - 1, seen)
        costs.append(total)
    return min(costs)


@pytest.mark.parametrize("expertise", EXPERTISE)
@pytest.mark.parametrize("start", BELIEFS)
def test_it_is_below_the_optimum_and_close(expertise: float, start: str) -> None:
    model, belief = small_model(expertise), BELIEFS[start]
    best = optimum(model, belief, 6)
    found = bound(model, belief, 6, **SMALL)
    assert not found.exact and found.exact_cycles == found.memory == 2
    assert found.state_revealed == (start == "several" and expertise > 0)
    tightness = 0.98 if expertise == 0 else 0.8 if found.state_revealed else 0.9
    assert tightness * best < found.cost <= best


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("expertise", [0.0, 5.0, math.inf])
def test_it_is_below_the_optimum_of_any_three_by_three(seed: int, expertise: float) -> None:
    model = small_model(expertise, actions=3, preferences=3, seed=seed)
    best = optimum(model, SINGLE, 4)
    costs = [bound(model, SINGLE, 4, classes=classes, leaves=1).cost for classes in (9, 81)]
    assert 0 < costs[0] <= costs[1] <= best
    assert costs[1] > 0.9 * best or expertise > 0


@pytest.mark.parametrize("expertise", EXPERTISE)
@pytest.mark.parametrize("start", BELIEFS)
def test_it_is_the_optimum_where_every_history_fits(expertise: float, start: str) -> None:
    model, belief = small_model(expertise), BELIEFS[start]
    found = bound(model, belief, 5)
    assert found.exact and not found.state_revealed and found.exact_cycles == 5
    assert found.cost == pytest.approx(optimum(model, belief, 5), rel=2 * ROUNDING)


LIKED = np.array([[1.0, 0.3]])
HABIT = np.array([[1.0, 0.5], [1.0, 0.1], [0.4, 1.0]])


@pytest.mark.parametrize("expertise", EXPERTISE)
@pytest.mark.parametrize("start", BELIEFS)
@pytest.mark.parametrize("factors", [LIKED, HABIT])
def test_it_holds_for_who_likes_some_preferences_or_clings_to_one(
    expertise: float, start: str, factors: np.ndarray
) -> None:
    model, belief = replace(small_model(expertise), factors=factors), BELIEFS[start]
    found, every = bound(model, belief, 6, **SMALL), bound(model, belief, 5)
    best = optimum(model, belief, 6)
    assert not found.exact and (0.98 if expertise == 0 else 0.8) * best < found.cost <= best
    assert every.exact and every.cost == pytest.approx(optimum(model, belief, 5), rel=2 * ROUNDING)
    if 0 < expertise < math.inf:
        assert best != pytest.approx(optimum(small_model(expertise), belief, 6), rel=1e-4)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("later", [0, 1])
def test_it_holds_where_classes_do_not_know_the_last_choice(first: int, later: int) -> None:
    """An expert's first choice is too close to call, so no class remembers anything: every habit is possible.

    From rest the reactions cost the same, but the first is forgotten slower. Who likes it at first and the other ever
    after costs less than who always likes it: the bound may not take his first habit for his habit.
    """
    gain = np.array([[[0.9, 0.9, 0.5, 0.5], [0.5, 0.5, 0.2, 0.2]]])
    offset = 1e-3 * np.array([[[0.4, 0.1, 0.0, 0.0], [0.0, 0.0, 0.4, 0.1]]])  # costs are some 1e-8
    liked = np.array([[1.0, 1e-3], [1e-3, 1.0]])
    model = Model(gain, offset, 2e6, factors=liked[[first, later, later]])
    start = Start(np.zeros((1, 4)), np.ones(1))
    found, best = bound(model, start, 6), optimum(model, start, 6)
    always = optimum(replace(model, factors=liked[[first] * 3]), start, 6)
    assert found.memory == found.exact_cycles == 0 and 0 < found.cost <= best
    assert first == later or abs(always - best) > 0.2 * best


def test_a_novice_never_reveals_a_hidden_state() -> None:
    """The bound stays above what policies that know the state can reach."""
    model = small_model(0)
    found = bound(model, SEVERAL, 6, **SMALL)
    assert not found.state_revealed and not found.exact
    known = [optimum(model, Start(state[None], np.ones(1)), 6) for state in SEVERAL.states]
    assert SEVERAL.weights @ known < 0.95 * found.cost


@pytest.mark.parametrize("start", BELIEFS)
def test_with_one_action_the_novices_cost_is_exact(start: str) -> None:
    model = small_model(0, actions=1)
    found = bound(model, BELIEFS[start], 10, classes=4, leaves=1)
    assert found.exact_cycles == 2
    assert found.cost == pytest.approx(optimum(model, BELIEFS[start], 10), rel=1e-6)


def test_one_reaction_only() -> None:
    found = bound(small_model(0, actions=1, preferences=1), SINGLE, 30)
    assert found.exact and found.exact_cycles == 30


@pytest.mark.parametrize("expertise", [0.0, 10.0, math.inf])
def test_more_cycles_cost_more_and_more_effort_tightens(expertise: float) -> None:
    model = small_model(expertise)
    costs = [bound(model, SINGLE, n, **SMALL).cost for n in range(1, 15)]
    assert (np.diff(costs) > 0).all()
    assert costs[11] <= bound(model, SINGLE, 12, classes=64, leaves=1000).cost


def test_a_worker_who_is_never_tired_costs_nothing() -> None:
    model = small_model(0)
    maps = np.zeros_like(model.offset)
    found = cost_lower_bound(model.gain, maps, 0, np.zeros((1, 4)), np.ones(1), 0.9, 8, 20)
    assert found.cost == 0


def test_negative_gains_are_refused() -> None:
    model = small_model(0)
    with pytest.raises(ValueError, match="gains"):
        cost_lower_bound(-model.gain, model.offset, 0, SINGLE.states, SINGLE.weights, 0.9, 8, 5)


@pytest.mark.parametrize("damage", [1e-6, 1e-3, 0.1, 10.0])
@pytest.mark.parametrize("expertise", [0.0, 10.0, math.inf])
def test_damaged_slopes_and_curvatures_never_lift_it_above_the_optimum(
    damage: float, expertise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = small_model(expertise)
    best, whole = optimum(model, SINGLE, 6), bound(model, SINGLE, 6, **SMALL).cost
    for seed in range(10):
        rng = np.random.default_rng(seed)

        def damaged(functions: Quadratics, states: ClassStates) -> Quadratics:
            sound = below_all(functions, states)
            noise = damage * rng.normal(size=(2, *sound.slope.shape))  # noqa: B023
            shape = Quadratics(sound.value, sound.slope + noise[0], sound.curvature + noise[1])
            return lowered(shape, functions, states)

        monkeypatch.setattr(sub_solution, "below_all", damaged)
        found = bound(model, SINGLE, 6, **SMALL).cost
        assert found <= best
        if damage == 10:
            assert found < whole


def lowered(shape: Quadratics, functions: Quadratics, states: ClassStates) -> Quadratics:
    """The functions `shape` (M,), moved up or down until they lie below all functions (M, F) in their box."""
    excess = (functions - shape[:, None]).minimum(states.low[:, None], states.high[:, None]).min(axis=-1)
    return Quadratics(shape.value + excess, shape.slope, shape.curvature)


def slowly_below_all(functions: Quadratics, states: ClassStates) -> Quadratics:
    """What `fill_below` does, for all classes at once and every candidate to its end."""

    def candidate(weights: np.ndarray) -> tuple[Quadratics, np.ndarray]:
        mean = functions.mean(weights)
        deviation = np.sqrt(np.einsum("mf,mfl->ml", weights, np.square(functions.slope - mean.slope[:, None])))
        bent = mean.curvature - deviation / (2 * np.maximum(states.spread, sub_solution.MIN_SPREAD))
        found = lowered(Quadratics(mean.value, mean.slope, bent), functions, states)
        return found, found.value + (found.curvature * np.square(states.spread)).sum(axis=-1)

    weights = np.zeros_like(functions.value)
    weights[:, 0] = 1
    _, merit = candidate(weights)
    for towards in np.eye(weights.shape[1])[1:]:
        origin = weights
        for step in sub_solution.STEPS:
            moved = (1 - step) * origin + step * towards
            _, moved_merit = candidate(moved)
            weights = np.where((moved_merit > merit)[:, None], moved, weights)
            merit = np.maximum(moved_merit, merit)
    return candidate(weights)[0]


def some_functions(length: int) -> tuple[Quadratics, ClassStates]:
    """Five functions of each of 30 classes, and the classes' boxes."""
    rng = np.random.default_rng(length)
    shape = 30, 5, length
    functions = Quadratics(rng.normal(size=shape[:2]), rng.normal(size=shape), rng.normal(size=shape) / 2)
    low, high, spread = (rng.uniform(0, 0.5, (30, length)) for _ in range(3))
    return functions, ClassStates(np.zeros_like(low), spread / 5, -low, high)


@pytest.mark.parametrize("length", [3, 8, 11])
def test_one_function_lies_below_all_and_is_the_one_that_a_full_search_finds(length: int) -> None:
    """To 1e-12: means and variances along a line instead of sums over all weights."""
    functions, states = some_functions(length)
    found, expected = below_all(functions, states), slowly_below_all(functions, states)
    for own, other in ((found.value, expected.value), (found.slope, expected.slope)):
        np.testing.assert_allclose(own, other, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.curvature, expected.curvature, rtol=1e-9, atol=1e-9)
    rng = np.random.default_rng(1)
    for _ in range(200):
        point = states.low + (states.high - states.low) * rng.random(states.low.shape)
        assert (found.at(point)[:, None] <= functions.at(point[:, None]) + 1e-12).all()


def test_what_lies_below_all_is_the_same_in_plain_python_in_every_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    functions, states = some_functions(3)
    few, own = functions[:4], states[slice(0, 4)]
    compiled = below_all(few, own)
    monkeypatch.setattr(sub_solution, "fill_below", interpreted(sub_solution.fill_below))
    plain = below_all(few, own)
    for name in ("value", "slope", "curvature"):
        assert np.array_equal(getattr(compiled, name), getattr(plain, name))


def test_the_boxes_hold_every_state_of_their_class() -> None:
    model = small_model(0)
    task = hidden_state(known(model, 0.0), np.ones(4), 8, SEVERAL.states, SEVERAL.weights)
    tree = look_ahead([task], np.ones(1), 6, 2, 10_000)
    assert len(tree.states[:, 0]) == 4**6
    states = HistoryClasses(task, 2, 6).states(6)
    displacement = tree.states[:, 0] - states.typical[tree.classes]
    assert (displacement >= states.low[tree.classes] - 1e-15).all()
    assert (displacement <= states.high[tree.classes] + 1e-15).all()
    for m in range(16):
        own = tree.states[:, 0][tree.classes == m]
        np.testing.assert_allclose(own.mean(axis=0), states.typical[m], rtol=1e-12)
        np.testing.assert_allclose(own.std(axis=0), states.spread[m], atol=1e-8)


def test_a_hidden_state_merges_the_entries_that_start_alike() -> None:
    model = small_model(0)
    task = hidden_state(known(model, 0.0), np.ones(4), 8, SEVERAL.states, SEVERAL.weights)
    assert sorted(task.start) == [0, 0, 0, 0.1, 0.6, 0.8, 0.9]
    costs = [weight * model.cost(state) for weight, state in zip(SEVERAL.weights, SEVERAL.states, strict=True)]
    assert np.square(task.start) @ task.cost_weight == pytest.approx(sum(costs))


@pytest.mark.parametrize("likes", ["nothing", "one", "the last"])
@pytest.mark.parametrize("preferences", [2, 3])
@pytest.mark.parametrize("expertise", [1e-3, 1.0, 100.0, 1e300, math.inf])
def test_the_extreme_reactions_span_every_choice_in_the_box(expertise: float, preferences: int, likes: str) -> None:
    """No linear function of the probabilities is lower at a state of the box than at every extreme."""
    rng = np.random.default_rng(0)
    rows = {"nothing": 1, "one": 1, "the last": 1 + preferences}[likes]
    factors = np.ones((1, preferences)) if likes == "nothing" else rng.uniform(0.05, 1, (rows, preferences))
    model = replace(small_model(expertise, preferences=preferences), factors=factors)
    task = known(model, expertise)
    states = HistoryClasses(task, 1, 5).states(3)
    extremes = reaction_extremes(task, states, task.factors_after(np.arange(task.branches))[:, None])
    np.testing.assert_allclose(extremes.sum(axis=-1), 1, rtol=1e-12)
    assert (extremes >= 0).all()
    value = rng.normal(size=(20, preferences))
    for m, _ in product(range(task.branches), range(50)):
        state = states.typical[m] + rng.uniform(states.low[m], states.high[m])
        for action in range(2):
            chosen = value @ model.choice(state, action, m % preferences)
            assert (chosen >= (extremes[m, action] @ value.T).min(axis=0) - 1e-12).all()


@pytest.mark.parametrize("expertise", EXPERTISE)
def test_the_choice_is_that_of_the_model(expertise: float) -> None:
    model = small_model(0)
    task = known(model, expertise)
    costs = np.array([[0.1, 0.3, 0.2], [0.2, 0.1, 0.1], [0.0, 0.0, 0.0]])
    expected = [choice_probabilities(row, expertise) for row in costs]
    np.testing.assert_allclose(task.choice(costs, np.ones(3)), expected, rtol=1e-14)


def test_the_minimum_over_a_box() -> None:
    rng = np.random.default_rng(0)
    functions = Quadratics(rng.normal(size=50), rng.normal(size=(50, 3)), rng.normal(size=(50, 3)))
    functions.curvature[:5] = 0
    low, high = -rng.random((50, 3)), rng.random((50, 3))
    low[5], high[5] = 0, 0
    least = functions.minimum(low, high)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 41)] * 3), axis=-1).reshape(-1, 1, 3)
    sampled = functions.at(low + grid * (high - low)).min(axis=0)
    assert (least <= sampled + 1e-12).all()
    np.testing.assert_allclose(least, sampled, atol=5e-3)


# The probability that any of the random comparisons in this file fails although all is well: one in a million.
FALSE_ALARM = 1e-6


def allowance(cost: np.ndarray, comparisons: int) -> float:
    """By how much a mean may be off by chance, at that false-alarm rate over all comparisons."""
    return float(student.isf(FALSE_ALARM / comparisons, len(cost) - 1) * cost.std(ddof=1) / math.sqrt(len(cost)))


def assert_no_policy_beats(found: CostBound, costs: dict[str, np.ndarray], comparisons: int) -> None:
    """Mean costs above the bound, by Student's t where costs are random, exactly where they are not."""
    for name, cost in costs.items():
        assert cost.mean() + allowance(cost, comparisons) >= found.cost, name
        if np.ptp(cost) == 0:
            assert cost[0] >= found.cost, name


def situation_of(model: Model, belief: Start) -> Scenario:
    """The package's own model of the same problem."""
    rest = model.entries - model.gain.shape[2]
    zeros, ones = np.zeros((1, model.entries)), np.ones(model.entries)
    loaded = DoseProfile(np.pad(np.ones((1, 4)), [(0, 0), (0, rest)]), zeros, zeros, ones, ones, ones)
    names = "abc"[: len(model.gain)], "xyz"[: model.gain.shape[1]]
    worker = one_worker(model.expertise)
    blank = build_pomdp(*names, dict.fromkeys(product(*names), loaded), zeros, worker, model.discount)
    wide = [np.pad(table, [(0, 0), (0, 0), (0, rest)])[None] for table in (model.gain, model.offset)]
    pomdp = blank.with_maps(*wide, worker)
    states = np.array([pomdp.state(np.pad(state, (0, rest))) for state in belief.states])
    return Scenario(pomdp, states, belief.weights, None, ExactSettings(kind="exact"))


def policy_costs(
    paper: Experiment, task: Scenario, condition: str, n_cycles: int, trials: int, descents: int
) -> dict[str, np.ndarray]:
    """Cost of every policy of the paper, and of two lookaheads, in the same trials."""
    costs = {}
    policies: dict[str, PolicySettings] = {
        name: settings.model_copy(update={"descents": descents}) if settings.kind == "pomcp" else settings
        for name, settings in paper.benchmark.policies.items()
    }
    policies["lookahead"] = LookaheadSettings(kind="lookahead", depth=3)
    policies["plans"] = LookaheadSettings(kind="lookahead", depth=2, leaf_value="bound")
    for name, settings in policies.items():
        results = [
            run_trial(
                task,
                settings.build(),
                "prior",
                n_cycles,
                draw_random_numbers(7, condition, n_cycles, trial),
                np.random.default_rng(trial),
            )
            for trial in range(trials)
        ]
        costs[name] = -np.array([result.discounted_return for result in results])
    return costs


@pytest.mark.parametrize("expertise", [0.0, 30.0, math.inf])
@pytest.mark.parametrize("start", BELIEFS)
def test_no_policy_beats_it(expertise: float, start: str, paper: Experiment) -> None:
    model, belief = small_model(expertise), BELIEFS[start]
    costs = policy_costs(paper, situation_of(model, belief), start, 12, trials=40, descents=50)
    found = bound(model, belief, 12, classes=64, leaves=1000)
    assert_no_policy_beats(found, costs, comparisons=6 * len(costs))
    assert min(cost.mean() for cost in costs.values()) < 1.15 * found.cost


@pytest.mark.slow
@pytest.mark.parametrize("n_cycles", [5, 20, 100])
@pytest.mark.parametrize("condition", ["single_novice", "single_expert", "multiple_novice"])
def test_in_the_papers_conditions_no_policy_beats_it_and_the_best_is_within_a_percent(
    condition: str, n_cycles: int, paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    task = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions[condition])
    costs = policy_costs(paper, task, condition, n_cycles, trials=40, descents=1000)
    found = bound_of(task, n_cycles)
    assert_no_policy_beats(found, costs, comparisons=9 * len(costs))
    best = min(costs.values(), key=np.mean)
    assert best.mean() - allowance(best, 9) < 1.01 * found.cost


@pytest.mark.parametrize("seed", range(6))
def test_an_experts_choice_between_equal_costs_is_not_decided_by_rounding(seed: int) -> None:
    """Reactions that tire mirrored joints: which is cheaper depends only on the order of a sum."""
    rng = np.random.default_rng(seed)
    offset = rng.uniform(0.05, 0.5, 4)
    gain = np.array([0.9, 0.9, 0.1, 0.1])
    model = Model(np.tile(gain, (1, 2, 1)), np.stack([offset, offset[[1, 0, 3, 2]]])[None], math.inf)
    start = Start(np.zeros((1, 4)), np.ones(1))
    found = bound(model, start, 3)
    assert not found.exact
    either = [optimum(Model(model.gain[:, [u]], model.offset[:, [u]], 0.0), start, 3) for u in (0, 1)]
    assert found.cost <= min(*either, optimum(model, start, 3))

"""Soft evidence, nothing seen, and time: beliefs against enumeration of all that may have happened.

Random tests compare at five standard errors of the mean: a false alarm in 6e-7 per number compared.
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
from conftest import ROOT
from small_problems import EXPERTISES, NOISY, STARTS, belief_in, small_model, table_belief, table_problem, two_workers
from test_hidden_worker import CONTINUOUS, FINITE, chances_of_workers, in_mind
from test_particles import FALSE_ALARM, z_scores

import fatigue_planner as fp
from fatigue_planner.core.errors import ProblemError
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.laws.law import FatigueLaw, Rates
from fatigue_planner.fatigue.laws.registry import KINDS
from fatigue_planner.fatigue.model import Rest
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.bounded import MAX_STATES, merged, thinned
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.history import relive
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.beliefs.registry import ExactSettings, ParticleSettings
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.timing import Timing
from fatigue_planner.reactions.reaction import Reaction

sys.path.insert(0, str(ROOT / "examples"))
from tiger import NO_IDEA

RNG = np.random.default_rng(0)
CYCLE_S = 2.0


@dataclass(frozen=True)
class Lived:
    """A cycle: the action, the likelihood of both reactions, how long it took, and the pause before it."""

    action: int
    likelihood: tuple[float, float] = (1.0, 1.0)
    duration_s: float = CYCLE_S
    pause_s: float = 0.0


# Seen for sure, not at all, softly; shorter, longer, after a pause.
SHIFT = (
    Lived(0, (1, 0)),
    Lived(1),
    Lived(1, (0.9, 0.1), duration_s=2.3),
    Lived(0, pause_s=1.7),
    Lived(1, (1e-200, 3e-200), duration_s=1.31),
    Lived(0, (0, 5), duration_s=0.0, pause_s=0.4),
    Lived(0, (7e300, 2e300)),
)


def timed(model: FatiguePomdp) -> FatiguePomdp:
    """The model with cycles of 2 s and the rest of Ma's law."""
    rate = model.profiles[0][0].recovery_rate  # type: ignore[attr-defined]
    return replace(model, timing=Timing(CYCLE_S, Rest(np.zeros(3), np.zeros(3), rate)))


def lived_through(belief: Belief, shift: Sequence[Lived], rng: np.random.Generator) -> Belief:
    for cycle in shift:
        if cycle.pause_s:
            belief = belief.rest(cycle.pause_s)
        duration_s = None if cycle.duration_s == CYCLE_S else cycle.duration_s
        if cycle.likelihood == (1, 1):
            belief = belief.predict(cycle.action, rng, duration_s=duration_s)
        else:
            belief = belief.weigh(cycle.action, cycle.likelihood, rng, duration_s=duration_s)
        assert not belief.surprised
    return belief


def enumerated(start: Belief, shift: Sequence[Lived]) -> tuple[np.ndarray, np.ndarray]:
    """States and weights of every start with every sequence of reactions, by the formulas of the fatigue law."""
    model = start.model
    assert isinstance(model, FatiguePomdp)
    ends, masses = [], []
    for state, weight in zip(start.states, start.weights, strict=True):
        faster, sooner, _ = (float(values[int(state[-1])]) for values in model.workers)
        rate = sooner * model.profiles[0][0].recovery_rate  # type: ignore[attr-defined]
        for path in product(range(2), repeat=len(shift)):
            mass, moved = float(weight), state.copy()
            for cycle, reaction in zip(shift, path, strict=True):
                moved[:3] *= np.exp(-rate * cycle.pause_s)
                mass *= model.probabilities(moved, cycle.action)[reaction]
                mass *= cycle.likelihood[reaction] / sum(cycle.likelihood)
                share = min(1.0, math.floor(100 * cycle.duration_s / CYCLE_S) / 100)
                gain, offset = model.profiles[cycle.action][reaction].maps(share * faster, share * sooner)
                left = np.exp(-rate * (cycle.duration_s - share * CYCLE_S))
                moved[:3] = left * (gain * moved[:3] + offset)
            ends.append(moved)
            masses.append(mass)
    return np.array(ends), np.array(masses) / sum(masses)


def by_worker(belief: Belief | tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """The probability of each worker, and the first and second moments of the fatigue he may have."""
    states, weights = (belief.states, belief.weights) if isinstance(belief, Belief) else belief
    mine = [weights * (states[:, -1] == worker) for worker in np.unique(states[:, -1])]
    return np.array([[of.sum(), *(of @ states[:, :3]), *(of @ states[:, :3] ** 2)] for of in mine]).ravel()


@pytest.mark.parametrize("expertise", [0.0, 25.0])
def test_a_shift_is_bayes_rule_over_all_that_may_have_happened(expertise: float) -> None:
    start = belief_in(timed(small_model(expertise)), STARTS, [0.3, 0.7])
    belief = lived_through(start, SHIFT, RNG)
    np.testing.assert_allclose(by_worker(belief), by_worker(enumerated(start, SHIFT)), rtol=1e-12)


def test_a_shift_of_hidden_workers_is_bayes_rule_too() -> None:
    start = two_workers()
    start = replace(start, model=timed(start.model))  # type: ignore[arg-type]
    belief = lived_through(start, SHIFT, RNG)
    np.testing.assert_allclose(by_worker(belief), by_worker(enumerated(start, SHIFT)), rtol=1e-12)


@pytest.mark.parametrize("expertise", EXPERTISES)
def test_an_observation_is_a_column_of_the_recognition(expertise: float) -> None:
    seen, weighed = (belief_in(small_model(expertise, NOISY), STARTS, [0.3, 0.7]) for _ in range(2))
    for action, observation in ((0, 0), (1, 1), (1, 0)):
        seen = seen.update(action, observation, RNG)
        weighed = weighed.weigh(action, NOISY[:, observation], RNG)
    np.testing.assert_allclose(by_worker(weighed), by_worker(seen), rtol=1e-12)
    assert weighed.surprised == seen.surprised


def test_evidence_that_distinguishes_nothing_is_nothing_seen() -> None:
    start = belief_in(small_model(25.0), STARTS, [0.3, 0.7])
    nothing = start.predict(1, RNG)
    for same in (0.2, 1e-300, 1e300):
        flat = start.weigh(1, (same, same), RNG)
        assert (flat.states == nothing.states).all() and (flat.weights == nothing.weights).all()


def test_evidence_for_what_is_impossible_widens_the_belief() -> None:
    model = small_model(math.inf)
    for belief in (belief_in(model, STARTS[:1], [1.0]), ParticleBelief.begin(model, model.state(STARTS[0])[None])):
        never = 1 - int(model.probabilities(belief.states[0], 0).argmax())
        after = belief.weigh(0, np.eye(2)[never], RNG)
        assert after.surprised
        np.testing.assert_allclose(after.states[0], model.transition(belief.states[0], 0, never)[0])


def test_any_problem_takes_soft_evidence() -> None:
    """A problem of tables: the forward algorithm of a hidden Markov model."""
    rng = np.random.default_rng(2)
    move, see = rng.dirichlet(np.ones(3), (2, 3)), rng.dirichlet(np.ones(2), (2, 3))
    problem = table_problem(move, np.zeros((2, 3, 3)), see, 99, 1.0)
    by_hand = np.array([0.2, 0.5, 0.3])
    belief: Belief = table_belief(problem, by_hand)
    for action, likelihood in ((0, (0.2, 0.5, 0.9)), (1, (1, 1, 1)), (1, (1, 1, 1)), (0, (0, 1, 2))):
        belief = belief.weigh(action, likelihood, RNG)
        by_hand = by_hand @ move[action] * likelihood
        by_hand /= by_hand.sum()
    chances = np.bincount(belief.states[:, 0].astype(int), belief.weights, 3)
    np.testing.assert_allclose(chances, by_hand, rtol=1e-12)
    assert len(belief.weights) == 2


# --- memory ------------------------------------------------------------------------------------------------------


def test_two_hundred_cycles_of_which_novices_show_nothing() -> None:
    """At most 1,000 states, and of every entry the mean and the variance that follow from the maps alone."""
    model = small_model(0.0)
    belief: Belief = belief_in(model, STARTS, [0.3, 0.7])
    mean, square = belief.weights @ belief.states[:, :3], belief.weights @ belief.states[:, :3] ** 2
    rng = np.random.default_rng(7)
    for cycle in range(200):
        action = cycle // 3 % 2
        belief = belief.predict(action, rng) if cycle % 5 else belief.weigh(action, (0.7, 0.3), rng)
        shares = (0.5, 0.5) if cycle % 5 else (0.7, 0.3)
        maps = [profile.maps(1.0, 1.0) for profile in model.profiles[action]]
        square = sum(p * (g**2 * square + 2 * g * o * mean + o**2) for p, (g, o) in zip(shares, maps, strict=True))
        mean = sum(p * (g * mean + o) for p, (g, o) in zip(shares, maps, strict=True))
        assert len(belief.weights) <= MAX_STATES
    assert len(belief.weights) > 500
    np.testing.assert_allclose(belief.weights @ belief.states[:, :3], mean, rtol=1e-12)
    np.testing.assert_allclose(belief.weights @ belief.states[:, :3] ** 2, square, rtol=1e-11)


def test_thinned_beliefs_are_right_on_average() -> None:
    """Two workers, one of them no novice, not seen for 11 cycles: 8,192 states against 60 beliefs of at most 1,000."""
    start = two_workers(np.full((2, 2), 0.5))
    exact, actions = start, [0, 1, 1, 0, 0, 1, 0, 1, 1, 1, 0]
    for action in actions:
        exact = exact.update(action, 0, RNG)
    assert len(exact.weights) == 4 * 2**11
    rng, estimates = np.random.default_rng(5), []
    for _ in range(60):
        belief: Belief = start
        for action in actions:
            belief = belief.predict(action, rng)
        assert len(belief.weights) <= MAX_STATES
        estimates.append(by_worker(belief))
    truth, certain = by_worker(exact), [0, 7]  # nobody was seen, so nobody is likelier than he was
    np.testing.assert_allclose(np.array(estimates)[:, certain], np.tile(truth[certain], (60, 1)))
    others = np.delete(np.arange(14), certain)
    assert z_scores(np.array(estimates)[:, others], truth[others]).max() < FALSE_ALARM


def test_thinning_keeps_heavy_states_and_every_weight_on_average() -> None:
    weights = np.array([0.3, 0.2, *np.full(40, 0.01), *np.geomspace(1e-3, 1e-6, 58)])
    weights /= weights.sum()
    rng, total = np.random.default_rng(1), []
    for _ in range(4000):
        kept, share = thinned(weights, np.zeros(100, int), 20, rng)
        assert {0, 1} <= set(kept.tolist()) and len(kept) == 20 and share.sum() == pytest.approx(1)
        total.append(np.bincount(kept, share, weights.size))
    np.testing.assert_allclose(np.array(total)[:, :2], np.tile(weights[:2], (4000, 1)))
    assert z_scores(np.array(total)[:, 2:60], weights[2:60]).max() < FALSE_ALARM
    for unlikely in (1e-3, 1e-9, 1e-300):  # a worker keeps his probability, and some of his states
        two = np.concatenate([np.full(50, unlikely), weights])
        worker = np.repeat([0, 1], [50, 100])
        kept, share = thinned(two, worker, 20, rng)
        of_worker = np.bincount(worker, two) / two.sum()
        np.testing.assert_allclose(np.bincount(worker[kept], share), of_worker)
        assert np.bincount(worker[kept])[0] >= 2 and len(kept) <= 21


def test_states_that_nobody_can_tell_apart_are_one() -> None:
    states = np.array([[0.5 + 1e-8, 0], [0.2, 0], [0.5 + 3e-8, 0], [0.5 + 1e-8, 1]])
    few, weights = merged(states, np.array([0.1, 0.4, 0.3, 0.2]), 1e-6)
    np.testing.assert_allclose(few, [[0.5 + 2.5e-8, 0], [0.2, 0], [0.5 + 1e-8, 1]], rtol=1e-15)
    np.testing.assert_allclose(weights, [0.4, 0.4, 0.2])
    assert merged(states, np.full(4, 0.25), 0.0)[0] is states
    assert merged(states[[0, 1, 0]], np.full(3, 1 / 3), 0.0)[1] == pytest.approx([2 / 3, 1 / 3])


# --- time ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_pauses_add_up_under_every_law(kind: type[FatigueLaw]) -> None:
    law = kind.model_validate({"kind": kind.model_fields["kind"].annotation.__args__[0]})  # type: ignore[union-attr]
    rng = np.random.default_rng(4)
    rates = Rates(*rng.uniform(0.001, 0.1, (2, 78)), rng.uniform(1, 20, 78), np.full(78, 0.1))
    rest, faster, sooner = law.rest(rates), rng.uniform(0.5, 2, 5), rng.uniform(0.5, 2, 5)
    start = rng.uniform(0, 1, (5, 78))

    def after(fatigue: np.ndarray, seconds: float) -> np.ndarray:
        gain, offset = rest.maps(faster, sooner, seconds)
        return gain * fatigue + offset

    for first, second in ((37.2, 2700.0), (0.0, 16.0), (1e-9, 1.2), (3.3, 4.4)):
        np.testing.assert_allclose(after(after(start, first), second), after(start, first + second), atol=3e-16)
    # a cycle of no load is a rest, and a cycle in less time is one with greater rates
    share = rng.uniform(0, 0.5, (7, 78))
    idle = law.profile(np.zeros((7, 78)), 0.3, rates).maps(faster, sooner)
    np.testing.assert_allclose(rest.maps(faster, sooner, 2.1), idle, rtol=1e-12, atol=1e-15)
    quick = law.profile(share, 0.7 * 0.3, rates).maps(faster, sooner)
    np.testing.assert_allclose(law.profile(share, 0.3, rates).maps(0.7 * faster, 0.7 * sooner), quick, rtol=1e-12)
    assert (law.rest_rate(rates) == rest.slowing + rest.recovering).all()


def whole(expertise: float = 25.0, count: int = 40) -> tuple[Belief, ...]:
    """A belief of every kind about the same task."""
    rng = np.random.default_rng(3)
    start = belief_in(timed(small_model(expertise)), STARTS, [0.3, 0.7])
    task = in_mind(CONTINUOUS)
    hidden = HiddenWorkerBelief.start(timed(task.model), np.repeat(task.states[:1], count, axis=0), CONTINUOUS, rng)
    return start, ParticleBelief.begin(start.model, np.repeat(start.states, count // 2, axis=0)), hidden


@pytest.mark.parametrize("number", range(3))
def test_pauses_of_a_belief_add_up(number: int) -> None:
    """Against the law by hand; rest(a).rest(b) is rest(a + b), and a longer cycle is a cycle and a rest."""
    belief = whole()[number]
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    own = model.workers.recovery_rate_factor[belief.states[:, -1].astype(int), None]
    rate = model.profiles[0][0].recovery_rate * own  # type: ignore[attr-defined]
    after = belief.rest(37.2)
    np.testing.assert_allclose(after.states[:, :3], np.exp(-rate * 37.2) * belief.states[:, :3], rtol=1e-13)
    assert (after.states[:, -1] == belief.states[:, -1]).all() and (after.weights == belief.weights).all()
    for first, second in ((37.2, 2700.0), (0.7, 0.8)):
        np.testing.assert_allclose(
            belief.rest(first).rest(second).states, belief.rest(first + second).states, rtol=1e-13, atol=3e-16
        )
    longer, then_rest = (np.random.default_rng(1) for _ in range(2))
    states = belief.weigh(1, (1, 0), longer, duration_s=CYCLE_S + 1.2).states
    np.testing.assert_allclose(states, belief.weigh(1, (1, 0), then_rest).rest(1.2).states, rtol=1e-13)
    assert longer.random() == then_rest.random()


def test_workers_who_take_turns_are_those_who_work_alone() -> None:
    """Beliefs of two workers, updated in turn, each resting while the other works: nothing passes between them."""
    alone = [lived_through(belief, SHIFT[:4], np.random.default_rng(2)) for belief in whole()]
    beliefs, streams = list(whole()), [np.random.default_rng(2) for _ in range(3)]
    for cycle in SHIFT[:4]:
        beliefs = [lived_through(belief, [cycle], stream) for belief, stream in zip(beliefs, streams, strict=True)]
    for ours, theirs in zip(beliefs, alone, strict=True):
        assert ours.states.tobytes() == theirs.states.tobytes() and ours.weights.tobytes() == theirs.weights.tobytes()


def test_pauses_and_durations_survive_rejuvenation() -> None:
    """The particles are what their workers' pasts made of them, with all pauses, after every worker was exchanged."""
    belief = lived_through(whole(count=400)[2], SHIFT[:6], RNG)
    assert isinstance(belief, HiddenWorkerBelief)
    after = belief.rejuvenated(RNG).rest(5.0)
    history = after.history
    assert history.rest_s.tolist() == pytest.approx([0, 0, 0, 0.3 + 1.7, 0, 1.31 - 1.3 + 0.4, 5.0])
    assert history.shares.tolist() == [1, 1, 1, 1, 0.65, 0]
    moved = (after.states[:, :3] != belief.rest(5.0).states[:, :3]).any(axis=1)
    assert moved.mean() > 0.3
    for number in (3, 50, 399):
        mine = after.model.workers.pick(np.array([number]))
        rate = mine.recovery_rate_factor * after.model.profiles[0][0].recovery_rate  # type: ignore[attr-defined]
        fatigue, chance = history.start[number, :3] * np.exp(-rate * history.rest_s[0]), 0.0
        for t, (action, reaction) in enumerate(zip(history.actions, history.outcomes[number], strict=True)):
            state = np.append(np.pad(fatigue, (0, after.states.shape[1] - 4)), number)
            chance += math.log(after.model.probabilities(state, action)[reaction])
            share = history.shares[t]
            maps = after.model.profiles[action][reaction].maps(share * mine[0][0], share * mine[1][0])
            fatigue = (maps[0] * fatigue + maps[1]) * np.exp(-rate * history.rest_s[t + 1])
        np.testing.assert_allclose(after.states[number, :3], fatigue, rtol=1e-10)
        assert history.log_likelihood[number] == pytest.approx(chance, rel=1e-9)
    states = history.start.copy()
    np.testing.assert_allclose(relive(after.model, states, history), history.log_likelihood, rtol=1e-9)
    np.testing.assert_allclose(states, after.states, rtol=1e-12)


def test_particles_find_the_exact_posterior_of_a_shift() -> None:
    """Workers and fatigue after soft evidence, cycles not seen and pauses: 30 filters of 400 particles."""
    task = in_mind(FINITE)
    model, rng = timed(task.model), np.random.default_rng(2)
    shift = [*SHIFT[:4], Lived(0, (1, 0)), Lived(1, (0, 1), pause_s=2.0), Lived(1, (1, 0)), Lived(0, (0.2, 0.8))]
    args = model, task.states, task.weights, FINITE

    def estimates_of(belief: Belief) -> np.ndarray:
        return np.concatenate([chances_of_workers(belief), belief.weights @ belief.states[:, :3]])  # type: ignore[arg-type]

    exact = lived_through(ExactSettings(kind="exact").build(*args, rng), shift, rng)
    settings = ParticleSettings(kind="particles", count=400)
    found = [lived_through(settings.build(*args, rng), shift, rng) for _ in range(30)]
    estimates = np.array([estimates_of(belief.resampled(rng)) for belief in found])  # type: ignore[attr-defined]
    assert z_scores(estimates, estimates_of(exact)).max() < FALSE_ALARM


# --- the paper's task, and what is refused ---------------------------------------------------------------------------


def test_a_lunch_break_beside_the_papers_task(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Half of the fatigue is gone after ln 2 / 0.04 s = 17.3 s, all of it after lunch (section IV-B)."""
    task = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions["single_novice"])
    belief: Belief = task.initial_belief("prior", task.model, RNG)
    for cycle in range(6):
        belief = belief.predict(cycle % 2, RNG)
    assert len(belief.weights) == 2**6 and belief.states[:, :-1].max() > 0.2
    np.testing.assert_allclose(belief.rest(math.log(2) / 0.04).states[:, :-1], belief.states[:, :-1] / 2, rtol=1e-12)
    assert belief.rest(45 * 60).states[:, :-1].max() < 1e-40
    after = belief.predict(0, RNG, duration_s=17.2)
    np.testing.assert_allclose(after.states, belief.predict(0, RNG).rest(17.2 - 16).states, rtol=1e-13)


WRONG = [(math.nan, 1), (math.inf, 1), (-1e-9, 1), (0, 0), (1,), (1, 1, 1), ("a", "b"), None, [[1, 1]], [{}, 1]]


@pytest.mark.parametrize("number", range(3))
def test_what_is_no_evidence_or_time_is_refused(number: int) -> None:
    belief = whole()[number]
    for likelihood in WRONG:
        with pytest.raises(ProblemError, match="likelihood: "):
            belief.weigh(0, likelihood, RNG)  # type: ignore[arg-type]
    for seconds in (math.nan, math.inf, -1.0, "3", None):
        with pytest.raises(ProblemError, match="is no time in seconds"):
            belief.rest(seconds)  # type: ignore[arg-type]
        if seconds is not None:
            with pytest.raises(ProblemError, match="is no time in seconds"):
                belief.predict(0, RNG, duration_s=seconds)  # type: ignore[arg-type]
    with pytest.raises(IndexError, match="action 2"):
        belief.predict(2, RNG)


@dataclass(frozen=True)
class OwnBelief(fp.Belief):
    """A belief that only knows observations."""

    def update(self, action: int, observation: object, rng: np.random.Generator) -> "OwnBelief":
        return self


@dataclass(frozen=True)
class OwnExactBelief(fp.ExactBelief):
    """An exact belief with something of its own."""

    mark: str = "mine"


def test_beliefs_of_ones_own() -> None:
    """What derives from the base says what it cannot do; what derives from the exact one can, and stays itself."""
    start = belief_in(timed(small_model(25.0)), STARTS, [0.3, 0.7])
    own = OwnBelief(start.model, start.states, start.weights)
    for try_it in (lambda: own.predict(0, RNG), lambda: own.weigh(0, (1, 2), RNG)):
        with pytest.raises(ProblemError, match="OwnBelief has no `weigh`"):
            try_it()
    with pytest.raises(ProblemError, match="OwnBelief has no `rest`"):
        own.rest(1.0)
    derived = OwnExactBelief(start.model, start.states, start.weights, mark="kept").predict(0, RNG).rest(3.0)
    assert isinstance(derived, OwnExactBelief) and derived.mark == "kept" and len(derived.weights) == 4


def test_problems_without_time() -> None:
    """Listening of which nothing was heard tells nothing; a tiger knows no rest."""
    heard = replace(NO_IDEA, weights=np.array([0.85, 0.15]))
    np.testing.assert_allclose(heard.predict(2, RNG).weights, heard.weights)
    opened = heard.predict(0, RNG)
    assert sorted(opened.states[:, 0]) == [0, 1] and opened.weights.tolist() == [0.5, 0.5]
    with pytest.raises(ProblemError, match="the problem does not say what rest does"):
        NO_IDEA.rest(3.0)
    with pytest.raises(ProblemError, match="the problem does not say how long its cycles take"):
        NO_IDEA.predict(0, RNG, duration_s=3.0)
    untimed = belief_in(small_model(0.0), STARTS, [0.3, 0.7])
    with pytest.raises(ProblemError, match="the problem does not say what rest does"):
        untimed.rest(3.0)

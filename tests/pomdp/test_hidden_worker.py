"""Workers with hidden rates and expertise: their settings, their cycle maps, and what is inferred about them.

Random tests of means compare at five standard errors: a false alarm in 6e-7 per index compared.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER, ROOT
from pydantic import TypeAdapter
from scipy import stats
from test_particles import BLIND, FALSE_ALARM, NOISY, STARTS, small_model, z_scores

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.random_streams import draw_random_numbers
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.planners.baselines import GreedyPolicy
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.history import History, relive
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.beliefs.registry import (
    MAX_EXACT,
    ExactSettings,
    ParticleSettings,
    default_belief,
)
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, one_worker
from fatigue_planner.pomdp.hidden_worker import Distribution, HiddenWorker, WorkerPrior
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.pomdp.scenario import Scenario, average_worker
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.tables import OUTCOMES, trial_table

K = {"kind": "lognormal", "median": 1.0, "sigma": 0.5}
R = {"kind": "uniform", "from": 0.5, "to": 2.0}
BETA = {"kind": "lognormal", "median": 10.0, "sigma": 1.0}


def prior_of(known: float | None = None, **parameters: object) -> WorkerPrior:
    return WorkerPrior(HiddenWorker.model_validate(parameters, strict=False), known)


CONTINUOUS = prior_of(fatigue_rate_factor=K, recovery_rate_factor=R, expertise=BETA)
FINITE = prior_of(
    fatigue_rate_factor={"kind": "choice", "values": [0.5, 1.0, 2.0], "probabilities": [0.3, 0.4, 0.3]},
    expertise={"kind": "choice", "values": [0.0, 25.0], "probabilities": [0.5, 0.5]},
)


def in_mind(prior: WorkerPrior, recognition: np.ndarray | None = None) -> Scenario:
    """The small problem with a hidden worker, who starts in one of three states."""
    model = small_model(average_worker(prior), recognition)
    states = np.array([model.state(fatigue) for fatigue in STARTS])
    return Scenario(
        model, states, np.array([0.2, 0.5, 0.3]), prior, default_belief(model.observation_reveals_outcome, prior)
    )


def lived(world: FatiguePomdp, state: np.ndarray, cycles: int, seed: int) -> list[tuple[int, int]]:
    """Actions, and the reactions of a worker to them."""
    rng, past = np.random.default_rng(seed), []
    for action in rng.integers(0, 2, cycles):
        reaction = draw(world.probabilities(state, action), rng.random())
        state, _ = world.transition(state, action, reaction)
        past.append((int(action), reaction))
    return past


# --- distributions -------------------------------------------------------------------------------------------------


def distribution(settings: dict[str, object]) -> Distribution:
    return TypeAdapter(Distribution).validate_python(settings)


def test_quantiles() -> None:
    levels = np.array([0.0, 0.1, 0.2, 0.5, 0.69999, 0.7, 0.999999])
    choice = distribution({"kind": "choice", "values": (3.0, 1.0, math.inf), "probabilities": (0.5, 0.2, 0.3)})
    assert choice.quantile(levels).tolist() == [1, 1, 3, 3, 3, math.inf, math.inf]
    uniform = distribution({"kind": "uniform", "from": 2.0, "to": 6.0})
    np.testing.assert_allclose(uniform.quantile(levels), 2 + 4 * levels)
    lognormal = distribution({"kind": "lognormal", "median": 7.0, "sigma": 0.4})
    np.testing.assert_allclose(lognormal.quantile(levels), stats.lognorm(0.4, scale=7.0).ppf(levels), rtol=1e-12)
    tenths = distribution({"kind": "choice", "values": tuple(map(float, range(10))), "probabilities": (0.1,) * 10})
    assert tenths.quantile(np.array([1 - 2**-53])).tolist() == [9]


def test_the_average_worker_is_the_median() -> None:
    workers = average_worker(CONTINUOUS)
    assert [float(values[0]) for values in workers] == pytest.approx([1.0, 1.25, 10.0])
    known = average_worker(prior_of(4.0, fatigue_rate_factor=K))
    assert [float(values[0]) for values in known] == pytest.approx([1.0, 1.0, 4.0])


def test_a_finite_prior_lists_its_workers() -> None:
    workers, chances = FINITE.support()
    assert FINITE.size == 6 == len(chances) and CONTINUOUS.size == math.inf
    assert FINITE.hidden() == [0, 2] and prior_of(0.0).hidden() == []
    listed = dict(zip(zip(*map(np.ndarray.tolist, workers), strict=True), chances, strict=True))
    assert listed[0.5, 1.0, 25.0] == pytest.approx(0.15) and listed[1.0, 1.0, 0.0] == pytest.approx(0.2)
    drawn = FINITE.at(np.random.default_rng(0).random((20_000, 3)))
    counts = [((drawn.fatigue_rate_factor == k) & (drawn.expertise == beta)).sum() for k, _, beta in listed]
    assert stats.chisquare(counts, 20_000 * chances).pvalue > 1e-6


def test_the_belief_that_fits() -> None:
    tenth = {"kind": "choice", "values": [float(v) for v in range(1, 12)], "probabilities": [1 / 11] * 11}
    many = prior_of(fatigue_rate_factor=tenth, recovery_rate_factor=tenth, expertise=tenth)
    assert many.size == 11**3 > MAX_EXACT
    kinds = [
        default_belief(revealed, p).kind
        for revealed, p in ((True, None), (True, FINITE), (False, FINITE), (True, many))
    ]
    assert (
        kinds == ["exact", "exact", "particles", "particles"] and default_belief(True, CONTINUOUS).kind == "particles"
    )


# --- cycle maps ----------------------------------------------------------------------------------------------------


def test_maps_for_other_rates_are_those_of_eq_2() -> None:
    """Gain and offset with k and R multiplied, against Runge-Kutta steps through Eq. 2, tick by tick."""
    rng = np.random.default_rng(5)
    ticks, step, law = 40, 0.1, MaLaw(kind="ma")
    torque = rng.normal(0, 3, (5, 39)).repeat(8, axis=0) + rng.normal(0, 0.5, (ticks, 39))
    parameters = FatigueParameters(
        *rng.uniform(0.01, 0.5, (2, 78)), np.ones(78), np.full(78, 0.2), np.full(78, 10.0), law, None
    )
    load_fraction = np.hstack([np.maximum(torque, 0), np.maximum(-torque, 0)]) / 10
    factors = [(1.0, 1.0), (0.3, 2.0), (4.0, 0.5)]
    gains, offsets = law.profile(load_fraction, step, parameters).maps(*np.transpose(factors))
    start = rng.uniform(0, 1, 78)
    for (faster, sooner), gain, offset in zip(factors, gains, offsets, strict=True):
        k, r, f = faster * parameters.fatigue_rate, sooner * parameters.recovery_rate, start.copy()
        for load in load_fraction:
            tires = load > 0.2

            def slope(f: np.ndarray, load: np.ndarray = load, tires: np.ndarray = tires) -> np.ndarray:
                return np.where(tires, k * load * (1 - f), -r * f)  # noqa: B023

            h = step / 4
            for _ in range(4):
                a = slope(f)
                b = slope(f + h / 2 * a)
                c = slope(f + h / 2 * b)
                f = f + h / 6 * (a + 2 * b + 2 * c + slope(f + h * c))
        np.testing.assert_allclose(gain * start + offset, f, atol=1e-9)


def test_every_worker_has_rows_of_its_own() -> None:
    workers = FINITE.support()[0]
    model = small_model(workers)
    for index in range(6):
        alone = model.for_workers(workers.pick(np.array([index])))
        state = model.state(STARTS[0], index)
        for action in range(2):
            probabilities = alone.probabilities(alone.state(STARTS[0]), action)
            np.testing.assert_array_equal(model.probabilities(state, action), probabilities)
            for reaction in range(2):
                ours, cost = model.transition(state, action, reaction)
                theirs, expected = alone.transition(alone.state(STARTS[0]), action, reaction)
                np.testing.assert_array_equal(ours[:-1], theirs[:-1])
                assert ours[-1] == index and cost == expected


# --- beliefs -------------------------------------------------------------------------------------------------------


def test_exact_belief_over_workers_is_bayes_rule_by_hand() -> None:
    """Product of the probabilities of the reactions seen, worker by worker and start by start."""
    task = in_mind(FINITE)
    assert isinstance(task.belief, ExactSettings)
    rng = np.random.default_rng(0)
    belief = task.initial_belief("prior", task.model, rng)
    assert len(belief.weights) == 18 and belief.weights.sum() == pytest.approx(1)
    workers, chances = FINITE.support()
    past = lived(task.worker(np.array([0.9, 0.5, 0.9])), task.states[1], 12, 7)
    by_hand = np.outer(task.weights, chances)
    for start in range(3):
        for index in range(6):
            alone = task.model.for_workers(workers.pick(np.array([index])))
            state = task.states[start]
            for action, reaction in past:
                by_hand[start, index] *= alone.probabilities(state, action)[reaction]
                state, _ = alone.transition(state, action, reaction)
    for action, reaction in past:
        belief = belief.update(action, reaction, rng)
    np.testing.assert_allclose(belief.weights, (by_hand / by_hand.sum()).ravel(), rtol=1e-9)


def chances_of_workers(belief: HiddenWorkerBelief | ExactBelief) -> np.ndarray:
    """The probability of each combination of FINITE."""
    workers = belief.model.workers.pick(belief.states[:, -1].astype(int))
    return np.array([
        belief.weights[(workers.fatigue_rate_factor == k) & (workers.expertise == beta)].sum()
        for k in (0.5, 1.0, 2.0) for beta in (0.0, 25.0)
    ])  # fmt: skip


@pytest.mark.parametrize(("recognition", "cycles"), [(None, 40), (NOISY, 5)])
def test_particles_find_the_exact_posterior_of_a_finite_prior(recognition: np.ndarray | None, cycles: int) -> None:
    """Filters with resampling and rejuvenation: no worker is over- or underrated.

    30 filters of 500 particles; with noise, all ways the reactions may have gone are enumerated.
    """
    task = in_mind(FINITE, recognition)
    rng = np.random.default_rng(2)
    args = task.model, task.states, task.weights, FINITE
    exact = ExactSettings(kind="exact").build(*args, rng)
    past = lived(task.worker(np.array([0.1, 0.5, 0.9])), task.states[1], cycles, 4)
    for action, seen in past:
        exact = exact.update(action, seen, rng)
    estimates = []
    for _ in range(30):
        belief = ParticleSettings(kind="particles", count=500).build(*args, rng)
        for action, seen in past:
            belief = belief.update(action, seen, rng)
        belief = belief.resampled(rng)
        estimates.append(chances_of_workers(belief))
    truth = chances_of_workers(exact)
    assert truth.sum() == pytest.approx(1) and truth.max() > 0.2
    likely = truth > 0.005
    assert z_scores(np.array(estimates)[:, likely], truth[likely]).max() < FALSE_ALARM


def features(workers: Workers) -> np.ndarray:
    """Log k, R and log beta, (3, n)."""
    return np.array([np.log(workers[0]), workers[1], np.log(workers[2])])


def posterior_on_grid(task: Scenario, past: list[tuple[int, int]], count: int) -> tuple[Workers, np.ndarray]:
    """count^3 workers of CONTINUOUS, and their probabilities after what was seen from the second start on."""
    middles = (np.arange(count) + 0.5) / count
    grid = CONTINUOUS.at(np.stack(np.meshgrid(middles, middles, middles), axis=-1).reshape(-1, 3))
    states = np.repeat(task.states[1:2], count**3, axis=0)
    states[:, -1] = np.arange(count**3)
    actions, seen = np.array(past).T
    outcomes = np.tile(seen.astype(np.int16), (count**3, 1))
    shares, rest_s = np.ones(len(past)), np.zeros(len(past) + 1)
    history = replace(History.begin(states), actions=actions, outcomes=outcomes, shares=shares, rest_s=rest_s)
    log_likelihood = relive(task.model.for_workers(grid), states, history)
    posterior = np.exp(log_likelihood - log_likelihood.max())
    return grid, posterior / posterior.sum()


def test_particles_find_the_posterior_of_continuous_parameters() -> None:
    """Posterior means of log k, R and log beta after 40 reactions, against integration over a grid of 40^3 workers.

    40 filters of 500 particles with one start.
    """
    task = in_mind(CONTINUOUS)
    past = lived(task.worker(np.array([0.9, 0.2, 0.8])), task.states[1], 40, 11)
    grid, posterior = posterior_on_grid(task, past, 40)
    truth = features(grid) @ posterior
    before = features(grid).mean(axis=1)
    spread = np.sqrt(np.square(features(grid) - truth[:, None]) @ posterior)
    assert np.abs(truth - before).max() > 0.5  # there was something to learn
    rng = np.random.default_rng(8)
    estimates = []
    for _ in range(40):
        belief = HiddenWorkerBelief.start(task.model, np.repeat(task.states[1:2], 500, axis=0), CONTINUOUS, rng)
        for action, reaction in past:
            belief = belief.update(action, reaction, rng)
        estimates.append(features(belief.workers()) @ belief.weights)
    # the filter's own bias, O(1 / particles), and the grid's error are below a fiftieth of the spread
    off = np.abs(np.mean(estimates, axis=0) - truth) - spread / 50
    assert (off < FALSE_ALARM * np.std(estimates, axis=0, ddof=1) / math.sqrt(40)).all()


def test_rejuvenation_leaves_workers_and_their_pasts_as_they_are_distributed() -> None:
    """The kernel alone (as Geweke's test of posterior simulators has it).

    Particles whose workers come from the prior and whose pasts from these workers are a sample of the joint
    distribution; rejuvenation must leave them one. Reactions seen through a blind sensor are drawn so, with
    equal weights. Kolmogorov-Smirnov against the prior, false alarm 1e-6 each.
    """
    task = in_mind(CONTINUOUS, BLIND)
    rng = np.random.default_rng(3)
    belief = HiddenWorkerBelief.start(task.model, np.repeat(task.states[1:2], 20_000, axis=0), CONTINUOUS, rng)
    for action in (0, 1, 1, 0, 0, 1, 0, 1):
        belief = belief.update(action, 0, rng)
    assert np.ptp(belief.log_weights) < 1e-12
    after = belief.rejuvenated(rng)
    assert (after.workers().expertise != belief.workers().expertise).mean() > 0.3
    laws = stats.norm(0, 0.5), stats.uniform(0.5, 1.5), stats.norm(math.log(10), 1.0)
    for values, law, old in zip(after.workers(), laws, belief.workers(), strict=True):
        scale = np.asarray if law is laws[1] else np.log
        assert stats.kstest(scale(values), law.cdf).pvalue > 1e-6
        fit, fitted = after.history.log_likelihood, belief.history.log_likelihood
        for ours, theirs in ((fit, fitted), (scale(values) * fit, scale(old) * fitted)):
            assert abs(stats.ttest_rel(ours, theirs).statistic) < FALSE_ALARM
    # a particle's state and likelihood are those of its worker's past
    states = after.history.start.copy()
    log_likelihood = relive(after.model, states, after.history)
    np.testing.assert_array_equal(states, after.states)
    np.testing.assert_allclose(log_likelihood, after.history.log_likelihood, rtol=1e-9)


def test_expertise_is_inferred_from_reactions() -> None:
    """After 300 reactions of workers with beta = 2, 10 and 50, each lies within the range of 300 draws from the belief.

    The true one of a worker the prior makes lies outside in 2 of 301 cases.
    """
    task = in_mind(prior_of(expertise={"kind": "lognormal", "median": 10.0, "sigma": 1.5}))
    for beta in (2.0, 10.0, 50.0):
        world = task.model.for_workers(one_worker(beta))
        rng = np.random.default_rng(1)
        belief = task.initial_belief("prior", world, rng)
        assert isinstance(belief, HiddenWorkerBelief)
        first = np.log(belief.workers().expertise).std()
        for action, reaction in lived(world, task.states[1], 300, 5):
            belief = belief.update(action, reaction, rng)
            assert not belief.surprised
        believed = np.sort(np.log(belief.resampled(rng).workers().expertise))
        assert believed[0] < math.log(beta) < believed[-1]
        assert believed.std() < 0.6 * first
        assert len(np.unique(believed)) > 150  # of 300: rejuvenation prevents particle deprivation


def test_surprise_widens_to_workers_who_might_have_done_it() -> None:
    """Experts with hidden rates, and a belief only in those who would do one thing: they do the other."""
    task = in_mind(prior_of(math.inf, fatigue_rate_factor=K, recovery_rate_factor=R))
    rng = np.random.default_rng(0)
    undecided = task.model.state(np.array([0.1, 0.0, 1.0]))
    belief = HiddenWorkerBelief.start(task.model, np.repeat(undecided[None], 300, axis=0), task.prior, rng)
    chosen = np.array([belief.model.probabilities(state, 1)[0] for state in belief.states])
    assert 30 < chosen.sum() < 270
    with np.errstate(divide="ignore"):
        sure = replace(belief, weights=chosen / chosen.sum(), log_weights=np.log(chosen))
    after = sure.update(1, 1, rng)
    assert after.surprised and after.effective_size() == pytest.approx(300)
    of_today = task.model.for_workers(after.workers())
    would = [of_today.probabilities(start, 1)[1] for start in after.history.start]
    assert np.mean(would) > 0.05  # none of them before
    decision = GreedyPolicy().act(after, rng)
    assert "impossible under the model" in decision.reason


def test_knowledge_decides_the_belief() -> None:
    task = in_mind(CONTINUOUS)
    world = task.worker(np.array([0.3, 0.6, 0.9]))
    rng = np.random.default_rng(0)
    average, truth = task.initial_belief("average", world, rng), task.initial_belief("truth", world, rng)
    assert isinstance(average, ExactBelief) and isinstance(truth, ExactBelief)
    assert truth.model is world and average.model is task.model
    np.testing.assert_array_equal(world.workers, [v[[0]] for v in CONTINUOUS.at(np.array([[0.3, 0.6, 0.9]]))])
    assert not task.leaves_nothing_to_chance()
    noisy = in_mind(FINITE, NOISY)
    world = noisy.worker(np.array([0.3, 0.6, 0.9]))
    for knows in ("prior", "average", "truth"):
        assert isinstance(noisy.initial_belief(knows, world, rng), ParticleBelief)


# --- the experiment file -------------------------------------------------------------------------------------------

HIDDEN = """
hidden_workers:
  someone:
    fatigue_rate_factor: {kind: lognormal, median: 1.0, sigma: 0.45}
    recovery_rate_factor: {kind: uniform, from: 0.5, to: 2.0}
    expertise: {kind: choice, values: [0, 5000, .inf], probabilities: [0.2, 0.5, 0.3]}
recognition:
  arm: {arm: 0.9, back: 0.1}
  back: {arm: 0.2, back: 0.7, unclear: 0.1}
belief: {kind: particles, count: 40}
"""
NOVICE = "single_novice: {initial_belief: single, expertise: 0}"
SOMEONE = "single_novice: {initial_belief: single, hidden_worker: someone}"


def write(path: Path, old: str = "", new: str = "") -> Path:
    text = PAPER.read_text().replace("discount: 0.95 ", HIDDEN + "discount: 0.95 ").replace(NOVICE, SOMEONE)
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


def test_hidden_workers_in_a_file(tmp_path: Path) -> None:
    experiment = load_experiment(write(tmp_path / "mine.yaml"))
    names, (matrix,) = experiment.recognised(["high", "low"])
    assert names == ("arm", "back", "unclear")
    np.testing.assert_array_equal(matrix, [[0.9, 0.1, 0], [0.2, 0.7, 0.1]])
    assert experiment.benchmark.conditions["single_novice"].hidden_worker == "someone"
    again = Experiment.model_validate(experiment.model_dump(by_alias=True))
    assert again == experiment and '"Infinity"' in str(experiment.plain()).replace("'", '"')


EXPERTISE = "{kind: choice, values: [0, 5000, .inf], probabilities: [0.2, 0.5, 0.3]}"
K_TEXT = "{kind: lognormal, median: 1.0, sigma: 0.45}"
R_TEXT = "{kind: uniform, from: 0.5, to: 2.0}"
WHO = "hidden_workers.someone"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("hidden_worker: someone", "hidden_worker: nobody",
         "benchmark.conditions.single_novice.hidden_worker: 'nobody' is not one of someone."),
        ("[0.2, 0.5, 0.3]", "[0.2, 0.5, 0.2]", f"{WHO}.expertise: probabilities sum to 0.9, not to 1."),
        ("[0.2, 0.5, 0.3]", "[0.5, 0.5]", f"{WHO}.expertise: 3 values, but 2 probabilities."),
        ("[0.2, 0.5, 0.3]", "[0.2, 0.8, 0.0]", f"{WHO}.expertise.probabilities.2 = 0.0: input should be greater"),
        ("values: [0, 5000, .inf]", "values: []", f"{WHO}.expertise.values = []: should have"),
        ("values: [0, 5000, .inf]", "values: [0, -5, .inf]", f"{WHO}.expertise.values.1 = -5: input should be gre"),
        ("values: [0, 5000, .inf]", "values: [0, .nan, .inf]", f"{WHO}.expertise.values.1 = nan: "),
        (EXPERTISE, "{kind: dice}", f"{WHO}.expertise.kind = 'dice': should be one of 'choice', 'lognormal', 'unif"),
        (EXPERTISE, "{values: [1], probabilities: [1]}", f"{WHO}.expertise: needs a kind: one of 'choice', "),
        (EXPERTISE, "7", f"{WHO}.expertise = 7: should be a mapping of keys and values."),
        ("from: 0.5, to: 2.0", "from: 2.0, to: 0.5", f"{WHO}.recovery_rate_factor: from (2) should be less than to (0"),
        ("from: 0.5, to: 2.0", "from: 1, to: 1", f"{WHO}.recovery_rate_factor: from (1) should be less than to (1)."),
        ("from: 0.5, to: 2.0", "from: -1, to: 1", f"{WHO}.recovery_rate_factor.from = -1: input should be greater"),
        ("from: 0.5, to: 2.0", "from: 0, to: 1", f"{WHO}.recovery_rate_factor: 0 is not a usable factor: it must be"),
        ("from: 0.5, to: 2.0", "from: 0.5, to: .nan", f"{WHO}.recovery_rate_factor.to = nan: input should be a finite"),
        ("from: 0.5, to: 2.0", "from: 0.5, to: .inf", f"{WHO}.recovery_rate_factor.to = inf: input should be a finite"),
        ("from: 0.5, to: 2.0", "from: 0.5", f"{WHO}.recovery_rate_factor.to: is missing."),
        ("from: 0.5, to: 2.0", "first: 0.5, to: 2", f"{WHO}.recovery_rate_factor.first: unknown key"),
        (R_TEXT, "{kind: choice, values: [1, .inf], probabilities: [0.5, 0.5]}",
         f"{WHO}.recovery_rate_factor: inf is not a usable factor: it must be above 0 and at most 1000."),
        ("sigma: 0.45", "sigma: 0", f"{WHO}.fatigue_rate_factor.sigma = 0: input should be greater than 0."),
        ("sigma: 0.45", "sigma: .nan", f"{WHO}.fatigue_rate_factor.sigma = nan: "),
        ("sigma: 0.45", "sigma: 100", f"{WHO}.fatigue_rate_factor.sigma = 100: input should be less than or equal to"),
        ("median: 1.0", "median: -1", f"{WHO}.fatigue_rate_factor.median = -1: input should be greater than 0."),
        ("median: 1.0", "mean: 1.0", f"{WHO}.fatigue_rate_factor.mean: unknown key"),
        ("    fatigue_rate_factor", "    fatigue_rate", f"{WHO}.fatigue_rate: unknown key"),
        ("hidden_worker: someone", "hidden_worker: someone, expertise: 3",
         "benchmark.conditions.single_novice.expertise: hidden_workers.someone already gives one."),
        (", hidden_worker: someone", "", "benchmark.conditions.single_novice.expertise: is missing."),
        (f"    expertise: {EXPERTISE}\n", "", "benchmark.conditions.single_novice.expertise: is missing."),
        ("  someone:", "  some one:", "hidden_workers.some one"),
        ("arm: {arm: 0.9, back: 0.1}", "arm: {arm: 0.9, back: 0.2}", "recognition.arm: probabilities sum to 1.1, not"),
        ("arm: {arm: 0.9, back: 0.1}", "arm: {arm: 1.1}", "recognition.arm.arm = 1.1: input should be less"),
        ("arm: {arm: 0.9, back: 0.1}", "arm: {arm: .nan}", "recognition.arm.arm = nan: "),
        ("arm: {arm: 0.9, back: 0.1}", "arm: {}", "recognition.arm: probabilities sum to 0, not to 1."),
        ("  arm: {arm: 0.9, back: 0.1}\n", "", "recognition: needs a line for each of arm, back, and no other."),
        ("  arm: {arm: 0.9", "  leg: {arm: 0.9", "recognition: needs a line for each of arm, back, and no other."),
        ("unclear: 0.1", "not clear: 0.1", "recognition.back.not clear"),
        ("belief: {kind: particles, count: 40}", "belief: {kind: exact}",
         "belief.kind: exact needs reactions recognised without error; use particles."),
        ("belief: {kind: particles, count: 40}", "belief: {kind: particles}", "belief.count: is missing."),
        ("count: 40", "count: 0", "belief.count = 0: input should be greater than or equal to 1."),
        ("count: 40", "index: 40", "belief.index: unknown key"),
        ("kind: particles", "kind: kalman", "belief.kind = 'kalman': should be one of 'exact', 'particles'."),
    ],
)  # fmt: skip
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, expected: str) -> None:
    path = write(tmp_path / "mine.yaml", old, new)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    message = str(caught.value).removeprefix(f"{path}: ")
    assert expected in message


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (K_TEXT, "infinitely many; use particles."),
        ("{kind: choice, values: [%s], probabilities: [%s]}", "1200; use particles."),
    ],
)
def test_exact_belief_where_it_cannot_be(tmp_path: Path, values: str, expected: str) -> None:
    if "%s" in values:
        values %= ", ".join(str(v + 1) for v in range(400)), ", ".join(["0.0025"] * 400)
    path = write(tmp_path / "mine.yaml", K_TEXT, values)
    text = path.read_text().replace(f"    recovery_rate_factor: {R_TEXT}\n", "")
    text = text[: text.index("recognition:")] + "belief: {kind: exact}\n" + text[text.index("discount: 0.95 ") :]
    path.write_text(text)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert "belief.kind: exact can hold 1000 workers, hidden_workers.someone has " + expected in str(caught.value)


# --- runs ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_runs_are_the_same_with_any_number_of_jobs(tmp_path: Path) -> None:
    """Noisy recognition and hidden workers, particles and search: in this process or in two, to the last bit."""
    search = PomcpSettings(kind="pomcp", backup="max", exploration_constant=0.01, descents=30)
    few = ParticleSettings(kind="particles", count=30)
    cells = [
        Cell(name, 6, "search", search, replace(known, belief=few), 7, 10)
        for name, known in (("noisy", in_mind(CONTINUOUS, NOISY)), ("revealed", in_mind(CONTINUOUS)))
    ]
    in_process = [cell.run(range(10)) for cell in cells]
    elsewhere, _ = run_grid(cells, tmp_path, LocalProcesses(2), lambda cell, n: None)
    serial, parallel = (trial_table(cells, results)[OUTCOMES].to_numpy() for results in (in_process, elsewhere))
    np.testing.assert_array_equal(serial, parallel)
    assert len(np.unique(serial[:, 0])) == 20


def test_a_condition_of_the_papers_task(tmp_path: Path, reactions: tuple[Reaction, ...]) -> None:
    """From file to scenario: active entries, observations, prior."""
    experiment = load_experiment(write(tmp_path / "mine.yaml"))
    condition = experiment.benchmark.conditions["single_novice"]
    task = scenario(experiment, cycle_profiles(experiment, reactions), condition)
    assert (
        task.prior is not None
        and not task.model.observation_reveals_outcome
        and task.model.observations == ("arm", "back", "unclear")
    )
    assert task.model.workers.expertise.tolist() == [5000.0] and task.belief.kind == "particles"
    belief = task.initial_belief("prior", task.model, np.random.default_rng(0))
    assert len(belief.states) == 40
    for observation in (0, 2, 1, 2):
        belief = belief.update(1, observation, np.random.default_rng(1))
    assert belief.weights.sum() == pytest.approx(1)


def test_the_experiment_is_what_its_file_says(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """The paper's reactions; each policy with three kinds of knowledge; all of them meet the same worker."""
    experiment = load_experiment(ROOT / "experiments" / "hidden_worker.yaml")
    ours, theirs = ([request.motion for request in reaction_requests(e)] for e in (experiment, paper))
    assert ours == theirs
    policies = experiment.benchmark.policies
    for kind in ("plan", "greedy"):
        three = [policies[f"{kind}_{name}"] for name in ("infers", "average", "told")]
        assert [settings.knows for settings in three] == ["prior", "average", "truth"]
        assert len({str(settings.model_copy(update={"knows": "prior"})) for settings in three}) == 1
    profiles = cycle_profiles(experiment, reactions)
    sizes = {}
    for name, condition in experiment.benchmark.conditions.items():
        task = scenario(experiment, profiles, condition)
        world = draw_random_numbers(1, name, 3, 0)
        truth = task.worker(world.worker)
        sizes[name] = [
            len(task.initial_belief(k, truth, np.random.default_rng(0)).weights) for k in ("prior", "average", "truth")
        ]
        for settings in policies.values():
            cell = Cell(name, 3, "any", settings, task, 1, 1)
            (result,) = cell.run([0]).values()
            assert -0.1 < result.discounted_return < 0
    assert sizes == {"hidden_rates": [9, 1, 1], "hidden_expertise": [3, 1, 1], "all_hidden": [81, 3, 3]}

"""Learning preferences: the likelihood by enumeration, intervals that cover, and what the data cannot tell."""

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import PAPER
from scipy import stats
from simulated_choices import simulated

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.learning.bias import Observed, step
from fatigue_planner.recordings.learning.course import costs_along
from fatigue_planner.recordings.learning.cycles import Cycles, read_cycles, read_labelled
from fatigue_planner.recordings.learning.estimate import Estimator, Interval
from fatigue_planner.recordings.learning.learnt import Learnt, learnt_worker, summary
from fatigue_planner.recordings.learning.likelihood import UNSEEN, Choices, Confusion, smoothed
from fatigue_planner.recordings.learning.worker import learn_worker


def some_choices(cycles: int, preferences: int, seed: int = 0) -> Choices:
    """Cycles of two workers' shifts, some of them not seen, by two matrices of recognition."""
    rng = np.random.default_rng(seed)
    begins = np.zeros(cycles, bool)
    begins[[0, cycles // 2]] = True
    seen = rng.integers(UNSEEN, preferences, cycles)
    return Choices(rng.random((cycles, preferences)), seen, rng.integers(0, 2, cycles), begins)


@pytest.mark.parametrize("preferences", [2, 3])
def test_the_likelihood_is_the_sum_over_all_that_may_have_happened(preferences: int) -> None:
    choices, rng = some_choices(6, preferences), np.random.default_rng(1)
    confusion = rng.dirichlet(np.ones(preferences), (2, preferences))
    utility, inertia = rng.normal(size=(6, preferences)), 0.8
    total, of_reaction = 0.0, np.zeros((6, preferences))
    for path in product(range(preferences), repeat=6):
        chance = 1.0
        for t, u in enumerate(path):
            odds = utility[t].copy()
            if not choices.begins[t]:
                odds[path[t - 1]] += inertia
            chance *= np.exp(odds[u]) / np.exp(odds).sum()
            chance *= 1.0 if choices.seen[t] == UNSEEN else confusion[choices.group[t], u, choices.seen[t]]
        total += chance
        of_reaction[np.arange(6), path] += chance
    found = smoothed(utility, inertia, choices, confusion)
    assert found.log_likelihood == pytest.approx(math.log(total), rel=1e-12)
    np.testing.assert_allclose(found.chances, of_reaction / total, rtol=1e-10)


@pytest.mark.parametrize("preferences", [2, 3])
def test_the_gradient_is_that_of_the_likelihood(preferences: int) -> None:
    rng = np.random.default_rng(2)
    labelled = rng.integers(1, 30, (2, preferences, preferences)).astype(float)
    estimator = Estimator(some_choices(40, preferences), Confusion.from_counts(labelled))
    logits = np.log(estimator.confusion.chances).ravel()
    point = np.concatenate([[0.7], rng.normal(size=preferences - 1), [0.9], logits])
    _, gradient, _ = estimator.at(point)
    steps = 1e-6 * np.eye(point.size)
    numerical = [(estimator.at(point + step)[0] - estimator.at(point - step)[0]) / 2e-6 for step in steps]
    np.testing.assert_allclose(gradient, numerical, atol=1e-6)


def test_the_adjusted_score_is_that_of_every_observation_there_may_be() -> None:
    """Firth's I and P + Q summed over all 81 observations of four cycles, with numerical second derivatives."""
    rng = np.random.default_rng(4)
    costs, confusion = rng.random((4, 3)), rng.dirichlet(np.full(3, 2.0), (2, 3))
    group, begins, point, free = (
        np.array([0, 1, 1, 0]),
        np.arange(4) == 0,
        np.array([0.7, 0.3, -0.5, 0.0]),
        np.arange(3),
    )

    def seeing(seen: tuple[int, ...]) -> Estimator:
        return Estimator(Choices(costs, np.array(seen), group, begins), Confusion(confusion))

    information, cubic = np.zeros((3, 3)), np.zeros((3, 3, 3))
    for seen in product(range(3), repeat=4):
        one = seeing(seen)
        value, gradient, _ = one.at(point)
        curvature = [(one.at(point + d)[1] - one.at(point - d)[1])[free] / 2e-5 for d in 1e-5 * np.eye(4)[:3]]
        square = np.outer(gradient[free], gradient[free])
        information += math.exp(value) * square
        cubic += math.exp(value) * gradient[free, None, None] * (square + curvature)
    inverse = np.linalg.inv(information)
    estimator = seeing((0, 1, 2, 0))
    _, score, found = estimator.at(point)
    observed = Observed(estimator.relative, estimator.choices, confusion, None)
    expected = inverse @ (score[free] + 0.5 * np.einsum("ab,rab->r", inverse, cubic))
    np.testing.assert_allclose(step(point, score, found, observed, free), expected, rtol=1e-6)


@pytest.mark.parametrize("preferences", [2, 3])
def test_the_adjusted_score_does_not_depend_on_how_the_confusion_is_written(preferences: int) -> None:
    """With so many labelled repetitions that nothing is unknown of it, it is that of a known confusion."""
    choices, rng = some_choices(60, preferences), np.random.default_rng(5)
    labelled = 1e9 * rng.dirichlet(np.full(preferences, 2.0), (2, preferences))
    point = np.concatenate([[0.7], rng.normal(size=preferences - 1), [0.9]])
    steps = []
    for confusion in (Confusion.from_counts(labelled), Confusion(Confusion.from_counts(labelled).chances)):
        estimator = Estimator(choices, confusion)
        whole = np.append(point, np.log(confusion.chances) if confusion.labelled is not None else [])
        last = set(range(point.size + preferences - 1, whole.size, preferences))
        free = np.array([i for i in range(whole.size) if i not in last])
        _, score, found = estimator.at(whole)
        score[point.size :] = 0
        observed = Observed(estimator.relative, choices, confusion.chances, confusion.labelled)
        steps.append(step(whole, score, found, observed, free)[: point.size])
    np.testing.assert_allclose(steps[0], steps[1], rtol=1e-4)


def beta_of(estimator: Estimator, model: str = "offset") -> Interval:
    return estimator.interval(estimator.fit(model), model, 0)


@pytest.mark.slow
def test_intervals_of_beta_cover_it_and_its_estimate_has_no_bias() -> None:
    """120 of the 1,000 runs of `python perf/learning.py beta`.

    Were the coverage exactly 95 %, fewer than 105 or all 120 would cover in 1 of 300 cases. A bias of 5 % is allowed,
    and three standard errors: were the mean normal and the bias 5 %, it would be beyond in 1 of 700 cases.
    """
    estimators = [simulated(seed) for seed in range(120)]
    fits = [estimator.fit("offset") for estimator in estimators]
    runs = [estimator.interval(fit, "offset", 0) for estimator, fit in zip(estimators, fits, strict=True)]
    covered = sum(run.low <= 1 <= run.high for run in runs)
    assert stats.binom.cdf(104, 120, 0.95) + stats.binom.pmf(120, 120, 0.95) < 1 / 300
    assert 105 <= covered <= 119
    estimates = np.array([run.estimate for run in runs])
    assert estimates.mean() == pytest.approx(1, abs=0.05 + 3 * estimates.std() / math.sqrt(120))
    assert all(run.low < run.estimate < fit.beta for run, fit in zip(runs, fits, strict=True))


@pytest.mark.parametrize("seed", [15, 311])
def test_scoring_that_goes_too_far_is_damped(seed: int) -> None:
    """In these two of the runs above 300, undamped steps lead to and fro for ever."""
    estimator = simulated(seed)
    fit = estimator.fit("offset")
    assert 0 < estimator.without_bias(fit, "offset")[0] < fit.point[0]


def test_an_estimate_at_a_limit_stays_there() -> None:
    never = simulated(1, 12)
    choices = Choices(never.choices.costs, np.zeros(12, np.int64), never.choices.group, never.choices.begins)
    estimator = Estimator(choices, never.confusion)  # always the first preference: an endless offset
    fit = estimator.fit("offset")
    np.testing.assert_array_equal(estimator.without_bias(fit, "offset"), fit.point)


@pytest.mark.slow
def test_inertia_is_found_and_told_from_an_offset() -> None:
    """One worker; at five standard errors a false alarm is less likely than 1e-6 for each parameter."""
    estimator = simulated(3, 1000, inertia=1.5)
    fit = estimator.fit()
    learnt = summary(estimator, fit, ("x", "y"))
    assert learnt.chosen == "inertia" and learnt.as_good == ()
    assert all(parameter.is_told and parameter.more_cycles == 0 for parameter in learnt.parameters)
    for parameter, truth in zip(learnt.parameters, (1.0, 0.4, 1.5), strict=True):
        spread = (parameter.interval.high - parameter.interval.low) / (2 * 1.96)
        assert abs(parameter.interval.estimate - truth) < 5 * spread
    assert learnt.sentences() == []


@pytest.mark.slow
def test_what_the_data_cannot_tell_is_said() -> None:
    """Three cycles, each as likely as recognition allows: 2 * 3 * ln(0.9 / 0.5) is below the critical 3.84."""
    few = simulated(1, 3)
    found = [beta_of(few), beta_of(simulated(2, 3))]
    assert all(interval.low == 0 for interval in found)
    learnt = summary(few, few.fit(), ("x", "y"))
    assert learnt.sentences()[0].startswith("The data cannot tell beta from 0: ")


def test_an_expert_is_not_told_from_infinity() -> None:
    costs = simulated(1, 40).choices.costs
    certain = Choices(costs, (costs[:, 1] < 0).astype(np.int64), np.zeros(40, np.int64), np.arange(40) == 0)
    expert = Estimator(certain, Confusion(np.eye(2)[None]))
    fit = expert.fit("boltzmann")
    assert math.isinf(expert.interval(fit, "boltzmann", 0).high) and math.isinf(fit.beta)
    values = learnt_worker(expert, fit, "boltzmann", ("x", "y"))["hidden_workers"]["learnt"]["expertise"]["values"]
    assert math.inf in values


@pytest.fixture
def profiles(paper: Experiment, reactions: tuple[Reaction, ...]):
    return cycle_profiles(paper, reactions)


def test_costs_are_those_of_the_fatigue_lived_through(paper: Experiment, profiles) -> None:
    """Where reactions are known, the course is the worker's own: with pauses, too."""
    model = scenario(paper, profiles, paper.benchmark.conditions["single_novice"]).model
    rng = np.random.default_rng(0)
    actions, reactions = rng.integers(0, 2, 8), rng.integers(0, 2, 8)
    times = np.cumsum(rng.uniform(8, 90, 8))
    costs = costs_along(model, model.state(np.zeros(78)), Cycles(actions, reactions, times), np.eye(2)[reactions])
    state = model.state(np.zeros(78))
    for t in range(8):
        own = [-model.transition(state, int(actions[t]), u)[1] for u in range(2)]
        np.testing.assert_allclose(costs[t], own, rtol=1e-12)
        pace = model.pace(None if t == 7 else times[t + 1] - times[t])
        lived = model.for_workers(model.workers, pace.share)
        state, _ = lived.transition(state, int(actions[t]), int(reactions[t]))
        state = model.rested(state[None], pace.rest_s)[0]


def written(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def test_a_learnt_worker_is_one_an_experiment_takes(tmp_path: Path, paper: Experiment, profiles) -> None:
    """A worker of whom beta is far from 0 and infinity; the seed is the first tried."""
    model = scenario(
        paper, profiles, paper.benchmark.conditions["single_novice"].model_copy(update={"expertise": 2e4})
    ).model
    rng, state, lines = np.random.default_rng(0), model.state(np.zeros(78)), ["action,reaction"]
    for action in rng.integers(0, 2, 120):
        u = draw(model.probabilities(state, int(action)), rng.random())
        state, _ = model.transition(state, int(action), u)
        lines.append(f"{model.actions[action]},{model.outcomes[u]}")
    cycles = written(tmp_path, "cycles.csv", "\n".join(lines))
    learnt = learn_worker(paper, profiles, "single_novice", cycles, None)
    assert isinstance(learnt, Learnt) and learnt.cycles == learnt.seen == 120
    beta = learnt.parameters[0].interval
    assert beta.low < 2e4 < beta.high and beta.low > 0
    content = yaml.safe_load(PAPER.read_text(encoding="utf-8")) | learnt.worker
    condition = {"initial_belief": "single", "hidden_worker": "learnt"}
    if "choice_models" in learnt.worker:
        condition["choice_model"] = "learnt"
    content["benchmark"]["conditions"]["learnt"] = condition
    file = written(tmp_path, "mine.yaml", yaml.safe_dump(content))
    found = scenario(experiment := load_experiment(file), profiles, experiment.benchmark.conditions["learnt"])
    assert found.prior is not None and 1 < found.prior.size <= 7


BAD = {
    "": "line 1: the columns are none; required: action, reaction",
    "action,reaction\n": "has no rows",
    "action,reaction,mood\nhigh,arm,1": "line 1: the columns are",
    "action,reaction\nhigh,arm\nhihg,arm": "line 3: action = 'hihg': not one of high, low",
    "action,reaction\nhigh,leg": "line 2: reaction = 'leg': not one of arm, back",
    "action,reaction\nhigh": "line 2: has 1 cells; the table has 2 columns",
    "action,reaction,time_s\nhigh,arm,x": "line 2: time_s = 'x': should be a finite number",
    "action,reaction,time_s\nhigh,arm,9\nlow,arm,9": "line 3: time_s should grow",
    "action,reaction\0": "is not a text file",
}


@pytest.mark.parametrize("text", BAD)
def test_files_that_are_no_cycles_are_refused(tmp_path: Path, text: str) -> None:
    file = written(tmp_path, "cycles.csv", text)
    with pytest.raises(FatplanError) as caught:
        read_cycles(file, ("high", "low"), ("arm", "back"))
    assert str(caught.value).startswith(str(file)) and BAD[text] in str(caught.value)


BAD_COUNTS = {
    "preference,recognised,count\narm,arm,9": "no labelled repetition of back",
    "preference,recognised,count\narm,arm,-1": "count = -1: should be a whole number",
    "preference,recognised,count\narm,arm,1.5": "count = 1.5: should be a whole number",
    "preference,recognised,count\narm,arm,1e300": "count = 1e300: should be a whole number from 0 to 1000000",
    "action,preference,recognised,count\nhigh,arm,arm,9\nhigh,back,back,9": "repetition of low/arm, low/back",
}


@pytest.mark.parametrize("text", BAD_COUNTS)
def test_files_that_are_no_labelled_repetitions_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(FatplanError) as caught:
        read_labelled(written(tmp_path, "c.csv", text), ("high", "low"), ("arm", "back"), ("arm", "back"))
    assert BAD_COUNTS[text] in str(caught.value)


def test_labelled_repetitions_are_counted(tmp_path: Path) -> None:
    text = "preference,recognised,count\narm,arm,130\narm,back,10\nback,back,140\n\n"
    counts, groups = read_labelled(written(tmp_path, "c.csv", text), ("high", "low"), ("arm", "back"), ("arm", "back"))
    np.testing.assert_array_equal(counts, [[[130, 10], [0, 140]]])
    np.testing.assert_array_equal(groups, [0, 0])

"""Which reaction a motion is: on repetitions whose distribution is known."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import logsumexp

from fatigue_planner.core.errors import RecognitionError
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.recordings.recognition.action_model import ActionModel, moderated
from fatigue_planner.recordings.recognition.calibration import (
    blocks_of,
    calibration_error,
    chance_errors,
    fitted_temperature,
    posterior,
    reliability,
)
from fatigue_planner.recordings.recognition.confusion import Confusion, design_effect, group_names, groups_of
from fatigue_planner.recordings.recognition.recogniser import train
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, WORK, Repetitions, of_stream, part_ends_s

CYCLE = Cycle()
JOINTS = 6
# How far apart the reactions are during work in degrees: c is nearly b.
SHIFTS = {"a": 0.0, "b": 12.0, "c": 12.3}


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def repetitions(
    rng: np.random.Generator, people: int, repeats: int, shifts: dict[str, float] = SHIFTS, action: str = "low"
) -> Repetitions:
    """People with offsets of 5 degrees and noise of 3: the first two joints show what they do, from mid-reach on."""
    rise = np.clip((np.arange(N_PARTS) - 4) / 6, 0, 1)
    angles, labels = [], []
    for person in range(people):
        offset = 5 * rng.standard_normal(JOINTS)
        for name, shift in shifts.items():
            for _ in range(repeats):
                clean = np.zeros((N_PARTS, JOINTS))
                clean[:, :2] = shift * rise[:, None]
                angles.append(clean + offset + 3 * rng.standard_normal(clean.shape))
                labels.append((f"p{person}", action, name))
    whose, actions, preferences = np.array(labels).T
    return Repetitions(whose, actions, preferences, np.array(angles))


def test_the_likelihood_of_a_growing_motion_is_that_of_a_gaussian(rng: np.random.Generator) -> None:
    model = ActionModel.fit(repetitions(rng, 5, 3), ("a", "b", "c"))
    motion = rng.normal(0, 8, (2, N_PARTS, JOINTS))
    found = model.log_likelihood(motion)
    for parts in (1, 7, N_PARTS):
        for one in range(3):
            spread = 1 + 1 / model.people[one]
            for motion_of, value in zip(motion, found[:, one, parts - 1], strict=True):
                total = 0.0
                for joint in range(JOINTS):
                    matrix = model.variance_deg2[joint] * spread * model.correlation[:parts, :parts]
                    apart = motion_of[:parts, joint] - model.mean_deg[one, :parts, joint]
                    total -= (apart @ np.linalg.solve(matrix, apart) + np.linalg.slogdet(matrix)[1]) / 2
                    plain = np.linalg.slogdet(model.variance_deg2[joint] * model.correlation[:parts, :parts])[1]
                    total += plain / 2  # the same for all preferences
                assert value == pytest.approx(total, rel=1e-9)


def test_the_distribution_is_found_again() -> None:
    rng = np.random.default_rng(1)
    model = ActionModel.fit(repetitions(rng, 400, 2), ("a", "b", "c"))
    np.testing.assert_allclose(model.variance_deg2 * np.diag(model.correlation)[:, None], 34, rtol=0.1)
    off = model.correlation[~np.eye(N_PARTS, dtype=bool)] * model.variance_deg2.mean()
    np.testing.assert_allclose(off, 25, rtol=0.12)
    assert model.difference_deg()[0, 1] == pytest.approx(12 * np.sqrt(2 / JOINTS), rel=0.03)


def test_what_was_not_measured_says_nothing(rng: np.random.Generator) -> None:
    all_seen = repetitions(rng, 5, 3)
    model = ActionModel.fit(all_seen, ("a", "b", "c"))
    motion = all_seen.angles_deg[:1].copy()
    motion[:, :, 0] = np.nan
    blind = model.log_likelihood(motion)
    without = ActionModel(
        model.preferences, model.joints[1:], model.mean_deg[:, :, 1:], model.variance_deg2[1:], model.correlation,
        model.people,
    )  # fmt: skip
    np.testing.assert_allclose(blind, without.log_likelihood(motion))
    motion[:] = np.nan
    assert not model.log_likelihood(motion).any()
    gap = Repetitions(all_seen.people, all_seen.actions, all_seen.preferences, all_seen.angles_deg.copy())
    gap.angles_deg[3, 2, 4] = np.nan
    assert ActionModel.fit(gap, ("a", "b", "c")).joints.tolist() == [0, 1, 2, 3, 5]


def test_scattered_variances_are_drawn_together_by_what_is_chance() -> None:
    rng = np.random.default_rng(2)
    alike = moderated(4 * rng.chisquare(7, 2000) / 7, 7)
    np.testing.assert_allclose(alike, 4, rtol=0.15)
    assert np.ptp(np.log(alike)) < 0.6
    true = np.exp(rng.normal(0, 1.5, 2000))
    seen = true * rng.chisquare(7, 2000) / 7
    found = moderated(seen, 7)
    assert np.mean(np.log(found / true) ** 2) < np.mean(np.log(seen / true) ** 2)
    assert moderated(np.full(5, 3.0), 4) == pytest.approx(moderated(np.full(5, 3.0), 4)[0])


def test_reactions_that_are_one_are_named_and_merged() -> None:
    recogniser, _ = train(repetitions(np.random.default_rng(3), 8, 10), CYCLE, 0.75)
    known = recogniser.actions["low"]
    assert known.confusion.recognised == ("a", "b_or_c")
    assert known.apart[1, 2] < 0.65 and known.apart[0, 1] > 0.9
    assert known.confusion.counts.sum(axis=1).tolist() == [80, 80, 80]
    plain = known.confusion.plain()
    assert set(plain) == {"a", "b", "c"}
    for line in plain.values():
        assert sum(line.values()) == pytest.approx(1, abs=1e-12)
        assert all(value > 0 for value in line.values())
    lower, upper = known.confusion.interval()
    assert ((lower < known.confusion.probability()) & (known.confusion.probability() < upper)).all()


@pytest.mark.slow
def test_probabilities_are_right_as_often_as_they_say_for_people_never_seen() -> None:
    probabilities, truths = [], []
    for seed in range(6):
        recogniser, _ = train(repetitions(np.random.default_rng(seed), 12, 5), CYCLE, 0.75)
        known = recogniser.actions["low"]
        new = repetitions(np.random.default_rng(100 + seed), 60, 3)
        truths.append([known.model.preferences.index(name) for name in new.preferences.tolist()])
        probabilities.append(known.posterior(new.angles_deg, recogniser.temperature))
    probability, truth = np.concatenate(probabilities), np.concatenate(truths)
    for part in (4, 9, N_PARTS - 1):
        assert calibration_error(probability[:, :, part], truth) < 0.03


def test_what_a_live_shift_is_told() -> None:
    recogniser, _ = train(repetitions(np.random.default_rng(4), 5, 4), CYCLE, 0.75)
    new = repetitions(np.random.default_rng(5), 2, 1)
    found = recogniser.actions["low"].posterior(new.angles_deg, recogniser.temperature)
    told = recogniser.probabilities("low", new.angles_deg[0])
    assert list(told) == ["a", "b", "c"] and sum(told.values()) == pytest.approx(1)
    assert list(told.values()) == pytest.approx(found[0, :, -1].tolist())
    assert recogniser.probabilities("low", np.empty((0, JOINTS))) == pytest.approx(dict.fromkeys("abc", 1 / 3))
    with pytest.raises(RecognitionError, match="action 'high': the recogniser knows low"):
        recogniser.probabilities("high", new.angles_deg[0])


def test_it_is_known_in_the_reach_and_not_before_it() -> None:
    recogniser, held_out = train(repetitions(np.random.default_rng(6), 8, 10, {"a": 0, "b": 30}), CYCLE, 0.75)
    share = held_out["low"].right_share(recogniser.temperature, recogniser.actions["low"].groups)
    assert share[:4].max() < 0.65 and share[9] > 0.95 and share[-1] > 0.95


def test_temperature_flattens_what_is_too_sure_and_sharpens_nothing() -> None:
    rng = np.random.default_rng(7)
    truth = rng.integers(0, 2, 20_000)
    scores = rng.normal(0, 1, (len(truth), 2, 1))
    scores[np.arange(len(truth)), truth] += 1  # the log-likelihood ratio is the difference itself
    for factor, expected in ((3.0, 3.0), (0.3, 1.0)):
        found = fitted_temperature([(factor * scores, truth)])
        assert found == pytest.approx(expected, rel=0.05)
    even = posterior(np.array([[[50.0], [0.0]]]), np.ones(1), 0.1)[0, :, 0]
    assert even == pytest.approx([0.95, 0.05])


def test_the_calibration_error_of_known_cases() -> None:
    probability = np.array([[0.9, 0.1]] * 10 + [[0.35, 0.65]] * 10)
    truth = np.array([0] * 9 + [1] + [1] * 5 + [0] * 5)
    assert calibration_error(probability, truth) == pytest.approx(0.15 / 2)


def test_what_chance_alone_makes_of_a_calibration_error() -> None:
    """Of true probabilities the errors are those that chance predicts; of others and of people alike, larger."""
    rng = np.random.default_rng(8)
    confidence = rng.uniform(0.5, 1, 4000)
    probability = np.stack([confidence, 1 - confidence], axis=1)
    alone = np.arange(len(confidence))
    chance = chance_errors(probability, alone, rng, 400)
    true = [
        calibration_error(probability, (rng.random(len(confidence)) >= confidence).astype(np.int64)) for _ in range(400)
    ]
    assert np.mean(true) == pytest.approx(chance.mean(), rel=0.06)
    assert np.quantile(true, 0.95) == pytest.approx(np.quantile(chance, 0.95), rel=0.1)
    boast = (rng.random(len(confidence)) >= 0.9 * confidence).astype(np.int64)
    assert calibration_error(probability, boast) > chance.max()
    people = np.repeat([f"p{number}" for number in range(400)], 10)
    blocks = blocks_of(people, np.zeros(4000, np.int64), 10)
    own = np.repeat(probability[:400], 10, axis=0)  # a person is as sure in all repetitions
    assert chance_errors(own, blocks, rng, 400).mean() == pytest.approx(chance.mean() * np.sqrt(10), rel=0.1)


def test_blocks_are_of_one_persons_reaction() -> None:
    people, reactions = np.array(list("aaaabbbb")), np.array([0, 1, 0, 0, 0, 0, 1, 1])
    assert blocks_of(people, reactions, 2).tolist() == [0, 2, 0, 1, 3, 3, 4, 4]
    assert len(set(blocks_of(people, reactions, 1).tolist())) == 8
    bins = reliability(np.array([0.91, 0.99, 0.55, 1.0]), np.array([True, False, True, True]))
    assert bins == [(1, 0.55, 1.0), (3, pytest.approx(29 / 30), pytest.approx(2 / 3))]


def test_the_intervals_of_a_row_are_those_of_its_dirichlet_distribution(rng: np.random.Generator) -> None:
    row = Confusion(("a",), ("a", "b", "c"), np.array([[90, 10, 0]]), np.array([50.0]))
    draws = rng.dirichlet([45.5, 5.5, 0.5], 200_000)
    lower, upper = row.interval()
    np.testing.assert_allclose(np.quantile(draws, [0.025, 0.975], axis=0), [lower[0], upper[0]], atol=0.003)
    np.testing.assert_allclose(row.probability()[0], draws.mean(axis=0), atol=0.002)
    alone = Confusion(("a", "b"), ("a_or_b",), np.array([[9], [9]]), np.array([9.0, 9.0]))
    assert alone.interval()[0].tolist() == alone.interval()[1].tolist() == [[1.0], [1.0]]


def test_repetitions_of_one_person_count_for_less(rng: np.random.Generator) -> None:
    people, reactions = np.repeat(np.arange(40), 10), np.zeros(400, int)
    alike = np.repeat(rng.random(40) < 0.7, 10)
    assert design_effect(alike, reactions, people) == pytest.approx(10, rel=0.05)
    assert design_effect(rng.random(400) < 0.7, reactions, people) < 1.6
    assert design_effect(np.ones(400, bool), reactions, people) == 10
    # that one reaction is harder than another is no likeness between people
    split = np.repeat([0, 1], 200)
    assert design_effect(np.concatenate([np.ones(200, bool), rng.random(200) < 0.5]), split, people) < 1.7


def test_chains_of_reactions_not_told_apart_are_one() -> None:
    apart = np.array([[1, 0.6, 0.9, 1], [0.6, 1, 0.6, 1], [0.9, 0.6, 1, 1], [1, 1, 1, 1]])
    groups = groups_of(apart, 0.75)
    assert group_names(("a", "b", "c", "d"), groups) == ("a_or_b_or_c", "d")
    assert group_names(("a", "b", "c", "d"), groups_of(apart, 0.5)) == ("a", "b", "c", "d")
    assert group_names(("x" * 20, "y" * 20), np.zeros(2, np.int64)) == ("group_1",)


def test_too_few_people_are_refused(rng: np.random.Generator) -> None:
    with pytest.raises(RecognitionError, match="low/a: repetitions of 2 people; at least 3 are needed"):
        train(repetitions(rng, 2, 50), CYCLE, 0.75)


def test_a_stream_is_cut_into_the_parts_that_are_over() -> None:
    ends = part_ends_s(CYCLE)
    assert ends[[9, 14, 19]] == pytest.approx([5, 11, 16]) and slice(10, 15) == WORK
    times = np.arange(0, 16, 0.05)
    angles: NDArray[np.float64] = np.stack([times, -times], axis=1)
    whole = of_stream(times, angles, CYCLE)
    assert whole.shape == (N_PARTS - 1, 2)  # the last part ends with the next instant
    np.testing.assert_allclose(whole[:, 0], (np.concatenate([[0], ends[:-2]]) + ends[:-1]) / 2 - 0.025)
    some = times < 2.2
    assert of_stream(times[some], angles[some], CYCLE).shape == (4, 2)
    lost = (times < 0.5) | (times > 1.0)
    seen = of_stream(times[lost], angles[lost], CYCLE)
    assert np.isnan(seen[1]).all() and np.isfinite(seen[2:]).all()
    assert of_stream(np.empty(0), np.empty((0, 2)), CYCLE).shape == (0, 2)


def test_equal_likelihoods_are_no_evidence() -> None:
    even = posterior(np.zeros((1, 3, 1)), np.ones(1), 0.0)
    assert even[0, :, 0] == pytest.approx(1 / 3)
    assert logsumexp(np.log(even[0, :, 0])) == pytest.approx(0)

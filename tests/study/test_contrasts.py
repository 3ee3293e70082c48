"""The contrasts against independent implementations, and what must hold whatever the data."""

import itertools
import math
from dataclasses import asdict, replace
from statistics import NormalDist

import mpmath
import numpy as np
import pandas as pd
import pytest
from contrast_tables import shared_worlds, trial_table

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.experiment.statistics_settings import Family, StatisticsSettings
from fatigue_planner.study.statistics import inference
from fatigue_planner.study.statistics.contrast import COLUMNS, Contrast, Verdict, contrast_of, contrast_text
from fatigue_planner.study.statistics.contrasts import contrasts
from fatigue_planner.study.statistics.inference import detectable_noncentrality, equivalence_p, permutation_p, power
from fatigue_planner.study.statistics.multiple_testing import holm

SETTINGS = StatisticsSettings(significance_level=0.05, resamples=999)
SAMPLES = shared_worlds(np.random.default_rng(1))
TABLE = trial_table(SAMPLES)
GOLDEN = {"rel": 1e-10, "abs": 1e-10}


@pytest.fixture(scope="module")
def golden() -> Contrast:
    return contrast_of(contrasts(TABLE, SETTINGS, seed=7), "novice", 5, "a", "b")


def exact(values: np.ndarray) -> list[mpmath.mpf]:
    return [mpmath.mpf(float(value)) for value in values]


def moments(values: list[mpmath.mpf]) -> tuple[int, mpmath.mpf, mpmath.mpf]:
    """Number, mean and variance."""
    n, mean = len(values), mpmath.fsum(values) / len(values)
    return n, mean, mpmath.fsum((value - mean) ** 2 for value in values) / (n - 1)


def tail(t: mpmath.mpf, freedom: mpmath.mpf) -> mpmath.mpf:
    """P(T > t) of Student's distribution, by its density."""
    constant = mpmath.gamma((freedom + 1) / 2) / mpmath.sqrt(freedom * mpmath.pi) / mpmath.gamma(freedom / 2)
    return constant * mpmath.quad(lambda x: (1 + x * x / freedom) ** (-(freedom + 1) / 2), [t, t + 5, mpmath.inf])


def test_means_and_t_tests_by_mpmath(golden: Contrast) -> None:
    a, b = exact(SAMPLES["a"]), exact(SAMPLES["b"])
    (n, mean_a, variance_a), (_, mean_b, variance_b) = moments(a), moments(b)
    _, mean, variance = moments([x - y for x, y in zip(a, b, strict=True)])
    error = mpmath.sqrt(variance / n)
    cost = -(mean_a + mean_b) / 2
    assert golden.trials == n == 40
    assert golden.first_mean == pytest.approx(float(mean_a), **GOLDEN)
    assert golden.second_mean == pytest.approx(float(mean_b), **GOLDEN)
    assert golden.difference == pytest.approx(float(mean), **GOLDEN)
    assert golden.relative_difference == pytest.approx(float(mean / cost), **GOLDEN)
    assert golden.standard_error == pytest.approx(float(error), **GOLDEN)
    assert golden.cohen_dz == pytest.approx(float(mean / mpmath.sqrt(variance)), **GOLDEN)
    assert golden.paired_p == golden.holm_p == pytest.approx(float(2 * tail(abs(mean / error), n - 1)), **GOLDEN)
    pooled = (variance_a + variance_b) / 2
    student = abs(mean_a - mean_b) / mpmath.sqrt(pooled * 2 / n)
    assert golden.student_p == pytest.approx(float(2 * tail(student, 2 * n - 2)), **GOLDEN)
    share_a, share_b = variance_a / n, variance_b / n
    freedom = (share_a + share_b) ** 2 / ((share_a**2 + share_b**2) / (n - 1))
    welch = abs(mean_a - mean_b) / mpmath.sqrt(share_a + share_b)
    assert golden.welch_p == pytest.approx(float(2 * tail(welch, freedom)), **GOLDEN)
    assert golden.welch_p != golden.student_p
    half = (n - mpmath.mpf(1)) / 1
    factor = mpmath.gamma(half) / mpmath.sqrt(half) / mpmath.gamma(half - mpmath.mpf(1) / 2)
    assert golden.hedges_g == pytest.approx(float(factor * (mean_a - mean_b) / mpmath.sqrt(pooled)), **GOLDEN)
    low = (mean - golden.t_low) / error
    assert golden.t_low + golden.t_high == pytest.approx(2 * float(mean), **GOLDEN)
    assert float(2 * tail(low, n - 1)) == pytest.approx(0.05, **GOLDEN)


def test_equivalence_by_mpmath(golden: Contrast) -> None:
    n, mean, variance = moments([x - y for x, y in zip(exact(SAMPLES["a"]), exact(SAMPLES["b"]), strict=True)])
    error = mpmath.sqrt(variance / n)
    cost = -mpmath.mpf(golden.first_mean + golden.second_mean) / 2
    assert golden.equivalence_margin == pytest.approx(0.01 * float(cost), **GOLDEN)
    margin = mpmath.mpf(golden.equivalence_margin)
    larger = max(tail((mean + margin) / error, n - 1), 1 - tail((mean - margin) / error, n - 1))
    assert golden.equivalence_p == pytest.approx(float(larger), **GOLDEN)
    within = golden.equivalent_within * cost
    assert float(tail((within - abs(mean)) / error, n - 1)) == pytest.approx(0.05, **GOLDEN)
    differences = SAMPLES["a"] - SAMPLES["b"]
    assert equivalence_p(differences, float(within)) == pytest.approx(0.05, **GOLDEN)


def test_statsmodels_agrees(golden: Contrast) -> None:
    from statsmodels.stats.proportion import proportion_confint
    from statsmodels.stats.weightstats import DescrStatsW, ttest_ind, ttost_paired

    a, b = SAMPLES["a"], SAMPLES["b"]
    assert golden.student_p == pytest.approx(ttest_ind(a, b)[1], **GOLDEN)
    assert golden.welch_p == pytest.approx(ttest_ind(a, b, usevar="unequal")[1], **GOLDEN)
    margin = golden.equivalence_margin
    assert golden.equivalence_p == pytest.approx(ttost_paired(a, b, -margin, margin)[0], **GOLDEN)
    assert (golden.t_low, golden.t_high) == pytest.approx(DescrStatsW(a - b).tconfint_mean(0.05), **GOLDEN)
    wins = int((a > b).sum())
    assert golden.improvement == wins / 40
    wilson = proportion_confint(wins, 40, alpha=0.05, method="wilson")
    assert (golden.improvement_low, golden.improvement_high) == pytest.approx(wilson, **GOLDEN)


def test_holm_as_statsmodels() -> None:
    from statsmodels.stats.multitest import multipletests

    p_values = np.random.default_rng(0).random(30) ** 3
    p_values[7] = p_values[3]
    expected = multipletests(p_values, method="holm")[1]
    np.testing.assert_allclose(holm(p_values), expected, rtol=1e-10)
    holed = np.insert(p_values, [0, 5, 30], np.nan)
    np.testing.assert_array_equal(holm(holed)[~np.isnan(holed)], holm(p_values))
    assert np.isnan(holm(holed)[np.isnan(holed)]).all()


def test_holm_is_monotone_and_never_below_the_raw_value() -> None:
    p_values = np.sort(np.random.default_rng(1).random(20) ** 4)
    corrected = holm(p_values)
    assert (np.diff(corrected) >= 0).all() and (corrected >= p_values).all() and (corrected <= 1).all()
    assert corrected[0] == 20 * p_values[0]
    assert holm(np.empty(0)).shape == (0,)


def noncentral_tail(t: float, freedom: int, noncentrality: float) -> mpmath.mpf:
    """P((Z + noncentrality) / sqrt(V / freedom) > t), integrated over V's root."""
    constant = mpmath.mpf(2) ** (1 - mpmath.mpf(freedom) / 2) / mpmath.gamma(mpmath.mpf(freedom) / 2)
    middle = mpmath.sqrt(freedom)
    step, width = abs(noncentrality) * middle / t, middle / t  # where the integrand rises, and how steeply
    places = [0, middle / 2, middle, middle + 1, middle + 3, middle + 8, middle + 20]
    places += [place for k in (-8, -3, 0, 3, 8) if 0 < (place := step + k * width) < middle + 20]
    return constant * mpmath.quad(
        lambda u: mpmath.ncdf(noncentrality - t * u / middle) * u ** (freedom - 1) * mpmath.exp(-u * u / 2),
        sorted(places),
    )


@pytest.mark.parametrize("n", [2, 5, 40, 100])
@pytest.mark.parametrize("level", [0.05, 0.001])
def test_power_by_the_noncentral_t_of_mpmath(n: int, level: float) -> None:
    from scipy.stats import t as student

    noncentrality, critical = detectable_noncentrality(n, level), student.isf(level / 2, n - 1)
    for delta in (0.5, noncentrality):
        expected = noncentral_tail(critical, n - 1, delta) + noncentral_tail(critical, n - 1, -delta)
        assert power(delta, n, level) == pytest.approx(float(expected), **GOLDEN)
    assert power(noncentrality, n, level) == pytest.approx(0.8, **GOLDEN)


def test_detectable_difference_is_the_effect_of_statsmodels(golden: Contrast) -> None:
    from statsmodels.stats.power import TTestPower

    spread = float(np.std(SAMPLES["a"] - SAMPLES["b"], ddof=1))
    effect = TTestPower().solve_power(nobs=40, alpha=0.05, power=0.8)
    assert golden.detectable_difference == pytest.approx(effect * spread, rel=1e-6)  # its own solver's tolerance
    assert detectable_noncentrality(10, 0.85) == 0.0


def test_bca_in_plain_python_with_the_same_draws(golden: Contrast) -> None:
    """Efron (1987): percentiles shifted by the bias and the acceleration, which the jackknife gives."""
    d = [float(x) for x in SAMPLES["a"] - SAMPLES["b"]]
    n, normal = len(d), NormalDist()
    draws = random_stream(7, "bootstrap", "novice", 5, "a", "b").integers(0, n, (999, n))
    means = sorted(math.fsum(d[i] for i in row) / n for row in draws.tolist())
    middle = math.fsum(d) / n
    bias = normal.inv_cdf(sum(mean < middle for mean in means) / 999)
    left_out = [(math.fsum(d) - x) / (n - 1) for x in d]
    centre = math.fsum(left_out) / n
    cubes = math.fsum((centre - x) ** 3 for x in left_out)
    acceleration = cubes / (6 * math.fsum((centre - x) ** 2 for x in left_out) ** 1.5)
    ends = []
    for level in (0.025, 0.975):
        z = bias + normal.inv_cdf(level)
        place = 998 * normal.cdf(bias + z / (1 - acceleration * z))
        below = math.floor(place)
        ends.append(means[below] + (place - below) * (means[below + 1] - means[below]))
    assert acceleration != 0 and bias != 0
    assert (golden.bca_low, golden.bca_high) == pytest.approx(ends, **GOLDEN)


def test_few_pairs_are_flipped_in_every_way() -> None:
    from scipy.stats import permutation_test

    differences = np.array([0.3, -0.1, 0.5, 0.2, 0.2, -0.4, 0.7, 0.1])
    sums = [math.fsum(np.multiply(signs, differences)) for signs in itertools.product((1, -1), repeat=8)]
    expected = np.mean([abs(one) >= abs(differences.sum()) - 1e-9 for one in sums])
    found = permutation_p(differences, 999, np.random.default_rng(0))
    assert found == expected
    theirs = permutation_test((differences,), np.mean, permutation_type="samples", n_resamples=999)
    assert found == pytest.approx(theirs.pvalue, **GOLDEN)


def test_many_pairs_are_flipped_at_random() -> None:
    """Within five standard errors of all 65,536 flips (false alarm 6e-7), and in batches as in one go."""
    differences = np.random.default_rng(3).normal(size=16) + 1
    every = permutation_p(differences, 2**16, np.random.default_rng(0))
    drawn = permutation_p(differences, 19_999, np.random.default_rng(0))
    assert 0.02 < every < 0.5 and drawn != every
    assert abs(drawn - every) < 5 * math.sqrt(every * (1 - every) / 19_999)
    assert permutation_p(differences * 0 + 1, 999, np.random.default_rng(0)) == pytest.approx(0.001, abs=0.002)


def test_batches_of_draws_change_nothing(golden: Contrast, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inference, "MAX_DRAWS", 40 * 64)
    assert contrast_of(contrasts(TABLE, SETTINGS, seed=7), "novice", 5, "a", "b") == golden


def same(one: Contrast, other: Contrast, but: tuple[str, ...] = ()) -> None:
    for name, value in asdict(one).items():
        if name not in but:
            wanted = getattr(other, name)
            close = wanted if isinstance(wanted, str) else pytest.approx(wanted, rel=1e-9, abs=1e-12, nan_ok=True)
            assert value == close, name


def test_swapped_policies_swap_every_sign(golden: Contrast) -> None:
    turned = contrasts(trial_table({"b": SAMPLES["b"], "a": SAMPLES["a"]}), SETTINGS, seed=7)
    assert list(turned["first"]) == ["b"]
    same(contrast_of(turned, "novice", 5, "a", "b"), golden)
    other = contrast_of(turned, "novice", 5, "b", "a")
    same(other.flipped(), golden)
    assert other.difference == -golden.difference < 0 and other.t_low == pytest.approx(-golden.t_high)
    assert other.improvement == pytest.approx(1 - golden.improvement) and other.first_mean == golden.second_mean
    assert (golden.verdict(0.05), other.verdict(0.05)) == (Verdict.BETTER, Verdict.WORSE)


def test_a_constant_added_to_both_changes_only_shares_of_the_cost(golden: Contrast) -> None:
    shifted = trial_table({name: values - 3 for name, values in SAMPLES.items()})
    means = ("first_mean", "second_mean")
    shares = ("relative_difference", "equivalence_margin", "equivalence_p", "equivalent_within")
    moved = contrast_of(contrasts(shifted, SETTINGS, 7), "novice", 5, "a", "b")
    same(moved, golden, but=means + shares)
    assert moved.first_mean == pytest.approx(golden.first_mean - 3)


def test_costs_ten_times_as_large_scale(golden: Contrast) -> None:
    scaled = trial_table({name: values * 10 for name, values in SAMPLES.items()})
    absolute = (
        "first_mean", "second_mean", "difference", "standard_error", "t_low", "t_high", "bca_low", "bca_high",
        "detectable_difference", "equivalence_margin",
    )  # fmt: skip
    larger = contrast_of(contrasts(scaled, SETTINGS, 7), "novice", 5, "a", "b")
    same(larger, golden, but=absolute)
    for name in absolute:
        assert getattr(larger, name) == pytest.approx(10 * getattr(golden, name)), name


def three_policies(n_cycles: int = 5, condition: str = "novice") -> pd.DataFrame:
    rng = np.random.default_rng(n_cycles)
    samples = shared_worlds(rng) | {"c": rng.normal(size=40) - 11}
    return trial_table(samples, condition=condition, n_cycles=n_cycles)


def test_neither_the_order_of_rows_nor_the_other_policies_matter(golden: Contrast) -> None:
    table = pd.concat([TABLE, three_policies(20)])
    table = pd.concat([table, TABLE[TABLE["policy"] == "b"].assign(policy="d")])
    shuffled = contrasts(table.sample(frac=1, random_state=1), SETTINGS, 7)
    same(contrast_of(shuffled, "novice", 5, "a", "b"), golden, but=("holm_p",))
    assert contrast_of(shuffled, "novice", 5, "a", "b").holm_p > golden.holm_p
    again = contrasts(table, SETTINGS, 7)
    pd.testing.assert_frame_equal(again, contrasts(table.reset_index(drop=True), SETTINGS, 7))
    other_seed = contrast_of(contrasts(TABLE, SETTINGS, 8), "novice", 5, "a", "b")
    assert other_seed.bca_low != golden.bca_low and other_seed.permutation_p != golden.permutation_p
    assert other_seed.paired_p == golden.paired_p
    renumbered = contrasts(TABLE.assign(trial=7919 * TABLE["trial"] + 5), SETTINGS, 7)
    same(contrast_of(renumbered, "novice", 5, "a", "b"), golden)


def names(table: pd.DataFrame) -> list[tuple[str, str, int, str, str]]:
    return list(table[["family", "condition", "n_cycles", "first", "second"]].itertuples(index=False, name=None))


def with_families(**families: Family) -> StatisticsSettings:
    return SETTINGS.model_copy(update={"families": families, "resamples": 99})


def test_without_families_all_pairs_are_one() -> None:
    table = contrasts(pd.concat([three_policies(5), three_policies(20)]), with_families(), 1)
    assert list(table.columns) == COLUMNS
    pairs = [("a", "b"), ("a", "c"), ("b", "c")]
    assert names(table) == [("all", "novice", n_cycles, *pair) for n_cycles in (5, 20) for pair in pairs]
    np.testing.assert_array_equal(table["holm_p"], holm(table["paired_p"].to_numpy()))


def test_families_choose_and_are_corrected_apart() -> None:
    trials = pd.concat([three_policies(5), three_policies(20), three_policies(5, "expert")])
    settings = with_families(
        short=Family(n_cycles=(5,), conditions=("novice",), policies=("c", "a", "gone")),
        reference=Family(against=("c", "b"), conditions=("expert",)),
        nothing=Family(conditions=("gone",)),
    )
    table = contrasts(trials, settings, 1)
    assert names(table) == [
        ("short", "novice", 5, "a", "c"),
        ("reference", "expert", 5, "a", "b"),
        ("reference", "expert", 5, "a", "c"),
        ("reference", "expert", 5, "b", "c"),
    ]
    assert table["holm_p"][0] == table["paired_p"][0]
    np.testing.assert_array_equal(table["holm_p"][1:], holm(table["paired_p"][1:].to_numpy()))
    assert contrast_of(table, "novice", 5, "a", "b") is None
    assert contrast_of(table, "expert", 5, "b", "a").first == "b"


def test_one_policy_alone_has_no_contrast() -> None:
    table = contrasts(trial_table({"a": [-1.0, -2]}), SETTINGS, 1)
    assert list(table.columns) == COLUMNS and table.empty
    assert "none" in contrast_text(table, SETTINGS)


PAIRED = [
    "standard_error", "t_low", "t_high", "bca_low", "bca_high", "paired_p", "permutation_p", "holm_p", "cohen_dz",
    "detectable_difference", "equivalence_p", "equivalent_within",
]  # fmt: skip
P_VALUES = [name for name in COLUMNS if name.endswith("_p")]


def only(table: pd.DataFrame) -> Contrast:
    assert len(table) == 1
    return contrast_of(table, "novice", 5, *table.loc[0, ["first", "second"]])


def all_nan(contrast: Contrast, columns: list[str]) -> bool:
    return all(math.isnan(getattr(contrast, name)) for name in columns)


def test_where_nothing_is_left_to_chance_the_difference_is_exact() -> None:
    table = contrasts(trial_table({"a": [-1.0], "b": [-1.1]}, deterministic=("a", "b")), SETTINGS, 1)
    found = only(table)
    assert found.note == "n/a (deterministic: nothing is left to chance)" and all_nan(found, P_VALUES)
    assert {found.t_low, found.t_high, found.bca_low, found.bca_high} == {found.difference}
    assert found.difference == pytest.approx(0.1) and found.equivalent_within == pytest.approx(0.1 / 1.05)
    assert (found.trials, found.improvement, found.improvement_low, found.standard_error) == (1, 1.0, 1.0, 0.0)
    assert found.verdict(0.05) == "better" and found.flipped().verdict(0.05) == "worse"
    equal = only(contrasts(trial_table({"a": [-1.0], "b": [-1.0]}, deterministic=("a", "b")), SETTINGS, 1))
    assert equal.verdict(0.05) == "equivalent" and equal.improvement == 0.5


def test_one_deterministic_policy_meets_every_world_of_the_other() -> None:
    returns = np.random.default_rng(0).normal(size=30) - 5
    found = only(contrasts(trial_table({"a": returns, "once": [-5.2]}, deterministic=("once",)), SETTINGS, 1))
    n, mean, variance = moments(exact(returns + 5.2))
    assert found.trials == 30 and found.note == ""
    assert found.paired_p == pytest.approx(float(2 * tail(abs(mean) / mpmath.sqrt(variance / n), n - 1)), **GOLDEN)
    assert all_nan(found, ["student_p", "welch_p", "hedges_g"])


@pytest.mark.parametrize("deterministic", [(), ("b",)])
def test_one_run_of_chance_is_no_sample(deterministic: tuple[str, ...]) -> None:
    found = only(contrasts(trial_table({"a": [-1.0], "b": [-1.1]}, deterministic), SETTINGS, 1))
    assert found.note == "n/a (one run only)" and all_nan(found, [*PAIRED, *P_VALUES, "improvement"])
    assert found.difference == pytest.approx(0.1) and found.verdict(0.05) == "undetermined"


def test_policies_that_are_the_same_in_every_run_are_equivalent() -> None:
    """What rounding leaves is no difference; nor is chance that both have, but that never shows."""
    a = np.random.default_rng(0).normal(size=20) - 5
    for b in (a, a * (1 + 1e-15), np.full(20, -5.0)):
        found = only(contrasts(trial_table({"a": np.full(20, -5.0) if b[0] == b[1] else a, "b": b}), SETTINGS, 1))
        assert found.note == "n/a (the same in every run)" and found.verdict(0.05) == "equivalent"
        numbers = ("difference", "standard_error", "t_low", "t_high", "bca_low", "bca_high", "equivalent_within")
        assert {getattr(found, name) for name in numbers} == {0.0} and found.improvement == 0.5
        assert all_nan(found, ["paired_p", "permutation_p", "holm_p", "cohen_dz", "equivalence_p"])
        assert math.isnan(found.student_p) if b[0] == b[1] else found.student_p == pytest.approx(1)


def test_a_constant_difference_has_no_test() -> None:
    """0.1 + x - x is not quite 0.1: what rounding leaves is no spread."""
    a = np.random.default_rng(0).normal(size=20) - 5
    found = only(contrasts(trial_table({"a": a, "b": a - 0.1}), SETTINGS, 1))
    assert found.note == "n/a (constant differences)" and all_nan(found, PAIRED)
    assert found.student_p > 0.05 and found.verdict(0.05) == "undetermined" and found.improvement == 1.0
    flat = only(contrasts(trial_table({"a": [-1.0] * 5, "b": [-2.0] * 5}), SETTINGS, 1))
    assert flat.note == "n/a (constant differences)" and all_nan(flat, P_VALUES)


def test_missing_trials_are_named_and_nothing_is_said() -> None:
    holed = TABLE[~((TABLE["policy"] == "b") & TABLE["trial"].isin([3, 7]))]
    found = only(contrasts(holed, SETTINGS, 1))
    assert found.note == "n/a (trials 3, 7 of b are missing)"
    numbers = [name for name in COLUMNS[6:] if name != "note"]
    assert all_nan(found, numbers) and found.trials == 0
    without = TABLE.assign(discounted_return=TABLE["discounted_return"].mask(TABLE["trial"] == 4))
    assert only(contrasts(without, SETTINGS, 1)).trials == 39  # missing in both: the others are still pairs
    both = holed[~((holed["policy"] == "a") & (holed["trial"] == 0))]
    assert only(contrasts(both, SETTINGS, 1)).note == "n/a (trial 0 of a and trials 3, 7 of b are missing)"
    all_gone = TABLE.assign(discounted_return=TABLE["discounted_return"].where(TABLE["policy"] == "a"))
    assert only(contrasts(all_gone, SETTINGS, 1)).note == "n/a (trials 0, 1, 2, 3, 4, … of b are missing)"
    one = trial_table({"a": [math.nan], "b": [-1.0]}, deterministic=("a", "b"))
    assert only(contrasts(one, SETTINGS, 1)).note == "n/a (trial 0 of a is missing)"


def test_no_share_of_a_cost_that_is_not_positive() -> None:
    a = np.random.default_rng(0).normal(size=20)
    found = only(contrasts(trial_table({"a": a + 5, "b": a + np.arange(20) / 10}), SETTINGS, 1))
    shares = ["relative_difference", "equivalence_margin", "equivalence_p", "equivalent_within"]
    assert all_nan(found, shares) and found.paired_p < 0.05


def test_verdicts() -> None:
    base = Contrast("all", "c", 5, "a", "b", 9, standard_error=0.1, difference=0.3)
    assert replace(base, holm_p=0.04, equivalence_p=0.01).verdict(0.05) == "better"
    assert replace(base, holm_p=0.05, equivalence_p=0.04).verdict(0.05) == "equivalent"
    assert replace(base, holm_p=0.05, equivalence_p=0.05).verdict(0.05) == "undetermined"
    assert replace(base, holm_p=0.04, difference=-0.3).verdict(0.05) == "worse"


def test_the_text_counts_verdicts_and_says_where_the_paper_differs() -> None:
    rng = np.random.default_rng(2)
    world = rng.normal(size=30) * 2 - 20
    samples = {"worst": world - 3, "a": world, "better": world + 0.5, "like_a": world}
    samples = {name: values + rng.normal(size=30) * 0.05 for name, values in samples.items()}
    trials = pd.concat(
        [trial_table(samples), trial_table({"a": [-1.0], "worst": [-2.0]}, ("a", "worst"), condition="expert")]
    )
    text = contrast_text(contrasts(trials, SETTINGS, 1), SETTINGS)
    assert "all: 7 comparisons, 6 tested: 5 differ, 1 equivalent, 0 undetermined" in text
    assert "1 n/a (deterministic: nothing is left to chance)" in text
    assert "says otherwise of 2:" in text
    assert "novice, 5 cycles: better against a better, 2." in text
    assert "better against like_a better, 2." in text and "worst" not in text


def test_the_text_goes_by_the_corrected_p_value() -> None:
    found = Contrast(
        "all", "novice", 5, "a", "b", 30, -2.0, -1.9, -0.1, standard_error=0.05, t_low=-0.2, t_high=-0.002,
        student_p=0.04, paired_p=0.03, holm_p=0.06, equivalence_p=0.9,
    )  # fmt: skip
    table = pd.DataFrame([asdict(found)] * 20)
    text = contrast_text(table, SETTINGS)
    assert "20 comparisons, 20 tested: 0 differ, 0 equivalent, 20 undetermined" in text
    assert text.count("b against a undetermined, 5.13 % [0.10, 10.26] (p = 0.06, the paper's 0.04)") == 15
    assert "and of 5 more, see contrasts.csv" in text

"""The table of contrasts: every comparison with intervals, tests, effects and correction. Loads scipy.stats."""

from dataclasses import asdict, replace

import pandas as pd

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrast import COLUMNS, Contrast
from fatigue_planner.study.statistics.inference import (
    bca_interval,
    cohen_dz,
    detectable_difference,
    equivalence_p,
    equivalent_within,
    hedges_g,
    improvement,
    paired_p,
    permutation_p,
    standard_error,
    student_p,
    t_interval,
    welch_p,
    wilson_interval,
)
from fatigue_planner.study.statistics.multiple_testing import Pair, holm, pairs_by_family
from fatigue_planner.study.statistics.pairing import PairedReturns, pair_runs, runs_by_policy


def compute_contrast(
    family: str, pair: Pair, pairs: PairedReturns, settings: StatisticsSettings, seed: int
) -> Contrast:
    """The contrast of a pair of policies from their paired returns, without the correction for its family.

    Resampling draws from streams of the cell and the two policies, whatever else is compared.
    """
    empty = Contrast(family, **vars(pair))
    if pairs.fault:
        return replace(empty, note=f"n/a ({pairs.fault})")
    contrast = replace(
        empty,
        trials=len(pairs.first),
        first_mean=float(pairs.first.mean()),
        second_mean=float(pairs.second.mean()),
        difference=float(pairs.differences.mean()),
    )
    contrast = replace(
        contrast,
        relative_difference=contrast.difference / contrast.mean_cost,
        equivalence_margin=settings.equivalence_margin * contrast.mean_cost,
    )
    if not any(pairs.drawn):
        improved = improvement(pairs.differences)
        contrast = replace(contrast, improvement=improved, improvement_low=improved, improvement_high=improved)
        return _exact(contrast, "deterministic: nothing is left to chance")
    if len(pairs.first) < 2:
        return replace(contrast, note="n/a (one run only)")
    contrast = _with_improvement(_with_unpaired(contrast, pairs), pairs, settings.significance_level)
    if not pairs.differences.any():
        return _exact(contrast, "the same in every run")
    if pairs.constant():
        return replace(contrast, note="n/a (constant differences)")
    return _with_paired(contrast, pairs, settings, seed)


def _exact(contrast: Contrast, reason: str) -> Contrast:
    """Chance has no part in the difference: its intervals have no width, and there is nothing to test."""
    difference = contrast.difference
    return replace(
        contrast,
        standard_error=0.0,
        t_low=difference,
        t_high=difference,
        bca_low=difference,
        bca_high=difference,
        equivalent_within=abs(contrast.relative_difference),
        note=f"n/a ({reason})",
    )


def _with_unpaired(contrast: Contrast, pairs: PairedReturns) -> Contrast:
    if not pairs.comparable_unpaired():
        return contrast
    both = pairs.first, pairs.second
    return replace(contrast, student_p=student_p(*both), welch_p=welch_p(*both), hedges_g=hedges_g(*both))


def _with_improvement(contrast: Contrast, pairs: PairedReturns, level: float) -> Contrast:
    improved = improvement(pairs.differences)
    low, high = wilson_interval(improved, contrast.trials, level)
    return replace(contrast, improvement=improved, improvement_low=low, improvement_high=high)


def _with_paired(contrast: Contrast, pairs: PairedReturns, settings: StatisticsSettings, seed: int) -> Contrast:
    differences, level, resamples = pairs.differences, settings.significance_level, settings.resamples
    # the draws, too, are the same whichever policy comes first
    key: tuple[str | int, ...] = (contrast.condition, contrast.n_cycles, *sorted((contrast.first, contrast.second)))
    t_low, t_high = t_interval(differences, level)
    bca_low, bca_high = bca_interval(differences, level, resamples, random_stream(seed, "bootstrap", *key))
    return replace(
        contrast,
        standard_error=standard_error(differences),
        t_low=t_low,
        t_high=t_high,
        bca_low=bca_low,
        bca_high=bca_high,
        paired_p=paired_p(differences),
        permutation_p=permutation_p(differences, resamples, random_stream(seed, "permutation", *key)),
        cohen_dz=cohen_dz(differences),
        detectable_difference=detectable_difference(differences, level),
        equivalence_p=equivalence_p(differences, contrast.equivalence_margin),
        equivalent_within=equivalent_within(differences, level) / contrast.mean_cost,
    )


def contrasts(trials: pd.DataFrame, settings: StatisticsSettings, seed: int) -> pd.DataFrame:
    """One row per comparison of every family, the columns those of `Contrast`.

    `trials` has the columns condition, n_cycles, policy, trial, deterministic and discounted_return. Runs are paired by
    the number of their trial. holm_p corrects paired_p within the family; rows without one do not count.
    A row's other numbers depend on the runs of its two policies, the settings and the seed only.
    """
    runs = runs_by_policy(trials)
    rows = []
    for family, pair in pairs_by_family(trials, settings.families, settings.shown(trials["policy"])):
        pairs = pair_runs(runs[*pair.cell, pair.first], runs[*pair.cell, pair.second])
        rows.append(asdict(compute_contrast(family, pair, pairs, settings, seed)))
    table = pd.DataFrame(rows, columns=COLUMNS)
    for _, rows_of in table.groupby("family", sort=False):
        table.loc[rows_of.index, "holm_p"] = holm(rows_of["paired_p"].to_numpy(dtype=float))
    return table


CELL = ["condition", "n_cycles", "policy"]
FIRST, SECOND = "first", "second"


def side_by_side(first: pd.DataFrame, second: pd.DataFrame, settings: StatisticsSettings, seed: int) -> pd.DataFrame:
    """One row per condition, length and policy that both tables have; the columns of `contrasts` and `policy`.

    Runs are paired by trial, up to as many as both have: with the same seed they have common random numbers; with
    another seed the pairs are arbitrary, which is valid but finds less.
    """
    rows = []
    for label, own, other in ((FIRST, first, second), (SECOND, second, first)):
        shared = own[CELL].drop_duplicates().merge(other[CELL].drop_duplicates())
        most = other.groupby(CELL)["trial"].transform("size")
        sizes = other.assign(most=most).drop_duplicates(CELL)[[*CELL, "most", "deterministic"]]
        both = own.merge(shared).merge(sizes, on=CELL, suffixes=("", "_there"))
        rows.append(both[(both["trial"] < both["most"]) | both["deterministic_there"]].assign(table=label))
    runs = pd.concat(rows, ignore_index=True)
    runs["condition"] = runs["condition"] + "/" + runs["policy"]
    table = contrasts(
        runs.assign(policy=runs["table"]), settings.model_copy(update={"families": {}, "policies": None}), seed
    )
    cells = table["condition"].str.rsplit("/", n=1, expand=True) if len(table) else pd.DataFrame(columns=[0, 1])
    return table.assign(condition=cells[0], policy=cells[1])

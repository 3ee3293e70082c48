"""All statistics of one comparison. Loads scipy.stats, which takes most of a second."""

from dataclasses import replace

import numpy as np

from fatigue_planner.core.random_streams import stream
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrast import Contrast
from fatigue_planner.study.statistics.effects import cohen_dz, hedges_g, improvement
from fatigue_planner.study.statistics.families import Comparison
from fatigue_planner.study.statistics.hypotheses import (
    equivalence_p,
    equivalent_within,
    paired_p,
    permutation_p,
    student_p,
    welch_p,
)
from fatigue_planner.study.statistics.intervals import bca_interval, standard_error, t_interval, wilson_interval
from fatigue_planner.study.statistics.pairing import Pairs
from fatigue_planner.study.statistics.power import detectable_difference


def measure(comparison: Comparison, pairs: Pairs, settings: StatisticsSettings, seed: int) -> Contrast:
    """The contrast of the pairs, without the correction for its family.

    Resampling draws from streams of the cell and the two policies, whatever else is compared.
    """
    empty = Contrast(**vars(comparison))
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
        return _exact(contrast)
    if len(pairs.first) < 2:
        return replace(contrast, note="n/a (one run only)")
    contrast = _with_shares(_with_unpaired(contrast, pairs), pairs, settings.significance_level)
    if pairs.constant():
        return replace(contrast, note="n/a (constant differences)")
    return _with_paired(contrast, pairs, settings, seed)


def _exact(contrast: Contrast) -> Contrast:
    difference = contrast.difference
    share = improvement(np.array([difference]))
    return replace(
        contrast,
        standard_error=0.0,
        t_low=difference,
        t_high=difference,
        bca_low=difference,
        bca_high=difference,
        improvement=share,
        improvement_low=share,
        improvement_high=share,
        equivalent_within=abs(contrast.relative_difference),
        note="n/a (deterministic: nothing is left to chance)",
    )


def _with_unpaired(contrast: Contrast, pairs: Pairs) -> Contrast:
    if not pairs.comparable_unpaired():
        return contrast
    both = pairs.first, pairs.second
    return replace(contrast, student_p=student_p(*both), welch_p=welch_p(*both), hedges_g=hedges_g(*both))


def _with_shares(contrast: Contrast, pairs: Pairs, level: float) -> Contrast:
    share = improvement(pairs.differences)
    low, high = wilson_interval(share, contrast.trials, level)
    return replace(contrast, improvement=share, improvement_low=low, improvement_high=high)


def _with_paired(contrast: Contrast, pairs: Pairs, settings: StatisticsSettings, seed: int) -> Contrast:
    differences, level, resamples = pairs.differences, settings.significance_level, settings.resamples
    # the draws, too, are the same whichever policy comes first
    key: tuple[str | int, ...] = (contrast.condition, contrast.n_cycles, *sorted((contrast.first, contrast.second)))
    t_low, t_high = t_interval(differences, level)
    bca_low, bca_high = bca_interval(differences, level, resamples, stream(seed, "bootstrap", *key))
    return replace(
        contrast,
        standard_error=standard_error(differences),
        t_low=t_low,
        t_high=t_high,
        bca_low=bca_low,
        bca_high=bca_high,
        paired_p=paired_p(differences),
        permutation_p=permutation_p(differences, resamples, stream(seed, "permutation", *key)),
        cohen_dz=cohen_dz(differences),
        detectable_difference=detectable_difference(differences, level),
        equivalence_p=equivalence_p(differences, contrast.equivalence_margin),
        equivalent_within=equivalent_within(differences, level) / contrast.mean_cost,
    )

"""Which settings decide the gain: explained variance over the combinations, and swings one at a time."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.factors import FactorSettings, Level, level_text

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]

RESAMPLES = 999
INTERVAL = (0.025, 0.975)
# Relative differences up to this size are rounding errors.
ROUNDING = 1e-9
RESPONSE = ["condition", "n_cycles", "planner", "baseline"]


def importance_table(
    points: Sequence[Point], gains: pd.DataFrame, factors: Mapping[str, FactorSettings], seed: int
) -> pd.DataFrame:
    """One row per condition, length, planner, baseline and factor, the most important factor first.

    share: the fraction of the gain's variance over the combinations that the factor alone explains (see
    `explained_variance`), with a 95 % bootstrap interval (share_low, share_high); NaN with too few combinations.
    p_value: of that fraction under no effect, corrected for all factors (see `p_values`). rank_share, rank_p_value: the
    same for the gains' ranks, which a few very large gains do not dominate. swing: largest minus smallest gain over the
    factor's levels tried one at a time, including the base experiment's; least_at and most_at: these levels.
    chance: the mean squared standard error of the gains as a fraction of their variance over the combinations, the most
    that the finite number of trials adds to it (it adds less, as all combinations have common random numbers).
    `gains` is the table of `gains.gain_table`; points missing from it could not be performed.
    """
    responses = gains.pivot_table(index="point", columns=RESPONSE, values="gain", sort=False)
    combined = [point for point in points if point.design == "space filling" and point.name in responses.index]
    names = [point.name for point in combined]
    values = responses.loc[names].to_numpy()
    errors = gains.pivot_table(index="point", columns=RESPONSE, values="standard_error", sort=False)
    with np.errstate(invalid="ignore", divide="ignore"):
        chance = (errors.reindex(names) ** 2).mean().reindex(responses.columns) / responses.loc[names].var()
    designs = [factor.regressors([point.levels[name] for point in combined]) for name, factor in factors.items()]
    ranked = responses.loc[names].rank().to_numpy()
    chances = p_values(designs, values, random_stream(seed, "permutations")) if combined else None
    rank_chances = p_values(designs, ranked, random_stream(seed, "permutations")) if combined else None
    tables = []
    for index, (name, regressors) in enumerate(zip(factors, designs, strict=True)):
        table = responses.columns.to_frame(index=False)
        own = explained_variance(regressors, values, random_stream(seed, "bootstrap", name)) if combined else None
        table["factor"] = name
        for column, key in enumerate(("share", "share_low", "share_high")):
            table[key] = np.nan if own is None else own[column]
        table["p_value"] = np.nan if chances is None else chances[index]
        ranks = explained_variance(regressors, ranked, random_stream(seed, "bootstrap", name)) if combined else None
        table["rank_share"] = np.nan if ranks is None else ranks[0]
        table["rank_p_value"] = np.nan if rank_chances is None else rank_chances[index]
        table["chance"] = chance.to_numpy()
        tables.append(pd.concat([table, _swings(points, responses, name)], axis=1))
    # a stable sort keeps the order of factors whose fraction is NaN
    order = {tuple(key): index for index, key in enumerate(responses.columns.to_list())}
    table = pd.concat(tables, ignore_index=True)
    table["order"] = [order[tuple(row)] for row in table[RESPONSE].itertuples(index=False)]
    return (
        table.sort_values(["order", "share"], ascending=[True, False], kind="stable")
        .drop(columns="order")
        .reset_index(drop=True)
    )


def explained_variance(regressors: Matrix, values: Matrix, rng: np.random.Generator) -> Matrix:
    """Adjusted R^2 of values (n, responses) on regressors (n, p) and a constant, and its interval: (3, responses).

    For numbers the regressors are a parabola's, for names indicators; then it is the correlation ratio, adjusted
    (Kelley's epsilon squared). Adjusted, the mean over factors without effect is 0; single values may be
    negative. The interval is that of the percentile bootstrap over points, whose upper end is too high for small
    fractions. NaN where there are too few points or nothing varies.
    """
    n, p = regressors.shape
    if n < p + 2:
        return np.full((3, values.shape[1]), np.nan)
    design = np.column_stack([np.ones(n), regressors])
    centred = values - values.mean(axis=0)
    found = np.full((3, values.shape[1]), np.nan)
    found[0] = _adjusted(design, centred, np.ones((1, n)))[0]
    varies = ~np.isnan(found[0])
    counts = rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES).astype(float)
    found[1:, varies] = np.nanquantile(_adjusted(design, centred[:, varies], counts), INTERVAL, axis=0)
    return found


def p_values(designs: Sequence[Matrix], values: Matrix, rng: np.random.Generator) -> Matrix:
    """P-values (factors, responses) of no effect, for values (n, responses) and regressors (n, p) of each factor.

    The values are permuted over the points, in the same order for all factors. A factor's R^2 is ranked among those of
    the permuted values; the p-value is how often the best rank of all factors is as good, which controls the
    probability of naming any factor wrongly (single-step min-P of Westfall and Young 1993). NaN where nothing varies.
    """
    n = len(values)
    centred = values - values.mean(axis=0)
    orders = np.vstack([np.arange(n), rng.permuted(np.tile(np.arange(n), (RESAMPLES, 1)), axis=1)])
    permuted = centred[orders]  # (orders, n, responses)
    ranks = np.empty((len(designs), len(orders), values.shape[1]))
    for index, regressors in enumerate(designs):
        basis = _basis(regressors - regressors.mean(axis=0))
        explained = (np.einsum("np,bnr->bpr", basis, permuted) ** 2).sum(axis=1)
        ranks[index] = _fraction_at_least(explained)
    best = ranks.min(axis=0)
    found = (best[:, None, :] <= ranks[:, 0, :]).mean(axis=0)
    found[:, np.ptp(values, axis=0) <= ROUNDING * np.abs(values).max(axis=0)] = np.nan
    return np.asarray(found)


def _basis(regressors: Matrix) -> Matrix:
    """Orthonormal columns that span those of the regressors (n, p), which may be linearly dependent."""
    left, sizes, _ = np.linalg.svd(regressors, full_matrices=False)
    return np.asarray(left[:, sizes > ROUNDING * max(sizes.max(initial=0.0), 1.0)])


def _fraction_at_least(statistics: Matrix) -> Matrix:
    """For each of the statistics (orders, responses), the fraction of those of its response that are not smaller."""
    rounded = statistics * (1 + ROUNDING)  # equal except for rounding counts as not smaller
    ascending = np.sort(rounded, axis=0)
    smaller = [np.searchsorted(ascending[:, column], statistics[:, column]) for column in range(statistics.shape[1])]
    return np.asarray(1 - np.column_stack(smaller) / len(statistics))


def _adjusted(design: Matrix, values: Matrix, counts: Matrix) -> Matrix:
    """Adjusted R^2 (samples, responses) where sample i holds point j counts[i, j] times."""
    n, parameters = design.shape
    moments = np.einsum("bn,np,nq->bpq", counts, design, design)
    products = np.einsum("bn,np,nr->bpr", counts, design, values)
    coefficients = np.linalg.pinv(moments, hermitian=True) @ products
    explained = np.einsum("bpr,bpr->br", coefficients, products)
    sums, squares = counts @ values, counts @ values**2
    about_mean = squares - sums**2 / n
    residual = np.maximum(squares - explained, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(about_mean > 1e-12 * squares, residual / about_mean, np.nan)
    return np.asarray(1 - ratio * (n - 1) / (n - parameters))


def _swings(points: Sequence[Point], responses: pd.DataFrame, factor: str) -> pd.DataFrame:
    names = ["base", *(point.name for point in points if point.factor == factor)]
    levels: dict[str, Level] = {point.name: point.levels[factor] for point in points}
    own = responses.loc[[name for name in names if name in responses.index]]
    if own.empty:
        return pd.DataFrame({"swing": np.nan, "least_at": "", "most_at": ""}, index=range(responses.shape[1]))
    at = [level_text(levels[str(name)]) for name in own.index]
    values = own.to_numpy()
    return pd.DataFrame(
        {
            "swing": values.max(axis=0) - values.min(axis=0),
            "least_at": [at[index] for index in values.argmin(axis=0)],
            "most_at": [at[index] for index in values.argmax(axis=0)],
        }
    )

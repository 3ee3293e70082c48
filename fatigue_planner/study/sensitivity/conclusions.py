"""The conclusions of a study: a few sentences written from its tables."""

from collections.abc import Sequence

import pandas as pd

from fatigue_planner.core.text import brief_percent
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.gains import ANALYSES, CONFIDENCE, reproduced_fraction
from fatigue_planner.study.sensitivity.settings import Headline, StudySettings

# How many settings a sentence names at most.
MAX_NAMED = 3


def conclusions(
    study: StudySettings,
    points: Sequence[Point],
    gains: pd.DataFrame,
    importance: pd.DataFrame,
    leaders: pd.DataFrame,
    claims: pd.DataFrame | None,
    statistics: StatisticsSettings,
) -> list[str]:
    """A sentence per baseline, and one each on what decides, how large gains are, and the claims or the best policy.

    The tables are those of `gain_table`, `importance_table`, `leader_table` and `claim_table`; `statistics` has the
    level and the margin.
    """
    names = {point.name for point in points if point.design == "space filling"}
    combined = gains[gains["point"].isin(names)]
    done = combined["point"].nunique()
    opening = f"the digital human can perform {done} of {len(names)} combinations of all {len(study.factors)} settings"
    if done == 0:
        return [f"{opening[0].upper()}{opening[1:]}, so there is nothing to compare."]
    sentences = [_on_baseline(study, combined, baseline) for baseline in study.baselines]
    sentences[0] = f"{opening}; {sentences[0]}"
    sentences.append(_on_settings(study, importance, statistics.significance_level))
    sentences.append(_on_size(study, combined, statistics.equivalence_margin))
    sentences.append(_on_leaders(leaders[leaders["point"].isin(names)]) if claims is None else _on_claims(claims))
    return [sentence[0].upper() + sentence[1:] for sentence in sentences]


def at_headline(table: pd.DataFrame, headline: Headline) -> pd.DataFrame:
    """The rows of the headline's condition and length, all planners and baselines."""
    return table[(table["condition"] == headline.condition) & (table["n_cycles"] == headline.n_cycles)]


def of_headline(table: pd.DataFrame, headline: Headline) -> pd.DataFrame:
    """The same of the headline's planner alone."""
    return at_headline(table[table["planner"] == headline.planner], headline)


def _on_baseline(study: StudySettings, combined: pd.DataFrame, baseline: str) -> str:
    headline = study.headline
    rows = at_headline(combined, headline)
    rows = rows[rows["baseline"] == baseline]
    own = rows[rows["planner"] == headline.planner]
    better, worse = (int((own["verdict"] == verdict).sum()) for verdict in ("better", "worse"))
    others = [
        f"{planner} is better in {(other['verdict'] == 'better').sum()}, worse in {(other['verdict'] == 'worse').sum()}"
        for planner in study.planners
        if planner != headline.planner
        for other in [rows[rows["planner"] == planner]]
    ]
    return (
        f"{headline.planner} is significantly better than {baseline} in {better} of {len(own)} and worse in {worse} "
        f"({headline.condition}, {headline.n_cycles} cycles; individual {100 * CONFIDENCE:g} % intervals); its median "
        f"gain is {brief_percent(own['gain'].median())} of the cost, and its gains range from "
        f"{brief_percent(own['gain'].min())} to {brief_percent(own['gain'].max())}"
        f"{''.join(f'; {other}' for other in others)}."
    )


def _on_settings(study: StudySettings, importance: pd.DataFrame, level: float) -> str:
    rows = of_headline(importance, study.headline)
    decided = [
        f"over {baseline} {_deciding(own, 'share', 'p_value', level)} "
        f"(by ranks {_deciding(own, 'rank_share', 'rank_p_value', level)})"
        for baseline in study.baselines
        for own in [rows[rows["baseline"] == baseline]]
    ]
    return (
        f"settings that alone explain more of {study.headline.planner}'s gain than chance would: "
        f"{', '.join(decided)} (fraction of the variance over the combinations; permutation test of all settings "
        f"together, at {brief_percent(level)})"
        f"{_swings(rows[rows['baseline'] == study.baselines[0]], study.baselines[0])}."
    )


def _deciding(own: pd.DataFrame, fraction: str, p_value: str, level: float) -> str:
    """The settings that explain more than chance would, the most important first."""
    seen = own[own[p_value] < level].sort_values(fraction, ascending=False, kind="stable").iloc[:MAX_NAMED]
    return ", ".join(f"{row['factor']} {brief_percent(row[fraction])}" for _, row in seen.iterrows()) or "no setting"


def _swings(own: pd.DataFrame, baseline: str) -> str:
    """The settings that move the gain most when they alone are changed."""
    widest = own[own["swing"] > 0].sort_values("swing", ascending=False, kind="stable").iloc[:MAX_NAMED]
    named = ", ".join(
        f"{row['factor']} (by {brief_percent(row['swing'])} of the cost, {row['least_at']} to {row['most_at']})"
        for _, row in widest.iterrows()
    )
    return f"; changed one at a time, the gain over {baseline} moves most with {named}" if named else ""


def _on_size(study: StudySettings, combined: pd.DataFrame, margin: float) -> str:
    planner, baseline = study.headline.planner, study.baselines[0]
    own = combined[(combined["planner"] == planner) & (combined["baseline"] == baseline)]
    within = int((own["gain_high"] < margin).sum())
    most = own.sort_values("gain", kind="stable").iloc[-1]
    return (
        f"over all conditions and lengths, {planner} saves less than {brief_percent(margin)} of {baseline}'s cost (by "
        f"the upper end of the interval) in {within} of {len(own)} cells; the largest gain is "
        f"{brief_percent(most['gain'])} ({brief_percent(most['gain_low'])} to {brief_percent(most['gain_high'])}) at "
        f"{most['point']}, {most['condition']}, {most['n_cycles']} cycles."
    )


def _on_leaders(leaders: pd.DataFrame) -> str:
    counts = leaders["policy"].value_counts(sort=False).sort_values(ascending=False, kind="stable")
    named = ", ".join(f"{policy} in {count}" for policy, count in counts.items())
    return f"the policy with the lowest mean cost is {named} of {len(leaders)} cells."


def _on_claims(claims: pd.DataFrame) -> str:
    held = reproduced_fraction(claims)
    points = int(claims[claims["analysis"] == ANALYSES[0]].groupby("claim")["points"].sum().max())
    often, never = int((held > 0.5).sum()), int((held == 0).sum())
    return (
        f"of the paper's {len(held)} claims, {often} are reproduced at more than half of the {points} settings tried "
        f"and {never} at none; the most robust, {held.index[0]}, is reproduced at {brief_percent(held.iloc[0])} of "
        f"them."
    )

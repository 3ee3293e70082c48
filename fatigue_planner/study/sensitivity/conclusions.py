"""What one learns from a study, in a few sentences made from its tables."""

from collections.abc import Sequence

import pandas as pd

from fatigue_planner.core.text import brief_percent
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.gains import CONFIDENCE
from fatigue_planner.study.sensitivity.robustness import ANALYSES, reproduced_share
from fatigue_planner.study.sensitivity.settings import Headline, StudySettings

DECIDING = 3


def lessons(
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
    opening = f"Of {len(names)} combinations of all {len(study.factors)} settings the digital human can perform {done}"
    if done == 0:
        return [f"{opening}, so there is nothing to compare."]
    sentences = [_on_baseline(study, combined, baseline) for baseline in study.baselines]
    sentences[0] = f"{opening}; {sentences[0]}"
    sentences.append(_on_settings(study, importance, statistics.significance_level))
    sentences.append(_on_size(study, combined, statistics.equivalence_margin))
    sentences.append(_on_leaders(leaders[leaders["point"].isin(names)]) if claims is None else _on_claims(claims))
    return [sentence[0].upper() + sentence[1:] for sentence in sentences]


def at_headline(table: pd.DataFrame, headline: Headline) -> pd.DataFrame:
    """The rows of the headline's condition and length, all planners and baselines."""
    return table[(table["condition"] == headline.condition) & (table["n_cycles"] == headline.n_cycles)]


def _on_baseline(study: StudySettings, combined: pd.DataFrame, baseline: str) -> str:
    headline = study.headline
    here = at_headline(combined, headline)
    here = here[here["baseline"] == baseline]
    own = here[here["planner"] == headline.planner]
    better, worse = (int((own["verdict"] == verdict).sum()) for verdict in ("better", "worse"))
    others = [
        f"{planner} is better in {(rows['verdict'] == 'better').sum()}, worse in {(rows['verdict'] == 'worse').sum()}"
        for planner in study.planners
        if planner != headline.planner
        for rows in [here[here["planner"] == planner]]
    ]
    return (
        f"{headline.planner} is significantly better than {baseline} in {better} of {len(own)} and worse in {worse} "
        f"({headline.condition}, {headline.n_cycles} cycles; {100 * CONFIDENCE:g} % intervals, each for itself); its "
        f"gain is {brief_percent(own['gain'].median())} of the cost in the median, "
        f"{brief_percent(own['gain'].min())} to {brief_percent(own['gain'].max())} from one to another"
        f"{''.join(f'; {other}' for other in others)}."
    )


def _on_settings(study: StudySettings, importance: pd.DataFrame, level: float) -> str:
    here = at_headline(importance, study.headline)
    here = here[here["planner"] == study.headline.planner]
    decided = [
        f"over {baseline} {_deciding(own, 'share', 'p_value', level)} "
        f"(by ranks {_deciding(own, 'rank_share', 'rank_p_value', level)})"
        for baseline in study.baselines
        for own in [here[here["baseline"] == baseline]]
    ]
    return (
        f"what alone explains more of {study.headline.planner}'s gain over the combinations than chance might: "
        f"{', '.join(decided)} (share of the variance; permutations of all settings together, at "
        f"{brief_percent(level)})"
        f"{_swings(here[here['baseline'] == study.baselines[0]], study.baselines[0])}."
    )


def _deciding(own: pd.DataFrame, share: str, p_value: str, level: float) -> str:
    """The settings that explain more than chance, the most important first."""
    seen = own[own[p_value] < level].sort_values(share, ascending=False, kind="stable").iloc[:DECIDING]
    return ", ".join(f"{row['factor']} {brief_percent(row[share])}" for _, row in seen.iterrows()) or "no setting"


def _swings(own: pd.DataFrame, baseline: str) -> str:
    """The settings that move the gain most when they alone are changed."""
    widest = own[own["swing"] > 0].sort_values("swing", ascending=False, kind="stable").iloc[:DECIDING]
    named = ", ".join(
        f"{row['factor']} (by {brief_percent(row['swing'])} of the cost, {row['least_at']} to {row['most_at']})"
        for _, row in widest.iterrows()
    )
    return f"; one at a time, the gain over {baseline} moves most with {named}" if named else ""


def _on_size(study: StudySettings, combined: pd.DataFrame, margin: float) -> str:
    planner, baseline = study.headline.planner, study.baselines[0]
    own = combined[(combined["planner"] == planner) & (combined["baseline"] == baseline)]
    within = int((own["gain_high"] < margin).sum())
    most = own.sort_values("gain", kind="stable").iloc[-1]
    return (
        f"over all conditions and lengths {planner} saves less than {brief_percent(margin)} of what {baseline} costs, "
        f"by the upper end of the interval, in {within} of {len(own)} cells; the largest gain is at "
        f"{most['point']}, {most['condition']}, {most['n_cycles']} cycles: {brief_percent(most['gain'])} "
        f"({brief_percent(most['gain_low'])} to {brief_percent(most['gain_high'])})."
    )


def _on_leaders(leaders: pd.DataFrame) -> str:
    counts = leaders["policy"].value_counts(sort=False).sort_values(ascending=False, kind="stable")
    named = ", ".join(f"{policy} in {count}" for policy, count in counts.items())
    return f"of all policies, the least mean cost has {named} of {len(leaders)} cells."


def _on_claims(claims: pd.DataFrame) -> str:
    held = reproduced_share(claims)
    points = int(claims[claims["analysis"] == ANALYSES[0]].groupby("claim")["points"].sum().max())
    often, never = int((held > 0.5).sum()), int((held == 0).sum())
    return (
        f"of {len(held)} claims of the paper {often} are reproduced at more than half of the {points} settings tried "
        f"and {never} at none; the most robust, {held.index[0]}, is at {brief_percent(held.iloc[0])}."
    )

"""What holds at all points of a study, at some, and at none; for a few points that stand side by side."""

from collections.abc import Mapping

import pandas as pd

from fatigue_planner.core.text import brief_percent, format_label, listing
from fatigue_planner.study.sensitivity.conclusions import at_headline
from fatigue_planner.study.sensitivity.gains import ANALYSES, REPRODUCED
from fatigue_planner.study.sensitivity.settings import StudySettings
from fatigue_planner.study.statistics.pairing import records

# How many joints the sentence on the cost names.
JOINTS = 3


def agreement(study: StudySettings, gains: pd.DataFrame, verdicts: pd.DataFrame | None) -> pd.DataFrame:
    """One row per statement: kind, statement, held: at how many points, and points: of how many.

    Statements (kind `claim`) are the claims, reproduced by the modern analysis; and, for every planner and baseline in
    the headline's condition and length (kind `gain`), that the planner is significantly better.
    `gains` and `verdicts` are those of `gain_table` and `verdict_table`.
    """
    compared = at_headline(gains, study.headline)
    held = [
        ("gain", f"{planner} better than {baseline}", own["verdict"] == "better")
        for (planner, baseline), own in compared.groupby(["planner", "baseline"], sort=False)
    ]
    if verdicts is not None:
        modern = verdicts[verdicts["analysis"] == ANALYSES[0]]
        judged = modern.groupby("claim", sort=False)
        held += [("claim", str(claim), own["verdict"] == REPRODUCED) for claim, own in judged]
    rows = [(kind, statement, int(points.sum()), len(points)) for kind, statement, points in held]
    return pd.DataFrame(rows, columns=["kind", "statement", "held", "points"])


def agreement_sentences(
    study: StudySettings, agreed: pd.DataFrame, gains: pd.DataFrame, shares: pd.DataFrame, names: Mapping[str, str]
) -> list[str]:
    """What holds under all, some and none, a sentence each; how large the gains are; which joints make up the cost.

    `names`: of the points, as they are shown. The tables are those of `agreement`, `gain_table` and `shares.SHARES`.
    """
    if agreed.empty:
        return ["None of the points can be performed, so there is nothing to compare."]
    headline, points = study.headline, int(agreed["points"].max())
    everywhere, nowhere = agreed["held"] == agreed["points"], agreed["held"] == 0
    where = f"{format_label(headline.condition)}, {headline.n_cycles} cycles"
    return [
        f"Under all {points} readings: {_statements(agreed[everywhere])}.",
        f"Under some: {_statements(agreed[~everywhere & ~nowhere], counted=True)}.",
        f"Under none: {_statements(agreed[nowhere])}.",
        f"The policy {headline.planner} costs less ({where}) than "
        + listing([_gains(at_headline(gains, headline), headline.planner, name, names) for name in study.baselines])
        + ".",
        _on_shares(shares, study.baselines[0], names, where),
    ]


def _statements(rows: pd.DataFrame, counted: bool = False) -> str:
    """The gains, then the claims, each with at how many points it holds if asked for."""
    named = [
        (format_label(row["statement"]) if row["kind"] == "claim" else row["statement"])
        + (f" ({row['held']})" if counted else "")
        for row in records(rows)
    ]
    of_claims = sum(rows["kind"] == "claim")
    return f"{', '.join(named)} ({of_claims} of the paper's claims)" if named else "nothing"


def _gains(gains: pd.DataFrame, planner: str, baseline: str, names: Mapping[str, str]) -> str:
    own = gains[(gains["planner"] == planner) & (gains["baseline"] == baseline)].sort_values("gain", kind="stable")
    least, most = own.iloc[0], own.iloc[-1]
    return (
        f"{baseline} by {brief_percent(least['gain'])} ({names[least['point']]}) to {brief_percent(most['gain'])} "
        f"({names[most['point']]}), {brief_percent(own['gain'].median())} in the median"
    )


def _on_shares(shares: pd.DataFrame, baseline: str, names: Mapping[str, str], where: str) -> str:
    by_joint = shares.pivot_table(index="joint_group", columns="point", values="share", sort=False)
    largest = by_joint.mean(axis=1).sort_values(ascending=False, kind="stable").index[:JOINTS]
    parts = [
        f"the {format_label(joint)} makes up {brief_percent(own.min())} ({names[own.idxmin()]}) to "
        f"{brief_percent(own.max())} ({names[own.idxmax()]})"
        for joint in largest
        for own in [by_joint.loc[joint]]
    ]
    return f"Of {baseline}'s cost ({where}), {listing(parts)}."

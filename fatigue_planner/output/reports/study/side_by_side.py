"""The parts of a page that set a few points of a study side by side: claims, gains, joints, arguments."""

import pandas as pd

from fatigue_planner.core.text import brief_percent, format_label, percent
from fatigue_planner.output.reports.page import Block, Section, Table, Text
from fatigue_planner.output.reports.study.finished import FinishedStudy
from fatigue_planner.study.claims.schema import Answer
from fatigue_planner.study.sensitivity.gains import ANALYSES
from fatigue_planner.study.statistics.pairing import records

MARKS = {Answer.HOLDS.verdict: "✓", Answer.FAILS.verdict: "✗", Answer.OPEN.verdict: "?"}
# How many joints the table of shares has: those with the largest.
MAX_JOINTS = 7


def side_by_side(study: FinishedStudy, where: str) -> list[Section]:
    """All parts. `where`: path from the page to the study's folder, empty or ending in a slash."""
    tables = [gains(study, where), claims(study, where), shares(study, where)]
    return [
        Section("What holds where", [table for table in tables if table is not None]),
        Section("The readings and their arguments", arguments(study, where)),
    ]


def gains(study: FinishedStudy, where: str) -> Table:
    """What the headline's planner gains over each baseline, a row per point, in the headline's length."""
    headline, baselines, table = study.note.study.headline, study.note.study.baselines, study.tables["gains"]
    own = table[(table["planner"] == headline.planner) & (table["n_cycles"] == headline.n_cycles)]
    leaders = study.tables["leaders"]
    leaders = leaders[(leaders["condition"] == headline.condition) & (leaders["n_cycles"] == headline.n_cycles)]
    best = leaders.set_index("point")["policy"]
    columns = [(baseline, condition) for baseline in baselines for condition in dict.fromkeys(own["condition"])]
    cells = {(row["point"], row["baseline"], row["condition"]): _gain(row) for row in records(own)}
    rows = [
        [name, *(cells[point, *column] for column in columns), format_label(str(best[point]))]
        for point, name in _performed(study).items()
    ]
    caption = (
        f"What `{headline.planner}` saves of each baseline's cost over {headline.n_cycles} cycles; * where the paired "
        f"95 % interval excludes 0. Last: the policy with the least mean cost ({format_label(headline.condition)})."
    )
    header = ["reading", *(f"over {format_label(b)}, {format_label(c)}" for b, c in columns), "best policy"]
    return Table(caption, header, rows, f"{where}gains.csv")


def claims(study: FinishedStudy, where: str) -> Table | None:
    """A row per claim, a column per point; None if the claims were not judged."""
    verdicts = study.tables.get("verdicts")
    if verdicts is None:
        return None
    marks = verdicts.assign(mark=verdicts["verdict"].map(MARKS)).pivot_table(
        index="claim", columns=["point", "analysis"], values="mark", aggfunc="first", sort=False
    )
    points = _performed(study)
    rows = [
        [format_label(str(claim)), *(" ".join(row[point, analysis] for analysis in ANALYSES) for point in points)]
        for claim, row in marks.iterrows()
    ]
    caption = (
        "The paper's claims under each reading: reproduced (✓), not reproduced (✗) or undetermined (?), by the paired "
        f"and corrected analysis, then by the paper's own test, from {study.tables['gains']['trials'].max()} runs each."
    )
    return Table(caption, ["claim", *points.values()], rows, f"{where}verdicts.csv")


def shares(study: FinishedStudy, where: str) -> Table:
    """Which joints make up the first baseline's cost, a row per point."""
    table = study.tables["cost_shares"].pivot_table(index="point", columns="joint_group", values="share", sort=False)
    largest = table.mean().sort_values(ascending=False, kind="stable").index[:MAX_JOINTS]
    rows = [
        [name, *(percent(table.loc[point, joint], 0) for joint in largest)] for point, name in _performed(study).items()
    ]
    noted, headline = study.note.study, study.note.study.headline
    caption = (
        f"Which joints make up the discounted cost of `{noted.baselines[0]}` ({format_label(headline.condition)}, "
        f"{headline.n_cycles} cycles): the {len(largest)} with the largest shares."
    )
    return Table(caption, ["reading", *map(format_label, largest)], rows, f"{where}cost_shares.csv")


def arguments(study: FinishedStudy, where: str) -> list[Block]:
    """Every point with its argument and, where it cannot be performed, why."""
    points, names = study.tables["points"], _names(study)
    rows = [[names[row["point"]], row["argument"]] for row in records(points)]
    blocks: list[Block] = [Table("Each with its argument.", ["reading", "argument"], rows, f"{where}points.csv")]
    failed = points[~points["feasible"].astype(bool)]
    blocks += [Text(f"{names[row['point']]} cannot be performed: {row['reason']}") for row in records(failed)]
    return blocks


def _gain(row: dict[str, object]) -> str:
    return f"{brief_percent(float(str(row['gain'])))}{'' if row['verdict'] == 'undecided' else '*'}"


def _names(study: FinishedStudy) -> dict[str, str]:
    """The points as they are shown: by the level of the factor that differs, or, of the base, of the first one."""
    first = str(study.tables["factors"]["factor"].iloc[0])
    return {
        row["point"]: format_label(str(row[first if pd.isna(row["factor"]) else row["factor"]]))
        for row in records(study.tables["points"])
    }


def _performed(study: FinishedStudy) -> dict[str, str]:
    """The points that can be performed, as they are shown."""
    feasible = study.tables["points"].set_index("point")["feasible"].astype(bool)
    return {point: name for point, name in _names(study).items() if feasible[point]}

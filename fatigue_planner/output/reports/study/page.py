"""The page of a finished sensitivity study, and its parts for other pages."""

from collections import Counter

import pandas as pd

from fatigue_planner.core.provenance import versions
from fatigue_planner.core.text import brief_percent, format_label, listing, significant
from fatigue_planner.output.figures.style import Picture
from fatigue_planner.output.reports.page import Block, Code, Points, Section, Table, Text, page
from fatigue_planner.output.reports.study.finished import FIGURES, FinishedStudy
from fatigue_planner.output.reports.study.side_by_side import side_by_side
from fatigue_planner.study.claims.schema import VERDICTS
from fatigue_planner.study.sensitivity.conclusions import of_headline
from fatigue_planner.study.sensitivity.gains import ANALYSES
from fatigue_planner.study.statistics.pairing import records

MAX_REASON_LENGTH = 240
WIDEST = 3  # how many settings the text for a tornado chart names
COMBINED = "space filling"


def study_page(study: FinishedStudy, command: str) -> str:
    """The page (HTML) of a study in its own folder; `command` makes it."""
    note = study.note
    provenance: list[Block] = [
        Text("This command reproduces the tables and this page:"),
        Code(command),
        Text(
            f"Seed {note.seed}; {len(note.reactions)} reactions. Versions, configuration and hashes are in "
            "`manifest.json`."
        ),
    ]
    question = "When does planning pay?" if study.combines else "What holds under other readings?"
    sections: list[Section | None]
    if not study.combines:
        sections = [*side_by_side(study, "")]
    else:
        sections = [
            Section("Which settings decide", deciding(study, "")),
            Section("All conditions and lengths", [over_all_cells(study, "")]),
            claims_over_points(study, ""),
            Section("What was tried", [tried(study, "")]),
            Section("What cannot be performed", infeasible(study, "")),
        ]
    sections.append(Section("Provenance", provenance))
    subtitle = (
        f"Written by fatplan {versions()['fatplan']} from the tables beside this page; no number was typed by hand."
    )
    title = f"{question} The study {note.study.name}"
    return page(title, subtitle, [Points(study.conclusions)], [section for section in sections if section is not None])


def deciding(study: FinishedStudy, where: str, most: int | None = None) -> list[Block]:
    """Which settings decide: a table of settings (at most `most`) for each baseline, and all figures.

    `where`: path from the page to the study's folder, empty or ending in a slash.
    """
    headline = study.note.study.headline
    importance = of_headline(study.tables["importance"], headline)
    if most is not None:
        importance = importance.groupby("baseline", sort=False).head(most)
    rows = [
        [
            format_label(row["baseline"]), format_label(row["factor"]), _fraction(row["share"]),
            "–" if pd.isna(row["share_low"]) else f"{_fraction(row['share_low'])} to {_fraction(row['share_high'])}",
            _p_value(row["p_value"]), _fraction(row["rank_share"]), _p_value(row["rank_p_value"]),
            _fraction(row["swing"]),
            f"{format_label(row['least_at'])} → {format_label(row['most_at'])}" if row["swing"] > 0 else "–",
        ]
        for row in records(importance.fillna({"least_at": "", "most_at": ""}))
    ]  # fmt: skip
    caption = (
        f"What `{headline.planner}` gains over each baseline ({format_label(headline.condition)}, {headline.n_cycles} "
        "cycles), and which settings decide it: the fraction of the gain's variance over all combinations that a "
        "setting explains alone, with a 95 % bootstrap interval and a p value corrected for all settings "
        "(permutations); the same for the ranks of the gains, which a few very large gains do not dominate; and how "
        "far the setting alone moves the gain (largest minus smallest)."
    )
    header = [
        "gain over",
        "setting",
        "variance explained",
        "interval",
        "p",
        "of ranks",
        "p",
        "swing alone",
        "least → most at",
    ]
    table = Table(caption, header, rows, f"{where}importance.csv")
    return [table, *(_picture(study, name, where) for name in study.note.figures)]


def over_all_cells(study: FinishedStudy, where: str) -> Table:
    """How often each planner is better or worse than each baseline over the combinations, in every cell."""
    names = set(study.tables["points"].query("design == @COMBINED")["point"])
    gains = study.tables["gains"]
    rows = [
        [
            format_label(str(planner)), format_label(str(baseline)), format_label(str(condition)), str(n_cycles),
            f"{(own['verdict'] == 'better').sum()} / {(own['verdict'] == 'worse').sum()} of {len(own)}",
            brief_percent(own["gain"].median()),
            f"{brief_percent(own['gain'].min())} to {brief_percent(own['gain'].max())}",
        ]
        for (planner, baseline, condition, n_cycles), own in gains[gains["point"].isin(names)].groupby(
            ["planner", "baseline", "condition", "n_cycles"], sort=False
        )
    ]  # fmt: skip
    caption = (
        "At the combinations of all settings: how often each planner is significantly better or worse, and its gain."
    )
    header = ["planner", "over", "condition", "cycles", "better / worse", "median gain", "least to most"]
    return Table(caption, header, rows, f"{where}gains.csv")


def claims_over_points(study: FinishedStudy, where: str) -> Section | None:
    """How often each claim is reproduced over all settings tried; None if they were not judged."""
    claims = study.tables.get("claims_over_points")
    if claims is None:
        return None
    wide = claims.pivot_table(
        index="claim", columns=["analysis", "verdict"], values="points", aggfunc="sum", fill_value=0, sort=False
    )
    columns = [(analysis, verdict) for analysis in ANALYSES for verdict in VERDICTS]
    wide = wide.reindex(columns=pd.MultiIndex.from_tuples(columns), fill_value=0)
    wide = wide.sort_values(columns[0], ascending=False, kind="stable")
    rows = [[str(claim).replace("_", " "), *(f"{count:.0f}" for count in counts)] for claim, counts in wide.iterrows()]
    points = int(wide[[column for column in columns if column[0] == "modern"]].sum(axis=1).max())
    trials = study.tables["gains"]["trials"].max()
    caption = (
        f"At how many of {points} settings (one at a time and combined) each claim of the paper is reproduced, by the "
        f"paired and corrected analysis and by the paper's own test, from {trials} runs each."
    )
    header = ["claim", *VERDICTS, *(f"{verdict} (paper's test)" for verdict in VERDICTS)]
    table = Table(caption, header, rows, f"{where}claims_over_points.csv")
    return Section("The paper's claims over all settings", [table])


def tried(study: FinishedStudy, where: str) -> Table:
    """The settings, their levels, and the reasons for these."""
    rows = [
        [format_label(row["factor"]), row["levels"], str(row["base"]), row["reason"]]
        for row in records(study.tables["factors"])
    ]
    header = ["setting", "levels alone", "the experiment's own", "why these"]
    return Table("The settings that were changed, one at a time and all at once.", header, rows, f"{where}factors.csv")


def infeasible(study: FinishedStudy, where: str) -> list[Block]:
    """The points that the digital human cannot perform, with reasons."""
    points = study.tables["points"]
    counts = Counter(points["design"])
    failed = points[~points["feasible"].astype(bool)]
    lost = Counter(failed["design"])
    summary = listing(
        [f"{lost[design]} of {count} points of the design `{design}`" for design, count in counts.items()]
    )
    blocks: list[Block] = [Text(f"The digital human cannot perform {summary}; these are left out above.")]
    if len(failed):
        rows = [[row["point"], _short(str(row["reason"]))] for row in records(failed)]
        blocks.append(Table("The reasons.", ["point", "reason"], rows, f"{where}points.csv"))
    return blocks


def _fraction(fraction: float) -> str:
    return "–" if pd.isna(fraction) else brief_percent(fraction)


def _p_value(p_value: float) -> str:
    return "–" if pd.isna(p_value) else significant(p_value, 2)


def _short(reason: str) -> str:
    return reason if len(reason) <= MAX_REASON_LENGTH else f"{reason[:MAX_REASON_LENGTH]}…"


def _picture(study: FinishedStudy, name: str, where: str) -> Picture:
    (svg, data), planner = study.figure(name), study.note.study.headline.planner
    if name == "importance":
        caption = "How much of the gain's variance over all combinations each setting explains alone."
        first = data[data["baseline"] == study.note.study.baselines[0]].head(WIDEST)
        alternative = f"over {study.note.study.baselines[0]}: " + _listed(first, "factor", "share")
    elif name == "trends":
        caption = "The gain at every combination against the settings that decide most; bars are 95 % intervals."
        alternative = listing(
            [
                f"over {baseline} from {brief_percent(own['gain'].min())} to {brief_percent(own['gain'].max())}, "
                f"median {brief_percent(own['gain'].median())}"
                for baseline in study.note.study.baselines
                for own in [data[data["baseline"] == baseline]]
            ]
        )
    else:
        baseline = name.removeprefix("tornado_")
        caption = f"How far each setting alone moves what `{planner}` gains over `{baseline}`; each mark is a level."
        widest = list(dict.fromkeys(data["factor"].dropna()))[:WIDEST]
        alternative = listing(
            [
                f"{format_label(factor)} moves it from {brief_percent(own.min())} to {brief_percent(own.max())}"
                for factor in widest
                for own in [data.loc[(data["factor"] == factor) | data["factor"].isna(), "gain"]]
            ]
        )
    return Picture(svg, caption, f"{alternative}.", f"{where}{FIGURES}/{name}.csv")


def _listed(table: pd.DataFrame, name: str, fraction: str) -> str:
    return listing([f"{format_label(row[name])} {brief_percent(row[fraction])}" for row in records(table)])

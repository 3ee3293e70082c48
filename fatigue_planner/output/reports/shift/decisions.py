"""What the robot was told and why, what it did, and what was seen of the worker's cycles."""

from collections import Counter
from itertools import groupby

import pandas as pd

from fatigue_planner.core.text import counted, format_label, percent
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Block, Points, Section, Table, Text
from fatigue_planner.study.statistics.pairing import records

# Rows of a list on the page; the data file has all.
MAX_ROWS = 40


def decisions_section(cycles: pd.DataFrame, figures: FigureFolder) -> Section:
    """What was decided and why, and where the robot did something else."""
    file = figures.add_table("cycles", cycles)
    decided = cycles.dropna(subset=["decided"])
    counts = Counter((row["decided"], row["reason"], row["fallback"]) for row in records(decided))
    rows = [
        [
            action,
            reason,
            "–" if fallback == "none" else format_label(fallback),
            str(count),
            percent(count / len(decided), 0),
        ]
        for (action, reason, fallback), count in counts.most_common(MAX_ROWS)
    ]
    blocks: list[Block] = [
        Table(
            "What the robot was told, and why.",
            ["action", "reason", "instead of the policy", "cycles", "share"],
            rows,
            file,
        )
    ]
    other = cycles[cycles["done"].notna() & cycles["decided"].notna() & (cycles["done"] != cycles["decided"])]
    if len(other):
        rows = [[str(row["cycle"]), row["ended"][11:16], row["decided"], row["done"]] for row in records(other)]
        caption = f"Cycles in which the robot did something else than it was told{of_all(rows)}; what it did counts."
        blocks.append(Table(caption, ["cycle", "ended", "told", "did"], rows[:MAX_ROWS], file))
    else:
        blocks.append(Text("The robot did what it was told in every cycle of which that is known."))
    return Section("Decisions", blocks)


def sight_section(cycles: pd.DataFrame) -> Section:
    """What was not seen."""
    counts = Counter(cycles["seen"])
    runs = [len(list(group)) for seen, group in groupby(cycles["seen"]) if seen == "nothing"]
    words = {
        "recognised": "the reaction was recognised",
        "likelihood": "the recogniser said how likely each reaction was",
        "unclear": "you were seen to do none of the reactions that the task knows",
        "nothing": "nothing was seen",
        "skipped": "you did nothing",
        "off": "the belief was off, and nothing was kept",
    }
    rows = [
        [text, str(counts[seen]), percent(counts[seen] / len(cycles), 1)]
        for seen, text in words.items()
        if counts[seen]
    ]
    points = []
    if runs:
        points.append(f"The longest time without news was {counted(max(runs), 'cycle')}.")
    if late := int(cycles["told_late"].sum()):
        points.append(
            f"{counted(late, 'cycle')} became known late: decisions in between stood, the estimate was made anew."
        )
    if surprised := int(cycles["surprised"].sum()):
        points.append(
            f"In {counted(surprised, 'cycle')} the model rules out what was seen: it does not fit all that you do."
        )
    return Section(
        "What was seen",
        [
            Table("Cycles by what was known of them.", ["what was known", "cycles", "share"], rows, "cycles.csv"),
            *([Points(points)] if points else []),
        ],
    )


def of_all(rows: list[list[str]]) -> str:
    """What a caption says of a list that is too long for the page."""
    return f": the first {MAX_ROWS} of {len(rows)}" if len(rows) > MAX_ROWS else ""

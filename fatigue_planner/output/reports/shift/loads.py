"""Load doses by joint and hour, as a table on the page."""

import pandas as pd

from fatigue_planner.core.text import fixed, format_label
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Section, Table, Text
from fatigue_planner.study.statistics.pairing import records

# Entries with less in a whole shift are in the data file only.
LEAST_S = 1.0


def doses_section(table: pd.DataFrame, figures: FigureFolder) -> Section | None:
    """Doses by joint and hour."""
    if not len(table):
        return None
    file = figures.add_table("doses", table)
    return Section(
        "Load by hour",
        [
            Text(
                "A dose adds up how hard a muscle group had to work while that was hard enough to tire it: 60 s are a "
                "minute at full strength, or ten minutes at a tenth. No limit of it is known, so none is given."
            ),
            dose_table(table, "dose_s", file, "Load doses in s by the hour in which a cycle ended."),
        ],
    )


def dose_table(table: pd.DataFrame, value: str, file: str, caption: str) -> Table:
    """Doses by entry (the most loaded first) and hour; ± is the standard deviation of what was not seen for certain."""
    order = table.groupby("entry", sort=False)[value].sum().sort_values(ascending=False, kind="stable")
    by_cell = {(row["entry"], row["begins"]): row for row in records(table)}
    begins = list(dict.fromkeys(table["begins"]))
    rows = [
        [format_label(entry), *(_dose(by_cell.get((entry, hour)), value) for hour in begins)]
        for entry in order[order >= LEAST_S].index
    ]
    header = ["joint and direction", *(f"from {hour[11:16]}" for hour in begins)]
    caption += f" Less than {LEAST_S:g} s in all is left out. ± is one standard deviation of what was not seen surely."
    return Table(caption, header, rows, file)


def _dose(row: dict[str, float] | None, value: str) -> str:
    if row is None:
        return "–"
    deviation = row.get("deviation_s", 0.0)
    return fixed(row[value]) + (f" ± {fixed(deviation)}" if deviation >= 0.05 else "")

"""The evaluated claims for people to read."""

import textwrap
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from fatigue_planner.study.claims.schema import VERDICTS

INDENT = "    "


def claims_text(table: pd.DataFrame, width: int) -> str:
    """The table of `tables.claims_table`, a block per claim, wrapped to a width in characters; counts come last."""
    blocks = [_block(row, width) for row in table.to_dict("records")]
    return "\n\n".join([*blocks, _counts(table)]) + "\n"


def _block(row: Mapping[Hashable, Any], width: int) -> str:
    title = f"{row['claim']} (section {row['place']}): {row['verdict'].upper()}; by the paper's own test "
    lines = [
        f"“{row['quote']}”",
        f"Read as: {row['interpretation']}" if row["interpretation"] else "",
        f"{row['relation']}: {_listed(row['policies'])}{_others(row)}",
        f"Why: {row['reason']}.",
        f"Numbers (difference of the returns in % of the cost): {row['numbers']}." if row["numbers"] else "",
        f"Paper's own test: {row['paper_reason']}." if row["paper_reason"] != row["reason"] else "",
        f"Headroom: {row['room_to_win']}." if row["room_to_win"] else "",
    ]
    wrapped = [_wrap(title + row["paper_verdict"], width, "")]
    wrapped += [_wrap(line, width, INDENT) for line in lines if line]
    return "\n".join(wrapped)


def _wrap(line: str, width: int, indent: str) -> str:
    together = line.replace(" %", "\u00a0%")  # a no-break space, so that no number loses its unit
    return textwrap.fill(
        together, width, initial_indent=indent, subsequent_indent=INDENT, break_on_hyphens=False, break_long_words=False
    )


def _others(row: Mapping[Hashable, Any]) -> str:
    against = f" | {_listed(row['others'])}" if row["others"] else ""
    return f"{against} ({_listed(row['conditions'])}; {_listed(row['n_cycles'])} cycles)"


def _listed(names: str) -> str:
    return ", ".join(names.split())


def _counts(table: pd.DataFrame) -> str:
    return (
        f"{len(table)} claims: {_count(table['verdict'])}.\nBy the paper's own test of the same runs: "
        f"{_count(table['paper_verdict'])}."
    )


def _count(verdicts: pd.Series) -> str:
    counts = verdicts.value_counts()
    return ", ".join(f"{counts.get(name, 0)} {name}" for name in VERDICTS)

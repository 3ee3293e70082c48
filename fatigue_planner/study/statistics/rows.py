"""Walking over tables, with types."""

from collections.abc import Iterator
from typing import Any, cast

import pandas as pd


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows by name of their columns."""
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


def cells_of(table: pd.DataFrame) -> Iterator[tuple[str, int, pd.DataFrame]]:
    """The rows of every condition and number of cycles, in the order of the table."""
    for key, rows in table.groupby(["condition", "n_cycles"], sort=False):
        condition, n_cycles = cast(tuple[str, int], key)
        yield condition, int(n_cycles), rows


def groups_of(table: pd.DataFrame, column: str) -> Iterator[tuple[str, pd.DataFrame]]:
    """The rows of every value of a column of texts, in the order of the table."""
    for name, rows in table.groupby(column, sort=False):
        yield str(name), rows

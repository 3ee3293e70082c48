"""What messages show of numbers."""

import math

import pytest

from fatigue_planner.core.errors import told_apart


@pytest.mark.parametrize(
    ("first", "second", "form", "texts"),
    [
        (1.04, 1.0, ".1f", ("1.04", "1.00")),
        (3.1, 1.0, ".1f", ("3.1", "1.0")),
        (1.0, 1.0, ".1f", ("1.0", "1.0")),
        (1.0 + 1e-9, 1.0, ".2e", ("1.000000001e+00", "1.000000000e+00")),
        (9.9999996, 10.0, ".6g", ("9.9999996", "10")),
        (math.nan, 1.0, ".1f", ("nan", "1.0")),
        (math.inf, math.inf, ".1f", ("inf", "inf")),
        (0.1 + 0.2, 0.3, ".1f", ("0.30000000000000004", "0.29999999999999999")),
    ],
)
def test_numbers_that_differ_look_different(first: float, second: float, form: str, texts: tuple[str, str]) -> None:
    assert told_apart(first, second, form) == texts

"""Numbers and lists in words."""

import math
from collections.abc import Sequence

BLANK = "\u00a0"


def significant(value: float, digits: int = 3) -> str:
    """A number with some significant digits; `n/a` where there is none."""
    return "n/a" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def percent(share: float, digits: int = 2) -> str:
    """A share as per cent with some decimals; the sign stays with the number where a line breaks."""
    if math.isnan(share):
        return "n/a"
    rounded = round(100 * share, digits) + 0.0  # zero has no sign
    return f"{rounded:.{digits}f}{BLANK}%".replace("-", "−")


def percent_range(low: float, high: float, digits: int = 2) -> str:
    """An interval of shares as per cent."""
    return f"{percent(low, digits).removesuffix(f'{BLANK}%')} to {percent(high, digits)}"


def counted(number: int, what: str, several: str = "") -> str:
    """`1 run`, `2 runs`."""
    return f"{number} {what if number == 1 else several or what + 's'}"


def listing(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)

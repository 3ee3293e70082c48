"""Numbers and lists in words."""

import math
from collections.abc import Sequence

BLANK = "\u00a0"


def significant(value: float, digits: int = 3) -> str:
    """A number with some significant digits; `n/a` where there is none."""
    return "n/a" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def percent(share: float, digits: int = 2) -> str:
    """A share as per cent with some decimals; the sign stays with the number where a line breaks."""
    return "n/a" if math.isnan(share) else f"{100 * share:.{digits}f}{BLANK}%".replace("-", "−")


def percent_range(low: float, high: float, digits: int = 2) -> str:
    """An interval of shares as per cent."""
    return f"{percent(low, digits).removesuffix(f'{BLANK}%')} to {percent(high, digits)}"


def listing(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)

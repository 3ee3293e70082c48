"""Numbers, names and lists as people read them in figures, pages and messages."""

import math
import re
from collections.abc import Sequence


def fixed(value: float, digits: int = 1) -> str:
    """A number with so many decimals; zero has no sign."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def significant(value: float, digits: int = 3) -> str:
    """A number with so many significant digits; `n/a` where there is none."""
    return "n/a" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def percent(fraction: float, digits: int = 2) -> str:
    """A fraction in per cent with so many decimals; `n/a` where there is none."""
    return "n/a" if math.isnan(fraction) else f"{fixed(100 * fraction, digits)} %"


def percent_range(low: float, high: float, digits: int = 2) -> str:
    """An interval of fractions in per cent."""
    return f"{percent(low, digits).removesuffix(' %')} to {percent(high, digits)}"


def brief_percent(fraction: float) -> str:
    """A fraction in per cent with one decimal or, below 1 %, two significant digits; no zeros at the end."""
    value = 100 * fraction
    rounded = round(value, 1) if abs(value) >= 0.95 else float(f"{value:.2g}")
    return f"{rounded + 0.0:.6g} %".replace("-", "−")


def signed_percent(deviation: float) -> str:
    """A deviation in whole per cent with its sign."""
    text = percent(deviation, 0)
    return text if text[0] in "−0" else f"+{text}"


def counted(number: int, what: str, several: str = "") -> str:
    """`1 run`, `2 runs`."""
    return f"{number} {what if number == 1 else several or what + 's'}"


def times(number: int) -> str:
    """`once`, `twice`, `3 times`."""
    return {1: "once", 2: "twice"}.get(number, f"{number} times")


def listing(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)


def format_label(name: str) -> str:
    """The name of a policy, condition, joint or setting as it is shown in a figure or a table."""
    return re.sub(r"[_:]", " ", name)

"""Numbers, names and lists as people read them in figures, pages and messages."""

import math


def fixed(value: float, digits: int = 1) -> str:
    """A number with so many decimals; zero has no sign."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def significant(value: float, digits: int = 3) -> str:
    """A number with so many significant digits; `n/a` where there is none."""
    return "n/a" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def signed_percent(deviation: float) -> str:
    """A deviation in whole per cent with its sign."""
    text = fixed(100 * deviation, 0)
    return f"{'' if text[0] in '−0' else '+'}{text} %"

"""Pieces of a Markdown page: tables, numbers, verdicts, and sentences made from deviations."""

from collections.abc import Mapping, Sequence

NOTEWORTHY = 0.20  # a deviation the page mentions in words
NUMERIC = "0123456789+−–"  # what the cells of a column of numbers begin with


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; columns of numbers are aligned to the right."""
    columns = zip(*rows, strict=True)
    ruler = ["---:" if all(cell[0] in NUMERIC for cell in column) else "---" for column in columns]
    return "\n".join(f"| {' | '.join(line)} |" for line in (header, ruler, *rows))


def number(value: float | None, digits: int = 1) -> str:
    """A number with a fixed count of digits, a dash for none; zero has no sign."""
    if value is None:
        return "–"
    rounded = round(value, digits) + 0.0
    return f"{rounded:.{digits}f}".replace("-", "−")


def interval(bounds: tuple[float, float] | None, digits: int = 1) -> str:
    """`least to most`, one number if both are the same, a dash for none."""
    if bounds is None:
        return "–"
    return " to ".join(dict.fromkeys(number(bound, digits) for bound in bounds))


def signed_percent(deviation: float | None) -> str:
    """A deviation as whole per cent with its sign."""
    if deviation is None:
        return "–"
    percent = round(100 * deviation)
    sign = "+" if percent > 0 else "−" if percent < 0 else ""
    return f"{sign}{abs(percent)} %"


def verdict(value: float, bounds: tuple[float, float] | None) -> str:
    """`inside` or `OUTSIDE` of the bounds, a dash if there are none."""
    if bounds is None:
        return "–"
    return "inside" if bounds[0] <= value <= bounds[1] else "**OUTSIDE**"


def deviation_from(value: float, bounds: tuple[float, float]) -> float:
    """Relative distance of a value from the nearer end of an interval; 0 within it."""
    least, most = bounds
    nearest = min(max(value, least), most)
    return value / nearest - 1


def noteworthy(what: str, deviations: Mapping[str, float]) -> str:
    """A sentence that names every deviation above 20 %, or says that there is none; `what` says from what."""
    large = [f"{name} ({signed_percent(d)})" for name, d in deviations.items() if abs(d) > NOTEWORTHY]
    if not large:
        return f"Nothing deviates by more than {number(100 * NOTEWORTHY, 0)} % from {what}."
    return f"More than {number(100 * NOTEWORTHY, 0)} % from {what}: {', '.join(large)}."


def outside(what: str, verdicts: Mapping[str, bool]) -> str:
    """A sentence that names what lies outside `what`; verdicts say what is inside."""
    names = [name for name, inside in verdicts.items() if not inside]
    return f"Outside {what}: {', '.join(names)}." if names else f"Everything is inside {what}."

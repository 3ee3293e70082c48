"""Endurance times of the fatigue model beside measured ones."""

from math import log

import numpy as np

from fatigue_planner.output.reports.human.markdown import noteworthy, number, signed_percent, table
from fatigue_planner.output.reports.human.references import Endurance, references

SHARES = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
GENERAL = "general"
# Where the model has to follow the general curve, and how closely.
TESTED = (0.2, 0.5)
TOLERANCE = 0.10


def endurance_time_s(share: float, fatigue_rate_per_s: float) -> float:
    """Time until a constant share f of the strength cannot be held any more, by Eq. 2: -ln(f) / (k f)."""
    return -log(share) / (fatigue_rate_per_s * share)


def largest_deviation(curve: Endurance, fatigue_rate_per_s: float) -> float:
    """The relative deviation of the model from a curve, with its sign, where it is largest in .2 <= f <= .5."""
    shares = np.linspace(*TESTED, 61)
    return max((endurance_time_s(f, fatigue_rate_per_s) / curve.time_s(f) - 1 for f in shares), key=abs)


def endurance_section(fatigue_rate_per_s: float) -> str:
    """Endurance times by Ma's model and by the measured curves, with the test of the general one."""
    curves = references().endurance
    rows = []
    for share in SHARES:
        model = endurance_time_s(share, fatigue_rate_per_s)
        cells = [number(share), number(model, 0)]
        for curve in curves.values():
            measured = curve.time_s(share)
            cells.append(f"{number(measured, 0)} ({signed_percent(model / measured - 1)})")
        rows.append(cells)
    deviations = {name: largest_deviation(curve, fatigue_rate_per_s) for name, curve in curves.items()}
    worst = abs(deviations[GENERAL])
    passed = "passed" if worst < TOLERANCE else "**FAILED**"
    return "\n\n".join(
        [
            "## Endurance of a constant load",
            table(["load f, of the strength", "model, s", *(f"{name}, s" for name in curves)], rows),
            f"The model: −ln(f) / (k f) with k = {number(60 * fatigue_rate_per_s, 2)} per minute for every joint; in "
            "brackets its deviation from the measured curve. Test: less than 10 % from the general curve for "
            f".2 ≤ f ≤ .5; largest deviation {number(100 * worst)} %: {passed}. Towards f = 1 the model's time goes to "
            "0, the measured ones do not.",
            noteworthy("a measured curve somewhere in .2 ≤ f ≤ .5, with the largest deviation there", deviations),
            references().cite("frey_law", "kamon_endurance"),
        ]
    )

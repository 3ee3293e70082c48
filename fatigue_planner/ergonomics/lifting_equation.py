"""The revised NIOSH lifting equation (Waters, Putz-Anderson & Garg, DHHS (NIOSH) 94-110, revised 9/2021)."""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

Duration = Literal["short", "moderate", "long"]
Coupling = Literal["good", "fair", "poor"]

# Lifts per minute; then short, moderate and long duration, below and from the height on that parts both.
FREQUENCY = np.array([
    [0.2, 1.00, 1.00, 0.95, 0.95, 0.85, 0.85], [0.5, 0.97, 0.97, 0.92, 0.92, 0.81, 0.81],
    [1, 0.94, 0.94, 0.88, 0.88, 0.75, 0.75], [2, 0.91, 0.91, 0.84, 0.84, 0.65, 0.65],
    [3, 0.88, 0.88, 0.79, 0.79, 0.55, 0.55], [4, 0.84, 0.84, 0.72, 0.72, 0.45, 0.45],
    [5, 0.80, 0.80, 0.60, 0.60, 0.35, 0.35], [6, 0.75, 0.75, 0.50, 0.50, 0.27, 0.27],
    [7, 0.70, 0.70, 0.42, 0.42, 0.22, 0.22], [8, 0.60, 0.60, 0.35, 0.35, 0.18, 0.18],
    [9, 0.52, 0.52, 0.30, 0.30, 0.00, 0.15], [10, 0.45, 0.45, 0.26, 0.26, 0.00, 0.13],
    [11, 0.41, 0.41, 0.00, 0.23, 0.00, 0.00], [12, 0.37, 0.37, 0.00, 0.21, 0.00, 0.00],
    [13, 0.00, 0.34, 0.00, 0.00, 0.00, 0.00], [14, 0.00, 0.31, 0.00, 0.00, 0.00, 0.00],
    [15, 0.00, 0.28, 0.00, 0.00, 0.00, 0.00],
])  # fmt: skip
COUPLING = {"good": (1.00, 1.00), "fair": (0.95, 1.00), "poor": (0.90, 0.90)}
# The longest time of a class, in h.
LONGEST_H: dict[Duration, float] = {"short": 1.0, "moderate": 2.0, "long": 8.0}
DURATIONS = tuple(LONGEST_H)
MOST_ASYMMETRY_DEG = 135.0


class Units(NamedTuple):
    """The constants of one system of units; those of the other are no exact conversions of them."""

    load: float
    near: float
    far: float
    height: float
    per_height: float
    highest: float
    per_distance: float
    shortest: float
    longest: float


# kg and cm.
METRIC = Units(23, 25, 63, 75, 0.003, 175, 4.5, 25, 175)


class Place(NamedTuple):
    """Where the hands are at one end of a lift: horizontally from the ankles, above the floor, and beside (degrees)."""

    horizontal: float
    height: float
    asymmetry_deg: float


class Lift(NamedTuple):
    """One lift: load, where it begins, where it ends if that has to be controlled, way up or down, how, how often.

    In the units of `Units`; per_minute is the frequency.
    """

    load: float
    origin: Place
    destination: Place | None
    travel: float
    coupling: Coupling
    per_minute: float

    def independent_limit(self, units: Units = METRIC) -> float:
        """FIRWL: the recommended weight limit without regard to frequency, the lower one of both ends."""
        ends = [self.origin] if self.destination is None else [self.origin, self.destination]
        return min(units.load * math.prod(multipliers(end, self.travel, self.coupling, units).values()) for end in ends)

    def frequency_multiplier(self, per_minute: float, duration: Duration, units: Units = METRIC) -> float:
        """FM at a frequency, by the height at the origin."""
        return frequency_multiplier(per_minute, duration, self.origin.height >= units.height)


def multipliers(place: Place, travel: float, coupling: Coupling, units: Units = METRIC) -> dict[str, float]:
    """HM, VM, DM, AM and CM at one end of a lift."""
    horizontal, height, asymmetry_deg = place
    high = height >= units.height
    return {
        "HM": 0.0 if horizontal > units.far else units.near / max(horizontal, units.near),
        "VM": 0.0 if height > units.highest else 1 - units.per_height * abs(height - units.height),
        "DM": 0.0 if travel > units.longest else 0.82 + units.per_distance / max(travel, units.shortest),
        "AM": 0.0 if asymmetry_deg > MOST_ASYMMETRY_DEG else 1 - 0.0032 * asymmetry_deg,
        "CM": COUPLING[coupling][high],
    }


def frequency_multiplier(per_minute: float, duration: Duration, high: bool) -> float:
    """FM: linear between the rows, 0 above the last one."""
    column = 1 + 2 * DURATIONS.index(duration) + high
    return float(np.interp(per_minute, FREQUENCY[:, 0], FREQUENCY[:, column], right=0.0))


def duration_class(sessions: Sequence[tuple[float, float]]) -> Duration | None:
    """The class of sessions of lifting, each with its time and the rest after it, in h; None: more than 8 h.

    A rest that is too short for the class of the time before it does not count: the times add up. The rest at the end
    of the shift is always long enough.
    """
    worst, total = 0, 0.0
    for index, (work_h, rest_h) in enumerate(sessions):
        total += work_h
        last = index == len(sessions) - 1
        needed = 1.0 if total <= 1 else 0.3 if total <= 2 else math.inf
        if last or rest_h >= needed * total * (1 - 1e-9):
            if total > LONGEST_H["long"]:
                return None
            worst = max(worst, sum(total > longest_h for longest_h in LONGEST_H.values()))
            total = 0.0
    return DURATIONS[worst]


def composite_index(lifts: Sequence[Lift], duration: Duration, units: Units = METRIC) -> float:
    """CLI of several lifts; of one, its lifting index. Infinite where no load is allowed.

    Lifts are taken by falling STLI, at equal ones the more frequent first. Each adds what its load costs at the
    frequency of all until then; the frequency multiplier is by its own height (the source leaves it open).
    """
    limits = [lift.independent_limit(units) for lift in lifts]
    single = [
        _over(lift.load, limit * lift.frequency_multiplier(lift.per_minute, duration, units))
        for lift, limit in zip(lifts, limits, strict=True)
    ]
    order = sorted(range(len(lifts)), key=lambda k: (-single[k], -lifts[k].per_minute))
    index, so_far = single[order[0]], lifts[order[0]].per_minute
    if math.isinf(index):
        return index
    for k in order[1:]:
        lift = lifts[k]
        before = lift.frequency_multiplier(so_far, duration, units)
        so_far += lift.per_minute
        after = lift.frequency_multiplier(so_far, duration, units)
        if after <= 0:
            return math.inf
        index += _over(lift.load, limits[k]) * (1 / after - 1 / before)
    return index


def _over(load: float, limit: float) -> float:
    return load / limit if limit > 0 else math.inf if load > 0 else 0.0

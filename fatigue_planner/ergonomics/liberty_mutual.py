"""The Liberty Mutual equations for handling loads (Potvin et al. 2021, Ergonomics 64, 955-970).

The load in kg that half of the men or women find acceptable for 8 h is a reference load times a factor for each of the
hands' reach or height, the way and the frequency; loads are normal with a coefficient of variation. m and 1/min.
"""

import math
from typing import Literal, NamedTuple

from fatigue_planner.ergonomics.indicators.percent_capable import capable_percent
from fatigue_planner.human.anthropometry import Sex

Kind = Literal["lift", "lower", "push initial", "push sustained", "pull initial", "pull sustained", "carry"]
Coefficients = tuple[float, ...]

# Frequency: once in 8 h to 20 or 10 times a minute.
LEAST_PER_MINUTE = 1 / 480


class Equation(NamedTuple):
    """Reference load in kg, coefficient of variation, and the coefficients of the factors.

    reach      of H: a - H/b (lift, lower), or of the height V of the hands: a + V/b + V^2/c
    middle     of VRM: a + VRM/b + VRM^2/c (lift, lower)
    way        of DV (lift, lower) or DH: a + ln(way)/b, or a + way/b + way^2/c with `straight`
    frequency  a + ln(F)/b + ln(F)^2/c
    """

    load_kg: float
    variation: float
    reach: Coefficients
    way: Coefficients
    frequency: Coefficients
    middle: Coefficients = ()
    straight: bool = False

    def median_kg(self, hands_m: float, way_m: float, per_minute: float, middle_m: float = 0.0) -> float:
        """The load that half of the people find acceptable; hands_m: H of a lift, else V."""
        often = math.log(per_minute)
        along = way_m if self.straight else math.log(way_m)
        factors = [_series(self.reach, hands_m), _series(self.way, along), _series(self.frequency, often)]
        if self.middle:
            factors.append(_series(self.middle, middle_m))
        return self.load_kg * math.prod(max(0.0, factor) for factor in factors)

    def capable_percent(self, load_kg: float, median_kg: float) -> float:
        """The share of people in % for whom a load is acceptable."""
        return float(capable_percent(load_kg, median_kg, self.variation)) if median_kg > 0 else 0.0


def _series(coefficients: Coefficients, value: float) -> float:
    """a + x/b + x^2/c."""
    constant, *divisors = coefficients
    return constant + sum(value**power / divisor for power, divisor in enumerate(divisors, 1))


_H_F, _VRM_F, _DV_F, _OFTEN_F = (1.2602, -0.7686), (0.9877, 13.69, -9.221), (0.8199, -7.696), (0.6767, -12.59, -228.2)
_H_M, _VRM_M, _DV_M = (1.3532, -0.7079), (0.7746, 1.912, -3.296), (0.8695, -10.62)
_V_FIRST_F, _DH_FIRST_F, _OFTEN_FIRST_F = (
    (-0.5304, 0.3361, -0.6915),
    (1.0286, -72.22, 9782),
    (0.7251, -13.19, -197.3),
)
_V_LATER_F, _DH_LATER_F, _OFTEN_LATER_F = (-0.6539, 0.2941, -0.5722), (1.0391, -52.91, 7975), (0.6086, -11.95, -304.4)
_DH_FIRST_M, _OFTEN_FIRST_M = (1.0790, -9.392), (0.6281, -13.07, -379.5)
_DH_LATER_M, _OFTEN_LATER_M = (1.1035, -7.170), (0.4896, -10.20, -403.9)
EQUATIONS: dict[tuple[Kind, Sex], Equation] = {
    ("lift", "female"): Equation(34.9, 0.260, _H_F, _DV_F, _OFTEN_F, _VRM_F),
    ("lift", "male"): Equation(82.6, 0.276, _H_M, _DV_M, (0.6259, -9.092, -125.0), _VRM_M),
    ("lower", "female"): Equation(37.0, 0.307, _H_F, _DV_F, _OFTEN_F, _VRM_F),
    ("lower", "male"): Equation(95.9, 0.304, _H_M, _DV_M, (0.5773, -10.80, -255.9), _VRM_M),
    ("push initial", "female"): Equation(36.9, 0.214, _V_FIRST_F, _DH_FIRST_F, _OFTEN_FIRST_F, straight=True),
    ("pull initial", "female"): Equation(36.9, 0.234, _V_FIRST_F, _DH_FIRST_F, _OFTEN_FIRST_F, straight=True),
    ("push sustained", "female"): Equation(25.5, 0.286, _V_LATER_F, _DH_LATER_F, _OFTEN_LATER_F, straight=True),
    ("pull sustained", "female"): Equation(25.5, 0.298, _V_LATER_F, _DH_LATER_F, _OFTEN_LATER_F, straight=True),
    ("push initial", "male"): Equation(70.3, 0.231, (1.2737, -1.335, 2.576), _DH_FIRST_M, _OFTEN_FIRST_M),
    ("push sustained", "male"): Equation(65.3, 0.267, (2.2940, -0.3345, 0.6887), _DH_LATER_M, _OFTEN_LATER_M),
    ("pull initial", "male"): Equation(69.8, 0.238, (1.7186, -0.6888, 2.025), _DH_FIRST_M, _OFTEN_FIRST_M),
    ("pull sustained", "male"): Equation(61.0, 0.257, (2.1977, -0.3850, 0.9047), _DH_LATER_M, _OFTEN_LATER_M),
    ("carry", "female"): Equation(28.6, 0.231, (1.1645, -4.437), (1.0101, -207.8), (0.6224, -16.33), straight=True),
    ("carry", "male"): Equation(74.9, 0.278, (1.5505, -1.417), (1.1172, -6.332), (0.5149, -7.958, -131.1)),
}
# What may be put in, least and most, by kind of handling and sex: reach H or height V, way, frequency, way a minute.
_ARM_REACH_M: dict[Sex, float] = {"female": 1.96, "male": 2.14}


class Limits(NamedTuple):
    """The least and the most of the inputs, and the most of the way per minute, m/min."""

    hands_m: tuple[float, float]
    way_m: tuple[float, float]
    most_per_minute: float
    most_speed_m_per_minute: float


def limits(kind: Kind, sex: Sex) -> Limits:
    """What the equations were made for."""
    female = sex == "female"
    if kind in ("lift", "lower"):
        return Limits((0.20, 0.68) if female else (0.25, 0.73), (0.25, _ARM_REACH_M[sex]), 20, 11)
    if kind == "carry":
        return Limits((0.71, 1.03) if female else (0.78, 1.10), (2.1, 10), 10, 29)
    return Limits((0.58, 1.33) if female else (0.63, 1.44), (2.1, 61), 10, 37)

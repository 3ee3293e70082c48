"""How tall and how heavy people are: percentiles of stature by sex, and the mass that goes with a stature.

A "5th percentile woman" is a percentile of stature. Her mass is the median of women of her stature: nobody is at the
same percentile in everything. Strength is an axis of its own (`strength_sets`).
"""

import math
from functools import cache
from statistics import NormalDist

import numpy as np
from pydantic import Field

from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.skeleton import DATA


class Spread(Settings):
    """Mean and standard deviation of a normal distribution."""

    mean: float = Field(gt=0, le=500, description="Mean, in the unit of the key.")
    sd: float = Field(gt=0, le=100, description="Standard deviation, in the unit of the key.")


class People(Settings):
    """Women or men of a population: stature and, if it is known, mass."""

    stature_m: Spread = Field(description="Stature without shoes, in m: mean and standard deviation.")
    mass_kg: Spread | None = Field(
        default=None,
        description="Body mass in kg: mean and standard deviation. Default: what ANSUR II says of people as tall.",
    )


class Population(Settings):
    """A population of the user's own."""

    female: People | None = Field(default=None, description="The women of the population.")
    male: People | None = Field(default=None, description="The men of the population.")

    def people(self, sex: Sex) -> People | None:
        """The women or the men; None if nothing is known of them."""
        return self.female if sex == "female" else self.male


class SurveyedStature(Settings):
    """Stature in cm as a survey prints it: mean, standard deviation, and percentiles, p1 for the first."""

    mean: float
    sd: float
    percentiles: dict[str, float]


class LogMass(Settings):
    """A regression of ln(mass / kg) on ln(stature / m)."""

    intercept: float
    slope: float
    residual_sd: float


class SurveyedPeople(Settings):
    """The women or the men of a survey; correlation: of stature and mass."""

    stature_cm: SurveyedStature
    mass_kg: Spread
    correlation: float
    log_mass: LogMass


class Survey(Settings):
    """A survey of data/populations.yaml."""

    source: str
    female: SurveyedPeople
    male: SurveyedPeople

    def people(self, sex: Sex) -> SurveyedPeople:
        """The women or the men."""
        return self.female if sex == "female" else self.male


@cache
def survey() -> Survey:
    """ANSUR II."""
    return load_data(DATA / "populations.yaml", dict[str, Survey])["ansur"]


def stature_m(percentile: float, sex: Sex, own: People | None = None) -> float:
    """The stature in m at a percentile, 0 to 100 without its ends: of `own` people, else of ANSUR II.

    ANSUR's percentiles are as printed; between them, and beyond the first and the last, its distribution is taken for
    normal piece by piece.
    """
    z = NormalDist().inv_cdf(percentile / 100)
    if own is not None:
        return own.stature_m.mean + z * own.stature_m.sd
    return _piecewise(z, *_printed(sex)) / 100


def percentile_of(stature: float, sex: Sex, own: People | None = None) -> float:
    """The percentile, 0 to 100, of a stature in m: the inverse of `stature_m`."""
    if own is not None:
        z = (stature - own.stature_m.mean) / own.stature_m.sd
    else:
        scores, statures = _printed(sex)
        z = _piecewise(stature * 100, statures, scores)
    return 100 * NormalDist().cdf(z)


def median_mass_kg(stature: float, sex: Sex, own: People | None = None) -> float:
    """The median mass in kg of people of a stature in m.

    Where the masses of `own` people are not known, as in ANSUR II; where they are, by ANSUR's correlation.
    """
    known = survey().people(sex)
    if own is None or own.mass_kg is None:
        return math.exp(known.log_mass.intercept + known.log_mass.slope * math.log(stature))
    z = (stature - own.stature_m.mean) / own.stature_m.sd
    return own.mass_kg.mean + known.correlation * own.mass_kg.sd * z


def _printed(sex: Sex) -> tuple[list[float], list[float]]:
    """Standard scores and statures in cm of ANSUR's percentiles."""
    printed = survey().people(sex).stature_cm.percentiles
    return [NormalDist().inv_cdf(int(name[1:]) / 100) for name in printed], list(printed.values())


def _piecewise(x: float, known_x: list[float], known_y: list[float]) -> float:
    """Linear between known points, and on beyond the first and the last with the slope of the piece that ends there."""
    index = int(np.clip(np.searchsorted(known_x, x), 1, len(known_x) - 1))
    (x0, x1), (y0, y1) = known_x[index - 1 : index + 1], known_y[index - 1 : index + 1]
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)

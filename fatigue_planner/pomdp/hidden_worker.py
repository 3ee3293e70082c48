"""The worker's parameters that may be hidden: rates of fatigue and recovery, and expertise (paper, section VI)."""

import itertools
import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from fatigue_planner.core.settings import Settings
from fatigue_planner.pomdp.fatigue_pomdp import Workers

Vector = NDArray[np.float64]
# Probabilities of values must sum to 1 within this.
ROUNDING = 1e-9
MAX_FACTOR = 1000


class Choice(Settings):
    """One of several values."""

    kind: Literal["choice"] = Field(description="One of several values.")
    values: tuple[Annotated[float, Field(ge=0, allow_inf_nan=True)], ...] = Field(
        min_length=1, max_length=1000, description="The values, in the unit of what is distributed."
    )
    probabilities: tuple[Annotated[float, Field(gt=0, le=1)], ...] = Field(
        min_length=1, max_length=1000, description="The probability of each value; their sum is 1."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.values) != len(self.probabilities):
            raise ValueError(f"{len(self.values)} values, but {len(self.probabilities)} probabilities")
        if abs(sum(self.probabilities) - 1) > ROUNDING:
            raise ValueError(f"probabilities sum to {sum(self.probabilities):.12g}, not to 1")
        return self

    def quantile(self, uniform: Vector) -> Vector:
        """The quantiles (inverse of the distribution function) at `uniform` in [0, 1]."""
        order = np.argsort(self.values)
        ends = np.cumsum(np.array(self.probabilities)[order])
        index = np.minimum(np.searchsorted(ends, uniform, side="right"), order.size - 1)
        return np.array(self.values)[order][index]

    def bounds(self) -> tuple[float, float]:
        """The smallest and the largest value the settings name."""
        return min(self.values), max(self.values)


class LogNormal(Settings):
    """A positive value whose logarithm is normal with standard deviation `sigma`."""

    kind: Literal["lognormal"] = Field(description="A positive value whose logarithm is normally distributed.")
    median: float = Field(gt=0, le=1e9, description="The median, in the unit of what is distributed.")
    sigma: float = Field(gt=0, le=10, description="Standard deviation of the natural logarithm, without unit.")

    def quantile(self, uniform: Vector) -> Vector:
        """The quantiles (inverse of the distribution function) at `uniform` in [0, 1]."""
        from scipy.special import ndtri  # noqa: PLC0415 - takes 0.2 s

        return np.asarray(self.median * np.exp(self.sigma * ndtri(uniform)))

    def bounds(self) -> tuple[float, float]:
        """The smallest and the largest value the settings name."""
        return self.median, self.median


class Uniform(Settings):
    """Any value between two limits."""

    kind: Literal["uniform"] = Field(description="Any value between two limits, all equally likely.")
    first: float = Field(alias="from", ge=0, le=1e9, description="Lower end, in the unit of what is distributed.")
    last: float = Field(alias="to", ge=0, le=1e9, description="Upper end, in the unit of what is distributed.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.first >= self.last:
            raise ValueError(f"from ({self.first:g}) should be less than to ({self.last:g})")
        return self

    def quantile(self, uniform: Vector) -> Vector:
        """The quantiles (inverse of the distribution function) at `uniform` in [0, 1]."""
        return np.asarray(self.first + (self.last - self.first) * uniform)

    def bounds(self) -> tuple[float, float]:
        """The smallest and the largest value the settings name."""
        return self.first, self.last


Distribution = Annotated[Choice | LogNormal | Uniform, Field(discriminator="kind")]


def _usable_factor(distribution: Choice | LogNormal | Uniform) -> Choice | LogNormal | Uniform:
    smallest, largest = distribution.bounds()
    if smallest <= 0 or largest > MAX_FACTOR:
        wrong = smallest if smallest <= 0 else largest
        raise ValueError(f"{wrong:g} is not a usable factor: it must be above 0 and at most {MAX_FACTOR}")
    return distribution


Factor = Annotated[Distribution, AfterValidator(_usable_factor)]
KNOWN_FACTOR = Choice(kind="choice", values=(1.0,), probabilities=(1.0,))


class HiddenWorker(Settings):
    """Independent distributions of the hidden parameters; those left out are known."""

    fatigue_rate_factor: Factor = Field(
        default=KNOWN_FACTOR, description="Distribution of a factor of all fatigue rates k, without unit."
    )
    recovery_rate_factor: Factor = Field(
        default=KNOWN_FACTOR, description="Distribution of a factor of all recovery rates R, without unit."
    )
    expertise: Distribution | None = Field(
        default=None,
        description="Distribution of beta of Eq. 4, in 1 / cost; left out, it is known and the condition gives it.",
    )

    def distributions(self, expertise: float | None) -> tuple[Distribution, Distribution, Distribution]:
        """The distributions in the order of Workers; a known expertise is a choice among a single value."""
        if self.expertise is None:
            assert expertise is not None
            known = Choice(kind="choice", values=(expertise,), probabilities=(1.0,))
            return self.fatigue_rate_factor, self.recovery_rate_factor, known
        return self.fatigue_rate_factor, self.recovery_rate_factor, self.expertise


class WorkerPrior:
    """The distribution of a condition's worker."""

    def __init__(self, hidden: HiddenWorker, expertise: float | None) -> None:
        self.distributions = hidden.distributions(expertise)

    @property
    def size(self) -> float:
        """The number of possible workers; infinite where a distribution is continuous."""
        return math.prod(len(d.values) if isinstance(d, Choice) else math.inf for d in self.distributions)

    def hidden(self) -> list[int]:
        """The indices of those parameters of Workers that are not known."""
        return [i for i, d in enumerate(self.distributions) if not (isinstance(d, Choice) and len(d.values) == 1)]

    def support(self) -> tuple[Workers, Vector]:
        """All possible workers and their probabilities, where their number is finite."""
        choices = [d for d in self.distributions if isinstance(d, Choice)]
        assert len(choices) == len(self.distributions)
        combined = list(itertools.product(*(zip(c.values, c.probabilities, strict=True) for c in choices)))
        values = np.array([[value for value, _ in row] for row in combined])
        weights = np.array([np.prod([p for _, p in row]) for row in combined])
        return Workers(*values.T.copy()), weights / weights.sum()

    def at(self, uniforms: NDArray[np.float64]) -> Workers:
        """The workers at quantiles (n, 3) of the distributions; 0.5 is the median, the average worker."""
        columns = zip(self.distributions, np.asarray(uniforms).T, strict=True)
        return Workers(*(distribution.quantile(column) for distribution, column in columns))

"""What may be hidden of a worker: the speed of tiring and recovering, and the expertise (paper, section VI)."""

import itertools
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.pomdp.fatigue_model import Workers
from fatigue_planner.settings import Settings

Vector = NDArray[np.float64]
# Chances of values must sum to 1 within this.
ROUNDING = 1e-9


class Choice(Settings):
    """One of some values."""

    kind: Literal["choice"]
    values: tuple[Annotated[float, Field(ge=0, allow_inf_nan=True)], ...] = Field(min_length=1)
    probabilities: tuple[Annotated[float, Field(gt=0, le=1)], ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.values) != len(self.probabilities):
            raise ValueError(f"{len(self.values)} values, but {len(self.probabilities)} probabilities")
        if abs(sum(self.probabilities) - 1) > ROUNDING:
            raise ValueError(f"probabilities sum to {sum(self.probabilities):g}, not to 1")
        return self

    def quantile(self, uniform: Vector) -> Vector:
        """The values at these shares of the distribution, in the order of the values' size."""
        order = np.argsort(self.values)
        ends = np.cumsum(np.array(self.probabilities)[order])
        place = np.minimum(np.searchsorted(ends - ROUNDING, uniform), order.size - 1)
        return np.array(self.values)[order][place]


class LogNormal(Settings):
    """A positive value whose logarithm is normal with standard deviation `sigma`."""

    kind: Literal["lognormal"]
    median: float = Field(gt=0)
    sigma: float = Field(gt=0)

    def quantile(self, uniform: Vector) -> Vector:
        """The values at these shares of the distribution."""
        from scipy.special import ndtri  # noqa: PLC0415 - takes 0.2 s

        return np.asarray(self.median * np.exp(self.sigma * ndtri(uniform)))


class Uniform(Settings):
    """Any value between two."""

    kind: Literal["uniform"]
    first: float = Field(alias="from", ge=0)
    last: float = Field(alias="to", ge=0)

    def quantile(self, uniform: Vector) -> Vector:
        """The values at these shares of the distribution."""
        return np.asarray(self.first + (self.last - self.first) * uniform)


Distribution = Annotated[Choice | LogNormal | Uniform, Field(discriminator="kind")]
KNOWN_FACTOR = Choice(kind="choice", values=(1.0,), probabilities=(1.0,))


class HiddenWorker(Settings):
    """Independent distributions of what is hidden; what is left out is known.

    fatigue_rate_factor, recovery_rate_factor: multiply all rates k and R of the experiment.
    expertise: beta of Eq. 4; where it is left out, the condition gives it.
    """

    fatigue_rate_factor: Distribution = KNOWN_FACTOR
    recovery_rate_factor: Distribution = KNOWN_FACTOR
    expertise: Distribution | None = None

    def distributions(self, expertise: float | None) -> tuple[Distribution, Distribution, Distribution]:
        """The three distributions; a known expertise is a choice of one."""
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
    def is_finite(self) -> bool:
        """Whether finitely many workers may be meant."""
        return all(isinstance(distribution, Choice) for distribution in self.distributions)

    def support(self) -> tuple[Workers, Vector]:
        """All workers that may be meant, and their probabilities, where they are finitely many."""
        choices = [d for d in self.distributions if isinstance(d, Choice)]
        assert len(choices) == len(self.distributions)
        combined = list(itertools.product(*(zip(c.values, c.probabilities, strict=True) for c in choices)))
        values = np.array([[value for value, _ in row] for row in combined])
        weights = np.array([np.prod([p for _, p in row]) for row in combined])
        return Workers(*values.T.copy()), weights / weights.sum()

    def at(self, uniforms: NDArray[np.float64]) -> Workers:
        """The workers at shares (n, 3) of the three distributions; 0.5 is the average worker."""
        columns = zip(self.distributions, np.asarray(uniforms).T, strict=True)
        return Workers(*(distribution.quantile(column) for distribution, column in columns))

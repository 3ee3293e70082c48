"""The content of a study file."""

from typing import Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Name, Seed, Settings
from fatigue_planner.planners.registry import AnyPolicy
from fatigue_planner.study.sensitivity.factors import AnyFactor

# Every level of every factor is checked before anything is run.
MAX_FACTORS = 50


class Grid(Settings):
    """The runs at every point; what is left out is as in the base experiment."""

    conditions: tuple[Name, ...] | None = Field(default=None, min_length=1)
    n_cycles: tuple[int, ...] | None = Field(default=None, min_length=1)
    policies: tuple[Name, ...] | None = Field(default=None, min_length=1)
    # Policies that the base experiment does not have.
    further_policies: dict[Name, AnyPolicy] = Field(default_factory=dict)
    trials: int | None = Field(default=None, ge=1, le=1_000_000)


class Headline(Settings):
    """The comparison that sentences and figures speak of; the tables hold all."""

    planner: Name
    condition: Name
    n_cycles: int


class SpaceFilling(Settings):
    """All factors at once: a scrambled Sobol sequence, which is even only in powers of two."""

    points: int = Field(ge=2, le=65_536)
    seed: Seed

    @model_validator(mode="after")
    def _check_points(self) -> Self:
        if self.points & (self.points - 1):
            raise ValueError(f"points = {self.points}: should be a power of two, as Sobol's sequence is even only then")
        return self


class StudySettings(Settings):
    """How the comparison of planners with baselines depends on choices that could have been made otherwise.

    base: the experiment file, claims: a file of claims about it, relative to the study's; planners are compared with
    baselines.
    """

    name: Name
    base: str = Field(min_length=1, max_length=1000)
    grid: Grid
    planners: tuple[Name, ...] = Field(min_length=1)
    baselines: tuple[Name, ...] = Field(min_length=1)
    headline: Headline
    space_filling: SpaceFilling
    claims: str | None = Field(default=None, min_length=1, max_length=1000)
    factors: dict[Name, AnyFactor] = Field(min_length=1, max_length=MAX_FACTORS)

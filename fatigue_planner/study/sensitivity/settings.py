"""The content of a study file."""

from typing import Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Name, Seed, Settings
from fatigue_planner.planners.registry import AnyPolicy
from fatigue_planner.study.sensitivity.factors import AnyFactor

# Every level of every factor is checked before anything is run.
MAX_FACTORS = 50


class Grid(Settings):
    """The runs at every point; the base experiment gives what is left out."""

    conditions: tuple[Name, ...] | None = Field(
        default=None, min_length=1, description="Conditions of the base experiment; left out, all."
    )
    n_cycles: tuple[int, ...] | None = Field(
        default=None, min_length=1, description="Numbers of cycles; left out, those of the base experiment."
    )
    policies: tuple[Name, ...] | None = Field(
        default=None, min_length=1, description="Policies of the base experiment; left out, all."
    )
    further_policies: dict[Name, AnyPolicy] = Field(default_factory=dict, description="Additional policies, by name.")
    trials: int | None = Field(
        default=None, ge=1, le=1_000_000, description="Trials per cell; left out, as many as in the base experiment."
    )


class Headline(Settings):
    """The comparison that sentences and figures are about; the tables contain all comparisons."""

    planner: Name = Field(description="One of the planners.")
    condition: Name = Field(description="One of the grid's conditions.")
    n_cycles: int = Field(description="One of the grid's numbers of cycles.")


class SpaceFilling(Settings):
    """All factors at once: a scrambled Sobol sequence, which is balanced only for powers of two."""

    points: int = Field(ge=2, le=65_536, description="Number of points, a power of two.")
    seed: Seed = Field(description="Seed of the scrambling.")

    @model_validator(mode="after")
    def _check_points(self) -> Self:
        if self.points & (self.points - 1):
            raise ValueError(
                f"points = {self.points}: should be a power of two, as Sobol's sequence is balanced only then"
            )
        return self


class StudySettings(Settings):
    """A study of how the comparison of planners with baselines depends on choices that could have been different."""

    name: Name = Field(description="Name of the study; results go to a folder of this name.")
    base: str = Field(
        min_length=1,
        max_length=1000,
        description="The base experiment's file, relative to the folder of this file, or the name of one that ships.",
    )
    grid: Grid = Field(description="Which of the base experiment's runs are made at every point.")
    planners: tuple[Name, ...] = Field(min_length=1, description="Policies that are compared with the baselines.")
    baselines: tuple[Name, ...] = Field(min_length=1, description="Policies that the planners are compared with.")
    headline: Headline = Field(description="The comparison that sentences and figures are about.")
    space_filling: SpaceFilling | None = Field(
        default=None,
        description="Points at which all factors change at once (Sobol's sequence); left out, they change one at a "
        "time only.",
    )
    claims: str | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="A file of claims about the base experiment that are judged at every point, relative to the folder "
        "of this file, or the name of one that ships.",
    )
    factors: dict[Name, AnyFactor] = Field(
        min_length=1, max_length=MAX_FACTORS, description="Choices that could have been different, by name."
    )

"""How a worker tires: the law, the rates and the threshold of every entry (paper, sections III-B and IV-B)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.core.settings import Settings
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.fatigue.laws.law import FatigueLaw, Rates
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.laws.registry import AnyLaw
from fatigue_planner.fatigue.rates import MAX_PATH_LENGTH, Multiplier, Rate, rate_file, rates_by_entry
from fatigue_planner.fatigue.strength_by_angle import StrengthByAngle, strength_by_angle
from fatigue_planner.human.joint_data import MaximumTorque

Vector = NDArray[np.float64]

# The paper's k and R, the same for all joints (section IV-B).
PAPER_RATES = {"fatigue_rate_per_s": 0.01667, "recovery_rate_per_s": 0.04}
# The set of rates of a law where an experiment names none.
USUAL_RATES = {"3cc_r": "frey_law_2012"}

Threshold = Annotated[float, Field(ge=0, lt=1)]


class JointFatigue(Settings):
    """The rates and threshold of a joint that differ from those of all joints."""

    fatigue_rate_per_s: Rate | None = Field(
        default=None, description="Fatigue rate k (3cc_r: F) of the joint in 1/s; left out, that of all joints."
    )
    recovery_rate_per_s: Rate | None = Field(
        default=None, description="Recovery rate R of the joint in 1/s; left out, that of all joints."
    )
    rest_multiplier: Multiplier | None = Field(
        default=None,
        description="Factor r, without unit, by which the joint recovers faster at rest, in laws that have one "
        "(3cc_r); left out, that of all joints.",
    )
    threshold: Threshold | None = Field(
        default=None,
        description="Torque below which the joint does not tire, as a fraction of its strength; left out, that of all.",
    )


def _usual_rates(settings: Mapping[str, Any]) -> str | None:
    law = settings.get("law")
    return USUAL_RATES.get(law.rates_of) if isinstance(law, FatigueLaw) else None


def _paper_rate(key: str, settings: Mapping[str, Any]) -> float | None:
    return PAPER_RATES[key] if settings.get("rates") is None else None


class FatigueSettings(Settings):
    """The law, and the rates and threshold of every joint.

    `rates` are per joint; what is given for all joints replaces them, and what `joints` gives replaces that.
    A joint is named as in `entry_indices`. Where two names mean the same entry, the later one counts.
    """

    law: AnyLaw = Field(
        default=MaLaw(kind="ma"), description="Fatigue law. Default: the paper's Eq. 2 (ma); 3cc_r is another one."
    )
    rates: Annotated[str, Field(min_length=1, max_length=MAX_PATH_LENGTH)] | None = Field(
        default_factory=_usual_rates,
        description="Rates per joint in 1/s: the name of a set that ships with fatplan (frey_law_avin_2010 for ma, "
        "frey_law_2012 for 3cc_r), or a YAML file. Default: none for ma, frey_law_2012 for 3cc_r.",
    )
    fatigue_rate_per_s: Rate | None = Field(
        default_factory=lambda settings: _paper_rate("fatigue_rate_per_s", settings),
        description="Fatigue rate k (3cc_r: F) of all joints in 1/s. Default: those of `rates`, or else the paper's "
        "0.01667, which is 1 per minute (section IV-B).",
    )
    recovery_rate_per_s: Rate | None = Field(
        default_factory=lambda settings: _paper_rate("recovery_rate_per_s", settings),
        description="Recovery rate R of all joints in 1/s. Default: those of `rates`, or else the paper's 0.04 "
        "(section IV-B).",
    )
    rest_multiplier: Multiplier | None = Field(
        default=None,
        description="Factor r, without unit, by which all joints recover faster at rest, in laws that have one "
        "(3cc_r). Default: those of `rates`.",
    )
    threshold: Threshold = Field(
        default=0.1,
        description="Torque up to which a joint rests, as a fraction of its strength; the paper's is 0.1 "
        "(section IV-B).",
    )
    strength_by_angle: tuple[Annotated[str, Field(min_length=1, max_length=MAX_PATH_LENGTH)], ...] = Field(
        default=(),
        max_length=100,
        description="Sources by which strength depends on the joint's angle: names that ship with fatplan "
        "(medx_lumbar, kamon_arm, anderson_leg), or YAML files; what none has is constant. Default: none, "
        "as in the paper.",
    )
    joints: dict[str, JointFatigue] = Field(
        default_factory=dict,
        description="Exceptions: values that differ at a joint, by entry (lumbar_flexion:negative), degree of freedom "
        "(lumbar_flexion), joint (back), or any of them without its side.",
    )

    @model_validator(mode="after")
    def _check_rest_multiplier(self) -> Self:
        """A factor that the law would not use."""
        named = {"rest_multiplier": self.rest_multiplier}
        named |= {f"joints.{name}.rest_multiplier": own.rest_multiplier for name, own in self.joints.items()}
        given = [key for key, value in named.items() if value is not None]
        if given and not self.law.rests_faster:
            raise ValueError(f"{given[0]}: the law {self.law.kind} has none; 3cc_r has")
        return self


@dataclass(frozen=True)
class FatigueParameters(Rates):
    """How a worker tires: the law, its rates and the strength tau_max in N.m, (78,).

    by_angle: how the strength depends on the angle; None where it is constant.
    """

    maximum_torque_nm: Vector
    law: FatigueLaw
    by_angle: StrengthByAngle | None


def fatigue_parameters(settings: FatigueSettings, strength: MaximumTorque) -> FatigueParameters:
    """The parameters of a worker with these strengths. Raises DataFileError for unknown joints, rates and curves."""
    values = _set_of_rates(settings) | {"threshold": np.full(len(ENTRIES), settings.threshold)}
    for key in PAPER_RATES.keys() | {"rest_multiplier"}:
        if (common := getattr(settings, key)) is not None:
            values[key] = np.full(len(ENTRIES), common)
    for name, own in settings.joints.items():
        indices = entry_indices(name, f"fatigue.joints.{name}")
        for key, value in own.model_dump(exclude_none=True).items():
            values[key][indices] = value
    return FatigueParameters(
        fatigue_rate=values["fatigue_rate_per_s"],
        recovery_rate=values["recovery_rate_per_s"],
        rest_multiplier=values["rest_multiplier"],
        threshold=values["threshold"],
        maximum_torque_nm=np.concatenate(strength.vectors()),
        law=settings.law,
        by_angle=strength_by_angle(settings.strength_by_angle),
    )


def _set_of_rates(settings: FatigueSettings) -> dict[str, Vector]:
    """The rates by key that the named set has for the law; without one, only the multiplier 1."""
    if settings.rates is None:
        if settings.fatigue_rate_per_s is None or settings.recovery_rate_per_s is None:
            raise DataFileError("fatigue.rates: is missing; or give fatigue_rate_per_s and recovery_rate_per_s")
        return {"rest_multiplier": np.ones(len(ENTRIES))}
    try:
        content = rate_file(settings.rates)
        if content.law != settings.law.rates_of:
            raise DataFileError(f"are rates of the law {content.law}; the law is {settings.law.kind}")
        return rates_by_entry(content, settings.rates)
    except DataFileError as error:
        raise DataFileError(f"fatigue.rates = {settings.rates!r}: {error}") from error

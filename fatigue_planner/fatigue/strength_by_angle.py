"""Strength that depends on the joint's angle: curves from data files, one file per source."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

CURVES = Path(__file__).parent / "data" / "strength_by_angle"
MAX_PATH_LENGTH = 1000
# Whose torques the curves give; other workers keep their ratio to him, entry by entry.
REFERENCE_SET = "average_man"
# m g h of the average man, 75 kg and 1.75 m, in N.m: the unit of Anderson's coefficients.
REFERENCE_MGH_NM = 75 * 9.81 * 1.75
# A cosine falls to 0 outside the angles that were measured; it counts as at least this fraction of its peak (assumed).
LOWEST = 0.2


class Curve(Settings):
    """The torque of the average man at each angle of a degree of freedom, in one direction."""

    kind: str
    source: str

    @abstractmethod
    def torque_nm(self, angle_rad: Vector) -> Vector:
        """The torque at angles (T,), in N.m."""


class Points(Curve):
    """Measured torques; straight lines between them, and the outermost ones beyond."""

    kind: Literal["points"]
    angles_deg: tuple[float, ...] = Field(min_length=2)
    torques_nm: tuple[Annotated[float, Field(gt=0, le=10_000)], ...]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.angles_deg) != len(self.torques_nm) or sorted(set(self.angles_deg)) != list(self.angles_deg):
            raise ValueError("needs rising angles, and a torque for each")
        return self

    def torque_nm(self, angle_rad: Vector) -> Vector:
        """See Curve.torque_nm."""
        return np.interp(np.degrees(angle_rad), self.angles_deg, self.torques_nm)


class Cosine(Curve):
    """Anderson, Madigan & Nussbaum (2007) at rest: c1 m g h cos(c2 (angle - c3)), angles in rad."""

    kind: Literal["cosine"]
    c1: float = Field(gt=0, le=10)
    c2: float = Field(gt=0, le=10)
    c3: float = Field(ge=-4, le=4)

    def torque_nm(self, angle_rad: Vector) -> Vector:
        """See Curve.torque_nm."""
        return self.c1 * REFERENCE_MGH_NM * np.maximum(np.cos(self.c2 * (angle_rad - self.c3)), LOWEST)


class CurveFile(Settings):
    """The curves of a source, by entry (`elbow_flexion:positive`), with or without a side."""

    population: str
    curves: dict[str, Annotated[Points | Cosine, Field(discriminator="kind")]]


@dataclass(frozen=True)
class StrengthByAngle:
    """How the strength of some entries depends on the angle: their curves, by the index of the entry."""

    curves: dict[int, Curve]

    def factors(self, angle_rad: Matrix) -> Matrix:
        """By what the constant strengths are multiplied at joint angles (T, 39), (T, 78); 1 where there is no curve."""
        reference = np.concatenate(maximum_torque(REFERENCE_SET).vectors())
        factors = np.ones((len(angle_rad), len(ENTRIES)))
        for entry, curve in self.curves.items():
            factors[:, entry] = curve.torque_nm(angle_rad[:, entry % len(DEGREES_OF_FREEDOM)]) / reference[entry]
        return factors


def shipped_curves() -> tuple[str, ...]:
    """Names of the sources that ship with the package, in alphabetical order."""
    return tuple(sorted(path.stem for path in CURVES.glob("*.yaml")))


def strength_by_angle(names: Sequence[str]) -> StrengthByAngle | None:
    """The curves of sources, by name or path; a later one counts where two have the same entry. None without sources.

    Raises DataFileError, naming the source, for one that is unknown, unreadable or has an unknown entry.
    """
    curves: dict[int, Curve] = {}
    for name in names:
        path = CURVES / f"{name}.yaml" if name in shipped_curves() else Path(name)
        key = f"fatigue.strength_by_angle: {name!r}"
        try:
            found = path.is_file()
        except (OSError, ValueError):  # the system takes no such name
            found = False
        if not found:
            known = ", ".join(shipped_curves())
            raise DataFileError(f"{key} is neither one of {known} nor a file ({path.absolute()}).")
        for entry, curve in load_data(path, CurveFile).curves.items():
            if ":" not in entry:
                raise DataFileError(f"{key}: curves.{entry} needs a direction, :positive or :negative.")
            curves |= dict.fromkeys(entry_indices(entry, f"{key}: curves.{entry}"), curve)
    return StrengthByAngle(curves) if names else None

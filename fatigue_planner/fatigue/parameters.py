"""Parameters of the fatigue model (paper, sections III-B and IV-B)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.errors import DataFileError
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, without_side
from fatigue_planner.settings import Settings

Vector = NDArray[np.float64]

DIRECTIONS = ("positive", "negative")
# The 2N entries of the fatigue state: all agonists (positive torque), then all antagonists.
ENTRIES = tuple(f"{name}:{direction}" for direction in DIRECTIONS for name in DEGREES_OF_FREEDOM)


class FatigueSettings(Settings):
    """Rates and threshold of Eq. 2, the same for every joint."""

    fatigue_rate_per_s: float = Field(gt=0)
    recovery_rate_per_s: float = Field(gt=0)
    threshold: float = Field(ge=0, lt=1)


@dataclass(frozen=True)
class FatigueParameters:
    """Eq. 2's parameters per entry, each (78,): k and R in 1/s, alpha, tau_max in N.m."""

    fatigue_rate: Vector
    recovery_rate: Vector
    threshold: Vector
    maximum_torque_nm: Vector


def fatigue_parameters(settings: FatigueSettings, strength: str) -> FatigueParameters:
    """The parameters of a worker with a strength set. Raises DataFileError for an unknown set."""
    ones = np.ones(len(ENTRIES))
    return FatigueParameters(
        fatigue_rate=settings.fatigue_rate_per_s * ones,
        recovery_rate=settings.recovery_rate_per_s * ones,
        threshold=settings.threshold * ones,
        maximum_torque_nm=np.concatenate(maximum_torques(strength)),
    )


def fatigue_state(levels: dict[str, float]) -> Vector:
    """A fatigue state (78,) from levels by name; what is not named is 0.

    A name is an entry (`lumbar_flexion:negative`), a degree of freedom (both its entries), or either
    without its side (both sides). Raises DataFileError for an unknown name.
    """
    state = np.zeros(len(ENTRIES))
    for name, level in levels.items():
        places = [i for i, entry in enumerate(ENTRIES) if name in _names_of(entry)]
        if not places:
            raise DataFileError(f"fatigue: unknown joint {name!r}; known: {', '.join(DEGREES_OF_FREEDOM)}")
        state[places] = level
    return state


def _names_of(entry: str) -> set[str]:
    freedom = entry.split(":", maxsplit=1)[0]
    return {entry, freedom, without_side(entry), without_side(freedom)}

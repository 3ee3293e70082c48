"""The fatigue state: its entries, their parameters (paper, sections III-B and IV-B), and joints they belong to."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.core.settings import Settings
from fatigue_planner.human.joint_data import MaximumTorque, known_names
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, JOINTS, without_side

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

DIRECTIONS = ("positive", "negative")
# The 2N entries of the fatigue state: all agonists (positive torque), then all antagonists.
ENTRIES = tuple(f"{name}:{direction}" for direction in DIRECTIONS for name in DEGREES_OF_FREEDOM)
# Joints of the spine that everyday language takes as one.
JOINT_GROUP_OF = {"lumbar": "back", "thoracic": "back", "head": "neck"}

# In 1/s: nobody tires or recovers within a hundredth of a second.
Rate = Annotated[float, Field(gt=0, le=100)]


class JointFatigue(Settings):
    """The rates and threshold of a joint that differ from those of all joints."""

    fatigue_rate_per_s: Rate | None = Field(
        default=None, description="Fatigue rate k of the joint in 1/s; left out, that of all joints."
    )
    recovery_rate_per_s: Rate | None = Field(
        default=None, description="Recovery rate R of the joint in 1/s; left out, that of all joints."
    )
    threshold: float | None = Field(
        default=None,
        ge=0,
        lt=1,
        description="Torque below which the joint does not tire, as a fraction of its strength; left out, that of all.",
    )


class FatigueSettings(Settings):
    """Rates and threshold of Eq. 2, the same for every joint except those under `joints`.

    A joint is named as in an initial belief: an entry, a degree of freedom, or either without its side.
    Where two names mean the same entry, the later one counts.
    """

    fatigue_rate_per_s: Rate = Field(
        default=0.01667, description="Fatigue rate k of Eq. 2 in 1/s; the paper's is 1 per minute (section IV-B)."
    )
    recovery_rate_per_s: Rate = Field(
        default=0.04, description="Recovery rate R of Eq. 2 in 1/s; the paper's is 0.04 (section IV-B)."
    )
    threshold: float = Field(
        default=0.1,
        ge=0,
        lt=1,
        description="Torque below which a joint does not tire, as a fraction of its strength; the paper's is 0.1 "
        "(section IV-B).",
    )
    joints: dict[str, JointFatigue] = Field(
        default_factory=dict,
        description="Exceptions: values that differ at a joint, by entry (lumbar_flexion:negative), degree of freedom "
        "(lumbar_flexion), or either without its side.",
    )


@dataclass(frozen=True)
class FatigueParameters:
    """Eq. 2's parameters per entry, each (78,): k and R in 1/s, alpha, tau_max in N.m."""

    fatigue_rate: Vector
    recovery_rate: Vector
    threshold: Vector
    maximum_torque_nm: Vector


def fatigue_parameters(settings: FatigueSettings, strength: MaximumTorque) -> FatigueParameters:
    """The parameters of a worker with these strengths. Raises DataFileError for an unknown joint."""
    ones = np.ones(len(ENTRIES))
    rates = {
        "fatigue_rate_per_s": settings.fatigue_rate_per_s * ones,
        "recovery_rate_per_s": settings.recovery_rate_per_s * ones,
        "threshold": settings.threshold * ones,
    }
    for name, own in settings.joints.items():
        indices = _indices(name, f"fatigue.joints.{name}")
        for key, value in own.model_dump(exclude_none=True).items():
            rates[key][indices] = value
    return FatigueParameters(
        fatigue_rate=rates["fatigue_rate_per_s"],
        recovery_rate=rates["recovery_rate_per_s"],
        threshold=rates["threshold"],
        maximum_torque_nm=np.concatenate(strength.vectors()),
    )


def fatigue_state(levels: dict[str, float]) -> Vector:
    """A fatigue state (78,) from levels by name; all other entries are 0.

    A name is an entry (`lumbar_flexion:negative`), a degree of freedom (both its entries), or either
    without its side (both sides). Raises DataFileError for an unknown name.
    """
    state = np.zeros(len(ENTRIES))
    for name, level in levels.items():
        state[_indices(name, "fatigue")] = level
    return state


def _indices(name: str, key: str) -> list[int]:
    """The indices of the entries that a name means. Raises DataFileError, naming the key, if there are none."""
    indices = [i for i, entry in enumerate(ENTRIES) if name in _names_of(entry)]
    if not indices:
        raise DataFileError(f"{key}: unknown joint {name!r}{known_names(name)}")
    return indices


def _freedom_of(entry: str) -> str:
    return entry.split(":", maxsplit=1)[0]


def _names_of(entry: str) -> set[str]:
    freedom = _freedom_of(entry)
    return {entry, freedom, without_side(entry), without_side(freedom)}


def joint_load_fractions(fraction: Vector) -> dict[str, float]:
    """The largest fraction of strength in any degree of freedom and direction of each joint; fraction (78,)."""
    by_entry = dict(zip(ENTRIES, fraction, strict=True))
    return {
        joint.name: max(
            by_entry[f"{dof.name}:{direction}"] for dof in joint.degrees_of_freedom for direction in DIRECTIONS
        )
        for joint in JOINTS
    }


def _groups() -> dict[str, NDArray[np.intp]]:
    names: dict[str, list[str]] = {}
    for joint in JOINTS:
        group = names.setdefault(JOINT_GROUP_OF.get(joint.name, joint.name), [])
        group += [dof.name for dof in joint.degrees_of_freedom]
    freedom_of = np.array([_freedom_of(entry) for entry in ENTRIES])
    return {group: np.flatnonzero(np.isin(freedom_of, freedoms)) for group, freedoms in names.items()}


JOINT_GROUPS = _groups()


def highest_fatigue(fatigue: Array) -> dict[str, Array]:
    """The highest fatigue of any entry, by group (...), from fatigue (..., 78)."""
    return {group: fatigue[..., indices].max(axis=-1) for group, indices in JOINT_GROUPS.items()}

"""The 2N entries of the fatigue state, the names that mean them, and the joints they belong to."""

import difflib

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.human.joint_data import known_names
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, JOINTS, without_side

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

DIRECTIONS = ("positive", "negative")
# The 2N entries of the fatigue state: all agonists (positive torque), then all antagonists.
ENTRIES = tuple(f"{name}:{direction}" for direction in DIRECTIONS for name in DEGREES_OF_FREEDOM)
# Joints of the spine that everyday language takes as one.
JOINT_GROUP_OF = {"lumbar": "back", "thoracic": "back", "head": "neck"}


def _freedom_of(entry: str) -> str:
    return entry.split(":", maxsplit=1)[0]


def _groups() -> dict[str, NDArray[np.intp]]:
    names: dict[str, list[str]] = {}
    for joint in JOINTS:
        group = names.setdefault(JOINT_GROUP_OF.get(joint.name, joint.name), [])
        group += [dof.name for dof in joint.degrees_of_freedom]
    freedom_of = np.array([_freedom_of(entry) for entry in ENTRIES])
    return {group: np.flatnonzero(np.isin(freedom_of, freedoms)) for group, freedoms in names.items()}


JOINT_GROUPS = _groups()
GROUP_OF = {ENTRIES[index]: group for group, indices in JOINT_GROUPS.items() for index in indices}
# What names all entries.
ALL = "all"


def _indices_by_name() -> dict[str, list[int]]:
    """The indices of the entries that each name means."""
    found: dict[str, list[int]] = {}
    for index, entry in enumerate(ENTRIES):
        names = (entry, _freedom_of(entry), GROUP_OF[entry])
        for name in {*names, *map(without_side, names), ALL}:
            found.setdefault(name, []).append(index)
    return found


_INDICES = _indices_by_name()


def entry_indices(name: str, key: str) -> list[int]:
    """The indices of the entries that a name means.

    A name is an entry (`lumbar_flexion:negative`), a degree of freedom (both its entries), a group of joints (`back`),
    any of these without its side (both sides), or `all`. Raises DataFileError, naming the key, if it means none.
    """
    if name not in _INDICES:
        groups = sorted(set(map(without_side, JOINT_GROUPS)))
        if close := difflib.get_close_matches(name, [*JOINT_GROUPS, *groups], n=1):
            raise DataFileError(
                f"{key}: unknown joint {name!r}; did you mean {close[0]!r}? Joints: {', '.join(groups)}"
            )
        raise DataFileError(f"{key}: unknown joint {name!r}{known_names(name)}; joints: {', '.join(groups)}")
    return _INDICES[name].copy()


def fatigue_state(levels: dict[str, float]) -> Vector:
    """A fatigue state (78,) from levels by name (see `entry_indices`); all other entries are 0.

    Raises DataFileError for an unknown name.
    """
    state = np.zeros(len(ENTRIES))
    for name, level in levels.items():
        state[entry_indices(name, "fatigue")] = level
    return state


def joint_load_fractions(fraction: Vector) -> dict[str, float]:
    """The largest fraction of strength in any degree of freedom and direction of each joint; fraction (78,)."""
    by_entry = dict(zip(ENTRIES, fraction, strict=True))
    return {
        joint.name: max(
            by_entry[f"{dof.name}:{direction}"] for dof in joint.degrees_of_freedom for direction in DIRECTIONS
        )
        for joint in JOINTS
    }


def highest_fatigue(fatigue: Array) -> dict[str, Array]:
    """The highest fatigue of any entry, by group (...), from fatigue (..., 78)."""
    return {group: fatigue[..., indices].max(axis=-1) for group, indices in JOINT_GROUPS.items()}

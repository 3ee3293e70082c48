"""Joints as people speak of them: the entries of a fatigue state by back, neck, and every joint of each limb."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.parameters import ENTRIES
from fatigue_planner.human.skeleton import JOINTS

Array = NDArray[np.float64]

# Joints of the spine that are one in everyday words.
TOGETHER = {"lumbar": "back", "thoracic": "back", "head": "neck"}

_FREEDOM_OF = np.array([entry.split(":", maxsplit=1)[0] for entry in ENTRIES])


def _groups() -> dict[str, NDArray[np.intp]]:
    names: dict[str, list[str]] = {}
    for joint in JOINTS:
        group = names.setdefault(TOGETHER.get(joint.name, joint.name), [])
        group += [dof.name for dof in joint.degrees_of_freedom]
    return {group: np.flatnonzero(np.isin(_FREEDOM_OF, freedoms)) for group, freedoms in names.items()}


JOINT_GROUPS = _groups()


def highest_fatigue(fatigue: Array) -> dict[str, Array]:
    """The most tired entry of every group: fatigue (..., 78) to (...) by group."""
    return {group: fatigue[..., places].max(axis=-1) for group, places in JOINT_GROUPS.items()}

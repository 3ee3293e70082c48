"""Grids of poses: an action whose coordinates are ranges stands for one action per point of the grid."""

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pydantic import Field, ValidationError

from fatigue_planner.core.errors import shortened
from fatigue_planner.core.settings import MAX_NAME_LENGTH, Settings
from fatigue_planner.experiment.error_messages import dotted, error_lines
from fatigue_planner.experiment.schema import MAX_ACTIONS

HANDS = ("right_hand", "left_hand")
AXES = ("x", "y", "z")
MAX_DISTANCE_M = 3.0


class Range(Settings):
    """`count` evenly spaced coordinates in m, both ends among them."""

    first: float = Field(
        alias="from", ge=-MAX_DISTANCE_M, le=MAX_DISTANCE_M, description="First coordinate of the grid in m."
    )
    last: float = Field(
        alias="to", ge=-MAX_DISTANCE_M, le=MAX_DISTANCE_M, description="Last coordinate of the grid in m."
    )
    count: int = Field(ge=2, le=1000, description="Number of coordinates, both ends among them.")

    def values(self) -> list[float]:
        """The coordinates, rounded to a hundredth of a millimetre."""
        return [round(float(value), 5) + 0.0 for value in np.linspace(self.first, self.last, self.count)]


def expand_pose_grids(content: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The content of an experiment file with every grid of actions written out, and what is wrong with grids.

    Where a coordinate of a hand's position_m is a range {from, to, count}, the action becomes one action
    per value, named after it: shelf_x0.4_z1.2 (m for minus). Ranges of the same axis in both hands must have the same
    count: the hands move over the grid together. A faulty grid is left as it is.
    """
    actions = content.get("actions")
    if not isinstance(actions, dict):
        return content, []
    expanded: dict[str, Any] = {}
    faults: list[str] = []
    for name, action in actions.items():
        try:
            singles = _expand(name, action, MAX_ACTIONS - len(expanded))
        except GridError as error:
            faults += error.args
            singles = [(name, action)]
        for full_name, single in singles:
            if full_name in expanded:
                faults.append(
                    f"{dotted(['actions', name])}: its grid makes {full_name}, a name that another action has."
                )
                break
            expanded[full_name] = single
    return content | {"actions": expanded}, faults


class GridError(Exception):
    """The faults of one action's grid."""


def _expand(name: str, action: Any, max_actions: int) -> list[tuple[str, Any]]:
    """The actions of a grid by name, at most `max_actions`; any other action as it is. Raises GridError."""
    axes: dict[str, dict[str, list[float]]] = {}  # axis -> hand -> values
    for hand, axis, value in _ranges(action):
        key = dotted(["actions", name, hand, "position_m", axis])
        axes.setdefault(axis, {})[hand] = range_of(key, value).values()
    if not axes:
        return [(name, action)]
    key = dotted(["actions", name])
    for axis, hands in axes.items():
        if len({len(values) for values in hands.values()}) > 1:
            raise GridError(f"{key}: the ranges of {axis} of both hands must have the same count.")
    counts = [range(len(next(iter(hands.values())))) for hands in axes.values()]
    if (size := math.prod(map(len, counts))) > max_actions:
        raise GridError(f"{key}: its grid has {size} points; at most {MAX_ACTIONS} actions are allowed in all.")
    singles = []
    for indices in itertools.product(*counts):
        single = dict(action)
        at = {}
        for (axis, hands), index in zip(axes.items(), indices, strict=True):
            at[axis] = next(iter(hands.values()))[index]
            for hand, values in hands.items():
                goal = single[hand]
                single[hand] = goal | {"position_m": goal["position_m"] | {axis: values[index]}}
        label = point_name(name, at)
        if len(label) > MAX_NAME_LENGTH:
            raise GridError(f"{key}: its grid makes names as long as {shortened(label)}; choose a shorter name.")
        singles.append((label, single))
    return singles


def point_name(grid: str, at: Mapping[str, float]) -> str:
    """The name of a grid's point by its coordinates in m, m for minus: shelf_x0.4_z1.2."""
    return grid + "".join(f"_{axis}{value:g}".replace("-", "m") for axis, value in at.items())


def _ranges(action: Any) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Hand, axis and value of every coordinate that is not a number but a mapping."""
    for hand in HANDS if isinstance(action, dict) else ():
        goal = action.get(hand)
        position = goal.get("position_m") if isinstance(goal, dict) else None
        for axis, value in position.items() if isinstance(position, dict) else ():
            if axis in AXES and isinstance(value, dict):
                yield hand, axis, value


def range_of(key: str, value: dict[str, Any]) -> Range:
    """The range of a coordinate; `key` is its place in the file. Raises GridError with all that is wrong with it."""
    try:
        return Range.model_validate(value, strict=True)
    except ValidationError as error:
        example = "A range is {from: 0.3, to: 0.6, count: 5}."
        raise GridError(*(f"{line} {example}" for line in error_lines(error, Range, key))) from error

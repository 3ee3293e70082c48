"""Grids of poses: an action whose coordinates are ranges stands for one action per place of the grid."""

import itertools
import math
from typing import Any

import numpy as np
from pydantic import Field, ValidationError

from fatigue_planner.errors import ExperimentError
from fatigue_planner.experiment.schema import LONGEST_NAME
from fatigue_planner.settings import Settings

HANDS = ("right_hand", "left_hand")
MOST_PLACES = 10_000


class Range(Settings):
    """`count` evenly spaced coordinates in m, both ends among them."""

    first: float = Field(alias="from")
    last: float = Field(alias="to")
    count: int = Field(ge=2, le=1000)

    def values(self) -> list[float]:
        """The coordinates, rounded to a hundredth of a millimetre."""
        return [round(float(value), 5) + 0.0 for value in np.linspace(self.first, self.last, self.count)]


def expand_grids(content: dict[str, Any]) -> dict[str, Any]:
    """The content of an experiment file with every grid of actions written out.

    Where a coordinate of a hand's position_m is a range {from, to, count}, the action becomes one action
    per value, named after it: shelf_x0.4_z1.2 (m for minus). Ranges of the same axis in both hands must have the same
    count: the hands move over the grid together. Raises ExperimentError for a faulty range.
    """
    actions = content.get("actions")
    if not isinstance(actions, dict):
        return content
    expanded: dict[str, Any] = {}
    for name, action in actions.items():
        for full_name, single in _expand(f"actions.{name}", name, action):
            if full_name in expanded:
                raise ExperimentError(f"actions.{name}: its grid makes {full_name}, a name that stands twice.")
            expanded[full_name] = single
    return content | {"actions": expanded}


def _expand(key: str, name: str, action: Any) -> list[tuple[str, Any]]:
    axes: dict[str, dict[str, list[float]]] = {}  # axis -> hand -> values
    if isinstance(action, dict):
        for hand in HANDS:
            goal = action.get(hand)
            position = goal.get("position_m") if isinstance(goal, dict) else None
            for axis, value in position.items() if isinstance(position, dict) else ():
                if isinstance(value, dict):
                    axes.setdefault(axis, {})[hand] = _range(f"{key}.{hand}.position_m.{axis}", value).values()
    if not axes:
        return [(name, action)]
    for axis, hands in axes.items():
        if len({len(values) for values in hands.values()}) > 1:
            raise ExperimentError(f"{key}: the ranges of {axis} of both hands must have the same count.")
    counts = [range(len(next(iter(hands.values())))) for hands in axes.values()]
    if (size := math.prod(map(len, counts))) > MOST_PLACES:
        raise ExperimentError(f"{key}: its grid has {size} places; at most {MOST_PLACES} are allowed.")
    singles = []
    for places in itertools.product(*counts):
        single = dict(action)
        label = name
        for (axis, hands), place in zip(axes.items(), places, strict=True):
            label += f"_{axis}{next(iter(hands.values()))[place]:g}".replace("-", "m")
            for hand, values in hands.items():
                goal = single[hand]
                single[hand] = goal | {"position_m": goal["position_m"] | {axis: values[place]}}
        if len(label) > LONGEST_NAME:
            raise ExperimentError(f"{key}: its grid makes names as long as {label}; choose a shorter name.")
        singles.append((label, single))
    return singles


def _range(key: str, value: dict[str, Any]) -> Range:
    try:
        return Range.model_validate(value, strict=True)
    except ValidationError as error:
        fault = error.errors()[0]
        where = ".".join([key, *map(str, fault["loc"])])
        raise ExperimentError(f"{where}: {fault['msg']}; a range is {{from: 0.3, to: 0.6, count: 5}}.") from error

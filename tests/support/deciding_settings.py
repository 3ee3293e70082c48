"""What every setting of an experiment decides: written from what the setting means, not from how keys are made.

EXPERIMENT has every setting that there is, the paper's among them. RULES say, for each, which keys change with it.
"""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from conftest import PAPER
from settings_leaves import Leaf

from fatigue_planner.experiment.loader import read_content

Content = dict[str, Any]
CHOICE = {"kind": "choice", "values": [0.8, 1.25], "probabilities": [0.5, 0.5]}
LOGNORMAL = {"kind": "lognormal", "median": 1.0, "sigma": 0.2}
UNIFORM = {"kind": "uniform", "from": 0.5, "to": 1.5}
POINT = {"x": 0.4, "y": -0.2, "z": 1.1}
TURN = {"x": 5.0, "y": -90.0, "z": 5.0}
PHASES = ["reach", "work", "return"]
POSTURE = {"knee_flexion": 5.0, "hip_flexion": 2.5, "ankle_flexion": 2.5, "elbow_flexion": 15.0}
HIDDEN = ("fatigue_rate_factor", "recovery_rate_factor", "expertise")


def _listed(value: Any) -> Any:
    """The same with lists, which can be changed, in place of tuples."""
    if isinstance(value, dict):
        return {key: _listed(item) for key, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, tuple | list) else value


def _experiment() -> Content:
    content: Content = _listed(read_content(PAPER))
    content["tool"]["hand"] = "right"
    content["cycle"] |= {"reach_s": 1.0, "work_s": 0.5, "return_s": 1.0}  # quick to simulate
    content["workers"]["woman"] = {
        "height_m": 1.65, "mass_kg": 62.0, "sex": "female", "strength": "average_woman", "natural_posture_deg": POSTURE,
    }  # fmt: skip
    content["actions"]["path"] = {
        "left_hand": {
            "waypoints": [
                {"work_time_s": 0.0, "position_m": POINT | {"y": 0.2}, "orientation_deg": TURN},
                {"work_time_s": 0.3, "position_m": POINT | {"y": 0.25}, "orientation_deg": TURN},
            ]
        },
        "right_hand": {
            "waypoints": [
                {"work_time_s": 0.0, "position_m": POINT, "orientation_deg": TURN},
                {"work_time_s": 0.3, "position_m": POINT | {"z": 1.15}, "orientation_deg": TURN},
            ]
        },
        "loads": [
            {"kind": "mass", "hand": "left", "mass_kg": 1.0, "during": ["work"]},
            {
                "kind": "force", "hand": "right", "frame": "world",
                "force_n": [{"cycle_time_s": 0.5, "x": 1.0, "y": 1.0, "z": -5.0}, {"cycle_time_s": 1.0, "z": -6.0}],
            },
        ],
    }  # fmt: skip
    content["actions"]["left"] = {
        "left_hand": {"position_m": POINT | {"y": 0.25}, "orientation_deg": {"x": 0.0, "y": -90.0, "z": 0.0}}
    }
    content["preferences"]["all"] = {
        "tasks": [
            {"kind": "segment_upright", "segment": "head", "weight": 1.0, "during": ["work"]},
            {"kind": "segment_orientation", "segment": "thorax", "orientation_deg": TURN | {"y": 10.0}, "weight": 1.0},
            {"kind": "segment_position", "segment": "pelvis", "position_m": {"x": 0.0, "y": 0.0, "z": 0.9},
             "weight": 1.0},
            {"kind": "centre_of_mass", "position_m": {"x": 0.02, "y": 0.01, "z": 0.95}, "weight": 1.0},
            {"kind": "joint_posture", "angles_deg": {"knee_flexion": 20.0}, "weight": 1.0},
            {"kind": "hand", "hand": "left", "position_m": {"x": 0.1, "y": 0.3, "z": 0.8}, "orientation_deg": TURN,
             "weight": 1.0},
        ]
    }  # fmt: skip
    content["fatigue"]["joints"] = {
        "lumbar_flexion": {"fatigue_rate_per_s": 0.02, "recovery_rate_per_s": 0.05, "threshold": 0.05}
    }
    kinds = (CHOICE, LOGNORMAL, UNIFORM)
    content["hidden_workers"] = {
        f"unknown_{turn}": {name: kinds[(place + turn) % 3] for place, name in enumerate(HIDDEN)} for turn in range(3)
    }
    names = list(content["preferences"])
    content["recognition"] = {name: {other: float(other == name) for other in names} for name in names}
    content["belief"] = {"kind": "particles", "count": 20}
    grid = content["benchmark"]
    for condition in grid["conditions"].values():
        condition["worker"] = "average_man"
    grid["conditions"] |= {
        "tired_woman": {"worker": "woman", "initial_belief": "multiple", "expertise": 0.5},
        **{
            f"unknown_{turn}": {"worker": "woman", "initial_belief": "single", "hidden_worker": f"unknown_{turn}"}
            for turn in range(3)
        },
    }
    grid["policies"] |= {
        "timed": {
            "kind": "pomcp", "backup": "mean", "exploration_constant": 0.1, "exploration": "scaled", "seconds": 0.01,
            "leaf_value": "random_rollout", "rollout_cycles": 5, "reuse_tree": True,
        },
        "lookahead": {"kind": "lookahead", "depth": 1, "leaf_value": "greedy_rollout", "rollout_cycles": 5},
    }  # fmt: skip
    grid["n_cycles"] = [5, 20]
    grid["reference"] = {"kind": "lookahead", "depth": 1, "leaf_value": "bound", "rollout_cycles": 5}
    content["statistics"]["families"]["search"] = {
        "policies": ["greedy"], "against": ["random"], "conditions": ["single_novice"], "n_cycles": [5],
    }  # fmt: skip
    for task in (task for one in content["preferences"].values() for task in one["tasks"]):
        task.setdefault("during", PHASES)
    return _listed(content)  # nothing of it stands in two places


EXPERIMENT = _experiment()


@dataclass(frozen=True)
class Rule:
    """What the settings of some names decide, and why.

    reactions: whether (worker, action, preference) is decided; cells, bounds: whether (condition, policy) is; regret
    follows the cells, and `regret` says where more is decided; change: how to change it, if not by its kind of value.
    """

    names: tuple[str, ...]
    why: str
    reactions: Callable[[Leaf, tuple[str, str, str]], bool] = lambda leaf, name: False
    cells: Callable[[Leaf, str, str], bool] = lambda leaf, condition, policy: False
    bounds: Callable[[Leaf, str], bool] = lambda leaf, condition: False
    regret: bool = False


def _conditions(key: str) -> Callable[[str], set[str]]:
    """The conditions that have a value under a key."""
    return lambda value: {name for name, one in EXPERIMENT["benchmark"]["conditions"].items() if one.get(key) == value}


OF_WORKER, OF_START, OF_HIDDEN = map(_conditions, ("worker", "initial_belief", "hidden_worker"))
EVERYWHERE = {"cells": lambda leaf, condition, policy: True, "bounds": lambda leaf, condition: True}
ALL_MOTIONS = {"reactions": lambda leaf, name: True}

RULES = (
    Rule(("name",), "says where results go"),
    Rule(
        ("workers.*.height_m", "workers.*.mass_kg", "workers.*.sex", "workers.*.natural_posture_deg.*"),
        "the worker's body and stance: every motion of this worker, and what follows from its torques only",
        reactions=lambda leaf, name: name[0] == leaf.path[1],
    ),
    Rule(
        ("workers.*.strength",),
        "limits the torques of this worker's motions, and is what fatigue is a share of",
        reactions=lambda leaf, name: name[0] == leaf.path[1],
        cells=lambda leaf, condition, policy: condition in OF_WORKER(leaf.path[1]),
        bounds=lambda leaf, condition: condition in OF_WORKER(leaf.path[1]),
    ),
    Rule(("tool.*", "cycle.*", "controller.*"), "common to all motions; what runs see of it is the torques",
         **ALL_MOTIONS),
    Rule(("accuracy.*",), "decides whether a motion may be used, when it is read"),
    Rule(("actions.*",), "where this action takes the hands, and its loads",
         reactions=lambda leaf, name: name[1] == leaf.path[1]),
    Rule(("preferences.*",), "how the body moves with this preference",
         reactions=lambda leaf, name: name[2] == leaf.path[1]),
    Rule(("fatigue.*",), "how torques tire: no motion, but every run", **EVERYWHERE),
    Rule(("discount",), "what later cycles count: every return, decision and bound", **EVERYWHERE),
    Rule(
        ("initial_beliefs.*",),
        "where the worker may start in the conditions that say so",
        cells=lambda leaf, condition, policy: condition in OF_START(leaf.path[1]),
        bounds=lambda leaf, condition: condition in OF_START(leaf.path[1]),
    ),
    Rule(
        ("hidden_workers.*",),
        "who the worker may be in the conditions that say so; these have no bound",
        cells=lambda leaf, condition, policy: condition in OF_HIDDEN(leaf.path[1]),
    ),
    Rule(("recognition.*", "belief.*"),
         "what is seen and how it is remembered; a bound holds for policies that see everything. Policies that do not "
         "look at their belief are keyed all the same: the belief's draws come from their stream",
         cells=lambda leaf, condition, policy: True),
    Rule(
        ("benchmark.conditions.*",),
        "who works in this condition, what is known of the start and of the worker",
        cells=lambda leaf, condition, policy: condition == leaf.path[2],
        bounds=lambda leaf, condition: condition == leaf.path[2],
    ),
    Rule(
        ("benchmark.policies.*",),
        "how this policy decides; a bound holds for all",
        cells=lambda leaf, condition, policy: policy == leaf.path[2],
    ),
    Rule(("benchmark.n_cycles.[]", "benchmark.trials"), "how much is run: what both grids have stays"),
    Rule(("benchmark.seed",), "the chance of every run; a bound has none", cells=lambda leaf, condition, policy: True),
    Rule(("benchmark.reference.*",), "what decisions are measured against", regret=True),
    Rule(("statistics.*", "figures.*"), "what is made of the runs"),
)  # fmt: skip

# The only value there is: a kind without another, a path's beginning, the chance of the only start.
NO_OTHER_VALUE = {
    "benchmark.reference.kind": "there is no other kind",
    "actions.*.left_hand.waypoints.[].work_time_s": "a path begins at 0",
    "actions.*.right_hand.waypoints.[].work_time_s": "a path begins at 0",
    "initial_beliefs.*.[].probability": "probabilities sum to 1",
}


def has_no_other_value(leaf: Leaf) -> bool:
    """Whether this leaf cannot be changed by itself, nor together with its neighbours."""
    if leaf.name.startswith("actions"):
        return leaf.path[-2:] == (0, "work_time_s")
    return leaf.path == ("initial_beliefs", "single", 0, "probability") or leaf.name == "benchmark.reference.kind"


# Values of texts that stand for something, and of what is not changed by a tenth.
OTHER_TEXT = {
    "name": "other", "strength": "young_man", "worker": {"average_man": "woman", "woman": "average_man"},
    "initial_belief": {"single": "multiple", "multiple": "single"},
    "hidden_worker": {"unknown_0": "unknown_1", "unknown_1": "unknown_2", "unknown_2": "unknown_0"},
}  # fmt: skip
OTHER_KIND: Mapping[str, Any] = {
    "loads": {"kind": "mass", "hand": "right", "mass_kg": 2.0},
    "tasks": {"kind": "joint_posture", "angles_deg": {"elbow_flexion": 30.0}, "weight": 2.0},
    "policies": {"kind": "lookahead", "depth": 2},
    "hidden_workers": {"kind": "choice", "values": [1.0, 1.1], "probabilities": [0.3, 0.7]},
}


def changed(leaf: Leaf, content: Content) -> Content:  # noqa: PLR0912 - one case per kind of value
    """The content with another valid value at a leaf, and at those that must change with it."""
    content = copy.deepcopy(content)
    group: Any = content
    for step in leaf.path[:-1]:
        group = group[step]
    key, value = leaf.path[-1], leaf.value
    if key == "kind":
        _change_kind(leaf, content)
    elif leaf.name == "recognition.*.*":
        other = next(name for name in group if name != key)
        group.update(dict.fromkeys(group, 0.0) | {key: 0.6, other: 0.4})
    elif leaf.name == "benchmark.n_cycles.[]":
        group[key] = value + 1
        content["statistics"]["families"]["search"]["n_cycles"] = [value + 1]
    elif leaf.name == "statistics.families.*.n_cycles.[]":
        group[key] = next(n for n in content["benchmark"]["n_cycles"] if n != value)
    elif key == "probability" or "probabilities" in leaf.path:
        siblings = content["initial_beliefs"][leaf.path[1]] if key == "probability" else group
        place = leaf.path[2] if key == "probability" else key
        other = (place + 1) % len(siblings)
        for one, by in ((place, -0.1), (other, 0.1)):
            if key == "probability":
                siblings[one]["probability"] += by
            else:
                siblings[one] += by
    elif key in ("knee_flexion", "hip_flexion", "ankle_flexion") and leaf.path[0] == "workers":
        for joint in ("knee_flexion", "hip_flexion", "ankle_flexion"):  # so that the soles stay flat
            group[joint] *= 1.5
    elif "during" in leaf.path:
        group[:] = [one for one in PHASES if one not in group] or ["work"]
    elif isinstance(value, bool):
        group[key] = not value
    elif leaf.choices:
        group[key] = next(one for one in leaf.choices if one != value)
    elif isinstance(value, str):
        group[key] = _other_text(leaf, content)
    elif isinstance(value, int):
        group[key] = value + 1
    else:
        group[key] = 0.5 if value in (0, float("inf")) and "expertise" in str(key) else value * 0.9 or 0.01
    return content


def _change_kind(leaf: Leaf, content: Content) -> None:
    if leaf.path == ("belief", "kind"):
        content["belief"] = {"kind": "exact"}
        for hidden in content["hidden_workers"].values():
            hidden.update(dict.fromkeys(HIDDEN, CHOICE))
        return
    group: Any = content
    for step in leaf.path[:-2]:
        group = group[step]
    place = leaf.path[-2]
    other = next(new for name, new in OTHER_KIND.items() if name in leaf.path)
    if group[place]["kind"] == other["kind"]:
        other = {"kind": "random"} if "policies" in leaf.path else UNIFORM if "hidden_workers" in leaf.path else other
    if "tasks" in leaf.path and group[place]["kind"] == other["kind"]:
        other = {"kind": "segment_upright", "segment": "thorax", "weight": 2.0}
    if "loads" in leaf.path and group[place]["kind"] == other["kind"]:
        other = {"kind": "force", "hand": "left", "frame": "hand", "force_n": [{"cycle_time_s": 0.0, "x": 3.0}]}
    group[place] = other


def _other_text(leaf: Leaf, content: Content) -> str:
    key = next((str(step) for step in reversed(leaf.path) if str(step) in OTHER_TEXT), None)
    if key is not None and leaf.path[0] not in ("statistics", "figures"):
        other = OTHER_TEXT[key]
        return other if isinstance(other, str) else other[leaf.value]
    names = content["benchmark"]["conditions" if leaf.value in content["benchmark"]["conditions"] else "policies"]
    group: Any = content
    for step in leaf.path[:-1]:
        group = group[step]
    return next(name for name in names if name not in group)

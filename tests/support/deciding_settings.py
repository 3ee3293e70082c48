"""What every setting of an experiment decides: written from what the setting means, not from how keys are made.

EXPERIMENT has every setting that there is, the paper's among them. RULES say, for each, which keys change with it.
"""

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from conftest import PAPER, ROOT
from settings_leaves import Leaf, Path, leaves

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.loader import parse_experiment, read_content
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.recorded import RecordingAccuracy

Content = dict[str, Any]
CHOICE = {"kind": "choice", "values": [0.8, 1.25], "probabilities": [0.5, 0.5]}
LOGNORMAL = {"kind": "lognormal", "median": 1.0, "sigma": 0.2}
UNIFORM = {"kind": "uniform", "from": 0.5, "to": 1.5}
POINT = {"x": 0.4, "y": -0.2, "z": 1.1}
TURN = {"x": 5.0, "y": -90.0, "z": 5.0}
PHASES = ["reach", "work", "return"]
POSTURE = {"knee_flexion": 5.0, "hip_flexion": 2.5, "ankle_flexion": 2.5, "elbow_flexion": 15.0}
# What the woman was recorded to do.
RECORDED = (("low", "arm"), ("high", "back"))
HIDDEN = ("fatigue_rate_factor", "recovery_rate_factor", "expertise")


def _listed(value: Any) -> Any:
    """The same with lists, which can be changed, in place of tuples."""
    if isinstance(value, dict):
        return {key: _listed(item) for key, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, tuple | list) else value


def parsed(content: Content) -> Experiment:
    return parse_experiment(_fixed(content), "the experiment")


def _fixed(value: Any) -> Any:
    """The same with tuples in place of lists, as files are read."""
    if isinstance(value, dict):
        return {key: _fixed(item) for key, item in value.items()}
    return tuple(map(_fixed, value)) if isinstance(value, list) else value


def _experiment() -> Content:
    content: Content = _listed(read_content(PAPER))
    content["tool"]["hand"] = "right"
    content["cycle"] |= {"reach_s": 1.0, "work_s": 0.5, "return_s": 1.0}  # quick to simulate
    content["workers"]["woman"] = {
        "human": "paper", "height_m": 1.65, "mass_kg": 62.0, "sex": "female", "strength": "average_woman",
        "natural_posture_deg": POSTURE,
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
            {"kind": "mass", "hand": "left", "mass_kg": 1.0, "during": ["work"],
             "centre_of_mass_m": {"x": 0.1, "y": 0.02, "z": -0.05}},
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
    content["robot"] = {
        "arm": "ur10e", "base_m": {"x": 1.2, "y": -0.1, "z": 0.4, "yaw_deg": 170.0}, "clearance_m": 0.02,
        "hold": {
            "distance_m": 0.15, "direction": {"x": -1.0, "y": 0.1, "z": 0.1}, "roll_deg": 10.0, "mass_kg": 2.0,
        },
        "link_radius_m": 0.05,
    }  # fmt: skip
    content["fatigue"] |= {
        "law": {"kind": "3cc_r"}, "rates": "frey_law_2012", "rest_multiplier": 15.0,
        "strength_by_angle": ["medx_lumbar", "kamon_arm"],
        "joints": {
            "lumbar_flexion": {
                "fatigue_rate_per_s": 0.02, "recovery_rate_per_s": 0.05, "rest_multiplier": 10.0, "threshold": 0.05,
            }
        },
    }  # fmt: skip
    content["cost"] = {
        "fatigue": "mean_square", "weights": {"lumbar_flexion": 2.0},
        "posture": [
            {"kind": "upper_arm_raised", "angle_deg": 60.0, "weight": 0.01},
            {"kind": "trunk_bent", "angle_deg": 30.0, "weight": 0.02},
        ],
    }  # fmt: skip
    kinds = (CHOICE, LOGNORMAL, UNIFORM)
    content["hidden_workers"] = {
        f"unknown_{turn}": {name: kinds[(index + turn) % 3] for index, name in enumerate(HIDDEN)} for turn in range(3)
    }
    names = list(content["preferences"])
    content["recognition"] = {name: {other: float(other == name) for other in names} for name in names}
    content["recognition_by_action"] = {"low": copy.deepcopy(content["recognition"])}
    for action, preference in RECORDED:
        content.setdefault("recorded", {}).setdefault("woman", {}).setdefault(action, {})[preference] = (
            f"{len(action + preference):016x}"
        )
    content["recording_accuracy"] = RecordingAccuracy(wrist_load_kg=1.0).model_dump()
    content["choice_models"] = {
        "plain": {"kind": "boltzmann"}, "liked": {"kind": "offset", "offsets": {"arm": 0.5}},
        "habit": {"kind": "inertia", "inertia": 1.0, "offsets": {"back": 0.2}},
    }  # fmt: skip
    content["belief"] = {"kind": "particles", "count": 20}
    grid = content["benchmark"]
    for condition in grid["conditions"].values():
        condition["worker"] = "average_man"
    grid["conditions"] |= {
        "tired_woman": {"worker": "woman", "initial_belief": "multiple", "expertise": 0.5},
        **{
            f"{name}_woman": {"worker": "woman", "initial_belief": "multiple", "expertise": 0.5, "choice_model": name}
            for name in content["choice_models"]
        },
        **{
            f"unknown_{turn}": {"worker": "woman", "initial_belief": "single", "hidden_worker": f"unknown_{turn}"}
            for turn in range(3)
        },
    }
    grid["policies"] = {name: grid["policies"][name] for name in content["statistics"]["policies"]} | {
        "timed": {
            "kind": "pomcp", "backup": "mean", "exploration_constant": 0.1, "exploration": "scaled", "seconds": 0.01,
            "leaf_value": "random_rollout", "rollout_cycles": 5, "reuse_tree": True,
        },
        **{
            f"widened_{turn}": {
                "kind": "pomcpow", "exploration_constant": 0.1, "leaf_value": "greedy_rollout", "rollout_cycles": 5,
                "observations_k": 2.0, "observations_alpha": 0.1, "actions_k": 2.0, "actions_alpha": 0.1, **budget,
            }
            for turn, budget in enumerate(({"descents": 20}, {"seconds": 0.01}))
        },
        "lookahead": {"kind": "lookahead", "depth": 1, "leaf_value": "greedy_rollout", "rollout_cycles": 5},
        "fixed": {"kind": "fixed", "action": "low"},
        "given": {"kind": "periodic", "sequence": ["high", "low"]},
        "periodic": {"kind": "periodic", "longest": 2},
        **{
            f"robust_{turn}": {"kind": "robust_periodic", "longest": 2, "workers": workers}
            for turn, workers in enumerate(content["hidden_workers"].values())
        },
        "threshold": {"kind": "threshold", "fatigue_threshold": 0.2, "recovery_threshold": 0.1},
        "agent": {"kind": "agent", "agent": "agents:Trained", "data": str(ROOT / "LICENSE")},
        "other_agent": {"kind": "agent", "agent": "agents:Other", "data": str(ROOT / "README.md")},
    }  # fmt: skip
    grid["n_cycles"] = [5, 20]
    grid["reference"] = {"kind": "lookahead", "depth": 1, "leaf_value": "bound", "rollout_cycles": 5}
    content["statistics"]["policies"] = ["greedy", "random"]
    content["statistics"]["families"]["search"] = {
        "policies": ["greedy"], "against": ["random"], "conditions": ["single_novice"], "n_cycles": [5],
    }  # fmt: skip
    for name, preference in content["preferences"].items():
        for task in preference["tasks"]:
            task.setdefault("during", PHASES)
            if name != "back":  # whose task has the controller's
                task.setdefault("stiffness_per_s2", 20.0)
    return _listed(content)  # nothing of it is shared


EXPERIMENT = _experiment()
WHOLE = parsed(EXPERIMENT)
LEAVES = list(leaves(WHOLE, Experiment))


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
    return lambda value: {
        name for name, condition in EXPERIMENT["benchmark"]["conditions"].items() if condition.get(key) == value
    }


OF_WORKER, OF_START, OF_HIDDEN, OF_CHOICES = map(
    _conditions, ("worker", "initial_belief", "hidden_worker", "choice_model")
)
OF_SIMULATION = (
    "solver", "weights.*", "stiffness_per_s2.*", "regularisation.*", "centre_of_mass_shift_m", "friction_coefficient",
    "torque_limit_factor", "velocity_limit_radps", "acceleration_limit_radps2",
)  # fmt: skip
EVERYWHERE = {"cells": lambda leaf, condition, policy: True, "bounds": lambda leaf, condition: True}


def was_recorded(name: tuple[str, str, str]) -> bool:
    return name[0] == "woman" and name[1:] in RECORDED


ALL_MOTIONS = {"reactions": lambda leaf, name: True}

RULES = (
    Rule(("name",), "says where results go"),
    Rule(
        ("workers.*.human", "workers.*.height_m", "workers.*.mass_kg", "workers.*.sex",
         "workers.*.natural_posture_deg.*"),
        "the worker's body and stance: every motion of this worker, and what follows from its torques only",
        reactions=lambda leaf, name: name[0] == leaf.path[1],
    ),
    Rule(
        ("human",),
        "the human of the workers that name none",
        reactions=lambda leaf, name: "human" not in EXPERIMENT["workers"][name[0]],
    ),
    Rule(
        ("workers.*.strength",),
        "limits the torques of this worker's motions, and is what a load is measured by",
        reactions=lambda leaf, name: name[0] == leaf.path[1],
        cells=lambda leaf, condition, policy: condition in OF_WORKER(leaf.path[1]),
        bounds=lambda leaf, condition: condition in OF_WORKER(leaf.path[1]),
    ),
    Rule(("tool.*", "cycle.*_s", "controller.time_step_s"), "common to all motions; what runs see of it is the torques",
         **ALL_MOTIONS),
    Rule(("cycle.return_hand", *(f"controller.{name}" for name in OF_SIMULATION)), "how the simulated human moves",
         reactions=lambda leaf, name: not was_recorded(name)),
    Rule(("recorded.*",), "which recording this reaction is",
         reactions=lambda leaf, name: name == leaf.path[1:]),
    Rule(("accuracy.*", "recording_accuracy.*"), "decides whether a motion may be used, when it is read"),
    Rule(("actions.*",), "where this action takes the hands, and its loads",
         reactions=lambda leaf, name: name[1] == leaf.path[1]),
    Rule(("preferences.*",), "how the simulated body moves with this preference",
         reactions=lambda leaf, name: name[2] == leaf.path[1] and not was_recorded(name)),
    Rule(
        (
            "fatigue.law.*", "fatigue.fatigue_rate_per_s", "fatigue.recovery_rate_per_s", "fatigue.rest_multiplier",
            "fatigue.threshold", "fatigue.strength_by_angle.*", "fatigue.joints.*",
        ),
        "how torques tire: no motion, but every run", **EVERYWHERE,
    ),
    Rule(("fatigue.rates",), "the rates of joints, all of which are replaced here by what is given for all"),
    Rule(("cost.*",), "what is minimised, and what experts compare: no motion, but every run and bound", **EVERYWHERE),
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
    Rule(
        ("choice_models.*",),
        "how the worker of the conditions that say so chooses",
        cells=lambda leaf, condition, policy: condition in OF_CHOICES(leaf.path[1]),
        bounds=lambda leaf, condition: condition in OF_CHOICES(leaf.path[1]),
    ),
    Rule(("recognition.*", "recognition_by_action.*", "belief.*"),
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
    Rule(("benchmark.max_decision_s",), "what is refused"),
    Rule(("robot.*",), "which actions are there to choose from: here all, whatever is changed"),
    Rule(("statistics.*", "figures.*"), "what is made of the runs"),
)  # fmt: skip


def changed(leaf: Leaf) -> Content | None:
    """The experiment with another valid value at a leaf, and what must change with it; None if there is no other."""
    for others in _others(leaf):
        content = copy.deepcopy(EXPERIMENT)
        for path, value in others.items():
            inside(content, path[:-1])[path[-1]] = copy.deepcopy(value)
        if _is_another(content):
            return content
    return None


def inside(content: Any, path: Path) -> Any:
    """The part of a content to which a path leads."""
    for step in path:
        content = content[step]
    return content


def _is_another(content: Content) -> bool:
    """Whether this is a valid experiment, and not the same one in other words."""
    try:
        return parsed(content) != WHOLE
    except ExperimentError:
        return False


def _others(leaf: Leaf) -> Iterator[Content]:
    """What may be valid instead, best first: values by their paths."""
    path, value = leaf.path, leaf.value
    above = path[:-1]
    if path[-1] == "kind":
        union = leaf.name.rpartition(".<")[0]
        for other in LEAVES:
            if other.name.startswith(f"{union}.<") and other.path[-1] == "kind" and other.value != value:
                yield {above: inside(EXPERIMENT, other.path[:-1])}
        hidden = EXPERIMENT["hidden_workers"]
        yield {("fatigue",): {"law": {"kind": "ma"}}} if leaf.name.startswith("fatigue.law.") else {}
        exact = {("hidden_workers", name): dict.fromkeys(HIDDEN, CHOICE) for name in hidden}
        yield {("belief",): {"kind": "exact"}} | exact if leaf.path[0] == "belief" else {}
    elif isinstance(value, bool):
        yield {path: not value}
    elif leaf.name == "robot.arm":
        yield {path: "ur5e"}
    elif leaf.name == "fatigue.rates":
        yield {path: None}
    elif leaf.name == "cost.fatigue":  # which no leaf value of cyclic plans goes with
        yield {path: "worst_joint", ("benchmark", "reference", "leaf_value"): "none"}
    elif isinstance(value, str):
        yield from ({path: choice} for choice in leaf.choices)
        yield from ({above: [choice]} for choice in leaf.choices)
        yield from ({path: other.value} for other in LEAVES if other.name == leaf.name)
        yield from ({path: name} for part in ("conditions", "policies") for name in EXPERIMENT["benchmark"][part])
        yield from ({path: name} for name in EXPERIMENT["actions"])
    elif isinstance(value, int):
        yield {path: value + 1}
        yield {path: value + 1, ("statistics", "families", "search", "n_cycles"): [value + 1]}
        yield from ({path: other.value} for other in LEAVES if other.path[-2:-1] == path[-2:-1])
    else:
        beside = [other for other in LEAVES if other.name == leaf.name and other.path[:2] == path[:2]]
        shift = 0.1 if value > 0.1 else -0.1
        if "natural_posture_deg" in path:
            yield {other.path: other.value * 0.9 for other in beside}  # the soles stay flat
        yield from ({path: new} for new in (value * 0.9, 0.01))
        yield from ({path: value - shift, other.path: other.value + shift} for other in beside if other != leaf)

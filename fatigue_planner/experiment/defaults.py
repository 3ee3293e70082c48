"""What an experiment is about where its file does not say: the paper's worker, preferences and start.

Numbers have their defaults in the classes of the schema, those of the benchmark in `benchmark_settings`.
"""

from collections.abc import Mapping
from typing import Any

from fatigue_planner.experiment.benchmark_settings import RESTED, InitialState
from fatigue_planner.human.model import Worker
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.settings import Segment, Side
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.tasks.segment_upright import SegmentUpright

UPPER_ARMS: dict[Side, Segment] = {"right": "right_upper_arm", "left": "left_upper_arm"}


def usual_workers(experiment: Mapping[str, Any]) -> dict[str, Worker]:
    """The average man; stature and mass are open in the paper (docs/deviations.md)."""
    human = experiment.get("human", "natural")
    return {"average_man": Worker(human=human, height_m=1.75, mass_kg=75.0, sex="male")}


def usual_beliefs() -> dict[str, tuple[InitialState, ...]]:
    """A rested worker for certain (paper, section IV-D: the single initial state)."""
    return {RESTED: (InitialState(probability=1.0),)}


def usual_preferences(experiment: Mapping[str, Any]) -> dict[str, Preference]:
    """The paper's arm and back (section IV-C): the trunk stays upright, or the upper arms of the hands that work."""
    actions: Mapping[str, Action] = experiment.get("actions", {})
    working = {side for action in actions.values() for side in action.goals()}
    arms = [arm for side, arm in UPPER_ARMS.items() if side in working]
    upright = tuple(SegmentUpright(kind="segment_upright", segment=arm, weight=10.0) for arm in arms)
    thorax = SegmentUpright(kind="segment_upright", segment="thorax", weight=1.0, stiffness_per_s2=80.0)
    return {"arm": Preference(tasks=(thorax,)), "back": Preference(tasks=upright)}


def usual_figures(experiment: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """One figure of the returns in all conditions."""
    return {"returns": tuple(experiment["benchmark"].conditions)} if "benchmark" in experiment else {}

"""What a motion fails for: load, speed, orientation and place, each left out in turn and tried again."""

from dataclasses import replace

import pytest

from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.action import Action, HandGoal, Orientation, Position
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.causes import REMEDIES, causes_of
from fatigue_planner.motion.payload import HandForce, TimedForce
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions.cache import simulate_and_measure


@pytest.fixture(scope="module")
def brisk(paper: Experiment) -> MotionRequest:
    """The paper's high object in 3 s, without a tool."""
    request = reaction_requests(paper)[0].motion
    empty = request.tool.model_copy(update={"mass_kg": 0.0})
    return replace(request, tool=empty, cycle=Cycle(reach_s=1.2, work_s=0.6, return_s=1.2))


def goal_at(x: float, y: float, z: float, turned: Orientation | None = None) -> Action:
    return Action(right_hand=HandGoal(position_m=Position(x=x, y=y, z=z), orientation_deg=turned))


@pytest.mark.slow
def test_a_load_that_is_too_heavy(brisk: MotionRequest) -> None:
    heavy = replace(brisk, tool=brisk.tool.model_copy(update={"mass_kg": 28.0}))
    told = simulate_and_measure(heavy)
    text = told if isinstance(told, str) else told[1].tested_causes
    assert f"it works without load: {REMEDIES['load']}" in text
    assert "it works with" not in text.replace("it works without load", "") and "half-way" in text


def test_a_place_that_is_too_far(brisk: MotionRequest) -> None:
    """Half of the way is in reach; a load is not tried, as there is none, an orientation where one is asked for."""
    causes = causes_of(replace(brisk, action=goal_at(1.2, -0.25, 1.2)))
    assert f"it works half-way to the hanging hand: {REMEDIES['place']}" in causes and "it fails at half" in causes
    assert "load" not in causes and "orientation" not in causes
    turned = causes_of(replace(brisk, action=goal_at(1.2, -0.25, 1.2, Orientation(y=-90))))
    assert "it fails at half the speed and with a free orientation" in turned


def test_a_haste_that_no_arm_has(brisk: MotionRequest) -> None:
    shove = TimedForce(cycle_time_s=0.3, x=-20.0)
    action = brisk.action.model_copy(
        update={"loads": (HandForce(kind="force", hand="right", frame="world", force_n=(shove,)),)}
    )
    hasty = replace(brisk, action=action, cycle=Cycle(reach_s=0.2, work_s=0.2, return_s=0.2))
    causes = causes_of(hasty)
    assert "at half the speed" in causes and "without load" in causes


def test_what_is_within_reach_is_not_tried(brisk: MotionRequest) -> None:
    told = simulate_and_measure(brisk)
    assert not isinstance(told, str) and told[1].tested_causes == ""

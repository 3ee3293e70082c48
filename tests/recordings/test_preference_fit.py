"""The inverse question: which weights and stiffnesses of a preference bring the human closest to recordings."""

from dataclasses import replace

import numpy as np
import pytest

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.reactions.reaction import ReactionName
from fatigue_planner.recordings.learning.preference_fit import (
    FAILED_DEG,
    Example,
    fit_preference,
    off_deg,
    rms,
    scaled,
    searches,
    stiffnesses_of,
)

PEOPLE = {"small": 1.62, "middle": 1.72, "tall": 1.84}


@pytest.fixture(scope="module")
def asked(paper: Experiment) -> dict[str, MotionRequest]:
    """Short reaches of three people, by the preference `arm`."""
    (request,) = [one.motion for one in reaction_requests(paper) if str(one.name) == "average_man/high/arm"]
    cycle = Cycle(reach_s=1.5, work_s=1.0, return_s=1.5)
    return {
        name: replace(request, cycle=cycle, worker=request.worker.model_copy(update={"height_m": height_m}))
        for name, height_m in PEOPLE.items()
    }


def shown(asked: dict[str, MotionRequest], factors: dict[str, tuple[float, float]]) -> list[Example]:
    """What is recorded of people whose weight and stiffness are these factors of the preference's."""
    found = []
    for person, request in asked.items():
        own = scaled(request.preference, stiffnesses_of(request), np.array([factors[person]]))
        motion = simulate(replace(request, preference=own))
        name = ReactionName(person, "high", "arm")
        found.append(Example(name, request, np.degrees(motion.configuration[:, 7:])))
    return found


@pytest.mark.slow
def test_the_weights_of_a_preference_are_found_again(asked: dict[str, MotionRequest]) -> None:
    """Three people move by a weight of 5 and a stiffness of 32 instead of 1 and 80; also the one left out is met."""
    examples, ended = shown(asked, dict.fromkeys(PEOPLE, (5.0, 0.4))), []
    found = fit_preference(examples, 60, LocalProcesses(2), lambda: ended.append(1))
    (task,) = found.preference.tasks
    assert task.weight == pytest.approx(5, rel=0.05) and task.stiffness_per_s2 == pytest.approx(32, rel=0.05)
    assert found.others_deg is not None and found.helps and len(ended) == 4
    assert rms(found.before_deg) > 0.5 and max(rms(found.after_deg), rms(found.others_deg)) < 0.05
    assert found.before_deg.shape == found.others_deg.shape == (3, 39)


@pytest.mark.slow
def test_what_fits_one_person_and_no_other_does_not_help(asked: dict[str, MotionRequest]) -> None:
    """Two people who differ from the preference in opposite ways: what is fitted to one is farther from the other."""
    two = {name: asked[name] for name in ("small", "tall")}
    found = fit_preference(shown(two, {"small": (8.0, 1.0), "tall": (0.05, 1.0)}), 30, LocalProcesses(2))
    assert found.helps is False and rms(found.after_deg) <= rms(found.before_deg)


@pytest.fixture
def too_far(asked: dict[str, MotionRequest]) -> Example:
    """A motion that cannot be: the object is 5 m away."""
    request = asked["middle"]
    goal = request.action.right_hand
    assert goal is not None
    beyond = goal.model_copy(update={"position_m": goal.position_m.model_copy(update={"x": 5.0})})
    far = replace(request, action=request.action.model_copy(update={"right_hand": beyond}))
    return Example(ReactionName("middle", "far", "arm"), far, np.zeros((400, 39)))


def test_a_motion_that_cannot_be_is_far_off(too_far: Example) -> None:
    assert off_deg(too_far.request.preference, too_far).tolist() == [FAILED_DEG] * 39


def test_where_no_motion_can_be_nothing_is_sought_and_the_reason_is_told(too_far: Example) -> None:
    with pytest.raises(FailedMotionError, match=r"No motion can be simulated .*\n  middle/far/arm: no admissible"):
        fit_preference([too_far], 10, LocalProcesses(1))


def test_everybody_is_left_out_once_where_there_are_several(asked: dict[str, MotionRequest]) -> None:
    examples = [Example(ReactionName(name, "high", "arm"), asked[name], np.zeros((1, 39))) for name in PEOPLE]
    assert {name: [one.name.worker for one in part] for name, part in searches([*examples, examples[0]]).items()} == {
        "": ["small", "middle", "tall", "small"], "small": ["middle", "tall"], "middle": ["small", "tall", "small"],
        "tall": ["small", "middle", "small"],
    }  # fmt: skip
    assert list(searches(examples[:1])) == [""]

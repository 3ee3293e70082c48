"""A whole cycle: its maps, what it settles to, and limits of postures, against computations of other kinds."""

import numpy as np
import pytest

from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.station.cycles import Course, Stretch, cost, peak, product, settled, shortfall
from fatigue_planner.station.limits import Limit, breaches

REST_S = 7.0
MAN = Anthropometry(1.75, 75, "male", "paper")


@pytest.fixture(scope="module")
def parameters() -> FatigueParameters:
    return fatigue_parameters(FatigueSettings(), maximum_torque("average_man"))


@pytest.fixture(scope="module")
def motions(reactions: tuple[Reaction, ...]) -> list[Motion]:
    return [reactions[0].motion, reactions[3].motion]


def test_the_product_of_the_maps_is_the_map_of_the_joined_cycle(
    motions: list[Motion], parameters: FatigueParameters
) -> None:
    courses = [Course.of(motion, parameters) for motion in motions]
    maps = [each for course in courses for each in (course.work, course.back)]
    whole = product([*maps, courses[-1].rest(REST_S)])
    joined = Stretch.joined([*map(Stretch.of, motions), Stretch.rest(motions[-1], REST_S)])
    once = cycle_profile(joined, parameters).cycle_map()
    assert whole.gain == pytest.approx(once.gain, rel=1e-12)
    assert whole.offset == pytest.approx(once.offset, abs=1e-12)


def test_a_cycle_settles_to_what_repeating_it_leads_to(motions: list[Motion], parameters: FatigueParameters) -> None:
    courses = [Course.of(motion, parameters) for motion in motions]
    fatigue, ends = np.zeros(78), []
    for _ in range(400):
        ends = []
        for course in courses:
            fatigue = course.work.apply(fatigue)
            ends.append(fatigue)
            fatigue = course.back.apply(fatigue)
        fatigue = courses[-1].rest(REST_S).apply(fatigue)
    found = settled(courses, REST_S)
    assert found == pytest.approx(np.array(ends), abs=1e-9)
    assert cost(found) == pytest.approx(float(np.mean(np.square(ends))))
    highest, entry = peak(found)
    assert highest == np.max(ends, initial=0) or highest == pytest.approx(np.max(ends))
    assert entry.endswith((":positive", ":negative"))


def test_more_rest_tires_less(motions: list[Motion], parameters: FatigueParameters) -> None:
    courses = [Course.of(motion, parameters) for motion in motions]
    costs = [cost(settled(courses, rest_s)) for rest_s in (0.0, 5.0, 60.0)]
    assert costs[0] > costs[1] > costs[2] > 0


def test_a_worker_too_weak_falls_short(motions: list[Motion]) -> None:
    weak = fatigue_parameters(FatigueSettings(), maximum_torque("average_man:p1"))
    strong = fatigue_parameters(FatigueSettings(), maximum_torque("average_man:p99"))
    assert shortfall(motions, 0.0, strong) is None
    short = shortfall(motions, 0.0, weak)
    assert short is not None and short.cycle >= 1


def test_limits_count_seconds_of_a_posture(motions: list[Motion]) -> None:
    motion = motions[0]
    poses = poses_of(tree_of(MAN), motion.configuration)
    arms = [poses.rotation[:, BODIES.index(f"{side}_upper_arm"), 2, 2] for side in ("right", "left")]
    raised = np.degrees(np.arccos(np.clip(np.min(arms, axis=0), -1, 1))) > 30
    seconds = float(raised.sum() * motion.time_step_s)
    assert seconds > 1
    at_most = Limit(measure="upper_arm_elevation", above_deg=30, at_most_s=round(2 * seconds) - 1)
    (breach,) = breaches((at_most.model_copy(update={"at_most_s": 1e3}), at_most), MAN, motion, 2)
    assert (breach.limit, breach.seconds) == (1, pytest.approx(2 * seconds))
    assert breaches((Limit(measure="trunk_inclination", above_deg=170, at_most_s=0),), MAN, motion, 1) == ()

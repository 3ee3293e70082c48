"""What an observer sees of a motion: measures of known postures, of arrays that were tampered with, and the verdict."""

import re
from dataclasses import asdict, replace

import numpy as np
import pytest

from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.joint_data import posture as angles
from fatigue_planner.human.kinematics import Poses, poses_of, tree_of
from fatigue_planner.human.model import Worker, build_human, joint_index
from fatigue_planner.human.multibody import stand
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion import posture_measures as posture
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.plausibility import BARS, Plausibility, measure_plausibility
from fatigue_planner.motion.verification import measure
from fatigue_planner.reactions.reaction import Reaction

WORKER = Worker.model_validate({"height_m": 1.75, "mass_kg": 75, "sex": "male", "human": "paper"})
PERSON = WORKER.anthropometry()


def standing(**degrees: float) -> Poses:
    """One posture, the pelvis' height by its soles."""
    human = build_human(WORKER)
    return poses_of(tree_of(PERSON), stand(human.model, angles(degrees, "posture"))[None])


@pytest.mark.parametrize(
    ("degrees", "measure", "expected"),
    [
        ({"lumbar_rotation": 10, "thoracic_rotation": 20}, posture.trunk_twist, 30),
        ({"lumbar_rotation": -15, "lumbar_flexion": 60}, posture.trunk_twist, -15),  # about its own axis, bent or not
        ({"lumbar_lateral": 10, "thoracic_lateral": 5}, posture.side_bend, 15),
        ({"lumbar_flexion": 40}, posture.side_bend, 0),
        ({}, posture.lean, 0),
        ({"hip_flexion": 30}, posture.lean, 30),  # both hips; the legs upright
        ({"neck_lateral": 12, "head_lateral": 8}, posture.head_roll, 20),
        ({"lumbar_lateral": 15}, posture.head_roll, 15),
        ({}, lambda poses: posture.upper_arm_elevation(poses, "right"), 0),
        ({"left_shoulder_flexion": 70}, lambda poses: posture.upper_arm_elevation(poses, "left"), 70),
        ({"lumbar_flexion": 30}, lambda poses: posture.upper_arm_elevation(poses, "left"), 30),  # from the vertical
        ({"right_shoulder_abduction": 90}, lambda poses: posture.shoulder_turn(poses, "right"), 0),
        ({"right_shoulder_rotation": 60, "right_elbow_flexion": 90}, lambda p: posture.shoulder_turn(p, "right"), 0),
    ],
)
def test_angles_of_known_postures(degrees, measure, expected) -> None:
    assert measure(standing(**degrees))[0] == pytest.approx(expected, abs=1e-6)


def test_a_shoulder_the_wrong_way_round_is_seen_on_both_sides() -> None:
    """Backward, up and turned in: each angle is in its range, the arm of a person could not be there."""
    wrong = {"shoulder_flexion": -60, "shoulder_abduction": 69, "shoulder_rotation": 70}
    right = {"shoulder_flexion": 75, "shoulder_abduction": 33, "shoulder_rotation": -8}
    for side in ("right", "left"):
        turned = posture.shoulder_turn(standing(**{f"{side}_{name}": angle for name, angle in wrong.items()}), side)
        assert 40 < turned[0] < 60
        assert posture.shoulder_turn(standing(**{f"{side}_{name}": a for name, a in right.items()}), side)[0] == 0


def test_the_eyes_take_a_part_of_the_way() -> None:
    """From the eyes straight ahead 0; 20 degrees down or 10 up are free; sideways nothing is."""
    poses = standing()
    eyes = poses.points("head", np.array([capsules_of(PERSON).radius_m[4], 0, (0.936 - 0.875) * 1.75]))[0]

    def seen(down: float, left: float) -> float:
        down, left = np.radians([down, left])
        line = np.array([np.cos(down) * np.cos(left), np.cos(down) * np.sin(left), -np.sin(down)])
        return float(posture.gaze(poses, PERSON, (eyes + 0.7 * line)[None])[0])

    for down, left, expected in ((0, 0, 0), (20, 0, 0), (35, 0, 15), (-10, 0, 0), (-30, 0, 20), (0, 40, 40)):
        assert seen(down, left) == pytest.approx(expected, abs=1e-5), (down, left)


def test_a_hand_in_a_thigh_is_seen() -> None:
    """Beside the thigh, in it, and beyond it: the hanging arm swings inward across the leg."""
    capsules, pair = capsules_of(PERSON), [BODIES.index("right_hand"), BODIES.index("right_thigh")]
    (row,) = np.flatnonzero((np.sort(capsules.pairs, axis=1) == sorted(pair)).all(axis=1))
    beside, within = (posture.distances(standing(shoulder_abduction=a), capsules)[0, row] for a in (15, -4))
    assert beside > 0.05 and -0.1 < within < -0.04


@pytest.fixture(scope="module")
def high(paper: Experiment, reactions: tuple[Reaction, ...]) -> tuple[MotionRequest, Motion]:
    return reaction_requests(paper)[0].motion, reactions[0].motion


def seen(request: MotionRequest, motion: Motion, **arrays: np.ndarray) -> Plausibility:
    return measure_plausibility(request, replace(motion, **arrays))


def test_muscles_that_push_into_an_end_are_timed(high: tuple[MotionRequest, Motion]) -> None:
    request, motion = high
    before = seen(request, motion)
    knee = joint_index("right_knee_flexion")
    configuration, torque = motion.configuration.copy(), motion.torque_nm.copy()
    configuration[100:200, 7 + knee] = np.radians(0.5)
    torque[100:200, knee] = -20.0
    found = seen(request, motion, configuration=configuration, torque_nm=torque)
    assert (before.pushing_s, found.pushing_s, found.pushing_joint) == (0.0, 1.0, "right_knee_flexion")
    torque[100:200, knee] = +20.0  # away from the end: it stands there, that is all
    assert seen(request, motion, configuration=configuration, torque_nm=torque).pushing_s == 0
    torque[100:200, knee] = -0.5  # less than 1 N.m
    assert seen(request, motion, configuration=configuration, torque_nm=torque).pushing_s == 0
    configuration[100:200, 7 + knee] = np.radians(1.5)
    torque[100:200, knee] = -20.0
    assert seen(request, motion, configuration=configuration, torque_nm=torque).pushing_s == 0


def test_torque_steps_are_those_within_40_ms_of_unhurried_phases(high: tuple[MotionRequest, Motion]) -> None:
    request, motion = high
    own = seen(request, motion).torque_step_nm + 4
    torque = motion.torque_nm.copy()
    torque[300:, 4] += 30 * np.minimum(np.arange(len(torque) - 300) / 4, 1)  # in 40 ms
    found = seen(request, motion, torque_nm=torque)
    assert found.torque_step_joint == "thoracic_lateral" and found.torque_step_nm == pytest.approx(30, abs=2)
    slow = motion.torque_nm.copy()
    slow[300:, 4] += 30 * np.minimum(np.arange(len(torque) - 300) / 40, 1)  # in 400 ms
    assert seen(request, motion, torque_nm=slow).torque_step_nm < own < 20
    reach, work, back = motion.phases
    brisk = (reach._replace(stop=290), work._replace(start=290, stop=400), back._replace(start=400))
    assert seen(request, replace(motion, phases=brisk), torque_nm=torque).torque_step_nm < own < 20


def test_taking_up_a_tool_is_no_step_of_the_body(high: tuple[MotionRequest, Motion]) -> None:
    request, motion = high
    own = seen(request, motion).torque_step_nm + 4
    torque = motion.torque_nm.copy()
    torque[500:1100, 2] += 30.0  # work: ticks 500 to 1100
    at_work = replace(request, tool=request.tool.model_copy(update={"held": "work"}))
    assert seen(at_work, motion, torque_nm=torque).torque_step_nm < own < 20
    assert seen(request, motion, torque_nm=torque).torque_step_nm > 26


def test_the_end_is_compared_with_the_stance(high: tuple[MotionRequest, Motion]) -> None:
    request, motion = high
    configuration, velocity = motion.configuration.copy(), motion.velocity.copy()
    configuration[-1, 7:] = configuration[0, 7:]
    configuration[-1, 7 + 2] += np.radians(3)
    velocity[-1, 6:] = np.radians(0.5)
    found = seen(request, motion, configuration=configuration, velocity=velocity)
    assert (found.end_pose_deg, found.end_speed_degps) == (pytest.approx(3), pytest.approx(0.5))
    assert found.end_pose_joint == "lumbar_rotation"
    assert {"end_pose_deg"} == {f.measure for f in found.findings() if f.measure.startswith("end")}


def test_the_load_of_the_stance_is_a_share_of_the_strength(high: tuple[MotionRequest, Motion]) -> None:
    request, motion = high
    torque = np.zeros_like(motion.torque_nm)
    torque[0, 7] = -0.3 * request.maximum_torque.negative_nm[7]
    found = seen(request, motion, torque_nm=torque)
    assert found.stance_load_share == pytest.approx(0.3) and found.stance_load_joint == "neck_lateral"
    assert seen(request, motion, torque_nm=0 * torque).stance_load_joint == ""


def test_the_papers_motions_are_possible_but_not_a_persons(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """What physiology knows of them; a mirrored experiment would show the same of the left hand."""
    for reaction in reactions:
        assert (
            reaction.quality.faults(paper.accuracy) == [] and reaction.quality.verdict(paper.accuracy) == "implausible"
        )
    beyond = {str(r.name): {f.measure for f in r.quality.plausibility.findings()} for r in reactions}
    assert all("gaze_deg" in found for found in beyond.values())
    assert "penetration_m" in beyond["average_man/high/back"]


def test_every_bar_is_of_a_measure_and_says_what_where_and_how_much() -> None:
    measures = asdict(calm())
    assert set(BARS) <= {name for name, value in measures.items() if not isinstance(value, str)}
    assert calm().findings() == []
    for name, bar in BARS.items():
        (finding,) = replace(calm(), **{name: bar.most + 1e-6}).findings()
        assert finding[:3] == (name, bar.most + 1e-6, bar.most)
        assert f"(at most {bar.most * bar.factor:g})" in finding.text and "nan" not in finding.text
        shown = re.findall(r"\d[\d.]*", finding.text.split(" (at most")[0])[-1]
        assert float(shown) > bar.most * bar.factor, finding.text


def calm() -> Plausibility:
    return Plausibility(**{name: "" if kind is str else 0.0 for name, kind in Plausibility.__annotations__.items()})


def test_nothing_is_seen_of_what_is_not_a_number(high: tuple[MotionRequest, Motion]) -> None:
    """A motion with NaN is not plausible, whatever else it is."""
    request, motion = high
    configuration = motion.configuration.copy()
    configuration[800, :] = np.nan
    assert seen(request, motion, configuration=configuration).findings()
    assert measure(request, replace(motion, configuration=configuration)).kept_as() == "implausible"

"""The posture over a motion: known postures, a second reading by MuJoCo, and loads."""

from dataclasses import replace

import numpy as np
import pytest
from second_reading import SIDES, readings

from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.posture import PostureCourse
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human, joint_index, stand
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.reaction import Reaction

# What the second reading calls what.
NAMES = {
    "trunk_deg": "trunk", "trunk_side_deg": "trunk_side", "trunk_twist_deg": "trunk_twist", "neck_deg": "neck",
    "neck_side_deg": "neck_side", "neck_twist_deg": "neck_twist", "head_deg": "head",
}  # fmt: skip
SIDED = {
    "arm_to_trunk_deg": "arm", "arm_abducted_deg": "arm_abducted", "arm_forward_deg": "arm_forward",
    "arm_raised_deg": "arm_raised", "elbow_deg": "elbow", "hand_out_m": "hand_out_m", "foot_share": "foot_share",
    "pronation_deg": "pronation", "wrist_deg": "wrist", "deviation_deg": "deviation", "knee_deg": "knee",
}  # fmt: skip


def standing(paper: Experiment, motion: Motion, **angles_deg: float) -> Motion:
    """A motion that stands still, upright but for some joint angles."""
    angles = np.zeros(len(DEGREES_OF_FREEDOM))
    for name, degrees in angles_deg.items():
        angles[joint_index(name)] = np.radians(degrees)
    human = build_human(paper.workers["average_man"])
    return replace(motion, configuration=np.tile(stand(human.model, angles), (len(motion.configuration), 1)))


@pytest.mark.parametrize(
    ("posture", "expected"),
    [
        ({}, {"trunk_deg": 0, "neck_deg": 0, "arm_to_trunk_deg": (0, 0), "elbow_deg": (0, 0), "trunk_twist_deg": 0}),
        ({"right_shoulder_flexion": 70}, {"arm_to_trunk_deg": (70, 0), "arm_raised_deg": (70, 0)}),
        ({"right_shoulder_flexion": -40}, {"arm_to_trunk_deg": (-40, 0), "arm_forward_deg": (-40, 0)}),
        ({"left_shoulder_abduction": 50}, {"arm_to_trunk_deg": (0, 50), "arm_abducted_deg": (0, 50)}),
        ({"right_shoulder_abduction": -20}, {"arm_abducted_deg": (-20, 0), "arm_to_trunk_deg": (20, 0)}),
        ({"neck_flexion": 15, "head_flexion": 5}, {"neck_deg": 20, "head_deg": 20, "trunk_deg": 0}),
        ({"neck_flexion": -15}, {"neck_deg": -15, "head_deg": -15}),
        ({"neck_rotation": 40}, {"neck_twist_deg": 40, "head_deg": 0}),
        ({"lumbar_lateral": 12}, {"trunk_side_deg": 12}),
        ({"lumbar_rotation": -15}, {"trunk_twist_deg": -15}),
        # bent at the hips: hanging arms go with the trunk, the head looks down
        (
            {"right_hip_flexion": 65, "left_hip_flexion": 65},
            {"trunk_deg": 65, "head_deg": 65, "neck_deg": 0, "arm_raised_deg": (65, 65), "arm_to_trunk_deg": (0, 0)},
        ),
        ({"right_hip_flexion": -15, "left_hip_flexion": -15}, {"trunk_deg": -15}),
        # less than the tolerance: upright, as people sway
        ({"right_hip_flexion": -3, "left_hip_flexion": -3}, {"trunk_deg": 3}),
    ],
)
def test_known_postures(
    paper: Experiment, reactions: tuple[Reaction, ...], posture: dict[str, float], expected: dict[str, object]
) -> None:
    person = paper.workers["average_man"].anthropometry()
    seen = PostureCourse.of(person, standing(paper, reactions[0].motion, **posture), step_s=4)
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(seen, name)[0], value, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("stride", [97, pytest.param(1, marks=pytest.mark.slow)])
def test_mujoco_sees_the_same(reactions: tuple[Reaction, ...], stride: int) -> None:
    for reaction in reactions:
        course = Operation.of(reaction, step_s=0).posture
        for tick, read in readings(reaction, stride).items():
            found = {name: getattr(course, name)[tick] for name in NAMES} | {
                f"{side} {name}": getattr(course, name)[tick, i] for name in SIDED for i, side in enumerate(SIDES)
            }
            expected = {name: read[key] for name, key in NAMES.items()} | {
                f"{side} {name}": read[f"{side}_{key}"] for name, key in SIDED.items() for side in SIDES
            }
            np.testing.assert_allclose(list(found.values()), list(expected.values()), atol=1e-5, err_msg=str(tick))
            heights = [read[f"{side}_hand_height_m"] for side in SIDES]
            np.testing.assert_allclose(course.hand_m[tick, :, 2], heights, atol=1e-7)


def test_a_course_takes_every_so_many_ticks(reactions: tuple[Reaction, ...]) -> None:
    all_ticks, tenth = (Operation.of(reactions[0], step_s=step).posture for step in (0.0, 0.1))
    assert (len(all_ticks.time_s), len(tenth.time_s), tenth.step_s) == (1600, 160, 0.1)
    np.testing.assert_array_equal(all_ticks.arm_raised_deg[::10], tenth.arm_raised_deg)


def test_the_load_is_what_the_hands_bear(reactions: tuple[Reaction, ...]) -> None:
    """The paper's worker holds 5 kg in the right hand; what is stated goes before it."""
    np.testing.assert_array_equal(Operation.of(reactions[0]).load_kg, np.tile([5.0, 0.0], (160, 1)))
    stated = Operation.of(reactions[0], Circumstances(load_kg=3))
    np.testing.assert_array_equal(stated.load_kg, np.tile([3.0, 0.0], (160, 1)))
    force = np.zeros_like(reactions[0].motion.hand_force_n)
    force[:, 3:] = 0, 30, -40
    pushing = replace(reactions[0], motion=replace(reactions[0].motion, hand_force_n=force))
    np.testing.assert_allclose(Operation.of(pushing).load_kg, np.tile([5.0, 50 / 9.81], (160, 1)))


def test_torques_are_shares_of_the_strength_in_their_direction(reactions: tuple[Reaction, ...]) -> None:
    operation = Operation.of(reactions[0], step_s=0)
    request, torque = operation.request, reactions[0].motion.torque_nm
    for tick in (0, 700, 1599):
        for joint, name in enumerate(DEGREES_OF_FREEDOM):
            limits = request.maximum_torque.positive_nm, request.maximum_torque.negative_nm
            expected = torque[tick, joint] / limits[int(torque[tick, joint] < 0)][joint]
            assert operation.torque_share[tick, joint] == pytest.approx(expected, abs=1e-12), name

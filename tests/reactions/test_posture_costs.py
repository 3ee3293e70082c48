"""Posture costs: known postures, the paper's motions against an independent chain of rotations, and own kinds."""

from dataclasses import replace

import numpy as np
import pytest

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.cost_settings import CostSettings
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human, joint_index, stand
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.posture_costs.posture_cost import positions_m
from fatigue_planner.reactions.posture_costs.trunk_bent import TrunkBent
from fatigue_planner.reactions.posture_costs.upper_arm_raised import UpperArmRaised
from fatigue_planner.reactions.reaction import Reaction

ARM, TRUNK = UpperArmRaised(kind="upper_arm_raised", weight=0.5), TrunkBent(kind="trunk_bent", weight=2.0)


def standing(paper: Experiment, motion: Motion, **angles_deg: float) -> Motion:
    """A motion that stands still, upright but for some joint angles."""
    angles = np.zeros(39)
    for name, degrees in angles_deg.items():
        angles[joint_index(name)] = np.radians(degrees)
    human = build_human(paper.workers["average_man"])
    return replace(motion, configuration=np.tile(stand(human.model, angles), (4, 1)))


@pytest.mark.parametrize(
    ("posture", "arm", "trunk"),
    [
        ({}, 0, 0),
        ({"right_shoulder_flexion": 59}, 0, 0),
        ({"right_shoulder_flexion": 61}, 1, 0),
        ({"left_shoulder_abduction": 61}, 1, 0),
        ({"left_shoulder_flexion": -50, "right_shoulder_flexion": 50}, 0, 0),
        # bent at the hips: the pelvis turns over the legs that stand; hanging arms go forward with the trunk
        ({"right_hip_flexion": 65, "left_hip_flexion": 65}, 1, 1),
        ({"right_hip_flexion": 55, "left_hip_flexion": 55}, 0, 0),
        (
            {
                "right_hip_flexion": 65,
                "left_hip_flexion": 65,
                "right_shoulder_flexion": 65,
                "left_shoulder_flexion": 65,
            },
            0,
            1,
        ),
    ],
)
def test_known_postures(
    paper: Experiment, reactions: tuple[Reaction, ...], posture: dict[str, float], arm: int, trunk: int
) -> None:
    human = build_human(paper.workers["average_man"])
    motion = standing(paper, reactions[0].motion, **posture)
    assert (ARM.of(human, motion), TRUNK.of(human, motion)) == (0.5 * arm, 2.0 * trunk)


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def test_the_upper_arm_is_where_a_chain_of_rotations_puts_it(
    paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """Pelvis' quaternion, lumbar, thoracic and shoulder axes by hand, for every reaction at some ticks."""
    human = build_human(paper.workers["average_man"])
    x, y, z = np.eye(3)
    chain = [
        (y, "lumbar_flexion"), (x, "lumbar_lateral"), (z, "lumbar_rotation"), (y, "thoracic_flexion"),
        (x, "thoracic_lateral"), (z, "thoracic_rotation"), (-y, "right_shoulder_flexion"),
        (-x, "right_shoulder_abduction"), (z, "right_shoulder_rotation"),
    ]  # fmt: skip
    for reaction in reactions:
        motion = replace(reaction.motion, configuration=reaction.motion.configuration[::97])
        shoulder, elbow = np.moveaxis(positions_m(human, motion, ["right_upper_arm", "right_forearm"]), 1, 0)
        for tick, configuration in enumerate(motion.configuration):
            *vector, scalar = configuration[3:7]
            turned = rotation(
                np.array(vector) / max(np.linalg.norm(vector), 1e-300), 2 * np.arctan2(np.linalg.norm(vector), scalar)
            )
            for axis, name in chain:
                turned = turned @ rotation(axis, configuration[7 + joint_index(name)])
            along = elbow[tick] - shoulder[tick]
            np.testing.assert_allclose(along / np.linalg.norm(along), -turned[:, 2], atol=1e-9)


def test_the_posture_is_part_of_the_cost_of_its_reaction(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """In low/back the trunk is bent beyond 60°; what it costs is added to every reward."""
    chosen = paper.model_copy(update={"cost": CostSettings(posture=(ARM, TRUNK))})
    profiles = cycle_profiles(chosen, reactions)
    raised = {str(name): profile.posture_cost for name, profile in profiles.items()}
    human = build_human(paper.workers["average_man"])
    assert raised == {str(r.name): ARM.of(human, r.motion) + TRUNK.of(human, r.motion) for r in reactions}
    assert [name for name, cost in raised.items() if cost > 0.1] == ["average_man/low/back"]
    condition = paper.benchmark.conditions["single_novice"]
    with_posture, without = (scenario(one, cycle_profiles(one, reactions), condition).model for one in (chosen, paper))
    for a, action in enumerate(paper.actions):
        for u, preference in enumerate(paper.preferences):
            state = without.state(np.zeros(78))
            costs = [-model.transition(state, a, u)[1] for model in (with_posture, without)]
            assert costs[0] - costs[1] == pytest.approx(raised[f"average_man/{action}/{preference}"], abs=1e-12)

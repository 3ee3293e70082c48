"""Percent capable, holding time, acceptable effort, compression: published values, and sums by hand over a motion."""

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from test_posture import standing

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.indicators.acceptable_effort import AcceptableEffort, acceptable_effort
from fatigue_planner.ergonomics.indicators.holding_time import HoldingTime, endurance_s, sjogaard_s
from fatigue_planner.ergonomics.indicators.l5s1_compression import L5S1Compression, compression_n, weight_n
from fatigue_planner.ergonomics.indicators.percent_capable import (
    CapableShare,
    PercentCapable,
    capable_percent,
    variation,
)
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment, Level
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import build_human, joint_index
from fatigue_planner.reactions.reaction import Reaction


def one(indicator: Indicator, *operations: Operation, **shift: float) -> Assessment:
    return evaluate(operations, Shift(**shift), [indicator])[0]


def with_torque(reaction: Reaction, joint: str, torque_nm: np.ndarray | float) -> Operation:
    """An operation in which one joint alone has a torque."""
    only = np.zeros_like(reaction.motion.torque_nm)
    only[:, joint_index(joint)] = torque_nm
    motion = replace(reaction.motion, torque_nm=only, tissue_nm=np.zeros_like(only))
    return replace(Operation.of(reaction), motion=motion)


def test_endurance_as_published() -> None:
    """At 30 % of the strength by Frey Law & Avin (2010); at 20 % by Sjøgaard, from ErgoCalculator's example."""
    groups = {"general": 238, "ankle": 415, "back": 349, "elbow": 257, "wrist": 233, "knee": 186, "shoulder": 135}
    assert {group: round(float(endurance_s(np.array([0.3]), group)[0])) for group in groups} == groups
    assert float(sjogaard_s(np.array([0.2]))[0]) / 60 == pytest.approx(9.385, abs=0.0005)
    assert np.isinf(endurance_s(np.array([0.149]), "knee")).all()
    assert np.isinf(sjogaard_s(np.array([0.0]))).all()


def test_acceptable_efforts_as_computed() -> None:
    found = acceptable_effort(np.array([0.01, 0.05, 0.1, 0.2, 0.3]))
    assert [round(float(effort), 2) for effort in found] == [0.67, 0.51, 0.42, 0.32, 0.25]
    assert acceptable_effort(np.array([1 / 28_800]))[0] == 1


def test_capable_shares_are_those_of_a_normal_distribution() -> None:
    for load, mean, cv in ((50, 80, 0.277), (100, 100, 0.2), (130, 100, 0.3), (10, 100, 0.15)):
        expected = 100 * (1 - NormalDist(mean, cv * mean).cdf(load))
        assert float(capable_percent(load, mean, cv)) == pytest.approx(expected, abs=1e-9)
    assert [CapableShare.level_of(percent) for percent in (75, 74.9, 25, 24.9)] == [
        Level.ACCEPTABLE, Level.INVESTIGATE, Level.INVESTIGATE, Level.NOT_ACCEPTABLE,
    ]  # fmt: skip


def test_variations_of_strength() -> None:
    assert variation("right_hip_flexion", "male") == (0.22, 0.30)
    assert variation("left_ankle_flexion", "female") == (0.22, 0.33)
    assert variation("left_shoulder_abduction", "male") == (0.277, 0.277)
    assert variation("lumbar_lateral", "female") == (0.28, 0.28)


def test_the_weakest_joint_decides_how_many_are_capable(reactions: tuple[Reaction, ...]) -> None:
    """A torque of the average man's strength: half of the men; 60 N.m of shoulder extension, of 85: 86 %."""
    nm = maximum_torque("average_man").negative_nm[joint_index("right_shoulder_flexion")]
    half = one(PercentCapable(), with_torque(reactions[0], "right_shoulder_flexion", -nm))
    assert half.value == (pytest.approx(50), pytest.approx(50))
    assert half.levels == (Level.INVESTIGATE, Level.INVESTIGATE)
    assert half.worst is not None
    assert half.worst[2:] == ("right", "shoulder flexion")
    most = one(PercentCapable(), with_torque(reactions[0], "right_shoulder_flexion", -60.0))
    assert most.value is not None
    assert most.value.low == pytest.approx(100 * (1 - NormalDist(nm, 0.277 * nm).cdf(60)))
    woman = with_torque(reactions[0], "lumbar_flexion", -100.0)
    worker = woman.request.worker.model_copy(update={"sex": "female"})
    woman = replace(woman, request=replace(woman.request, worker=worker))
    found = one(PercentCapable(), woman)
    mean = maximum_torque("average_woman").negative_nm[joint_index("lumbar_flexion")]
    assert found.value is not None
    assert found.value.low == pytest.approx(100 * (1 - NormalDist(mean, 0.28 * mean).cdf(100)))


def test_a_hold_uses_up_its_share_of_the_endurance(reactions: tuple[Reaction, ...]) -> None:
    """16 s at 30 % of the knee's strength: 16 / 186 and, by Sjøgaard, 16 / 237; a rest in between halves it."""
    strength = Operation.of(reactions[0]).request.maximum_torque.positive_nm[joint_index("left_knee_flexion")]
    torque = np.full(1600, 0.3 * strength)
    held = one(HoldingTime(), with_torque(reactions[0], "left_knee_flexion", torque))
    shares = [100 * 16 / (19.38 * 0.3**-1.88), 100 * 16 / (60 * 5710 / 30**2.14)]
    assert held.value == pytest.approx(sorted(shares))
    assert held.worst is not None
    assert held.worst[2:] == ("left", "knee flexion")
    torque[795:805] = 0
    rested = one(HoldingTime(), with_torque(reactions[0], "left_knee_flexion", torque))
    assert rested.value is not None
    assert rested.value.high == pytest.approx(max(shares) / 2, rel=0.02)
    nothing = one(HoldingTime(), with_torque(reactions[0], "left_knee_flexion", 0.1 * strength))
    assert (nothing.value, nothing.worst) == ((0, 0), None)


def test_an_effort_is_compared_with_what_is_acceptable_for_as_long(reactions: tuple[Reaction, ...]) -> None:
    """40 % of the strength for 8 s: in a cycle of 16 s too much, in one of 160 s acceptable."""
    strength = Operation.of(reactions[0]).request.maximum_torque.positive_nm[joint_index("right_elbow_flexion")]
    torque = np.where(np.arange(1600) < 800, 0.4, 0.05) * strength
    operation = with_torque(reactions[0], "right_elbow_flexion", torque)
    busy, idle = one(AcceptableEffort(), operation), one(AcceptableEffort(), operation, cycle_s=160)
    for found, duty in ((busy, 0.5), (idle, 0.05)):
        assert found.value is not None
        allowed = 1 - (duty - 1 / 28_800) ** 0.24
        assert found.value.low == pytest.approx(0.4 / allowed, rel=1e-6)
        assert found.parts["duty cycle"] == pytest.approx(duty)
    assert busy.levels == (Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE)
    assert idle.levels == (Level.ACCEPTABLE, Level.ACCEPTABLE)
    assert busy.worst is not None
    assert busy.worst[2:] == ("right", "elbow flexion")


def test_the_share_of_the_cycle_is_of_the_operations_own_time(reactions: tuple[Reaction, ...]) -> None:
    """Judged every 0.3 s, a load for 8 of 16 s in a cycle of 160 s is one for 26 or 27 of 54 instants."""
    strength = Operation.of(reactions[0]).request.maximum_torque.positive_nm[joint_index("right_elbow_flexion")]
    torque = np.where(np.arange(1600) < 810, 0.4, 0.0) * strength
    operation = replace(with_torque(reactions[0], "right_elbow_flexion", torque), step_s=0.3)
    found = one(AcceptableEffort(), operation, cycle_s=160)
    assert found.parts["duty cycle"] == pytest.approx(27 / 54 * 16 / 160)


def test_compression_of_an_example() -> None:
    """200 N.m and 450 N at 60 degrees: 2.9 to 4.2 kN, 3.6 with a lever of 6 cm."""
    forces = [
        float(compression_n(np.array([200.0]), np.array([450.0]), np.array([60.0]), lever)[0]) / 1000
        for lever in (0.075, 0.06, 0.05)
    ]
    assert [round(force, 1) for force in forces] == [2.9, 3.6, 4.2]


def test_compression_of_a_motion(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """The weight above L5/S1 as pinocchio's subtree has it; moments of muscles and tissue together."""
    human = build_human(paper.workers["average_man"])
    above = sum(
        human.model.inertias[joint].mass for joint in human.model.subtrees[human.model.getJointId("lumbar_flexion")]
    )
    operation = with_torque(reactions[0], "lumbar_flexion", -100.0)
    np.testing.assert_allclose(weight_n(operation), (above + 5) * 9.81)
    upright = replace(operation, motion=replace(operation.motion, configuration=standing(
        paper, reactions[0].motion).configuration))  # fmt: skip
    found = one(L5S1Compression(), upright)
    weight_kn = (above + 5) * 9.81 / 1000
    assert found.value == pytest.approx((0.1 / 0.075 + weight_kn, 0.1 / 0.05 + weight_kn))
    tissue = np.zeros_like(upright.motion.torque_nm)
    tissue[:, joint_index("lumbar_flexion")] = -60.0
    tissue[:, joint_index("lumbar_lateral")] = 120.0
    more = one(L5S1Compression(), replace(upright, motion=replace(upright.motion, tissue_nm=tissue)))
    assert more.value is not None
    assert more.value.high == pytest.approx(math.hypot(0.16, 0.12) / 0.05 + weight_kn)
    assert more.levels == (Level.ACCEPTABLE, Level.INVESTIGATE)
    assert more.text() == "3.1 to 4.4 kN"

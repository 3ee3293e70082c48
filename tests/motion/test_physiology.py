"""The natural human: what each piece of his physiology does, and that all of them together move plausibly."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import parse_experiment
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import build_human, joint_index
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.passive_moments import passive_moments_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.physiology import hand_turn, registry
from fatigue_planner.motion.physiology.clearance import APART_M, ROWS, Clearance
from fatigue_planner.motion.physiology.end_zones import EndZones
from fatigue_planner.motion.physiology.facing import Facing, heading
from fatigue_planner.motion.physiology.gaze import EYES_ASIDE_RAD, EYES_DOWN_RAD, EYES_UP_RAD, head_axes
from fatigue_planner.motion.physiology.piece import Bearer
from fatigue_planner.motion.physiology.stops import REACH_RAD, Stops
from fatigue_planner.motion.plausibility import Plausibility, measure_plausibility
from fatigue_planner.motion.posture_measures import turn
from fatigue_planner.motion.simulator import Simulator, simulate
from fatigue_planner.motion.verification import measure

POSE = {"position_m": {"x": 0.4, "y": -0.15, "z": 0.5}, "orientation_deg": {"y": -90}}
CONTENT = {
    "name": "natural",
    "human": "natural",
    "tool": {"mass_kg": 5},
    "cycle": {"reach_s": 3.0, "work_s": 1.0, "return_s": 3.0},
    "actions": {"low": {"right_hand": POSE}},
    "preferences": {
        "arm": {"tasks": ({"kind": "segment_upright", "segment": "thorax", "weight": 1, "stiffness_per_s2": 80},)},
        "back": {"tasks": ({"kind": "segment_upright", "segment": "right_upper_arm", "weight": 10},)},
    },
}
EXPERIMENT = parse_experiment(CONTENT, "natural")
REQUESTS = {request.name.preference: request.motion for request in reaction_requests(EXPERIMENT)}


@pytest.fixture(scope="module")
def motions() -> dict[str, Motion]:
    return {name: simulate(request) for name, request in REQUESTS.items()}


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """Take a piece away from the natural human."""

    def take(piece: type) -> None:
        left = tuple(other for other in registry.PIECES["natural"] if other is not piece)
        assert len(left) == len(registry.PIECES["natural"]) - 1
        monkeypatch.setitem(registry.PIECES, "natural", left)

    return take


def seen(request: MotionRequest, motion: Motion) -> Plausibility:
    return measure_plausibility(request, motion)


def test_low_reaches_are_plausible_and_differ_as_they_should(motions: dict[str, Motion]) -> None:
    leans = {}
    for name, motion in motions.items():
        assert measure(REQUESTS[name], motion).faults(EXPERIMENT.accuracy) == []
        assert seen(REQUESTS[name], motion).findings() == []
        assert not motion.eased_radps2.any()
        leans[name] = seen(REQUESTS[name], motion).lean_deg
    assert leans["arm"] <= 50 and leans["back"] - leans["arm"] >= 25


def test_muscles_bear_what_tissue_does_not(motions: dict[str, Motion]) -> None:
    """Muscles' torque = M a + h - J' w less the published moments at the end of the tick, by RNEA."""
    request, motion = REQUESTS["arm"], motions["arm"]
    human = build_human(request.worker, right_hand_kg=5)
    model, data, step = human.model, human.model.createData(), motion.time_step_s
    stretched = 0.0
    for tick in range(0, len(motion.torque_nm), 7):
        q, v, a = motion.configuration[tick], motion.velocity[tick], motion.acceleration[tick]
        total = pin.rnea(model, data, q, v, a)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        for side, wrench in zip(("right", "left"), motion.wrench[tick].reshape(2, 6), strict=True):
            total -= wrench @ pin.getFrameJacobian(model, data, model.getFrameId(f"{side}_sole"), pin.LOCAL)
        passive = passive_moments_of(human.anthropometry, q[7:] + step * (v + step * a)[BASE_DOF:])
        np.testing.assert_allclose(motion.torque_nm[tick], total[BASE_DOF:] - passive, atol=1e-8)
        stretched = max(stretched, np.abs(passive).max())
    assert stretched > 5  # in a squat hips, knees and ankles are


def test_what_is_stored_of_the_tissue_is_checked(motions: dict[str, Motion]) -> None:
    request, motion = REQUESTS["back"], motions["back"]
    assert measure(request, motion).tissue_violation_nm < 1e-9
    lent = motion.tissue_nm.copy()
    lent[100, joint_index("lumbar_flexion")] -= 1  # the muscles' torque borne by tissue that does not
    paid = motion.torque_nm.copy()
    paid[100, joint_index("lumbar_flexion")] += 1
    faults = measure(request, replace(motion, tissue_nm=lent, torque_nm=paid)).faults(EXPERIMENT.accuracy)
    assert [fault.split(" = ")[0] for fault in faults] == ["tissue_violation_nm"]


def test_a_stop_bears_inward_torque_within_a_degree_of_the_end() -> None:
    stops, knee = Stops(REQUESTS["arm"].worker.anthropometry()), joint_index("right_knee_flexion")
    lumbar = joint_index("lumbar_flexion")
    _, upper = position_limits()

    def borne(joint: int, angle_rad: float, torque_nm: float) -> float:
        angles, torque, moments = np.full(39, 0.3), np.zeros(39), np.zeros(39)
        angles[joint], torque[joint] = angle_rad, torque_nm
        stops.relieve(angles, torque, moments)
        assert not np.delete(moments, joint).any()
        return float(moments[joint])

    assert borne(knee, 0.0, 20) == 20 and borne(knee, REACH_RAD / 2, 20) == pytest.approx(10)
    assert borne(knee, REACH_RAD, 20) == 0 and borne(knee, 0.0, -20) == 0
    assert borne(lumbar, upper[lumbar], -50) == -50 and borne(lumbar, upper[lumbar], 50) == 0
    assert borne(joint_index("right_hip_flexion"), upper[joint_index("right_hip_flexion")], -50) == 0


class Corset(Bearer):
    """A new piece: a corset that carries a tenth of the lumbar bending."""

    def relieve(self, angles: np.ndarray, torque_nm: np.ndarray, moments: np.ndarray) -> None:
        lumbar = joint_index("lumbar_flexion")
        moments[lumbar] += 0.1 * (torque_nm[lumbar] - moments[lumbar])


def test_a_new_piece_is_a_class_and_a_line(motions: dict[str, Motion], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.PIECES, "natural", (*registry.PIECES["natural"], Corset))
    request = REQUESTS["back"]
    motion, lumbar = simulate(request), joint_index("lumbar_flexion")
    np.testing.assert_allclose(motion.torque_nm[:, lumbar], 0.9 * motions["back"].torque_nm[:, lumbar], atol=1e-9)
    assert measure(request, motion).faults(EXPERIMENT.accuracy) == []


def test_parts_of_the_body_pass_through_each_other_only_without_clearance(without: object) -> None:
    goal = {"position_m": {"x": 0.15, "y": 0.15, "z": 0.95}}  # a fist before the belly
    request = replace(REQUESTS["arm"], action=Action.model_validate({"right_hand": goal}))
    assert seen(request, simulate(request)).penetration_m < APART_M
    without(Clearance)
    assert seen(request, simulate(request)).penetration_m > 3 * APART_M


def test_rows_of_clearance_are_how_distances_change() -> None:
    """At a moving body in mid-reach: d(t + h) - d(t - h) = 2 h n . (J_1 - J_2) v."""
    simulator = Simulator(REQUESTS["arm"])
    for tick in range(200):
        simulator.prepare(tick)
        simulator.advance(simulator.body.controller.step().acceleration)
    simulator.prepare(200)
    clearance = next(piece for piece in simulator.body.physiology.pieces if isinstance(piece, Clearance))
    state, rows, least = simulator.body.state, np.zeros((ROWS, 45)), np.zeros(ROWS)
    clearance.limit(rows, least)
    q, v, h, used = simulator.configuration, simulator.velocity, 1e-6, np.isfinite(least)
    nearest = np.sort(clearance._nearest()[0])[: used.sum()]
    order = np.argsort(clearance._nearest()[0])[: used.sum()]
    assert used.any() and np.abs(v).max() > 0.1 and nearest.max() < 0.08
    after, before = (
        clearance._nearest()[0][order]
        for configuration in (pin.integrate(state.model, q, h * v), pin.integrate(state.model, q, -h * v))
        for _ in [state.update(configuration, v)]
    )
    np.testing.assert_allclose(rows[used] @ v, (after - before) / (2 * h), atol=1e-5)


def test_no_zone_moves_a_worker_who_stands() -> None:
    body = Simulator(REQUESTS["arm"]).body
    zones = next(piece for piece in body.physiology.pieces if isinstance(piece, EndZones))
    weight, target = np.ones(39), np.zeros(39)
    zones.draw(weight, target)
    assert weight.tolist() == [1.0] * 39 and not target.any()
    elbow = joint_index("right_elbow_flexion")
    body.state.configuration = body.state.configuration.copy()
    body.state.configuration[7 + elbow] = 0.0  # from 5 degrees to the end: all of the zone
    zones.draw(weight, target)
    assert weight[elbow] == pytest.approx(51) and target[elbow] == pytest.approx(50 / 51 * 40 * np.radians(5))


@pytest.mark.parametrize(("elevation", "pitch"), [(-60, -40), (-15, 0), (8, 0), (40, 30)])
def test_the_head_turns_level_and_leaves_a_part_to_the_eyes(elevation: float, pitch: float) -> None:
    up, aside = np.radians(elevation), np.radians(35)
    axes = head_axes(np.array([np.cos(up) * np.cos(aside), np.cos(up) * np.sin(aside), np.sin(up)]), 0.0)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert axes[2, 1] == 0 and np.degrees(np.arcsin(axes[2, 0])) == pytest.approx(pitch)
    assert np.degrees(np.arctan2(axes[1, 0], axes[0, 0])) == pytest.approx(20)
    assert np.degrees([EYES_DOWN_RAD, EYES_UP_RAD, EYES_ASIDE_RAD]) == pytest.approx([20, 10, 15])


@pytest.mark.parametrize(
    ("work", "chest", "turned"), [(35, 35, 35), (35, 25, 25), (35, 60, 50), (35, -30, 20), (-155, 170, -170)]
)
def test_the_head_goes_with_the_chest_where_the_eyes_can_do_the_rest(work: float, chest: float, turned: float) -> None:
    aside = np.radians(work)
    axes = head_axes(np.array([np.cos(aside), np.sin(aside), 0.0]), float(np.radians(chest)))
    assert np.degrees(np.arctan2(axes[1, 0], axes[0, 0])) == pytest.approx(turned)


def ahead() -> MotionRequest:
    """The right hand, before the midline, as far as the straight arm: whoever turns brings the shoulder forward."""
    goal = {"position_m": {"x": 0.49, "y": 0.0, "z": 0.9}}
    return replace(REQUESTS["arm"], action=Action.model_validate({"right_hand": goal}))


def turned_deg(motion: Motion) -> tuple[float, float]:
    """Pelvis on the feet, and head in the chest, in the middle of the work."""
    middle = motion.middle("work")
    poses = poses_of(tree_of(REQUESTS["arm"].worker.anthropometry()), motion.configuration[middle : middle + 1])
    pelvis, neck = poses.rotation[0, BODIES.index("pelvis")], turn(poses, "head", "thorax")[0]
    return float(np.degrees(heading(pelvis))), float(np.degrees(np.arctan2(neck[1, 0], neck[1, 1])))


def test_the_pelvis_faces_where_the_feet_point(without: object) -> None:
    request = ahead()
    motion = simulate(request)
    assert seen(request, motion).findings() == [] and measure(request, motion).faults(EXPERIMENT.accuracy) == []
    pelvis, neck = turned_deg(motion)
    without(Facing)
    free_pelvis, free_neck = turned_deg(simulate(request))
    assert 0 < pelvis < 0.6 * free_pelvis and free_pelvis > 25
    assert 0 > neck > 0.6 * free_neck


def test_where_a_body_faces_is_what_its_left_side_says_and_how_it_turns() -> None:
    """Leaning does not count; and in mid-reach d heading / dt is the task's row times v."""
    for leaning in (0, 60, 120):
        rotation = pin.rpy.rpyToMatrix(0.0, np.radians(leaning), np.radians(-40))
        assert np.degrees(heading(rotation)) == pytest.approx(-40)
    simulator = Simulator(ahead())
    for tick in range(150):
        simulator.prepare(tick)
        simulator.advance(simulator.body.controller.step().acceleration)
    simulator.prepare(150)
    task = next(piece.task for piece in simulator.body.physiology.pieces if isinstance(piece, Facing))
    state, row, target = simulator.body.state, np.zeros((1, 45)), np.zeros(1)
    q, v, h = simulator.configuration, simulator.velocity, 1e-5
    task.evaluate(state, row, target)
    now = heading(state.placement(task.frame).rotation)
    state.update(pin.integrate(state.model, q, h * v), v)
    later = heading(state.placement(task.frame).rotation)
    assert row[0] @ v == pytest.approx((later - now) / h, rel=0.05)
    state.update(q, np.zeros_like(v))
    task.evaluate(state, row, target)  # at rest nothing but the stiffness draws
    assert now > np.radians(1) and target[0] == pytest.approx(-4 * now)


def overhead(y_deg: float) -> MotionRequest:
    goal = {"position_m": {"x": 0.3, "y": -0.2, "z": 1.75}, "orientation_deg": {"y": y_deg}}
    empty = REQUESTS["arm"].tool.model_copy(update={"mass_kg": 0.0})
    paced = REQUESTS["arm"].cycle.model_copy(update={"reach_s": 5.0, "return_s": 5.0})  # the paper's
    return replace(REQUESTS["arm"], tool=empty, cycle=paced, action=Action.model_validate({"right_hand": goal}))


def test_a_hand_turns_the_way_round_that_its_shoulder_allows() -> None:
    """An arm is raised forward by 200 degrees, not backward by 160."""
    request = overhead(160)
    paths = {side: task.reference for side, task in Simulator(request).body.hands.items()}
    ways = list(hand_turn.ways_round(paths, 500))
    assert ways == [frozenset(), frozenset({"right"})]
    assert paths["right"].velocity[250, 4] > 0  # the shortest way: backward
    motion = simulate(request)
    assert seen(request, motion).findings() == [] and measure(request, motion).faults(EXPERIMENT.accuracy) == []
    assert motion.configuration[500:600, 7 + joint_index("right_shoulder_flexion")].min() > np.radians(90)


def test_a_hand_that_can_turn_neither_way_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    request = overhead(160)
    weak = tuple(0.05 * torque for torque in request.maximum_torque.positive_nm)
    weak_worker = request.maximum_torque.model_copy(update={"positive_nm": weak, "negative_nm": weak})
    with pytest.raises(FailedMotionError, match=r"^no admissible movement at t = "):
        simulate(replace(request, maximum_torque=weak_worker))


def test_a_brisk_cycle_ends_at_home_all_the_same() -> None:
    brisk = REQUESTS["arm"].cycle.model_copy(update={"reach_s": 2.0, "return_s": 2.0})
    request = replace(REQUESTS["arm"], cycle=brisk)
    found = seen(request, simulate(request))
    assert found.end_pose_deg < 1 and found.end_speed_degps < 1

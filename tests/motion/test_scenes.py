"""Any action, load and preference: hands, paths, forces, masses, phases, and the experiments that show them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human, joint_index
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.motion.action import Action, HandGoal, Orientation, Position, Waypoint
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.minimum_jerk import Pose, minimum_jerk
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.payload import CarriedMass, FromFist, HandForce, TimedForce
from fatigue_planner.motion.schedule import SWITCH_S, Run, hand_reference, phases_of, runs_of, weight_factor_of
from fatigue_planner.motion.settings import PHASES, Cycle
from fatigue_planner.motion.simulator import Simulator, simulate
from fatigue_planner.motion.tasks.centre_of_mass import CentreOfMass
from fatigue_planner.motion.tasks.hand import Hand
from fatigue_planner.motion.tasks.joint_posture import JointPosture
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.tasks.segment_orientation import SegmentOrientation
from fatigue_planner.motion.tasks.segment_position import SegmentPosition
from fatigue_planner.motion.tasks.task import Coordinates
from fatigue_planner.motion.verification import measure

EXPERIMENTS = ROOT / "experiments"
SHORT = Cycle(reach_s=2.0, work_s=1.0, return_s=2.0)
FORWARD = Orientation(y=-90.0)


@pytest.fixture
def request_(paper: Experiment) -> MotionRequest:
    """The paper's high arm reaction in five seconds, with empty hands."""
    request = reaction_requests(paper)[0].motion
    return replace(request, cycle=SHORT, tool=request.tool.model_copy(update={"mass_kg": 0.0}))


def places(request: MotionRequest, motion: Motion, frame: str, tick: int) -> pin.SE3:
    human = build_human(request.worker)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, motion.configuration[tick])
    return data.oMf[human.model.getFrameId(frame)]


def good(request: MotionRequest, motion: Motion, paper: Experiment) -> None:
    loose = paper.accuracy.model_copy(update={"hand_error_m": 0.02})
    assert measure(request, motion).faults(loose) == []


def test_the_left_hand_is_the_mirror_of_the_right(request_: MotionRequest) -> None:
    """The same target on the other side: the mirrored motion, torque by torque."""
    preference = Preference(tasks=())
    right = request_.action.right_hand
    mirrored = HandGoal(
        position_m=right.position_m.model_copy(update={"y": -right.position_m.y}), orientation_deg=FORWARD
    )
    ours = simulate(replace(request_, preference=preference))
    theirs = simulate(replace(request_, preference=preference, action=Action(left_hand=mirrored)))
    for joint in ("shoulder_flexion", "shoulder_abduction", "elbow_flexion", "wrist_deviation", "hip_flexion"):
        for side, other in (("right", "left"), ("left", "right")):
            np.testing.assert_allclose(
                ours.torque_nm[:, joint_index(f"{side}_{joint}")],
                theirs.torque_nm[:, joint_index(f"{other}_{joint}")],
                atol=1e-6,
            )


def test_both_hands_without_orientation(request_: MotionRequest, paper: Experiment) -> None:
    goals = {f"{side}_hand": HandGoal(position_m=Position(x=0.4, y=y, z=1.0)) for side, y in
             (("right", -0.15), ("left", 0.2))}  # fmt: skip
    request = replace(request_, action=Action(**goals))
    motion = simulate(request)
    good(request, motion, paper)
    middle = (motion.phase("work").start + motion.phase("work").stop) // 2
    for goal, side in ((goals["right_hand"], "right"), (goals["left_hand"], "left")):
        target = [goal.position_m.x, goal.position_m.y, goal.position_m.z]
        assert np.linalg.norm(places(request, motion, f"{side}_grip", middle).translation - target) < 0.01
    # free to turn: the hands are not where {y: -90} would have them
    assert abs(places(request, motion, "right_grip", middle).rotation[2, 2]) > 0.05


def test_a_path_is_followed_from_waypoint_to_waypoint(request_: MotionRequest, paper: Experiment) -> None:
    points = [(0.0, 0.9), (1.0, 1.1), (2.0, 0.9)]
    path = tuple(
        Waypoint(work_time_s=time, position_m=Position(x=0.4, y=-0.2, z=z), orientation_deg=FORWARD)
        for time, z in points
    )
    request = replace(
        request_, cycle=Cycle(reach_s=2.0, work_s=2.5, return_s=2.0), action=Action(right_hand=HandGoal(waypoints=path))
    )
    motion = simulate(request)
    good(request, motion, paper)
    start = motion.phase("work").start
    for time, z in (*points, (0.5, 1.0), (2.4, 0.9)):
        height = places(request, motion, "right_grip", start + round(time / motion.time_step_s)).translation[2]
        assert height == pytest.approx(z, abs=0.007)  # the squat's back pulls at the hand, by 6 mm at the lowest point


@pytest.mark.parametrize("hand", ["right", "left"])
def test_a_weight_as_force_and_as_mass_load_the_joints_alike_at_rest(
    request_: MotionRequest, paper: Experiment, hand: str
) -> None:
    """2 kg held still and 19.62 N downward: the same torque at the wrist, and nearly the same above it.

    The body balances a mass it has in the hand in its stance already, so it stands a little otherwise.
    """
    place = Position(x=0.5, y=-0.2 if hand == "right" else 0.2, z=1.2)
    goal = HandGoal(position_m=place, orientation_deg=FORWARD)
    hands = {f"{hand}_hand": goal}
    still = replace(request_, cycle=Cycle(reach_s=4.0, work_s=6.0, return_s=2.0), preference=Preference(tasks=()))
    mass = replace(still, action=Action(**hands, loads=(CarriedMass(kind="mass", hand=hand, mass_kg=2.0),)))
    force = HandForce(kind="force", hand=hand, frame="world", force_n=(TimedForce(cycle_time_s=0.0, z=-2 * 9.81),))
    pushed = replace(still, action=Action(**hands, loads=(force,)))
    arm = [joint_index(f"{hand}_{joint}") for joint in ("shoulder_flexion", "elbow_flexion", "wrist_deviation")]
    carried, felt = simulate(mass), simulate(pushed)
    good(mass, carried, paper)
    good(pushed, felt, paper)
    end = carried.phase("work").stop - 1
    np.testing.assert_allclose(carried.torque_nm[end, arm], felt.torque_nm[end, arm], rtol=0.02)
    np.testing.assert_allclose(carried.torque_nm[end, arm[-1]], felt.torque_nm[end, arm[-1]], atol=1e-5)
    assert np.abs(felt.torque_nm[end, arm]).min() > 1


def test_a_weight_pushes_as_the_mass_it_belongs_to(paper: Experiment) -> None:
    """At rest, whatever the posture; no motion is simulated."""
    light, heavy = (BodyState(build_human(paper.workers["average_man"], mass)) for mass in (0.0, 3.0))
    configuration = light.configuration.copy()
    configuration[7:] += np.random.default_rng(0).uniform(-0.3, 0.3, 39)
    for state in (light, heavy):
        state.update(configuration, np.zeros(45))
    light.push(light.frame("right_grip"), np.array([0, 0, -3.0 * GRAVITY_MPS2]))
    np.testing.assert_allclose(light.nonlinear_effects, heavy.nonlinear_effects, rtol=0, atol=1e-9)


def test_a_mass_away_from_the_fist_loads_the_joints_by_its_lever(paper: Experiment) -> None:
    """At rest, by virtual work: a joint bears what raises the weight as it turns (differences of its height)."""
    worker, mass, at = paper.workers["average_man"], 3.0, (0.12, -0.03, 0.05)
    empty = build_human(worker)
    full, data = build_human(worker, mass, 0.0, at), empty.model.createData()
    rng, step = np.random.default_rng(0), 1e-6

    def height(q: np.ndarray) -> float:
        pin.framesForwardKinematics(empty.model, data, q)
        return float((data.oMf[empty.model.getFrameId("right_grip")] * np.array(at))[2])

    for _ in range(20):
        q = pin.integrate(empty.model, empty.stance, rng.normal(0, 0.4, 45))
        borne = pin.computeGeneralizedGravity(full.model, full.model.createData(), q)
        borne -= pin.computeGeneralizedGravity(empty.model, empty.model.createData(), q)
        ways = [
            height(pin.integrate(empty.model, q, step * d)) - height(pin.integrate(empty.model, q, -step * d))
            for d in np.eye(45)
        ]
        np.testing.assert_allclose(borne, mass * GRAVITY_MPS2 * np.array(ways) / (2 * step), atol=1e-6)
    assert np.abs(borne[6 + joint_index("right_wrist_deviation")]) > 0.1


def test_a_tool_before_the_thumb_turns_the_wrist(request_: MotionRequest, paper: Experiment) -> None:
    """Held still with the fist forward, 2 kg 10 cm above the fist's centre and 2 kg in it: measured, and told apart."""
    goal = request_.action.right_hand
    still = replace(request_, preference=Preference(tasks=()))
    motions = {}
    for z in (0.0, -0.1):
        load = CarriedMass(kind="mass", hand="right", mass_kg=2.0, centre_of_mass_m=FromFist(z=z))
        request = replace(still, action=Action(right_hand=goal, loads=(load,)))
        motions[z] = simulate(request)
        good(request, motions[z], paper)
        tick = motions[z].phase("work").stop - 1
    wrist = [motion.torque_nm[tick, joint_index("right_wrist_deviation")] for motion in motions.values()]
    # the fist points forward (turned by -90 degrees about y), so that -z of the hand is ahead
    assert abs(abs(wrist[1]) - abs(wrist[0])) == pytest.approx(2.0 * GRAVITY_MPS2 * 0.1, rel=0.1)


def test_masses_in_a_hand_are_one_at_their_centre(paper: Experiment) -> None:
    phases, tool = phases_of(SHORT, 0.01), paper.tool.model_copy(update={"mass_kg": 0.0})
    loads = tuple(
        CarriedMass(kind="mass", hand="right", mass_kg=kg, centre_of_mass_m=FromFist(x=x, z=0.2), during=during)
        for kg, x, during in ((1.0, 0.1, PHASES), (3.0, -0.1, ("work",)))
    )
    runs = runs_of(tool, paper.actions["high"].model_copy(update={"loads": loads}), phases)
    assert [run[2:4] for run in runs] == [(1.0, 0.0), (4.0, 0.0), (1.0, 0.0)]
    np.testing.assert_allclose([run.right_at_m for run in runs], [[0.1, 0, 0.2], [-0.05, 0, 0.2], [0.1, 0, 0.2]])


def test_a_horizontal_force_is_carried_to_the_ground(request_: MotionRequest, paper: Experiment) -> None:
    """In the hand's axes: 30 N along the fist's fingers (-z) push the worker back; the feet hold against it."""
    push = HandForce(kind="force", hand="right", frame="hand", force_n=(
        TimedForce(cycle_time_s=2.0), TimedForce(cycle_time_s=2.4, z=30.0), TimedForce(cycle_time_s=2.9, z=30.0),
        TimedForce(cycle_time_s=3.0)))  # fmt: skip
    request = replace(request_, action=request_.action.model_copy(update={"loads": (push,)}))
    motion = simulate(request)
    good(request, motion, paper)
    tick = round(2.8 / motion.time_step_s)
    turned = places(request, motion, "right_grip", tick).rotation @ [0, 0, 30.0]
    np.testing.assert_allclose(motion.hand_force_n[tick, :3], turned, atol=1e-9)
    assert turned[0] < -29  # the fist points forward
    ground = motion.wrench[tick].reshape(2, 6)[:, 0].sum()
    assert ground == pytest.approx(-turned[0], abs=6)


def test_masses_change_only_with_phases(paper: Experiment) -> None:
    phases = phases_of(SHORT, 0.01)
    action = paper.actions["high"].model_copy(
        update={"loads": (CarriedMass(kind="mass", hand="left", mass_kg=1.0, during=("work", "return")),)}
    )
    assert runs_of(paper.tool, action, phases) == (Run(0, 200, 5.0, 0.0), Run(200, 500, 5.0, 1.0))
    at_work = paper.tool.model_copy(update={"held": "work"})
    assert [run[2:4] for run in runs_of(at_work, action, phases)] == [(0.0, 0.0), (5.0, 1.0), (0.0, 1.0)]
    assert runs_of(at_work, paper.actions["high"], phases)[1] == Run(200, 300, 5.0, 0.0)


def test_the_tool_is_in_the_hand_that_works(request_: MotionRequest, paper: Experiment) -> None:
    """Worked with the left hand, the paper's 5 kg load the left wrist as they load the right one on the other side."""
    phases = phases_of(SHORT, 0.01)
    right = request_.action.right_hand
    left = HandGoal(position_m=right.position_m.model_copy(update={"y": -right.position_m.y}), orientation_deg=FORWARD)
    actions = [Action(right_hand=right), Action(left_hand=left), Action(right_hand=right, left_hand=left)]
    assert [runs_of(paper.tool, one, phases)[0][2:4] for one in actions] == [(5.0, 0.0), (0.0, 5.0), (5.0, 0.0)]
    named = paper.tool.model_copy(update={"hand": "left"})
    assert runs_of(named, actions[2], phases)[0][2:4] == (0.0, 5.0)
    held = replace(request_, tool=paper.tool, preference=Preference(tasks=()))
    ours, theirs = (simulate(replace(held, action=action)) for action in actions[:2])
    tick = ours.middle("work")
    deviation = ours.torque_nm[tick, joint_index("right_wrist_deviation")]
    assert abs(deviation) > 4
    assert theirs.torque_nm[tick, joint_index("left_wrist_deviation")] == pytest.approx(deviation, rel=1e-3)


def test_every_time_but_a_phases_may_lie_between_two_steps(request_: MotionRequest) -> None:
    """The reference is read at the instants of the steps: a waypoint between two is passed there, and not moved."""
    step, home = 0.02, Pose(np.array([0.3, -0.2, 0.9]), np.eye(3))
    times, marks = (0.0, 0.309, 0.5), ((0.4, -0.2, 1.0), (0.4, -0.2, 1.2), (0.5, -0.2, 1.2))
    path = tuple(
        Waypoint(work_time_s=time, position_m=Position(x=x, y=y, z=z))
        for time, (x, y, z) in zip(times, marks, strict=True)
    )
    reference = hand_reference(home, HandGoal(waypoints=path), phases_of(SHORT, step), step)
    at_work = reference.position_m[round(SHORT.reach_s / step) :][: round(SHORT.work_s / step)]
    share = minimum_jerk(np.arange(len(at_work)) * step / times[1])[0]
    before = np.arange(len(at_work)) * step < times[1]
    np.testing.assert_allclose(at_work[before, 2], 1.0 + 0.2 * share[before], atol=1e-12)
    np.testing.assert_allclose(at_work[~before, 2], 1.2, atol=1e-12)


def test_tasks_come_and_go_with_their_phases() -> None:
    phases = phases_of(SHORT, 0.01)
    assert weight_factor_of(("reach", "work", "return"), phases, 0.01) is None
    share = weight_factor_of(("work",), phases, 0.01)
    ramp = round(SWITCH_S / 0.01)
    assert (share[:200] == 0).all() and (share[200 + ramp : 300] == 1).all() and (share[300 + ramp :] == 0).all()
    assert share[199 + ramp // 2] == pytest.approx(0.5) == share[299 + ramp // 2]
    assert np.abs(np.diff(share)).max() < 0.04
    begin = weight_factor_of(("reach", "work"), phases, 0.01)
    assert begin[0] < 1e-4 and (begin[ramp:300] == 1).all() and begin[-1] == 0
    brief = weight_factor_of(("work",), phases_of(Cycle(reach_s=0.2, work_s=0.3, return_s=0.2), 0.01), 0.01)
    assert np.abs(np.diff(brief)).max() < 0.1 and brief.max() == 1 and brief[-1] == 0


def test_every_kind_of_task_does_what_it_says(request_: MotionRequest) -> None:
    """Each with a weight that wins: what it is about is where it was told to be at the end of the work."""
    cycle = Cycle(reach_s=3.0, work_s=3.0, return_s=3.0)

    def end_of_work(*tasks: object) -> tuple[MotionRequest, Motion, int]:
        request = replace(request_, cycle=cycle, preference=Preference(tasks=tasks))
        motion = simulate(request)
        return request, motion, motion.phase("work").stop - 1

    turn = SegmentOrientation(
        kind="segment_orientation", weight=100.0, segment="head", orientation_deg=Orientation(z=30.0)
    )
    request, motion, tick = end_of_work(turn)
    head = places(request, motion, "head", tick).rotation
    assert np.degrees(pin.log3(head)) == pytest.approx([0, 0, 30], abs=1)

    low = SegmentPosition(
        kind="segment_position",
        weight=1000.0,
        segment="pelvis",
        position_m=Coordinates(z=0.8),
        during=("reach", "work"),
    )
    request, motion, tick = end_of_work(low)
    assert places(request, motion, "pelvis", tick).translation[2] == pytest.approx(0.8, abs=0.01)
    assert places(request, motion, "pelvis", -1).translation[2] > 0.85  # let go in the return

    angles = {"neck_flexion": 20.0, "right_elbow_flexion": 60.0}
    request, motion, tick = end_of_work(JointPosture(kind="joint_posture", weight=1000.0, angles_deg=angles))
    for name, angle in angles.items():
        assert np.degrees(motion.configuration[tick, 7 + joint_index(name)]) == pytest.approx(angle, abs=1.5)

    other = Hand(kind="hand", weight=10.0, hand="left", position_m=Position(x=0.3, y=0.25, z=1.0))
    request, motion, tick = end_of_work(other)
    np.testing.assert_allclose(places(request, motion, "left_grip", tick).translation, [0.3, 0.25, 1.0], atol=0.01)

    human = build_human(request_.worker)
    shift = CentreOfMass(kind="centre_of_mass", weight=1e5, position_m=Coordinates(x=-0.04))
    request, motion, tick = end_of_work(shift)
    centre = pin.centerOfMass(human.model, human.model.createData(), motion.configuration[tick])
    assert centre[0] == pytest.approx(-0.04, abs=0.005)


def test_the_squat_bends_the_knees_and_keeps_the_back_upright() -> None:
    experiment = load_experiment(EXPERIMENTS / "pose_grid.yaml")
    tilt, knee = {}, {}
    for request in reaction_requests(experiment):
        if request.name.action == "rack_x0.4_z0.5":
            motion = simulate(request.motion)
            tick = motion.phase("work").stop - 1
            upright = places(request.motion, motion, "thorax", tick).rotation[2, 2]
            tilt[request.name.preference] = np.degrees(np.arccos(upright))
            knee[request.name.preference] = np.degrees(
                motion.configuration[tick, 7 + joint_index("right_knee_flexion")]
            )
    assert tilt["squat"] < 30 < tilt["arm"] < 45 and tilt["back"] > 80
    assert knee["squat"] > knee["arm"] + 20 and knee["arm"] > 2 * knee["back"]


def test_pose_grid_is_what_its_file_says() -> None:
    experiment = load_experiment(EXPERIMENTS / "pose_grid.yaml")
    assert len(reaction_requests(experiment)) == 75
    spots = {(a.right_hand.position_m.x, a.right_hand.position_m.z) for a in experiment.actions.values()}
    assert len(spots) == 25 and {x for x, _ in spots} == {0.3, 0.35, 0.4, 0.45, 0.5}
    last = experiment.actions["rack_x0.5_z1.3"].right_hand
    assert (last.position_m.x, last.position_m.y, last.position_m.z, last.orientation_deg.y) == (0.5, -0.2, 1.3, -90)


def test_names_of_a_grid_say_minus_and_leave_the_rest(tmp_path: Path) -> None:
    text = (EXPERIMENTS / "pose_grid.yaml").read_text()
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("  rack: ", "  rack-left: ").replace("y: -0.2", "y: {from: -0.2, to: 0.0, count: 3}"))
    names = list(load_experiment(path).actions)
    assert len(names) == 75 and names[0] == "rack-left_x0.3_ym0.2_z0.5" and "rack-left_x0.3_y0_z0.5" in names


def test_co_transport_lifts_with_both_hands() -> None:
    experiment = load_experiment(EXPERIMENTS / "co_transport.yaml")
    requests = {request.name.action: request for request in reaction_requests(experiment)}
    for name, forces in (("even", (-40, -40)), ("right_more", (-60, -20)), ("left_more", (-20, -60))):
        request = requests[name]
        motion = simulate(request.motion)
        assert measure(request.motion, motion).faults(experiment.accuracy) == []
        lifting = round(6.0 / motion.time_step_s)
        np.testing.assert_allclose(motion.hand_force_n[lifting, [2, 5]], forces)
        assert not motion.hand_force_n[[0, -1]].any()
        for side in ("right", "left"):
            low, high = (
                places(request.motion, motion, f"{side}_grip", round(time / motion.time_step_s)).translation[2]
                for time in (4.0, 8.5)
            )
            assert (low, high) == (pytest.approx(0.75, abs=0.01), pytest.approx(1.15, abs=0.01))


def test_workers_differ_by_body_and_strength() -> None:
    experiment = load_experiment(EXPERIMENTS / "workers.yaml")
    heights = [worker.height_m for worker in experiment.workers.values()]
    assert len(heights) == 5 and heights == sorted(heights) and heights[0] < 1.55 and heights[-1] > 1.85
    requests = reaction_requests(experiment)
    assert len({request.digest for request in requests}) == 20
    with_five = replace(
        next(r.motion for r in requests if r.name == ("average_woman", "high", "arm")),
        tool=experiment.tool.model_copy(update={"mass_kg": 5.0}),
    )
    # the reason of the lighter tool in that file: her shoulder is at its maximum torque
    simulator = Simulator(with_five)
    limit = with_five.maximum_torque.vectors()[0][joint_index("right_shoulder_flexion")]
    for tick in range(400):
        simulator.prepare(tick)
        step = simulator.body.controller.step()
        assert step is not None
        simulator.advance(step.acceleration)
    assert step.torque_nm[joint_index("right_shoulder_flexion")] == pytest.approx(limit, rel=2e-3)


def fault(tmp_path: Path, source: str, old: str, new: str) -> str:
    text = (EXPERIMENTS / source).read_text()
    assert old in text
    path = tmp_path / source
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    return str(caught.value)


@pytest.mark.parametrize(
    ("source", "old", "new", "expected"),
    [
        ("pose_grid.yaml", "count: 5", "count: 1", "actions.rack.right_hand.position_m.x.count = 1: input should be"),
        ("pose_grid.yaml", "from: 0.3", "start: 0.3", "actions.rack.right_hand.position_m.x.from: is missing. A range"),
        ("pose_grid.yaml", "to: 0.5", "to: .nan", "actions.rack.right_hand.position_m.x.to = nan: input should be"),
        ("pose_grid.yaml", "to: 0.5", "to: 9.0", "actions.rack.right_hand.position_m.x.to = 9.0: input should be"),
        ("pose_grid.yaml", "kind: segment_upright", "kind: upright", "preferences.arm.tasks.0"),
        ("pose_grid.yaml", "weight: 1,", "weight: 1, during: [rest],",
         "preferences.arm.tasks.0.during.0 = 'rest': input should be 'reach', 'work' or 'return'."),
        ("pose_grid.yaml", "{kind: segment_upright, segment: thorax, weight: 1, stiffness_per_s2: 80}",
         "{kind: joint_posture, weight: 1, angles_deg: {knee: 5}}",
         "yaml: preferences.arm.tasks.0.angles_deg: unknown degree of freedom 'knee'"),
        ("pose_grid.yaml", "{kind: segment_upright, segment: thorax, weight: 1, stiffness_per_s2: 80}",
         "{kind: segment_position, segment: pelvis, weight: 1, position_m: {}}",
         "preferences.arm.tasks.0.position_m: give at least one of x, y and z."),
        ("co_transport.yaml", "work_time_s: 5,", "work_time_s: 7,",
         "actions.even.right_hand.waypoints: the last is reached after 7 s of work; cycle.work_s is 6"),
        ("co_transport.yaml", "work_time_s: 1,", "work_time_s: 0,", "they start at 0 and follow each other by 0.1 s"),
        ("co_transport.yaml", "z: 0.75}, orientation_deg: {y: -90}}", "z: 0.75}}",
         "actions.even.right_hand: waypoints: give orientation_deg to all of them or to none."),
        ("co_transport.yaml", "{cycle_time_s: 9}", "{cycle_time_s: 19}",
         "actions.even.loads.0.force_n: cycle_time_s = 19 is after the end of the cycle (12 s)"),
        ("co_transport.yaml", "{cycle_time_s: 4, z: -40}", "{cycle_time_s: 2, z: -40}", "the times must increase"),
        ("co_transport.yaml", "frame: world", "frame: ground", "loads.0.frame = 'ground': input should be 'world' or"),
        ("co_transport.yaml", "      waypoints:", "      position_m: {x: 0.3, y: 0, z: 1}\n      waypoints:",
         "actions.even.right_hand: give either position_m (a pose to hold) or waypoints (a path)."),
        ("workers.yaml", "{worker: small_woman, ", "{",
         "benchmark.conditions.small_woman.worker: is missing; choose one of small_woman, average_woman"),
        ("workers.yaml", "{worker: small_woman, ", "{worker: giant, ",
         "benchmark.conditions.small_woman.worker: 'giant' is not one of small_woman"),
        ("pose_grid.yaml", "count: 5}, y: -0.2, z: {from: 0.5, to: 1.3, count: 5}",
         "count: 1000}, y: -0.2, z: {from: 0.5, to: 1.3, count: 1000}",
         "actions.rack: its grid has 1000000 points; at most 10000 actions are allowed in all."),
        ("pose_grid.yaml", "  rack: ", "  a_rack_with_a_name_of_thirty_letters: ", "makes names as long as 'a_rack"),
        ("paper.yaml", "time_step_s: 0.01", "time_step_s: 1e-7", "controller.time_step_s = 1e-07: input should be"),
        ("paper.yaml", "posture: 1}", "posture: 1e300}", "controller.weights.posture = 1e+300: input should be"),
        ("pose_grid.yaml", "benchmark:", "fatigue: {joints: {nose: {}}}\nbenchmark:", "fatigue.joints.nose: unknown"),
        ("workers.yaml", "    right_hand:\n      position_m: {x: 0.5,",
         "    position_m: {}\n    right_hand:\n      position_m: {x: 0.5,",
         "actions.high.position_m: unknown key; allowed are right_hand, left_hand, "),
        ("pose_grid.yaml", "    tasks:\n      - {kind", "    tasks: 5\n    more:\n      - {kind",
         "preferences.arm.tasks = 5: should be a list."),
        ("workers.yaml", "sex: female", "sex: other", "workers.small_woman.sex = 'other'"),
    ],
)  # fmt: skip
def test_mistakes_are_named(tmp_path: Path, source: str, old: str, new: str, expected: str) -> None:
    assert expected in fault(tmp_path, source, old, new)


def test_who_is_pushed_leans_against_it(request_: MotionRequest, paper: Experiment) -> None:
    """60 N against a drill at 1.3 m: the centre of mass goes forward by z F / m g, the pressure stays where it was."""
    push = HandForce(kind="force", hand="right", frame="hand", force_n=(
        TimedForce(cycle_time_s=2.0), TimedForce(cycle_time_s=4.0, z=60.0)))  # fmt: skip
    goal = HandGoal(position_m=Position(x=0.4, y=-0.2, z=1.3), orientation_deg=FORWARD)
    request = replace(
        request_, cycle=Cycle(reach_s=2.0, work_s=8.0, return_s=2.0), action=Action(right_hand=goal, loads=(push,))
    )
    motion = simulate(request)
    human, tick = build_human(request.worker), motion.phase("work").stop - 1
    centres = [
        pin.centerOfMass(human.model, human.model.createData(), motion.configuration[i]).copy() for i in (0, tick)
    ]
    weight = human.mass_kg * 9.81
    assert centres[1][0] - centres[0][0] == pytest.approx(1.3 * 60 / weight, abs=0.004)
    soles = motion.wrench[[0, tick]].reshape(2, 2, 6)
    pressure = -soles[:, :, 4].sum(axis=1) / soles[:, :, 2].sum(axis=1)
    assert pressure[1] == pytest.approx(pressure[0], abs=0.005)
    assert measure(request, motion).centre_of_pressure_violation_m < 0


def test_the_way_home_may_leave_the_hands_free_to_turn() -> None:
    """A small woman lifts with both hands to 1.2 m and comes back; with a prescribed turn she cannot."""
    experiment = load_experiment(EXPERIMENTS / "workers.yaml")
    lift = load_experiment(EXPERIMENTS / "co_transport.yaml").actions["even"].model_copy(update={"loads": ()})
    high = {
        hand: HandGoal(
            waypoints=tuple(
                point.model_copy(update={"position_m": point.position_m.model_copy(update={"z": z})})
                for point, z in zip(getattr(lift, hand).waypoints, (0.8, 0.8, 1.2), strict=True)
            )
        )
        for hand in ("right_hand", "left_hand")
    }
    request = reaction_requests(experiment)[0].motion
    request = replace(
        request, action=Action(**high), tool=request.tool.model_copy(update={"mass_kg": 0.0}),
        cycle=Cycle(reach_s=4.0, work_s=6.0, return_s=4.0, return_hand="position"),
    )  # fmt: skip
    motion = simulate(request)
    assert measure(request, motion).faults(experiment.accuracy) == []
    assert np.abs(motion.configuration[-1, 7:] - motion.configuration[0, 7:]).max() < np.radians(25)

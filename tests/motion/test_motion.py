"""The whole-body program: references, limits, contacts, optimality, and the paper's four motions."""

from dataclasses import fields, replace
from itertools import product

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import linprog

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.body import Body, MotionRequest
from fatigue_planner.motion.contact import wrench_cone
from fatigue_planner.motion.joint_limits import acceleration_bounds
from fatigue_planner.motion.minimum_jerk import Pose, Reach, minimum_jerk
from fatigue_planner.motion.motion import ROWS, Motion, Phase
from fatigue_planner.motion.payload import HandForce, TimedForce
from fatigue_planner.motion.plausibility import Plausibility
from fatigue_planner.motion.quadratic_program import QuadraticProgram, smallest_slack, solve_eased
from fatigue_planner.motion.quality import NOT_BARS, Quality
from fatigue_planner.motion.schedule import phases_of
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.motion.simulator import Simulator, simulate
from fatigue_planner.motion.verification import MismatchError, measure
from fatigue_planner.reactions.reaction import Reaction


def test_minimum_jerk_has_its_known_peaks() -> None:
    """Peak speed 1.875 D/T at half time, peak acceleration 5.774 D/T^2 (Flash & Hogan 1985)."""
    share, speed, acceleration = minimum_jerk(np.linspace(0, 1, 2001))
    assert (share[0], speed[0], acceleration[0]) == (0, 0, 0) and (share[-1], speed[-1], acceleration[-1]) == (1, 0, 0)
    assert speed.max() == pytest.approx(1.875) and speed[1000] == pytest.approx(1.875)
    assert acceleration.max() == pytest.approx(10 / np.sqrt(3), rel=1e-5)
    outside = np.array(minimum_jerk(np.array([-1.0, 2.0])))
    assert outside.tolist() == [[0, 1], [0, 0], [0, 0]]


def test_reach_velocities_are_the_derivatives_of_its_pose() -> None:
    turned = pin.exp3(np.array([0.4, -1.2, 0.7]))
    start, end = Pose(np.zeros(3), pin.exp3(np.array([0.3, 0, 0]))), Pose(np.array([0.3, -0.1, 0.5]), turned)
    reach, h = Reach(start, end, 2.0), 1e-5
    moments = reach.at(np.array([0.0, 2.0, 3.0]))
    for moment, pose in zip(range(3), (start, end, end), strict=True):
        np.testing.assert_allclose(moments.position_m[moment], pose.position_m, atol=1e-14)
        np.testing.assert_allclose(moments.rotation[moment], pose.rotation, atol=1e-14)
    for t in (0.3, 1.0, 1.7):
        moments = reach.at(np.array([t - h, t, t + h]))
        turn = pin.log3(moments.rotation[2] @ moments.rotation[0].T)
        moved = np.concatenate([moments.position_m[2] - moments.position_m[0], turn])
        np.testing.assert_allclose(moved / (2 * h), moments.velocity[1], atol=1e-8)
        change = (moments.velocity[2] - moments.velocity[0]) / (2 * h)
        np.testing.assert_allclose(change, moments.acceleration[1], atol=1e-7)


def test_phases_are_whole_ticks() -> None:
    phases = phases_of(Cycle(reach_s=5, work_s=6, return_s=5), 0.005)
    assert [tuple(phase) for phase in phases] == [("reach", 0, 1000), ("work", 1000, 2200), ("return", 2200, 3200)]


def test_wrench_cone_is_that_of_forces_at_four_corners() -> None:
    """A wrench is in the cone if and only if corner forces inside friction pyramids make it up (by LP)."""
    half_length, half_breadth, friction = 0.13, 0.05, 0.5
    cone = wrench_cone(half_length, half_breadth, friction)
    mu = friction / np.sqrt(2)
    columns, limits = [], []
    for x in (half_length, -half_length):
        for y in (half_breadth, -half_breadth):
            columns.append(np.vstack([np.eye(3), pin.skew(np.array([x, y, 0]))]))
            limits.append([[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu]])
    grasp = np.hstack(columns)
    pyramids = np.zeros((16, 12))
    for i, rows in enumerate(limits):
        pyramids[4 * i : 4 * i + 4, 3 * i : 3 * i + 3] = rows
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(400):
        wrench = rng.normal(size=6) * [0.25, 0.25, 0, 0.04, 0.1, 0.06] + [0, 0, 1, 0, 0, 0]
        feasible = linprog(np.zeros(12), pyramids, np.zeros(16), grasp, wrench, bounds=(None, None)).status == 0
        assert (cone @ wrench <= 1e-9).all() == feasible
        inside += feasible
    assert 40 < inside < 360  # the sample tests both sides


def test_a_joint_driven_hard_at_its_limit_never_passes_it() -> None:
    dt, limit = 0.005, 10.0
    for start_speed, way in product((0.0, 0.5, 2.0), (1, -1)):  # to the upper and, in the mirror, to the lower limit
        q, v = np.array([-0.4 * way]), np.array([start_speed * way])
        lower, upper = np.sort([[-1.0 * way], [0.5 * way]], axis=0)
        for _ in range(2000):
            lowest, highest = np.empty(1), np.empty(1)
            acceleration_bounds(q, v, lower, upper, 3.0, limit, 2 * dt, lowest, highest)
            assert lowest <= highest
            v = v + dt * np.clip(1e3 * way, lowest, highest)
            q = q + dt * v
            assert q[0] * way <= 0.5 + 1e-12 and v[0] * way <= 3.0 + 1e-12
        assert q[0] == pytest.approx(0.5 * way, abs=1e-6)


def mid_reach(paper: Experiment, index: int) -> Body:
    """A body half-way through its reach, at speed, with its references set."""
    request = reaction_requests(paper)[index].motion
    simulator = Simulator(request)
    for tick in range(250):
        simulator.prepare(tick)
        result = simulator.body.controller.step()
        assert result is not None
        simulator.advance(result.acceleration)
    simulator.prepare(250)
    return simulator.body


@pytest.mark.parametrize("index", [0, 3])
def test_condensed_program_solves_the_papers_program(paper: Experiment, index: int) -> None:
    """The program with the torques as variables (Eq. 3 as printed), by another solver, agrees."""
    body = mid_reach(paper, index)
    result = body.controller.step()
    assert result is not None
    acceleration, wrench, torque, *_ = result
    body.controller.fill_whole_program()
    program, nv, nj = body.controller.program, 45, 39
    # unknowns (tau, a, w): the condensed program's rows and costs, its torque rows replaced
    torque_rows = slice(18, 18 + nj)
    T, h = body.controller._torque_map, body.state.nonlinear_effects[6:]
    soles = [body.state.local_jacobian(body.state.frame(f"{side}_sole")) for side in ("right", "left")]
    np.testing.assert_array_equal(T, np.hstack([body.state.mass_matrix[6:], -np.vstack(soles)[:, 6:].T]))
    D = np.diag(body.controller._torque_scale)
    H = np.zeros((nj + nv + 12, nj + nv + 12))
    H[:nj, :nj] = D
    H[nj:, nj:] = program.H - T.T @ D @ T
    g = np.concatenate([np.zeros(nj), program.g - T.T @ D @ h])
    A = np.hstack([np.zeros((program.A.shape[0], nj)), program.A])
    A[torque_rows] = np.hstack([np.eye(nj), -T])
    row_lower, row_upper = program.row_lower.copy(), program.row_upper.copy()
    lower_torque, upper_torque = row_lower[torque_rows] + h, row_upper[torque_rows] + h
    row_lower[torque_rows] = row_upper[torque_rows] = h
    solver = ca.conic("full", "qpoases", {"h": ca.DM(H).sparsity(), "a": ca.DM(A).sparsity()}, {"printLevel": "none"})
    solution = solver(
        h=H, g=g, a=A, lba=row_lower, uba=row_upper,
        lbx=np.concatenate([lower_torque, program.lower]), ubx=np.concatenate([upper_torque, program.upper]),
    )["x"].full().ravel()  # fmt: skip
    np.testing.assert_allclose(solution[:nj], torque, atol=1e-5)
    np.testing.assert_allclose(solution[nj : nj + nv], acceleration, atol=1e-5)
    np.testing.assert_allclose(solution[nj + nv :], wrench, atol=1e-4)


@pytest.mark.parametrize("index", range(4))
def test_solution_is_optimal(paper: Experiment, index: int) -> None:
    """Feasible, and no admissible direction goes downhill (stationarity by least squares multipliers)."""
    body = mid_reach(paper, index)
    result = body.controller.step()
    assert result is not None
    x = np.concatenate(result[:2])
    body.controller.fill_whole_program()
    p = body.controller.program
    rows = np.vstack([p.A, np.eye(len(x))])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    values = rows @ x
    assert (values >= lower - 1e-6).all() and (values <= upper + 1e-6).all()
    gradient = p.H @ x + p.g
    at_upper, at_lower = values > upper - 1e-6, values < lower + 1e-6
    bounds = [(None, None) if a and b else ((0, None) if a else ((None, 0) if b else (0, 0)))
              for a, b in zip(at_upper, at_lower, strict=True)]  # fmt: skip
    multipliers = linprog(
        np.zeros(len(rows)), A_ub=np.vstack([rows.T, -rows.T]),
        b_ub=np.concatenate([-gradient, gradient]) + 1e-5 * np.abs(gradient).max(), bounds=bounds,
    )  # fmt: skip
    assert multipliers.status == 0


def test_every_stored_motion_keeps_its_bars(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    requests = {request.name: request for request in reaction_requests(paper)}
    for reaction in reactions:
        quality = measure(requests[reaction.name].motion, reaction.motion)
        assert quality == reaction.quality and quality.faults(paper.accuracy) == []
        assert quality.equation_of_motion_nm <= 1e-8
        for violation in (
            quality.friction_violation_n, quality.unilateral_violation_n, quality.torque_violation_nm,
            quality.position_violation_rad, quality.velocity_violation_radps, quality.centre_of_pressure_violation_m,
            quality.centre_of_mass_violation_m,
        ):  # fmt: skip
            assert violation <= 1e-6
        assert quality.work_hand_error_m <= 0.01 and quality.foot_displacement_m <= 0.001
        assert quality.energy_error_share <= 0.01


def test_motions_are_consistent_and_return_to_the_stance(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    model = build_human(paper.workers["average_man"], paper.tool.mass_kg).model
    for reaction in reactions:
        motion = reaction.motion
        assert len(motion.torque_nm) == round(16 / motion.time_step_s)
        for tick in range(0, len(motion.torque_nm) - 1, 97):
            v = motion.velocity[tick] + motion.time_step_s * motion.acceleration[tick]
            q = pin.integrate(model, motion.configuration[tick], motion.time_step_s * v)
            np.testing.assert_allclose(v, motion.velocity[tick + 1], atol=1e-12)
            np.testing.assert_allclose(q, motion.configuration[tick + 1], atol=1e-12)
        assert np.abs(motion.configuration[-1, 7:] - motion.configuration[0, 7:]).max() < np.radians(1.5)


def test_the_preferences_do_what_they_say(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """For each object pose the arm reaction bends the back less, the back reaction lifts the arm less.

    At the low one they are a squat and a stoop: the line from mid-hip to C7 leans at most 50 deg, and 25 deg more.
    """
    human = build_human(paper.workers["average_man"])
    data = human.model.createData()
    tilt: dict[tuple[str, str, str], float] = {}
    for reaction in reactions:
        work = reaction.motion.phase("work")
        pin.framesForwardKinematics(human.model, data, reaction.motion.configuration[(work.start + work.stop) // 2])
        hips, c7 = (data.oMf[human.model.getFrameId(name)].translation for name in ("pelvis", "neck"))
        axes = {name: data.oMf[human.model.getFrameId(name)].rotation[:, 2] for name in ("thorax", "right_upper_arm")}
        for name, axis in {**axes, "spine": c7 - hips}.items():
            lean = np.degrees(np.arccos(axis[2] / np.linalg.norm(axis)))
            tilt[reaction.name.action, reaction.name.preference, name] = lean
    for action in ("high", "low"):
        assert tilt[action, "back", "right_upper_arm"] < tilt[action, "arm", "right_upper_arm"] - 5
        assert tilt[action, "arm", "thorax"] < tilt[action, "back", "thorax"] - 5
    assert tilt["low", "arm", "spine"] < 50
    assert tilt["low", "back", "spine"] - tilt["low", "arm", "spine"] > 25


def test_torques_are_in_the_literatures_bands(reactions: tuple[Reaction, ...]) -> None:
    """High target: 25-35 N.m hand-calculated at the shoulder; low: 100-200 N.m at L5/S1 (dynamics included)."""
    from fatigue_planner.human.model import joint_index

    by_name = {str(reaction.name): reaction.motion for reaction in reactions}
    high = by_name["average_man/high/arm"]
    shoulder = high.torque_nm[high.phase("work"), joint_index("right_shoulder_flexion")].mean()
    assert 25 < shoulder < 40
    for name in ("average_man/low/arm", "average_man/low/back"):
        motion = by_name[name]
        assert 100 < -motion.torque_nm[motion.phase("work"), joint_index("lumbar_flexion")].mean() < 200


def test_the_centre_of_mass_is_held_where_it_is_wanted(paper: Experiment) -> None:
    request = replace(reaction_requests(paper)[0].motion, cycle=Cycle(reach_s=1.0, work_s=4.0, return_s=1.0))
    centres = []
    for shift in (0.0, 0.03):
        controller = request.controller.model_copy(update={"centre_of_mass_shift_m": shift})
        motion = simulate(replace(request, controller=controller))
        human = build_human(request.worker, request.tool.mass_kg)
        held = motion.configuration[motion.phase("work").stop - 1]
        centres.append(pin.centerOfMass(human.model, human.model.createData(), held)[0])
    assert centres[1] - centres[0] == pytest.approx(0.03, abs=0.002)


def test_tool_only_during_work_loads_the_hand_only_then(paper: Experiment) -> None:
    request = reaction_requests(paper)[0].motion
    from fatigue_planner.human.model import joint_index

    short = Cycle(reach_s=1.0, work_s=0.5, return_s=1.0)
    motion = simulate(replace(request, cycle=short, tool=request.tool.model_copy(update={"held": "work"})))
    assert (
        measure(
            replace(request, cycle=short, tool=request.tool.model_copy(update={"held": "work"})), motion
        ).equation_of_motion_nm
        < 1e-8
    )
    deviation = motion.torque_nm[:, joint_index("right_wrist_deviation")]
    work = motion.phase("work")
    assert deviation[work.start + 1] - deviation[work.start - 1] > 3  # 5 kg, 8.7 cm beyond the wrist


@pytest.mark.parametrize("name", ["configuration", "velocity", "acceleration", "torque_nm", "wrench"])
def test_nan_never_passes_the_checks(paper: Experiment, reactions: tuple[Reaction, ...], name: str) -> None:

    request = reaction_requests(paper)[0]
    array = getattr(reactions[0].motion, name).copy()
    array[1500, -1] = np.nan
    faults = measure(request.motion, replace(reactions[0].motion, **{name: array})).faults(paper.accuracy)
    assert any("equation_of_motion" in fault for fault in faults)


def test_no_number_of_a_quality_may_be_none(paper: Experiment) -> None:
    seen = Plausibility(**{field.name: "" if field.type is str else 0 for field in fields(Plausibility)})
    sound = Quality(
        **{field.name: "" if field.type is str else 0 for field in fields(Quality)} | {"plausibility": seen}
    )
    assert sound.faults(paper.accuracy) == []
    numbers = [field.name for field in fields(Quality) if field.type is not str]
    for name in {*numbers} - {*NOT_BARS} | {"work_hand_error_m", "work_hand_turn_rad"}:
        assert len(replace(sound, **{name: np.nan}).faults(paper.accuracy)) == 1, name


def test_checks_are_made_from_the_stored_motion(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """A body moved by 10 cm misses its target and its footprints, whatever the controller noted."""

    moved = reactions[0].motion.configuration.copy()
    moved[:, 0] += 0.1
    quality = measure(reaction_requests(paper)[0].motion, replace(reactions[0].motion, configuration=moved))
    assert quality.work_hand_error_m > 0.09
    slid = reactions[0].quality.foot_displacement_m
    assert quality.foot_displacement_m == pytest.approx(0.1, abs=slid + 1e-9) and slid < 1e-4
    wrench = reactions[0].motion.wrench.copy()
    wrench[5, 5] += 1e3
    quality = measure(reaction_requests(paper)[0].motion, replace(reactions[0].motion, wrench=wrench))
    assert quality.wrench_cone_violation > 100


def test_an_answer_that_is_not_optimal_is_not_believed() -> None:
    """Wrong multipliers, a wrong point, or a violated bound, reported as a success, give no solution."""
    for spoil in ("point", "multiplier", "bound"):
        program = QuadraticProgram(2, 1, "daqp")
        program.H[:], program.A[:], program.g[:] = np.eye(2), 1, [-1, -2]
        program.lower[:], program.upper[:], program.row_lower[:], program.row_upper[:] = -np.inf, np.inf, -np.inf, 1
        assert program.solve() is not None and program.optimality() < 1e-12
        solve = program._evaluate

        def spoiled(solve=solve, program=program, spoil=spoil) -> None:
            solve()
            if spoil == "bound":  # the answer without the row that holds it
                program._solution[:], program._multipliers[:] = [1, 2], 0
            else:
                (program._solution if spoil == "point" else program._multipliers)[0] += 0.1

        program._evaluate = spoiled
        assert program.solve() is None


def test_failures_say_why(paper: Experiment) -> None:
    """Too weak, too heavy, out of balance: each its own message with time, phase, tick and limit."""

    request = reaction_requests(paper)[2].motion
    weak = request.controller.model_copy(update={"torque_limit_factor": 0.02})
    empty = request.tool.model_copy(update={"mass_kg": 0.0})
    with pytest.raises(FailedMotionError, match=r"t = 0\.\d\d s \(reach, tick \d+\): .* 100% of the time, first at 0"):
        simulate(replace(request, controller=weak, tool=empty))
    heavy = request.tool.model_copy(update={"mass_kg": 25.0})
    with pytest.raises(FailedMotionError, match=r"at its maximum torque \d+% of the time, first at"):
        simulate(replace(request, tool=heavy))
    shove = HandForce(kind="force", hand="right", frame="world", force_n=(TimedForce(cycle_time_s=0.0, x=-300.0),))
    pushed = request.action.model_copy(update={"loads": (shove,)})
    with pytest.raises(FailedMotionError, match=r"no admissible movement at t = 0\.\d\d s"):
        simulate(replace(request, action=pushed, tool=empty))


def test_limits_that_contradict_each_other_give_way_a_little_and_say_so(paper: Experiment) -> None:
    """Hardly any braking allowed: four ticks have no solution within the bounds; the verdict is honest.

    The motion is a stoop from bent elbows: that of the paper meets no contradiction.
    """

    request = reaction_requests(paper)[2].motion
    slow = request.controller.model_copy(update={"acceleration_limit_radps2": 1.0})
    (task,) = request.preference.tasks
    stoop = request.preference.model_copy(update={"tasks": (task.model_copy(update={"stiffness_per_s2": None}),)})
    bent = request.worker.model_copy(
        update={"natural_posture_deg": {**request.worker.natural_posture_deg, "elbow_flexion": 15.0}}
    )
    cycle = Cycle(reach_s=2.5, work_s=1.0, return_s=2.5, return_hand="pose")
    request = replace(request, controller=slow, cycle=cycle, preference=stoop, worker=bent)
    motion = simulate(request)
    quality = measure(request, motion)
    assert 0 < quality.eased_ticks < 30 and 0 < quality.eased_radps2 < 5
    assert (motion.eased_radps2 != 0).any(axis=1).sum() == quality.eased_ticks
    assert quality.equation_of_motion_nm < 1e-8 and quality.torque_violation_nm < 1e-6
    loose = {"hand_error_m": 0.02, "eased_position_rad": 0.02}
    assert quality.verdict(paper.accuracy.model_copy(update=loose)) == "implausible"
    assert f"at {quality.eased_ticks} ticks, by up to" in quality.degradation()
    assert (
        quality.verdict(
            paper.accuracy.model_copy(update=loose | {"eased_position_rad": quality.position_violation_rad / 2})
        )
        == "failed"
    )


def test_an_answer_nearly_right_is_polished() -> None:
    """Off by 1e-5, as solvers leave it at their tolerance: one step brings it to rounding."""
    program = QuadraticProgram(2, 1, "daqp")
    program.H[:], program.A[:], program.g[:] = np.diag([2.0, 4.0]), [[1, 1]], [-1, -2]
    program.lower[:], program.upper[:], program.row_lower[:], program.row_upper[:] = -np.inf, np.inf, 0.3, 0.3
    solve = program._evaluate

    def rough() -> None:
        solve()
        program._solution[0] += 1e-5

    exact = program.solve().copy()
    program._evaluate = rough
    np.testing.assert_allclose(program.solve(), exact, atol=1e-14)
    assert program.optimality() < 1e-12


def test_an_unloaded_sole_has_no_centre_of_pressure(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:

    wrench = reactions[0].motion.wrench.copy()
    wrench[7, :6] = 1e-9 * np.ones(6)
    quality = measure(reaction_requests(paper)[0].motion, replace(reactions[0].motion, wrench=wrench))
    assert quality.centre_of_pressure_violation_m < 1e-6
    wrench[7, 4] = 0.5
    quality = measure(reaction_requests(paper)[0].motion, replace(reactions[0].motion, wrench=wrench))
    assert quality.centre_of_pressure_violation_m > 0.4


def test_the_second_solver_takes_over(paper: Experiment, monkeypatch: pytest.MonkeyPatch) -> None:
    body = mid_reach(paper, 1)
    expected = body.controller.step()
    monkeypatch.setattr(body.controller.free, "solve", lambda: None)
    result = body.controller.step()
    assert expected is not None and result is not None
    np.testing.assert_allclose(result.torque_nm, expected.torque_nm, atol=1e-6)


def test_a_torque_at_its_limit_gives_the_whole_programs_answer(paper: Experiment) -> None:
    """Where the answer without torque and contact limits breaks one, the whole program is solved, exactly."""
    body = mid_reach(paper, 0)
    free = body.controller.step()
    joint = int(np.abs(free.torque_nm).argmax())
    bound = 0.98 * abs(free.torque_nm[joint])
    body.controller._highest_torque = body.controller._highest_torque.copy()
    body.controller._lowest_torque = body.controller._lowest_torque.copy()
    body.controller._highest_torque[joint], body.controller._lowest_torque[joint] = bound, -bound
    held = body.controller.step()
    assert abs(held.torque_nm[joint]) == pytest.approx(bound, abs=1e-9)
    assert body.controller.program.optimality() < 1e-9 and held.eased_radps2.max() == 0


@pytest.mark.parametrize("name", ["H", "A", "g", "row_upper", "lower"])
def test_not_finite_data_are_refused_before_solving(name: str) -> None:
    program = QuadraticProgram(2, 1, "daqp")
    program.H[:], program.A[:] = np.eye(2), 1
    program.g[:], program.lower[:], program.upper[:] = [-1, -2], -np.inf, np.inf
    program.row_lower[:], program.row_upper[:] = -np.inf, 1
    np.testing.assert_allclose(program.solve(), [0, 1], atol=1e-9)
    getattr(program, name).flat[0] = np.nan
    assert program.solve() is None


def test_an_infeasible_program_has_no_solution(capfd: pytest.CaptureFixture[str]) -> None:
    for solver in ("daqp", "qpoases"):
        program = QuadraticProgram(1, 1, solver)
        program.H[:], program.A[:], program.lower[:], program.upper[:] = 1, 1, 0, 1
        program.row_lower[:], program.row_upper[:] = 2, 3
        assert program.solve() is None
    assert capfd.readouterr().out == ""  # solvers do not talk


@pytest.mark.slow
def test_halving_the_time_step_changes_no_cycle_map_by_a_hundredth(
    paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """Each gain and offset by less than 1 % of the largest; the energy error halves (first order)."""

    from fatigue_planner.experiment.build import worker_fatigue
    from fatigue_planner.fatigue.load import cycle_profile

    parameters = worker_fatigue(paper)["average_man"]
    step = paper.controller.time_step_s / 2
    for request, reaction in zip(reaction_requests(paper), reactions, strict=True):
        finer = replace(request.motion, controller=paper.controller.model_copy(update={"time_step_s": step}))
        motion = simulate(finer)
        ours = cycle_profile(reaction.motion, parameters).cycle_map()
        theirs = cycle_profile(motion, parameters).cycle_map()
        assert np.abs(ours.gain - theirs.gain).max() < 0.01 * theirs.gain.max()
        assert np.abs(ours.offset - theirs.offset).max() < 0.01 * theirs.offset.max()
        order = np.log2(reaction.quality.energy_error_share / measure(finer, motion).energy_error_share)
        assert 0.9 < order < 1.1


def at_work(paper: Experiment) -> tuple[MotionRequest, Motion]:
    """A motion with the tool held at work only: three runs of different masses."""

    request = reaction_requests(paper)[0].motion
    short = Cycle(reach_s=2.0, work_s=1.0, return_s=2.0)
    request = replace(request, cycle=short, tool=request.tool.model_copy(update={"held": "work"}))
    return request, simulate(request)


def test_the_tool_held_at_work_only_keeps_every_bar(paper: Experiment) -> None:
    """The energy error of a run that stands still counts against the whole cycle's work, not its own."""

    for request in reaction_requests(paper)[1:2]:
        lent = replace(request.motion, tool=request.motion.tool.model_copy(update={"held": "work"}))
        assert measure(lent, simulate(lent)).faults(paper.accuracy) == []


def test_a_task_with_a_stiffness_of_its_own_moves_as_if_the_controller_had_it(paper: Experiment) -> None:
    """The same bytes, and others than with the controller's own stiffness; no other task is touched."""
    request = replace(reaction_requests(paper)[2].motion, cycle=Cycle(reach_s=1.0, work_s=0.2, return_s=0.5))
    settings, preference = request.controller, request.preference
    (task,) = preference.tasks
    own = preference.model_copy(update={"tasks": (task.model_copy(update={"stiffness_per_s2": 25.0}),)})
    none = preference.model_copy(update={"tasks": (task.model_copy(update={"stiffness_per_s2": None}),)})
    stiff = settings.model_copy(
        update={"stiffness_per_s2": settings.stiffness_per_s2.model_copy(update={"segment": 25.0})}
    )
    by_task = simulate(replace(request, preference=own)).torque_nm
    by_controller = simulate(replace(request, preference=none, controller=stiff)).torque_nm
    assert by_task.tobytes() == by_controller.tobytes()
    assert np.abs(by_task - simulate(replace(request, preference=none)).torque_nm).max() > 1


def test_nan_in_any_array_and_any_run_never_passes(paper: Experiment) -> None:

    request, motion = at_work(paper)
    loose = paper.accuracy.model_copy(update={"hand_error_m": 0.05})
    assert measure(request, motion).faults(loose) == []
    for name in ROWS:
        for tick in (50, 250, 450):
            array = getattr(motion, name).copy()
            array[tick, ...] = np.nan
            faults = measure(request, replace(motion, **{name: array})).faults(loose)
            assert any("not_finite" in fault for fault in faults), (name, tick)


def test_a_motion_that_is_none_is_found(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Balanced torques are not enough: poses strung together, another start, turned feet, noted errors."""

    request, motion = reaction_requests(paper)[0].motion, reactions[0].motion

    def error(**arrays: np.ndarray) -> float:
        return measure(request, replace(motion, **arrays)).record_error

    assert measure(request, motion).record_error < 1e-9
    jumped = motion.configuration.copy()
    jumped[800:] = jumped[801]
    assert error(configuration=jumped) > 1e-3
    assert error(velocity=np.zeros_like(motion.velocity)) > 1e-3
    assert error(hand_error_m=motion.hand_error_m / 2) > 1e-5
    assert error(hand_force_n=motion.hand_force_n + 1) == pytest.approx(1)
    turned = motion.configuration.copy()
    turn = pin.SE3(pin.rpy.rpyToMatrix(0, np.radians(2), 0), np.zeros(3))
    for row in turned:
        row[:7] = pin.SE3ToXYZQUAT(turn * pin.XYZQUATToSE3(row[:7]))
    assert measure(request, replace(motion, configuration=turned)).foot_displacement_m > 0.004
    with pytest.raises(MismatchError, match="other phases or another length"):
        measure(
            request, replace(motion, phases=(Phase("reach", 0, 10), Phase("work", 10, 11), Phase("return", 11, 1600)))
        )
    with pytest.raises(MismatchError):
        measure(request, replace(motion, torque_nm=motion.torque_nm[:-1]))


def test_limits_give_way_as_little_as_they_can(paper: Experiment) -> None:
    """Of two bounds that exclude each other by 4, with weights against it: each gives way by 2, no more."""
    program = QuadraticProgram(2, 1, "daqp")
    program.H[:], program.g[:] = np.eye(2) * 1e3, [-1e6, 1e6]
    program.A[:], program.row_lower[:], program.row_upper[:] = [[1, 1]], 10, 10
    program.lower[:], program.upper[:] = [-np.inf, -np.inf], [3, 3]
    assert program.solve() is None
    both = np.arange(2)
    slack = smallest_slack(program, both, np.arange(0), np.ones(2))
    np.testing.assert_allclose(slack, [2, 2], atol=1e-4)
    np.testing.assert_allclose(solve_eased(program, both, slack), [5, 5], atol=1e-4)

"""The whole-body controller: one quadratic program per tick (paper, Eq. 3).

The paper's unknowns are chi = (tau, a, w): joint torques, generalised acceleration and contact
wrenches. The joint rows of the equation of motion give the torques,
    tau = M_a a + h_a - J_a' w,
so they are eliminated and the program is solved for (a, w) alone (45 + 12 unknowns); their limits
stay, as rows. What is solved is the same program, 2-4 times faster.
Wrenches act from the ground on the foot (the paper writes them with the opposite sign).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.model import Human
from fatigue_planner.human.multibody import BASE_DOF, GRAVITY_MPS2
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.assembly import assemble, keeps, within_limits, without_tissue
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.contact import CONE_ROWS, WRENCH, SoleContact, wrench_cone
from fatigue_planner.motion.joint_limits import acceleration_bounds
from fatigue_planner.motion.obstacle import LimitKind, Limits, Obstacle, least_obstacle
from fatigue_planner.motion.physiology.registry import Physiology, Tissue
from fatigue_planner.motion.quadratic_program import QuadraticProgram, solve_eased, solve_with_fallback
from fatigue_planner.motion.settings import Controller
from fatigue_planner.motion.tasks.joint_posture import WholePosture
from fatigue_planner.motion.tasks.task import Task

Vector = NDArray[np.float64]


# Beyond this a body whose limits are eased is falling, not moving (human limbs reach it in fast throws only).
MAX_EASED_RADPS2 = 100.0
# The share of a torque limit that is kept free for what the linearised moments of tissue may be off.
LINEARISATION = 1e-3
# Limits of physiology give way: by SLACK s in their own unit, at the price of SLACK_PRICE s^2 / 2.
SLACK, SLACK_PRICE = 0.1, 10.0
# A limit that is kept by less than this holds the body.
HELD = 1e-6


class Tick(NamedTuple):
    """What the program decides at a tick.

    acceleration (45,); wrench (12,): force and moment on the right, then the left sole, in its own axes;
    torque_nm (39,): of the muscles; eased_radps2 (39,): how far joint accelerations are outside their bounds;
    tissue_nm (39,): what tissue and stops exert on the joints beside the muscles, at the end of the tick.
    """

    acceleration: Vector
    wrench: Vector
    torque_nm: Vector
    eased_radps2: Vector
    tissue_nm: Vector


class WholeBodyController:
    """Finds accelerations, contact wrenches and torques for a set of tasks.

    `strength` holds the maximum torques (positive, negative direction), each (39,) N.m.
    """

    def __init__(
        self,
        human: Human,
        state: BodyState,
        settings: Controller,
        strength: tuple[Vector, Vector],
        posture: WholePosture,
        physiology: Physiology,
        tasks: list[Task],
    ) -> None:
        self.settings = settings
        self.state = state
        self.posture = posture
        self.physiology, self._tissue = physiology, physiology.tissue
        self.tasks = tasks
        self.contacts = [
            SoleContact(state, state.frame(f"{side}_sole"), settings.stiffness_per_s2.contact) for side in SIDES
        ]
        nv = human.model.nv
        self.nv, self.nj = nv, nv - BASE_DOF
        wrenches = WRENCH * len(self.contacts)
        equalities = BASE_DOF + wrenches
        self._torque_rows = slice(equalities, equalities + self.nj)
        self._cone_rows = slice(self._torque_rows.stop, self._torque_rows.stop + CONE_ROWS * len(self.contacts))
        limits = physiology.limits
        sizes = [(0, equalities), (limits, self._cone_rows.stop + limits), (limits, equalities + limits)]
        self.free, self.program, limited = (
            QuadraticProgram(nv + wrenches + slacks, rows, settings.solver, eliminate=bool(physiology.pieces))
            for slacks, rows in sizes
        )
        self.limited = limited if limits else None
        self._limit_rows, self._least = np.zeros((limits, nv)), np.zeros(limits)
        self._lower, self._upper = human.model.lowerPositionLimit[7:], human.model.upperPositionLimit[7:]
        self._highest_torque = settings.torque_limit_factor * strength[0]
        self._lowest_torque = -settings.torque_limit_factor * strength[1]
        # rows of the whole program know the tissue's moments only to first order
        self._row_share = 1 - LINEARISATION if self._tissue else 1.0
        self._torque_scale = settings.regularisation.relative_torque / np.maximum(*strength) ** 2
        self._task_jacobian = np.zeros((sum(task.rows for task in tasks), nv))
        self._task_target = np.zeros(len(self._task_jacobian))
        self._task_weight = np.concatenate([np.full(task.rows, task.weight) for task in tasks])
        ends = np.cumsum([task.rows for task in tasks])
        self._task_rows = [slice(end - task.rows, end) for task, end in zip(tasks, ends, strict=True)]
        self._posture_weight, self._posture_target = np.zeros(self.nj), np.zeros(self.nj)
        self._contact_jacobian, self._required = np.zeros((wrenches, nv)), np.zeros(wrenches)
        self._not_eased, self._no_tissue = np.zeros(self.nj), np.zeros(self.nj)
        self._torque_map = np.zeros((self.nj, nv + wrenches))
        none = np.arange(0)
        force_n = np.full(CONE_ROWS * len(self.contacts), human.mass_kg * GRAVITY_MPS2)
        braking = np.full(self.nj, settings.acceleration_limit_radps2)
        self._limits = {
            LimitKind.JOINT: Limits(np.arange(BASE_DOF, nv), none, braking),
            LimitKind.TORQUE: Limits(none, np.r_[self._torque_rows], np.maximum(*strength)),
            LimitKind.CONTACT: Limits(none, np.r_[self._cone_rows], force_n),
        }
        self._held = False
        self._set_constant_parts(human)

    def _set_constant_parts(self, human: Human) -> None:
        program, nv = self.program, self.nv
        self.free.lower[:], self.free.upper[:] = -np.inf, np.inf
        length, breadth = human.sole_half_length_m, human.sole_half_breadth_m
        self._cone = cone = wrench_cone(length, breadth, self.settings.friction_coefficient)
        first = self._cone_rows.start
        for i in range(len(self.contacts)):
            rows = slice(first + i * CONE_ROWS, first + (i + 1) * CONE_ROWS)
            program.A[rows, nv + i * WRENCH : nv + (i + 1) * WRENCH] = cone
            program.row_lower[rows], program.row_upper[rows] = -np.inf, 0.0
        for limited in (program, self.limited) if self.limited else ():
            size, rows = len(self.free.g), slice(len(limited.A) - self.physiology.limits, len(limited.A))
            limited.H[size:, size:] = SLACK_PRICE * np.eye(self.physiology.limits)
            limited.A[rows, size:] = SLACK * np.eye(self.physiology.limits)
            limited.row_upper[rows], limited.upper[size:] = np.inf, np.inf
        # forces relative to the body's weight, moments to the weight at the sole's half length
        weight = human.mass_kg * GRAVITY_MPS2
        scale = np.array([weight] * 3 + [weight * human.sole_half_length_m] * 3)
        self._wrench_scale = np.tile(self.settings.regularisation.relative_wrench / scale**2, len(self.contacts))

    def step(self) -> Tick | None:
        """Solve the program for the current state; None if it has no solution.

        Torques and contact forces are free at first: where the answer keeps their limits, it is the answer
        of the whole program, too, since that is strictly convex. Where the limits contradict each other, the
        bounds of the joint accelerations are eased, as little as possible and never by more than
        MAX_EASED_RADPS2; all others hold.
        """
        self._fill_free_program()
        solution = self._free_solution()
        if solution is not None:
            tick = self._tick(solution, self._not_eased)
            if within_limits(tick.torque_nm, self._lowest_torque, self._highest_torque, self._cone, tick.wrench):
                return tick
        self.fill_whole_program()
        solution = solve_with_fallback(self.program)
        return self._eased_tick() if solution is None else self._tick(solution, self._not_eased)

    def _free_solution(self) -> Vector | None:
        """The solution with torques and contact forces free: first without the limits of physiology, too.

        Where they held the body at the tick before, they probably do again.
        """
        if not self._held:
            solution = solve_with_fallback(self.free)
            if self.limited is None or (solution is not None and keeps(self._limit_rows, self._least, solution)):
                return solution
        assert self.limited is not None
        self._fill_limited(self.limited)
        solution = solve_with_fallback(self.limited)
        self._held = solution is None or not keeps(self._limit_rows, self._least + HELD, solution)
        return solution

    def _fill_limited(self, program: QuadraticProgram) -> None:
        """Write the free program into another one, and the limits of physiology, each with a priced slack.

        The slacks s are the last variables, the limits the last rows: J a + SLACK s >= least, s >= 0.
        """
        size, limits, free = len(self.free.g), len(self._least), self.free
        program.H[:size, :size], program.g[:size] = free.H, free.g
        program.lower[:size], program.upper[:size] = free.lower, free.upper
        equalities = len(free.A)
        program.A[:equalities, :size] = free.A
        program.row_lower[:equalities], program.row_upper[:equalities] = free.row_lower, free.row_upper
        if limits:
            program.A[-limits:, : self.nv], program.row_lower[-limits:] = self._limit_rows, self._least

    def _tick(self, solution: Vector, eased_radps2: Vector) -> Tick:
        solution = solution[: len(self.free.g)]
        torque = self._torque_map @ solution + self._bias[BASE_DOF:]
        tissue = self._no_tissue
        if self._tissue is not None:
            torque, tissue = self._split(self._tissue, torque, solution[BASE_DOF : self.nv])
        return Tick(solution[: self.nv].copy(), solution[self.nv :].copy(), torque, eased_radps2, tissue)

    def _split(self, bearing: Tissue, torque: Vector, acceleration: Vector) -> tuple[Vector, Vector]:
        """What muscles and what tissue and stops exert, (39,) N.m each, by the exact moments at the end of the tick.

        Both together are what the program found, whose own share of the tissue is linearised.
        """
        further = self.settings.time_step_s**2 * acceleration
        angles = self._angles + further
        total = torque + self._moments + self._slopes @ further
        tissue = bearing.borne(angles, total)
        return total - tissue, tissue

    def _eased_tick(self) -> Tick | None:
        """The solution with the bounds of the joint accelerations eased as little as possible."""
        joints = self._limits[LimitKind.JOINT].bounds
        slack = self._limits[LimitKind.JOINT].slack(self.program)
        if slack is None or np.abs(slack).max() > MAX_EASED_RADPS2:
            return None
        lowest, highest = self.program.lower[joints], self.program.upper[joints]
        solution = solve_eased(self.program, joints, slack)
        if solution is None:
            return None
        beyond = np.maximum(solution[joints] - highest, 0) + np.minimum(solution[joints] - lowest, 0)
        return self._tick(solution, beyond)

    def obstacle(self) -> Obstacle | None:
        """After a step without solution: the limit that would have to be relaxed least, of all kinds, to allow one."""
        self.fill_whole_program()
        return least_obstacle(self.program, self._limits, self._lowest_torque, self._highest_torque)

    def weigh(self, task: int, share: float, first_row: int = 0) -> None:
        """Give a task (by its index), or its rows from `first_row` on, a fraction of its weight."""
        self._task_weight[self._task_rows[task]][first_row:] = share * self.tasks[task].weight

    def _fill_limits(self) -> None:
        acceleration_bounds(
            self.state.configuration[7:],
            self.state.velocity[BASE_DOF:],
            self._lower,
            self._upper,
            self.settings.velocity_limit_radps,
            self.settings.acceleration_limit_radps2,
            2 * self.settings.time_step_s,
            self.free.lower[BASE_DOF : self.nv],
            self.free.upper[BASE_DOF : self.nv],
        )

    def _fill_rows(self) -> None:
        """The rows of the tasks and of the contacts, and the map from (a, w) to torques, T = [M_a, -J_a']."""
        state, jacobian = self.state, self._contact_jacobian
        for i, contact in enumerate(self.contacts):
            rows = slice(i * WRENCH, (i + 1) * WRENCH)
            own = state.local_jacobian(contact.frame)
            jacobian[rows] = own
            self._required[rows] = contact.required_acceleration(state, own)
        for task, rows in zip(self.tasks, self._task_rows, strict=True):
            task.evaluate(state, self._task_jacobian[rows], self._task_target[rows])
        self._posture_weight[:], self._posture_target[:] = self.posture.weight, self.posture.target(state)
        self.physiology.draw(self._posture_weight, self._posture_target)
        self.physiology.limit(self._limit_rows, self._least)

    def _fill_dynamics(self) -> None:
        """Mass matrix and bias of the torques that muscles exert.

        What tissue exerts at the end of the tick, t(q + dt v + dt^2 a), is linearised in a; it belongs to both.
        """
        state, dt = self.state, self.settings.time_step_s
        self._mass, self._bias = state.mass_matrix, state.nonlinear_effects
        if self._tissue is not None:
            self._angles = state.configuration[7:] + dt * state.velocity[BASE_DOF:]
            self._moments, self._slopes = self._tissue.moments(self._angles)
            self._mass, self._bias = without_tissue(self._mass, self._bias, self._moments, dt**2 * self._slopes)

    def _fill_free_program(self) -> None:
        self._fill_limits()
        self._fill_rows()
        self._fill_dynamics()
        free = self.free
        assemble(
            free.H, free.g, free.A, free.row_lower, free.row_upper, self._torque_map,
            self._mass, self._bias, self._contact_jacobian, self._required,
            self._task_jacobian, self._task_target, self._task_weight,
            self._posture_weight, self._posture_target, self._torque_scale, self._wrench_scale,
        )  # fmt: skip

    def fill_whole_program(self) -> None:
        """Write the program with all its rows for the state of the last step."""
        whole, torques = self.program, self._torque_rows
        self._fill_limited(whole)
        whole.A[torques, : len(self.free.g)] = self._torque_map
        bias = self._bias[BASE_DOF:]
        lowest, highest = self._row_share * self._lowest_torque, self._row_share * self._highest_torque
        whole.row_lower[torques], whole.row_upper[torques] = lowest - bias, highest - bias

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

from fatigue_planner.human.model import BASE_DOF, GRAVITY_MPS2, Human
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.contact import CONE_ROWS, WRENCH, SoleContact, wrench_cone
from fatigue_planner.motion.elastic_program import Eased, solve_elastic
from fatigue_planner.motion.limits import acceleration_bounds
from fatigue_planner.motion.quadratic_program import QuadraticProgram, solve_either
from fatigue_planner.motion.settings import Controller
from fatigue_planner.motion.tasks.joint_posture import PostureTask
from fatigue_planner.motion.tasks.task import Task

Vector = NDArray[np.float64]


class Tick(NamedTuple):
    """What the program decides at a tick.

    acceleration (45,); wrench (12,): force and moment on the right, then the left sole, in its own axes;
    torque_nm (39,); eased_radps2 (39,): how far joint accelerations are outside their bounds.
    """

    acceleration: Vector
    wrench: Vector
    torque_nm: Vector
    eased_radps2: Vector


class Obstacle(NamedTuple):
    """The limit that stands most in the way of any movement: its kind, where, and by how much."""

    kind: str
    place: str
    amount: str


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
        posture: PostureTask,
        tasks: list[Task],
    ) -> None:
        self.settings = settings
        self.state = state
        self.posture = posture
        self.tasks = tasks
        self.contacts = [
            SoleContact(state, state.frame(f"{side}_sole"), settings.stiffness_per_s2.contact) for side in SIDES
        ]
        nv = human.model.nv
        self.nv, self.nj = nv, nv - BASE_DOF
        wrenches = WRENCH * len(self.contacts)
        rows = BASE_DOF + wrenches + self.nj + CONE_ROWS * len(self.contacts)
        self.program = QuadraticProgram(nv + wrenches, rows, settings.solver)
        self._lower, self._upper = human.model.lowerPositionLimit[7:], human.model.upperPositionLimit[7:]
        self._highest_torque = settings.torque_limit_factor * strength[0]
        self._lowest_torque = -settings.torque_limit_factor * strength[1]
        self._torque_scale = settings.regularisation.relative_torque / np.maximum(*strength) ** 2
        self._task_jacobian = np.zeros((sum(task.rows for task in tasks), nv))
        self._task_target = np.zeros(len(self._task_jacobian))
        self._task_weight = np.concatenate([np.full(task.rows, task.weight) for task in tasks])
        ends = np.cumsum([task.rows for task in tasks])
        self._task_rows = [slice(end - task.rows, end) for task, end in zip(tasks, ends, strict=True)]
        self._posture_target = np.zeros(self.nj)
        self._contact_jacobian = np.zeros((wrenches, nv))
        self._torque_map = np.zeros((self.nj, nv + wrenches))
        cone_scale = np.full(CONE_ROWS * len(self.contacts), human.mass_kg * GRAVITY_MPS2)
        acceleration_scale = np.full(self.nj, settings.acceleration_limit_radps2)
        self._slack_scale = np.concatenate([acceleration_scale, np.maximum(*strength), cone_scale])
        self._set_constant_parts(human)

    def _set_constant_parts(self, human: Human) -> None:
        program, nv = self.program, self.nv
        program.lower[:], program.upper[:] = -np.inf, np.inf
        cone = wrench_cone(human.sole_half_length_m, human.sole_half_breadth_m, self.settings.friction_coefficient)
        first = BASE_DOF + WRENCH * len(self.contacts) + self.nj
        for i in range(len(self.contacts)):
            rows = slice(first + i * CONE_ROWS, first + (i + 1) * CONE_ROWS)
            program.A[rows, nv + i * WRENCH : nv + (i + 1) * WRENCH] = cone
            program.row_lower[rows], program.row_upper[rows] = -np.inf, 0.0
        # forces relative to the body's weight, moments to the weight at the sole's half length
        weight = human.mass_kg * GRAVITY_MPS2
        scale = np.array([weight] * 3 + [weight * human.sole_half_length_m] * 3)
        self._wrench_scale = np.tile(self.settings.regularisation.relative_wrench / scale**2, len(self.contacts))

    def step(self) -> Tick | None:
        """Solve the program for the state as it stands; None if it has no solution.

        Where the limits contradict each other, the bounds of the joint accelerations give way, as little
        as they can; all others hold.
        """
        self._fill_constraints()
        self._fill_objective()
        solution = solve_either(self.program)
        eased: Vector = np.zeros(self.nj)
        if solution is None:
            relaxed = self._ease(accelerations_only=True)
            if relaxed is None:
                return None
            solution, eased = relaxed.solution, relaxed.slack
        acceleration, wrench = solution[: self.nv].copy(), solution[self.nv :].copy()
        torque = self._torque_map @ solution + self.state.nonlinear_effects[BASE_DOF:]
        return Tick(acceleration, wrench, torque, eased)

    def obstacle(self) -> Obstacle | None:
        """After a step without solution: which limit would have to give way most, were all of them elastic."""
        relaxed = self._ease(accelerations_only=False)
        if relaxed is None:
            return None
        share = np.abs(relaxed.slack) / self._slack_scale
        worst = int(share.argmax())
        if worst < self.nj:
            amount = f"{abs(relaxed.slack[worst]):.0f} rad/s^2"
            return Obstacle("joint range", DEGREES_OF_FREEDOM[worst], amount)
        if worst < 2 * self.nj:
            joint = worst - self.nj
            limit = (self._highest_torque if relaxed.slack[worst] > 0 else -self._lowest_torque)[joint]
            needed = limit + abs(relaxed.slack[worst])
            return Obstacle("torque", DEGREES_OF_FREEDOM[joint], f"{needed:.1f} N.m needed, {limit:.1f} N.m allowed")
        side = SIDES[(worst - 2 * self.nj) // CONE_ROWS]
        return Obstacle("foot contact", f"{side} foot", "it would lift, tip or slip")

    def _ease(self, accelerations_only: bool) -> Eased | None:
        first = BASE_DOF + WRENCH * len(self.contacts)
        rows = np.arange(first, first if accelerations_only else len(self.program.A))
        bounds = np.arange(BASE_DOF, self.nv)
        return solve_elastic(self.program, bounds, rows, self._slack_scale[: len(bounds) + len(rows)])

    def weigh(self, task: int, share: float) -> None:
        """Give a task (by its place in the list) a share of its weight."""
        self._task_weight[self._task_rows[task]] = share * self.tasks[task].weight

    def _fill_constraints(self) -> None:
        state, program, nv = self.state, self.program, self.nv
        mass, bias, jacobian = state.mass_matrix, state.nonlinear_effects, self._contact_jacobian
        torques = slice(BASE_DOF + len(jacobian), BASE_DOF + len(jacobian) + self.nj)
        for i, contact in enumerate(self.contacts):
            rows = slice(i * WRENCH, (i + 1) * WRENCH)
            jacobian[rows] = state.local_jacobian(contact.frame)
            required = contact.required_acceleration(state)
            program.row_lower[BASE_DOF:][rows] = required
            program.row_upper[BASE_DOF:][rows] = required
        program.A[:BASE_DOF, :nv] = mass[:BASE_DOF]
        program.A[:BASE_DOF, nv:] = -jacobian[:, :BASE_DOF].T
        program.row_lower[:BASE_DOF] = program.row_upper[:BASE_DOF] = -bias[:BASE_DOF]
        program.A[BASE_DOF : BASE_DOF + len(jacobian), :nv] = jacobian
        self._torque_map[:, :nv] = mass[BASE_DOF:]
        self._torque_map[:, nv:] = -jacobian[:, BASE_DOF:].T
        program.A[torques] = self._torque_map
        program.row_lower[torques] = self._lowest_torque - bias[BASE_DOF:]
        program.row_upper[torques] = self._highest_torque - bias[BASE_DOF:]
        program.lower[BASE_DOF:nv], program.upper[BASE_DOF:nv] = acceleration_bounds(
            state.configuration[7:],
            state.velocity[BASE_DOF:],
            self._lower,
            self._upper,
            self.settings.velocity_limit_radps,
            self.settings.acceleration_limit_radps2,
            2 * self.settings.time_step_s,
        )

    def _fill_objective(self) -> None:
        """H = J'WJ + regularisation, g = -J'W target, over the tasks' stacked rows."""
        program, nv, jacobian = self.program, self.nv, self._task_jacobian
        for task, rows in zip(self.tasks, self._task_rows, strict=True):
            task.evaluate(self.state, jacobian[rows], self._task_target[rows])
        self.posture.evaluate(self.state, jacobian[:0], self._posture_target)
        weighted = (jacobian * self._task_weight[:, None]).T
        scaled = self._torque_map.T * self._torque_scale
        program.H[:] = scaled @ self._torque_map
        program.g[:] = scaled @ self.state.nonlinear_effects[BASE_DOF:]
        program.H[:nv, :nv] += weighted @ jacobian
        program.g[:nv] -= weighted @ self._task_target
        diagonal = np.einsum("ii->i", program.H)
        diagonal[BASE_DOF:nv] += self.posture.weight
        diagonal[nv:] += self._wrench_scale
        program.g[BASE_DOF:nv] -= self.posture.weight * self._posture_target

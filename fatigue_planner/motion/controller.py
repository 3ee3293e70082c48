"""The whole-body controller: one quadratic program per tick (paper, Eq. 3).

The paper's unknowns are chi = (tau, a, w): joint torques, generalised acceleration and contact
wrenches. The joint rows of the equation of motion give the torques,
    tau = M_a a + h_a - J_a' w,
so they are eliminated and the program is solved for (a, w) alone (45 + 12 unknowns); their limits
stay, as rows. What is solved is the same program, 2-4 times faster.
Wrenches act from the ground on the foot (the paper writes them with the opposite sign).
"""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.model import BASE_DOF, GRAVITY_MPS2, Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.contact import CONE_ROWS, WRENCH, SoleContact, wrench_cone
from fatigue_planner.motion.limits import acceleration_bounds
from fatigue_planner.motion.quadratic_program import QuadraticProgram
from fatigue_planner.motion.settings import Controller
from fatigue_planner.motion.tasks import PostureTask, Task

Vector = NDArray[np.float64]

SECOND_OPINION = {"daqp": "qpoases", "qpoases": "daqp"}


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
            SoleContact(state, state.frame(f"{side}_sole"), settings.stiffness_per_s2.contact)
            for side in ("right", "left")
        ]
        nv = human.model.nv
        self.nv, self.nj = nv, nv - BASE_DOF
        wrenches = WRENCH * len(self.contacts)
        rows = BASE_DOF + wrenches + self.nj + CONE_ROWS * len(self.contacts)
        self.program = QuadraticProgram(nv + wrenches, rows, settings.solver)
        self._second: QuadraticProgram | None = None
        self._lower, self._upper = human.model.lowerPositionLimit[7:], human.model.upperPositionLimit[7:]
        self._highest_torque = settings.torque_limit_factor * strength[0]
        self._lowest_torque = -settings.torque_limit_factor * strength[1]
        self._torque_scale = settings.regularisation.relative_torque / np.maximum(*strength) ** 2
        self._task_jacobian = np.zeros((sum(task.rows for task in tasks), nv))
        self._task_target = np.zeros(len(self._task_jacobian))
        self._task_weight = np.concatenate([np.full(task.rows, task.weight) for task in tasks])
        self._posture_target = np.zeros(self.nj)
        self._contact_jacobian = np.zeros((wrenches, nv))
        self._torque_map = np.zeros((self.nj, nv + wrenches))
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

    def step(self) -> tuple[Vector, Vector, Vector] | None:
        """Accelerations (45,), wrenches (12,) and torques (39,) for the state as it stands.

        The wrenches (force, moment) are those on the right, then the left sole, in its own axes. None
        if neither solver finds a solution.
        """
        self._fill_constraints()
        self._fill_objective()
        solution = self.program.solve()
        if solution is None:
            solution = self._second_opinion()
        if solution is None:
            return None
        acceleration, wrench = solution[: self.nv].copy(), solution[self.nv :].copy()
        torque = self._torque_map @ solution + self.state.nonlinear_effects[BASE_DOF:]
        return acceleration, wrench, torque

    def _second_opinion(self) -> Vector | None:
        if self._second is None:
            rows, variables = self.program.A.shape
            self._second = QuadraticProgram(variables, rows, SECOND_OPINION[self.program.solver])
        self._second.copy_from(self.program)
        return self._second.solve()

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
        row = 0
        for task in self.tasks:
            rows = slice(row, row + task.rows)
            task.evaluate(self.state, jacobian[rows], self._task_target[rows])
            row += task.rows
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

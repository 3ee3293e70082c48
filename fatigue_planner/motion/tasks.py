"""Acceleration tasks of the whole-body program (paper, Eq. 3: the sum over i of w_i Delta_i).

A task wants an acceleration and knows the one the body would have: it writes the rows of
    Delta = || J a - (desired - drift) ||^2,   desired = a_ref + K_d (v_ref - v) + K_p (x_ref - x),
with a the generalised acceleration (45,) and critical damping, K_d = 2 sqrt(K_p).
"""

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.minimum_jerk import MovingPose

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_IDENTITY: Matrix = np.eye(3)


class Task(ABC):
    """One term of the objective: `rows` equations of a weight."""

    rows: int

    def __init__(self, weight: float, stiffness: float) -> None:
        self.weight = weight
        self.stiffness = stiffness
        self.damping = 2 * np.sqrt(stiffness)

    @abstractmethod
    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """Write the task's Jacobian (rows, 45) and its target, desired - drift (rows,), in place."""


class CentreOfMassTask(Task):
    """Hold the centre of mass above a point of the ground (horizontal position)."""

    rows = 2

    def __init__(self, weight: float, stiffness: float, reference_m: Vector) -> None:
        super().__init__(weight, stiffness)
        self.reference_m = reference_m

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        data = state.data
        jacobian[:] = data.Jcom[:2]
        error = self.reference_m[:2] - data.com[0][:2]
        target[:] = self.stiffness * error - self.damping * data.vcom[0][:2] - data.acom[0][:2]


class HandTask(Task):
    """Follow a moving pose with a fist: position and orientation."""

    rows = 6

    def __init__(self, weight: float, stiffness: float, frame: int) -> None:
        super().__init__(weight, stiffness)
        self.frame = frame
        self.reference: MovingPose | None = None

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        assert self.reference is not None
        placement, twist = state.placement(self.frame), state.twist(self.frame)
        reference = self.reference
        jacobian[:] = state.jacobian(self.frame)
        turn = pin.log3(reference.pose.rotation @ placement.rotation.T)
        target[:3] = (
            reference.acceleration
            + self.damping * (reference.velocity - twist[:3])
            + self.stiffness * (reference.pose.position_m - placement.translation)
        )
        target[3:] = (
            reference.angular_acceleration
            + self.damping * (reference.angular_velocity - twist[3:])
            + self.stiffness * turn
        )
        target -= state.drift(self.frame)


class SegmentUprightTask(Task):
    """Keep a segment's long axis (its z axis) vertical; the rotation about it is free.

    The error is the rotation vector from the axis e to the vertical, e x up. All three world
    components are written; the angular acceleration about e is taken out of the rows.
    """

    rows = 3

    def __init__(self, weight: float, stiffness: float, frame: int) -> None:
        super().__init__(weight, stiffness)
        self.frame = frame

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        axis = state.placement(self.frame).rotation[:, 2]
        across = _IDENTITY - axis[:, None] * axis
        error = np.array([axis[1], -axis[0], 0.0])  # axis x up
        desired = self.stiffness * error - self.damping * state.twist(self.frame)[3:]
        jacobian[:] = across @ state.jacobian(self.frame)[3:]
        target[:] = across @ (desired - state.drift(self.frame)[3:])


class PostureTask(Task):
    """Draw all joints to a posture; its Jacobian is the identity, so it writes only the target."""

    rows = 39

    def __init__(self, weight: float, stiffness: float, posture: Vector) -> None:
        super().__init__(weight, stiffness)
        self.posture = posture

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate; `jacobian` is left as it is."""
        target[:] = self.stiffness * (self.posture - state.configuration[7:]) - self.damping * state.velocity[6:]

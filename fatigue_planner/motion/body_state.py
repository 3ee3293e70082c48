"""Dynamics and kinematics of the digital human at one configuration and velocity, by Pinocchio."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.model import Human

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_LOCAL = pin.ReferenceFrame.LOCAL


class BodyState:
    """One evaluation of the model; `update` moves it to the next tick.

    A drift is the acceleration a frame (or the centre of mass) has at zero generalised acceleration.
    """

    def __init__(self, human: Human) -> None:
        self.model = human.model
        self.data = human.model.createData()
        self.configuration = human.stance.copy()
        self.velocity: Vector = np.zeros(human.model.nv)
        self._no_acceleration: Vector = np.zeros(human.model.nv)
        self.mass_matrix: Matrix = self.data.M
        self.nonlinear_effects: Vector = self.data.nle

    def update(self, configuration: Vector, velocity: Vector) -> None:
        """Evaluate at `configuration` (46,) and `velocity` (45,)."""
        self.configuration, self.velocity = configuration, velocity
        pin.crba(self.model, self.data, configuration)
        self.nonlinear_effects = pin.nonLinearEffects(self.model, self.data, configuration, velocity)
        self.mass_matrix = self.data.M
        pin.jacobianCenterOfMass(self.model, self.data, configuration)
        pin.centerOfMass(self.model, self.data, configuration, velocity, self._no_acceleration)
        pin.updateFramePlacements(self.model, self.data)

    def push(self, frame: int, force_n: Vector) -> None:
        """Let a force (3,) N, world axes, act on a frame: part of what the joints and the ground have to balance."""
        self.nonlinear_effects = self.nonlinear_effects - force_n @ self.jacobian(frame)[:3]

    def frame(self, name: str) -> int:
        """Index of a frame, to be looked up once."""
        return int(self.model.getFrameId(name))

    def placement(self, frame: int) -> pin.SE3:
        """Pose of a frame in the world."""
        return self.data.oMf[frame]

    def jacobian(self, frame: int) -> Matrix:
        """Jacobian (6, 45) of a frame, linear part first, world axes."""
        return np.asarray(pin.getFrameJacobian(self.model, self.data, frame, _WORLD))

    def twist(self, frame: int) -> Vector:
        """Velocity (6,) of a frame, world axes."""
        return np.asarray(pin.getFrameVelocity(self.model, self.data, frame, _WORLD).vector)

    def drift(self, frame: int) -> Vector:
        """Classical acceleration (6,) of a frame at zero generalised acceleration, world axes."""
        return np.asarray(pin.getFrameClassicalAcceleration(self.model, self.data, frame, _WORLD).vector)

    def local_jacobian(self, frame: int) -> Matrix:
        """Jacobian (6, 45) of a frame in its own axes."""
        return np.asarray(pin.getFrameJacobian(self.model, self.data, frame, _LOCAL))

    def local_twist(self, frame: int) -> Vector:
        """Velocity (6,) of a frame in its own axes."""
        return np.asarray(pin.getFrameVelocity(self.model, self.data, frame, _LOCAL).vector)

    def local_drift(self, frame: int) -> Vector:
        """Classical acceleration (6,) at zero generalised acceleration, the frame's own axes."""
        return np.asarray(pin.getFrameClassicalAcceleration(self.model, self.data, frame, _LOCAL).vector)

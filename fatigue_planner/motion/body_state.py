"""Dynamics and kinematics of the digital human at one configuration and velocity, by Pinocchio."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.model import Human

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_LOCAL = pin.ReferenceFrame.LOCAL


class CentreOfMassState(NamedTuple):
    """Position (3,) m, velocity (3,), drift (3,) and Jacobian (3, 45) of the centre of mass, world axes."""

    position_m: Vector
    velocity: Vector
    drift: Vector
    jacobian: Matrix


class BodyState:
    """One evaluation of the model; `update` moves it to the next tick.

    A drift is the acceleration a frame (or the centre of mass) has at zero generalised acceleration.
    `unforced_effects` are Coriolis, centrifugal and gravity forces; `nonlinear_effects` have the forces
    on the hands in them, too.
    """

    def __init__(self, human: Human) -> None:
        self.model = human.model
        self.data = human.model.createData()
        self.configuration = human.stance.copy()
        self.velocity: Vector = np.zeros(human.model.nv)
        self._gravity: Vector = human.model.gravity.linear.copy()
        self._no_acceleration: Vector = np.zeros(human.model.nv)
        self.mass_matrix: Matrix = self.data.M
        self.unforced_effects: Vector = self.data.nle
        self.nonlinear_effects: Vector = self.data.nle

    def update(self, configuration: Vector, velocity: Vector) -> None:
        """Evaluate at `configuration` (46,) and `velocity` (45,)."""
        self.configuration, self.velocity = configuration, velocity
        self.mass_matrix = pin.crba(self.model, self.data, configuration)
        self.unforced_effects = pin.nonLinearEffects(self.model, self.data, configuration, velocity)
        self.nonlinear_effects = self.unforced_effects
        pin.forwardKinematics(self.model, self.data, configuration, velocity, self._no_acceleration)
        pin.computeJointJacobians(self.model, self.data)
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

    def centre_of_mass(self) -> CentreOfMassState:
        """The centre of mass, by the momentum balance of the whole body.

        The first rows of M a + h are the force on the whole body in the pelvis' axes, m R' (c'' - g), and
        M's linear-angular block is -m [c]x with c from the pelvis: so J = R M_lin / m, and the
        acceleration at a = 0 is R h_lin / m + g.
        """
        base = self.data.oMi[1]
        return CentreOfMassState(
            *_centre_of_mass(
                self.mass_matrix, self.unforced_effects, base.rotation, base.translation, self._gravity, self.velocity
            )
        )

    def local_jacobian(self, frame: int) -> Matrix:
        """Jacobian (6, 45) of a frame in its own axes."""
        return np.asarray(pin.getFrameJacobian(self.model, self.data, frame, _LOCAL))

    def local_drift(self, frame: int) -> Vector:
        """Classical acceleration (6,) at zero generalised acceleration, the frame's own axes."""
        return np.asarray(pin.getFrameClassicalAcceleration(self.model, self.data, frame, _LOCAL).vector)


@compiled
def _centre_of_mass(
    mass_matrix: Matrix, effects: Vector, rotation: Matrix, origin: Vector, gravity: Vector, velocity: Vector
) -> tuple[Vector, Vector, Vector, Matrix]:
    """See BodyState.centre_of_mass."""
    mass = mass_matrix[0, 0]
    jacobian = rotation @ np.ascontiguousarray(mass_matrix[:3]) / mass
    from_pelvis = np.array([mass_matrix[1, 5], mass_matrix[2, 3], mass_matrix[0, 4]]) / mass
    drift = rotation @ effects[:3] / mass + gravity
    return origin + rotation @ from_pelvis, jacobian @ velocity, drift, jacobian

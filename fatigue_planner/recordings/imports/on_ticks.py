"""A recorded motion on the ticks of a cycle: every phase is stretched to the cycle's, and keeps its mean torques.

Torques stay those of the recorded speed; fatigue depends on how long a torque lasts, and a stretched phase lasts as
the cycle says. Velocities and accelerations are those of the stretched motion.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import build_human
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.physiology.registry import tissue_of
from fatigue_planner.motion.schedule import Run, hand_reference, phases_of
from fatigue_planner.recordings.dynamics import Movement
from fatigue_planner.recordings.imports.contacts import planted, soles_m
from fatigue_planner.recordings.imports.phases import Bounds
from fatigue_planner.recordings.kinematics.measured import Measured

Vector = NDArray[np.float64]


class Course(NamedTuple):
    """What is known of every frame: the motion, joint torques (n, 39) N.m and wrenches on the soles (n, 12)."""

    movement: Movement
    torque_nm: Vector
    wrench: Vector


def loaded(person: Measured, run: Run) -> pin.Model:
    """The person's body with the masses of a run in the fists."""
    model = person.model()
    for side, mass, at_m in (("right", run.right_kg, run.right_at_m), ("left", run.left_kg, run.left_at_m)):
        grip = model.frames[model.getFrameId(f"{side}_grip")]
        point = pin.Inertia(mass, np.array(at_m), np.zeros((3, 3)))
        model.appendBodyToJoint(grip.parentJoint, point, grip.placement)
    return model


def fists_m(person: Measured, configuration: Vector) -> Vector:
    """The centres (n, 2, 3) m of both fists."""
    poses = poses_of(tree_of(person), configuration)
    return np.stack([poses.points(f"{side}_hand", person.grip_m()) for side in SIDES], axis=1)


def origin_m(person: Measured, configuration: Vector) -> Vector:
    """The ground (3,) m at the middle between the soles, where they mostly are while both stand."""
    soles = soles_m(person, configuration)
    both = planted(soles).all(axis=1)
    return np.asarray(np.median((soles[both] if both.any() else soles).mean(axis=1), axis=0))


def motion_of(person: Measured, request: MotionRequest, course: Course, bounds: Bounds, origin: Vector) -> Motion:
    """The motion of a cycle, whose world's origin is at `origin` (3,) m of the recording's."""
    step = request.controller.time_step_s
    phases = phases_of(request.cycle, step)
    times = bounds.times_s(phases)
    pace = np.concatenate(
        [
            np.full(phase.stop - phase.start, (end - begin) / ((phase.stop - phase.start) * step))
            for index, phase in enumerate(phases)
            for begin, end in [bounds.of(index)]
        ]
    )[:, None]
    moved = course.movement
    configuration = _at(_even(moved.configuration), moved.rate_hz, times)
    configuration[:, 3:7] /= np.linalg.norm(configuration[:, 3:7], axis=1)[:, None]
    configuration[:, :3] -= origin
    total = _at(course.torque_nm, moved.rate_hz, times)
    tissue = tissue_of(request.worker.human, person)
    borne = np.zeros_like(total)
    if tissue is not None:
        borne = np.array([tissue.borne(*tick) for tick in zip(configuration[:, 7:], total, strict=True)])
    motion = Motion(
        time_step_s=step,
        phases=phases,
        configuration=configuration,
        velocity=_at(moved.velocity, moved.rate_hz, times) * pace,
        acceleration=_at(moved.acceleration, moved.rate_hz, times) * pace**2,
        torque_nm=total - borne,
        wrench=_at(course.wrench, moved.rate_hz, times),
        hand_force_n=np.zeros((len(times), 2 * 3)),
        hand_error_m=_hand_errors(person, request, configuration),
        eased_radps2=np.zeros((len(times), len(DEGREES_OF_FREEDOM))),
        tissue_nm=borne,
    )
    assert len(times) == phases[-1].stop
    return motion


def _at(values: Vector, rate_hz: float, times_s: Vector) -> Vector:
    """Values (n, c) of frames at times (T,)."""
    frames = np.arange(len(values)) / rate_hz
    return np.column_stack([np.interp(times_s, frames, column) for column in values.T])


def _even(configuration: Vector) -> Vector:
    """Configurations (n, 46) whose quaternions do not change sign from frame to frame."""
    even = configuration.copy()
    turned = (even[1:, 3:7] * even[:-1, 3:7]).sum(axis=1) < 0
    even[1:, 3:7] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
    return even


def _hand_errors(person: Measured, request: MotionRequest, configuration: Vector) -> Vector:
    """How far a fist is from where the simulated one would be (T,) m, the larger of those that work."""
    human = build_human(request.worker)
    step = request.controller.time_step_s
    phases = phases_of(request.cycle, step)
    home = poses_of(tree_of(human.anthropometry), human.stance[None])
    own = fists_m(person, configuration)
    away = []
    for side, goal in request.action.goals().items():
        start = home.points(f"{side}_hand", human.anthropometry.grip_m())[0]
        wanted = hand_reference(Pose(start, np.eye(3)), goal, phases, step)
        away.append(np.linalg.norm(own[:, SIDES.index(side)] - wanted.position_m, axis=1))
    return np.asarray(np.max(away, axis=0))

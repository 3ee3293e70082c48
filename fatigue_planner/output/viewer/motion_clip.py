"""A reaction as something to be looked at: who moves how, what it costs, what is held and aimed at."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.fatigue.entries import joint_load_fractions
from fatigue_planner.fatigue.load import loads, strength_nm
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.motion.contact import WRENCH
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Verdict
from fatigue_planner.motion.schedule import Run, runs_of
from fatigue_planner.motion.settings import Side
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest
from fatigue_planner.robot.shape import RobotShape

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

MIN_FORCE_N = 1.0  # below, a sole has no centre of pressure worth showing


@dataclass(frozen=True)
class Force:
    """A force (3,) N on the body and the point (3,) m where it acts, world axes."""

    point_m: Vector
    force_n: Vector


@dataclass(frozen=True)
class Instant:
    """What there is to see at one tick, world axes.

    Positions (17, 3) m and rotations (17, 3, 3) of `BODIES`, the largest share of strength by compound
    joint, the centre of mass (3,) m with what the hands hold, the poses of what they hold, and the forces
    on the feet and the hands.
    """

    positions: Vector
    rotations: Vector
    joint_share: dict[str, float]
    centre_of_mass_m: Vector
    tools: tuple[Pose, ...]
    forces: tuple[Force, ...]


@dataclass(frozen=True)
class MotionClip:
    """One cycle of T ticks to be shown.

    `human` has empty hands, `bodies` what they hold in each of `runs`; `working` are the sides whose hands
    have a goal; `strength_nm` (T or 1, 78) that of `ENTRIES`; `objects` the poses at which the robot
    presents the object, one per hand and waypoint; `verdict` and `remarks` what `simulate` says of the motion;
    `robot` the arm that presents it, if there is one that can;
    `markers_m` (T, k, 3) those of a recording, NaN where unseen.
    """

    name: ReactionName
    human: Human
    bodies: tuple[Human, ...]
    runs: tuple[Run, ...]
    working: tuple[Side, ...]
    motion: Motion
    strength_nm: Matrix
    objects: tuple[Pose, ...]
    verdict: Verdict
    remarks: tuple[str, ...] = ()
    robot: RobotShape | None = None
    markers_m: Matrix | None = None

    @property
    def duration_s(self) -> float:
        """Length of the cycle."""
        return len(self.motion.configuration) * self.motion.time_step_s

    def tick(self, time_s: float) -> int:
        """The tick at a time of the cycle."""
        return min(round(time_s / self.motion.time_step_s), len(self.motion.configuration) - 1)

    def phase(self, tick: int) -> str:
        """The name of a tick's phase."""
        return next(phase.name for phase in self.motion.phases if phase.start <= tick < phase.stop)

    def robot_waypoint(self, tick: int) -> int:
        """The waypoint at which the robot stands at a tick, if there is one."""
        assert self.robot is not None
        return self.robot.waypoint((tick - self.motion.phase("work").start) * self.motion.time_step_s)

    def instant(self, tick: int) -> Instant:
        """What there is to see at a tick."""
        body, run = next(pair for pair in zip(self.bodies, self.runs, strict=True) if tick < pair[1].stop)
        model = body.model
        data = model.createData()
        centre = pin.centerOfMass(model, data, self.motion.configuration[tick])
        pin.updateFramePlacements(model, data)
        pose = {frame.name: data.oMf[i] for i, frame in enumerate(model.frames)}
        load = loads(self.motion.torque_nm[tick : tick + 1])[0]
        wrenches, forces = self.motion.wrench[tick].reshape(2, WRENCH), self.motion.hand_force_n[tick].reshape(2, 3)
        on_feet = [_force(pose[f"{side}_sole"], wrench) for side, wrench in zip(SIDES, wrenches, strict=True)]
        on_hands = [
            Force(pose[f"{side}_grip"].translation.copy(), force) for side, force in zip(SIDES, forces, strict=True)
        ]
        return Instant(
            positions=np.array([pose[body].translation for body in BODIES]),
            rotations=np.array([pose[body].rotation for body in BODIES]),
            joint_share=joint_load_fractions(load / self.strength_nm[tick % len(self.strength_nm)]),
            centre_of_mass_m=centre.copy(),
            tools=tuple(
                Pose(pose[f"{side}_grip"].translation.copy(), pose[f"{side}_grip"].rotation.copy())
                for side, mass in zip(SIDES, (run.right_kg, run.left_kg), strict=True)
                if mass > 0
            ),
            forces=(*on_feet, *on_hands),
        )


def motion_clip_of(
    request: ReactionRequest,
    reaction: Reaction,
    parameters: FatigueParameters,
    robot: RobotShape | None = None,
    said: tuple[str, ...] = (),
) -> MotionClip:
    """What there is to see of a reaction. All that depends on how a reaction is asked for is read here.

    `robot`: the arm that presents the action, if there is one; `said`: what is to be said of it.
    """
    settings, motion = request.motion, reaction.motion
    human = build_human(settings.worker)
    runs = runs_of(settings.tool, settings.action, motion.phases)
    home = Pose(np.zeros(3), np.eye(3))  # for the orientation of objects that may be taken in any
    goals = settings.action.goals()
    return MotionClip(
        name=reaction.name,
        human=human,
        bodies=tuple(run.human(settings.worker) for run in runs),
        runs=runs,
        working=tuple(goals),
        motion=motion,
        strength_nm=strength_nm(motion, parameters),
        objects=tuple(waypoint.pose(home) for goal in goals.values() for waypoint in goal.path()),
        verdict=reaction.quality.kept_as(),
        remarks=(*reaction.quality.remarks(), *said),
        robot=robot,
    )


def _force(sole: pin.SE3, wrench: Vector) -> Force:
    """The ground's force at the centre of pressure, from the wrench (6,) at the sole's centre in its axes."""
    force, moment = wrench[:3], wrench[3:]
    if force[2] < MIN_FORCE_N:
        return Force(sole.translation.copy(), np.zeros(3))
    pressure = np.array([-moment[1] / force[2], moment[0] / force[2], 0.0])
    return Force(sole.act(pressure), sole.rotation @ force)

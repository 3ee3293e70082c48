"""A reaction as something to be looked at: who moves how, what it costs, what is held and aimed at."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.fatigue.cycle_map import loads
from fatigue_planner.figures.reactions import joint_shares
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.motion.contact import WRENCH
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.simulator import target_pose
from fatigue_planner.reactions.reaction import Reaction, ReactionRequest

Vector = NDArray[np.float64]

LEAST_FORCE_N = 1.0  # below, a sole has no centre of pressure worth showing


@dataclass(frozen=True)
class Force:
    """A force (3,) N on the body and the point (3,) m where it acts, world axes."""

    point_m: Vector
    force_n: Vector


@dataclass(frozen=True)
class Instant:
    """What there is to see at one tick, world axes.

    Positions (17, 3) m and rotations (17, 3, 3) of `BODIES`, the largest share of strength by compound
    joint, the centre of mass (3,) m with the tools in hand, their poses, and the forces on the feet.
    """

    positions: Vector
    rotations: Vector
    joint_share: dict[str, float]
    centre_of_mass_m: Vector
    tools: tuple[Pose, ...]
    forces: tuple[Force, ...]


@dataclass(frozen=True)
class Performance:
    """One cycle of T ticks to be shown.

    `loaded` is the human with the tools, `empty` without; `maximum_torque_nm` (78,) the strengths of
    `ENTRIES`; `tool_frames` names the fists that hold a tool and `held` (T,) says when; `objects` are the
    poses at which the robot presents the object.
    """

    title: str
    loaded: Human
    empty: Human
    motion: Motion
    maximum_torque_nm: Vector
    tool_frames: tuple[str, ...]
    held: NDArray[np.bool_]
    objects: tuple[Pose, ...]

    @property
    def duration_s(self) -> float:
        """Length of the cycle."""
        return len(self.held) * self.motion.time_step_s

    def tick(self, time_s: float) -> int:
        """The tick at a time of the cycle."""
        return min(round(time_s / self.motion.time_step_s), len(self.held) - 1)

    def phase(self, tick: int) -> str:
        """The name of a tick's phase."""
        return next(phase.name for phase in self.motion.phases if phase.start <= tick < phase.stop)

    def instant(self, tick: int) -> Instant:
        """What there is to see at a tick."""
        model = (self.loaded if self.held[tick] else self.empty).model
        data = model.createData()
        centre = pin.centerOfMass(model, data, self.motion.configuration[tick])
        pin.updateFramePlacements(model, data)
        pose = {frame.name: data.oMf[i] for i, frame in enumerate(model.frames)}
        load = loads(self.motion.torque_nm[tick : tick + 1])[0]
        return Instant(
            positions=np.array([pose[body].translation for body in BODIES]),
            rotations=np.array([pose[body].rotation for body in BODIES]),
            joint_share=joint_shares(load / self.maximum_torque_nm),
            centre_of_mass_m=centre.copy(),
            tools=tuple(
                Pose(pose[name].translation.copy(), pose[name].rotation.copy())
                for name in self.tool_frames
                if self.held[tick]
            ),
            forces=tuple(
                _force(pose[f"{side}_sole"], self.motion.wrench[tick, i * WRENCH : (i + 1) * WRENCH])
                for i, side in enumerate(SIDES)
            ),
        )


def performance_of(request: ReactionRequest, reaction: Reaction) -> Performance:
    """What there is to see of a reaction. All that depends on how a reaction is asked for is read here."""
    settings, motion = request.motion, reaction.motion
    held = np.full(len(motion.configuration), settings.tool.mass_kg > 0)
    if settings.tool.held == "work":
        work = motion.phase("work")
        held[: work.start] = held[work.stop :] = False
    return Performance(
        title=str(reaction.name),
        loaded=build_human(settings.worker, settings.tool.mass_kg),
        empty=build_human(settings.worker),
        motion=motion,
        maximum_torque_nm=np.concatenate(maximum_torques(settings.worker.strength)),
        tool_frames=("right_grip",),
        held=held,
        objects=(target_pose(settings.action),),
    )


def _force(sole: pin.SE3, wrench: Vector) -> Force:
    """The ground's force at the centre of pressure, from the wrench (6,) at the sole's centre in its axes."""
    force, moment = wrench[:3], wrench[3:]
    if force[2] < LEAST_FORCE_N:
        return Force(sole.translation.copy(), np.zeros(3))
    pressure = np.array([-moment[1] / force[2], moment[0] / force[2], 0.0])
    return Force(sole.act(pressure), sole.rotation @ force)

"""What an experiment's robot can present, and to which reactions it would come too near."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.robot.arm import arm_named
from fatigue_planner.robot.clearance import Body, Nearest
from fatigue_planner.robot.reach import Cell, PoseReach
from fatigue_planner.robot.scan import Standpoint, scanned
from fatigue_planner.robot.shape import RobotShape

Vector = NDArray[np.float64]


def told(part: str) -> str:
    """A part of the body in words."""
    return part.replace("_", " ")


@dataclass(frozen=True)
class Meeting:
    """The nearest that the arm comes to the body in any reaction to an action: which, how near, what part, when."""

    reaction: str
    distance_m: float
    part: str
    time_s: float


@dataclass(frozen=True)
class Presentation:
    """What the robot can make of an action: the worst of its poses.

    `reason` is empty where it is presented. `angles_deg` (n,) are the joints' in the first pose;
    `joint_margin_deg` is how far the joint `tightest` is from its limit; `manipulability` is sqrt(det J J^T) in m^3.
    """

    action: str
    reason: str
    angles_deg: tuple[float, ...]
    joint_margin_deg: float
    tightest: str
    manipulability: float
    meeting: Meeting | None


class RuledOut(NamedTuple):
    """Why the robot rules a reaction out: it cannot present it, or comes as near to the body as `distance_m`."""

    reason: str
    distance_m: float | None = None


class RobotCell:
    """The robot of an experiment in its place, and the workers before it.

    For every action the arm stands in one posture, whoever works and however: that of all found which is farthest from
    the workers as they stand. Raises ExperimentError for a URDF file that holds no arm.
    """

    def __init__(self, experiment: Experiment) -> None:
        assert experiment.robot is not None
        self._experiment = experiment
        self.cell = Cell(arm_named(experiment.robot.arm, experiment.robot.link_radius_m), experiment.robot)
        self._bodies: dict[tuple[str, str], Body] = {}

    @cached_property
    def presented(self) -> dict[str, tuple[PoseReach, ...]]:
        """What becomes of every pose of every action."""
        actions = self._experiment.actions
        return {name: self.presented_by(self.cell, name) for name in actions}

    def presented_by(self, cell: Cell, action: str) -> tuple[PoseReach, ...]:
        """The same for one action and another place of the robot."""
        _, targets = cell.settings.flange_targets(self._experiment.actions[action])
        return tuple(cell.reach(target, self._standing(action)) for target in targets)

    def nearest(self, name: ReactionName, motion: Motion) -> Nearest:
        """The nearest that the arm, presenting the action, comes to the body in a reaction."""
        body, radius = self._body(name.worker, name.action), self.cell.arm.chain.radius
        met = (body.nearest(motion.configuration, pose.ends_m, radius) for pose in self.presented[name.action])
        return min(met, key=lambda nearest: nearest.distance_m)

    def left_out(self, name: ReactionName, motion: Motion) -> RuledOut | None:
        """Why a reaction is left out of planning, if it is."""
        if reason := self.stopped(name.action):
            return RuledOut(reason)
        nearest = self.nearest(name, motion)
        if nearest.distance_m >= self.cell.settings.clearance_m:
            return None
        return RuledOut(f"{100 * nearest.distance_m:.0f} cm from the {told(nearest.part)}", nearest.distance_m)

    def shape(self, action: str) -> RobotShape | None:
        """What is seen of the robot while it presents an action, if it can."""
        if self.stopped(action):
            return None
        poses = self.presented[action]
        times_s, flanges = self.cell.settings.flange_targets(self._experiment.actions[action])
        return self.cell.shape(poses, flanges, times_s)

    def said(self, name: ReactionName, motion: Motion) -> str:
        """What is to be said of the robot in a reaction."""
        if reason := self.stopped(name.action):
            return f"The robot cannot present it: {reason}."
        nearest, limit_m = self.nearest(name, motion), self.cell.settings.clearance_m
        time_s = nearest.tick * motion.time_step_s
        near = f"{100 * nearest.distance_m:.0f} cm to the {told(nearest.part)}, at {time_s:.1f} s"
        left_out = (
            f"; clearance_m is {limit_m:g}, so it is left out of planning" if nearest.distance_m < limit_m else ""
        )
        return f"The robot comes as near as {near}{left_out}."

    def stopped(self, action: str) -> str:
        """Why the robot cannot present an action, or nothing."""
        return next((pose.reason for pose in self.presented[action] if pose.reason), "")

    def presentations(self, reactions: Iterable[Reaction]) -> list[Presentation]:
        """What the robot can make of every action, and how near it comes to the body in these reactions."""
        met: dict[str, Meeting] = {}
        for reaction in reactions:
            action = reaction.name.action
            if not self.stopped(action):
                nearest = self.nearest(reaction.name, reaction.motion)
                if action not in met or nearest.distance_m < met[action].distance_m:
                    time_s = nearest.tick * reaction.motion.time_step_s
                    met[action] = Meeting(str(reaction.name), nearest.distance_m, nearest.part, time_s)
        return [self._presentation(action, met.get(action)) for action in self._experiment.actions]

    def _presentation(self, action: str, meeting: Meeting | None) -> Presentation:
        poses, limit_m = self.presented[action], self.cell.settings.clearance_m
        reason = self.stopped(action)
        if not reason and meeting is not None and meeting.distance_m < limit_m:
            reason = (
                f"{100 * meeting.distance_m:.0f} cm from the {told(meeting.part)} in {meeting.reaction} at "
                f"{meeting.time_s:.1f} s; clearance_m is {limit_m:g}"
            )
        worst = min(poses, key=lambda pose: pose.joint_margin_rad)
        return Presentation(
            action, reason, tuple(np.degrees(poses[0].angles_rad).tolist()), float(np.degrees(worst.joint_margin_rad)),
            worst.tightest, min(pose.manipulability for pose in poses), meeting,
        )  # fmt: skip

    def scan(self, forward_m: Sequence[float], heights_m: Sequence[float]) -> list[Standpoint]:
        """How many actions are reached from every place of the base; y and yaw stay."""

        def reached(cell: Cell) -> int:
            actions = self._experiment.actions
            return sum(all(pose.reached for pose in self.presented_by(cell, action)) for action in actions)

        return scanned(self.cell, reached, forward_m, heights_m)

    def _body(self, worker: str, action: str) -> Body:
        key = worker, action
        if key not in self._bodies:
            working = frozenset(self._experiment.actions[action].goals())
            self._bodies[key] = Body(self._experiment.workers[worker].anthropometry(), working)
        return self._bodies[key]

    def _standing(self, action: str) -> tuple[Vector, Vector]:
        """The capsules of all workers in the stance, hanging arms and all."""
        ends, radii = [], []
        for worker, settings in self._experiment.workers.items():
            body = self._body(worker, action)
            ends.append(body.ends_m(build_human(settings).stance[None])[0])
            radii.append(body.radius_m)
        return np.concatenate(ends), np.concatenate(radii)

"""What a station's robot can present, and where it would come too near to a worker.

A place has one posture of the arm for every operation, whoever works and however: that which is farthest from the
workers as they stand. The worker chooses the way of working, so a place at which any way comes too near is left out.
"""

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.robot.arm import arm_named
from fatigue_planner.robot.clearance import Body
from fatigue_planner.robot.reach import Cell, PoseReach
from fatigue_planner.robot.scan import HEIGHTS_M, Standpoint, scanned
from fatigue_planner.robot.settings import RobotSettings, turn_about_vertical
from fatigue_planner.robot.shape import RobotShape
from fatigue_planner.station.assessment import RobotFinding, RobotMeeting, RobotPlace
from fatigue_planner.station.experiments import View, hands_of
from fatigue_planner.station.outcomes import Task
from fatigue_planner.station.schema import Station
from fatigue_planner.station.workers import worker_of

Vector = NDArray[np.float64]

# How much nearer and farther than where it stands the base is tried, in m.
STEPS_M = (-0.2, 0.0, 0.2)

CANNOT_PRESENT = "{place} is left out: the {arm} cannot present it: {reason}"
TOO_NEAR = (
    "{place} is left out: the {arm} would come as near as {distance_cm:.0f} cm to the {part} of {worker}; "
    "clearance_m is {limit_m:g}"
)


class StationRobot:
    """The robot of a station in its place. Raises ExperimentError for a URDF file that holds no arm."""

    def __init__(self, station: Station, settings: RobotSettings) -> None:
        self._station, self.settings = station, settings
        self.cell = Cell(arm_named(settings.arm, settings.link_radius_m), settings)
        self.pose = cache(self._pose)
        self._body = cache(self._new_body)

    def flange(self, place: str) -> Vector:
        """Where the flange has to be for a place, (4, 4) in the world: turned with a worker who faces it."""
        at = self._station.places[place].vector()
        return np.asarray(self.settings.flanges_at(at[None], self._turned_rad(place))[0])

    def of_worker(self, place: str, world: Vector) -> Vector:
        """Points (..., 3) m of the world in the axes of a worker at a place, who may be turned and has shoes."""
        return np.asarray((world - self._raised) @ turn_about_vertical(-self._turned_rad(place)).T)

    def of_world(self, place: str, own: Vector) -> Vector:
        """The reverse of `of_worker`."""
        return np.asarray(own @ turn_about_vertical(self._turned_rad(place)).T + self._raised)

    @property
    def _raised(self) -> Vector:
        return np.array([0.0, 0.0, self._station.shoes_m])

    def _turned_rad(self, place: str) -> float:
        return View.of(self._station, place, mirrored=False).turned_rad

    def _pose(self, operation: str, place: str) -> PoseReach:
        """What becomes of a place of an operation."""
        ends, radii = [], []
        for worker in self._station.workers:
            body, stance = self._body(worker, operation), build_human(worker_of(self._station, worker)).stance
            ends.append(self.of_world(place, body.ends_m(stance[None])[0]))
            radii.append(body.radius_m)
        return self.cell.reach(self.flange(place), (np.concatenate(ends), np.concatenate(radii)))

    def nearest(self, task: Task, motion: Motion) -> RobotMeeting:
        """The nearest that the arm, presenting the place of a task, comes to the body in its motion."""
        doing = task.doing
        ends = self.of_worker(doing.place, self.pose(doing.operation, doing.place).ends_m)
        body = self._body(doing.worker, doing.operation)
        found = body.nearest(motion.configuration, np.ascontiguousarray(ends), self.cell.arm.chain.radius)
        time_s = found.tick * motion.time_step_s
        return RobotMeeting(doing.worker, doing.way, found.distance_m, found.part.replace("_", " "), time_s)

    def shape(self, task: Task) -> RobotShape | None:
        """What the worker of a task has before him or her, in his or her own axes; None if the place is not reached."""
        pose = self.pose(task.doing.operation, task.doing.place)
        if not pose.reached:
            return None
        shape = self.cell.shape([pose], self.flange(task.doing.place)[None], np.zeros(1))
        parts = (shape.arm, shape.holder, shape.pedestal)
        arm, holder, pedestal = (self.of_worker(task.doing.place, each) for each in parts)
        return RobotShape(arm, shape.arm_radius, holder, pedestal, shape.times_s)

    def _new_body(self, worker: str, operation: str) -> Body:
        hands = hands_of(self._station, self._station.operations[operation], worker)
        return Body(worker_of(self._station, worker).anthropometry(), frozenset(hands))

    def scan(self) -> list[Standpoint]:
        """How many of the places are reached from other distances and heights of the base, and from its own."""
        used = dict.fromkeys(place for each in self._station.operations.values() for place in each.places)
        flanges, base = [self.flange(place) for place in used], self.settings.base_m
        forward = [round(base.x + step, 4) for step in STEPS_M]
        return scanned(
            self.cell,
            lambda cell: sum(cell.reach(flange).reached for flange in flanges),
            forward,
            sorted({*HEIGHTS_M, base.z}),
        )


def robot_places(station: Station, tasks: Sequence[Task], cache: ReactionCache, command: str) -> tuple[RobotPlace, ...]:
    """What a station's robot can make of every place of every operation; nothing for a station without one.

    tasks: those whose motion reaches its place. Raises what `ReactionCache.stream` raises.
    """
    if station.robot is None:
        return ()
    robot = StationRobot(station, station.robot)
    met: dict[tuple[str, str], RobotMeeting] = {}
    presented = [task for task in tasks if robot.pose(task.doing.operation, task.doing.place).reached]
    for task, reaction in zip(presented, cache.stream([task.request for task in presented], command), strict=True):
        assert isinstance(reaction, Reaction)
        key = task.doing.operation, task.doing.place
        found = robot.nearest(task, reaction.motion)
        if key not in met or found.distance_m < met[key].distance_m:
            met[key] = found
    return tuple(
        _place(robot, operation, place, met.get((operation, place)))
        for operation, said in station.operations.items()
        for place in said.places
    )


def _place(robot: StationRobot, operation: str, place: str, meeting: RobotMeeting | None) -> RobotPlace:
    pose, settings = robot.pose(operation, place), robot.settings
    named: dict[str, str | float] = {"place": place, "arm": robot.cell.arm.name}
    left_out = None
    if pose.reason:
        left_out = Phrase(CANNOT_PRESENT, named | {"reason": pose.reason})
    elif meeting is not None and meeting.distance_m < settings.clearance_m:
        near: dict[str, str | float] = {
            "distance_cm": 100 * meeting.distance_m,
            "part": meeting.part,
            "worker": meeting.worker,
        }
        left_out = Phrase(TOO_NEAR, named | near | {"limit_m": settings.clearance_m})
    return RobotPlace(
        operation, place, pose.reason, tuple(np.degrees(pose.angles_rad).round(2).tolist()),
        float(np.degrees(pose.joint_margin_rad)), pose.tightest, pose.manipulability, meeting, left_out,
    )  # fmt: skip


def ruled_out(places: Sequence[RobotPlace]) -> Mapping[tuple[str, str], Phrase]:
    """The places that the robot rules out, by operation and place, and why."""
    return {(each.operation, each.place): each.left_out for each in places if each.left_out is not None}


def robot_finding(station: Station, places: tuple[RobotPlace, ...]) -> RobotFinding | None:
    """What is said of a station's robot, with where else it could stand; None for a station without one."""
    if station.robot is None:
        return None
    robot = StationRobot(station, station.robot)
    return RobotFinding(
        robot.cell.arm.name, robot.cell.arm.source, robot.cell.arm.payload_kg, places, tuple(robot.scan())
    )

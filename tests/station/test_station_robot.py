"""A station's robot: where it stands before workers who turn, what it rules out, and what is said of it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from test_station_file import station

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.robot.kinematics import axes_apart
from fatigue_planner.robot.scan import Standpoint
from fatigue_planner.station.assessment import RobotFinding, RobotPlace
from fatigue_planner.station.bound_experiments import bound_experiments
from fatigue_planner.station.examine import Examined, examine
from fatigue_planner.station.robot_reach import STEPS_M, StationRobot, robot_finding
from fatigue_planner.station.schema import Station
from fatigue_planner.station.statements import of_robot

Vector = NDArray[np.float64]

ROBOT = {"arm": "ur5e", "base_m": {"x": 1.1, "y": 0.3, "z": 0.5}}
# A left-hander who turns to places that are aside.
WORKERS = {"lefty": {"height_m": 1.75, "mass_kg": 75.0, "sex": "male", "handedness": "left"}}
PLACES = {
    "aside": {"x": 0.35, "y": 0.2, "z": 1.1},
    "ahead": {"x": 0.45, "y": 0.0, "z": 1.0},
    "far": {"x": -0.4, "y": 0.0, "z": 1.1},
}
FIT = {"fit": {"places": list(PLACES), "seconds": 2.0}}


def with_robot(**more: Any) -> Station:
    robot = ROBOT | more.pop("robot", {})
    said = {"workers": WORKERS, "places": PLACES, "operations": FIT, "tools": {}, "ways": ["arm"], "robot": robot}
    return station(**said | more)


def robot_of(said: Station) -> StationRobot:
    assert said.robot is not None
    return StationRobot(said, said.robot)


def test_the_worlds_points_come_back() -> None:
    robot, points = robot_of(with_robot(shoes_m=0.03)), np.random.default_rng(1).normal(size=(4, 2, 3))
    np.testing.assert_allclose(robot.of_world("aside", robot.of_worker("aside", points)), points, atol=1e-14)
    ahead = robot.of_worker("aside", np.array([0.35, 0.2, 1.0]))
    np.testing.assert_allclose(ahead, [np.hypot(0.35, 0.2), 0, 0.97], atol=1e-14)


@pytest.mark.parametrize("feet", ["free", "fixed"])
def test_the_flange_points_at_a_worker_who_turns(feet: str) -> None:
    robot = robot_of(with_robot(feet=feet))
    flange, place = robot.flange("aside"), np.array([0.35, 0.2, 1.1])
    points_at = -np.array([0.35, 0.2, 0]) / np.hypot(0.35, 0.2) if feet == "free" else np.array([-1.0, 0, 0])
    np.testing.assert_allclose(flange[:3, 2], points_at, atol=1e-12)
    np.testing.assert_allclose(flange[:3, 3] + 0.1 * flange[:3, 2], place, atol=1e-12)
    np.testing.assert_allclose(flange[:3, :3].T @ flange[:3, :3], np.eye(3), atol=1e-12)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robot")


def examined(folder: Path, said: Station) -> Examined:
    return examine([said], ReactionCache(folder), LocalProcesses(1), "fatplan assess", lambda _: None)[0]


def motion_at(found: Examined, folder: Path, place: str) -> Reaction:
    (task,) = [task for task in found.tasks.values() if task.doing.place == place]
    (reaction,) = ReactionCache(folder).stream([task.request], "fatplan assess")
    assert isinstance(reaction, Reaction)
    return reaction


@pytest.mark.slow
def test_a_worker_and_the_arm_meet_in_one_world(folder: Path) -> None:
    """The fist of a worker who is turned and in shoes is at the place; distances are those of the world."""
    said = with_robot()
    found, robot = examined(folder, said), robot_of(said)
    places = {each.place: each for each in found.robot}
    for place in ("aside", "ahead"):
        motion = motion_at(found, folder, place).motion
        person = next(task for task in found.tasks.values()).request.motion.worker.anthropometry()
        poses, capsules = poses_of(tree_of(person), motion.configuration), capsules_of(person)
        ends = robot.of_world(place, capsules.world_ends(poses))
        hand = ends[motion.middle("work"), BODIES.index("left_hand")]
        at = np.array([PLACES[place][axis] for axis in "xyz"])
        assert np.linalg.norm(hand - at, axis=1).min() < 0.1
        pose, radius, least = robot.pose("fit", place), robot.cell.arm.chain.radius, np.inf
        for tick in range(0, len(ends), 10):
            for body, name in enumerate(BODIES):
                if name != "left_hand":
                    apart = [axes_apart(ends[tick, body], own) for own in pose.ends_m] - radius
                    least = min(least, float(apart.min()) - capsules.radius_m[body])
        meeting = places[place].meeting
        assert meeting is not None and least - 0.01 < meeting.distance_m <= least + 1e-12


@pytest.mark.slow
def test_what_the_robot_cannot_present_is_neither_recommended_nor_planned(folder: Path) -> None:
    said = with_robot()
    found = examined(folder, said)
    reasons = {each.place: str(each.left_out) for each in found.robot if each.left_out is not None}
    assert list(reasons) == ["far"] and reasons["far"].startswith(
        "far is left out: the UR5e cannot present it: out of reach"
    )
    assert ("fit", "far") in found.best.excluded and "far" not in found.best.places.values()
    assert all("far" not in each.places for each in found.ranking)
    (bound,) = bound_experiments(said, found.outcomes, found.robot)
    assert bound.experiment is not None and list(bound.experiment.actions) == ["aside", "ahead"]
    assert bound.left_out == (f"action far: {reasons['far']}",)
    near = examined(folder, with_robot(robot={"clearance_m": 1.0}))
    assert near.best.places == {} and not near.ranking and near.doings("lefty", {}) == ()
    assert "would come as near as" in str(near.best.excluded["fit", "ahead"])
    (bound,) = bound_experiments(with_robot(robot={"clearance_m": 1.0}), near.outcomes, near.robot)
    assert bound.experiment is None and len(bound.left_out) == 4
    without = examined(folder, station(**{**with_robot().plain(), "robot": None}))
    assert without.robot == () and without.best.places == {"fit": "far"}  # whom it is behind turns to it


def made(reached: dict[tuple[float, float], int]) -> RobotFinding:
    """A finding with 25 places, of which so many are reached from each place of the base."""
    places = tuple(RobotPlace("fit", str(i), "", (0.0,), 30.0, "elbow", 0.1, None, None) for i in range(25))
    scan = tuple(Standpoint(x, z, count) for (x, z), count in reached.items())
    return RobotFinding("UR5e", "", 5, places, scan)


@pytest.mark.parametrize(
    ("z", "reached", "said"),
    [
        (0.0, {(1.1, 0.0): 13, (1.1, 0.5): 25, (1.1, 0.75): 25, (0.9, 0.0): 20},
         ["The UR5e reaches 13 of 25 places from the floor, all from a pedestal of 0.5 m"]),
        (0.0, {(1.1, 0.0): 0, (1.1, 0.5): 5, (0.9, 0.5): 21},
         ["The UR5e reaches 0 of 25 places from the floor, 5 from a pedestal of 0.5 m",
          "With its base 0.9 m ahead it reaches 21, from a pedestal of 0.5 m"]),
        (0.5, {(1.1, 0.0): 25, (1.1, 0.5): 25}, ["The UR5e reaches all 25 places from a pedestal of 0.5 m"]),
        (0.5, {(1.1, 0.0): 1, (1.1, 0.5): 3},
         ["The UR5e reaches 3 of 25 places from a pedestal of 0.5 m; no other height that was tried reaches more"]),
    ],
)  # fmt: skip
def test_where_the_base_should_stand_is_one_sentence(
    z: float, reached: dict[tuple[float, float], int], said: list[str]
) -> None:
    own = with_robot(robot={"base_m": {"x": 1.1, "y": 0.3, "z": z}})
    found = list(map(str, of_robot(own, made(reached))))
    assert found[:-1] == said and found[-1] == "Its joints stay 30 degrees or more from their limits"


def test_the_base_is_tried_nearer_farther_and_at_other_heights() -> None:
    one = with_robot(robot={"base_m": {"x": 1.1, "y": 0.3, "z": 0.3}}, places={"ahead": PLACES["ahead"]},
                     operations={"fit": {"places": ["ahead"], "seconds": 2.0}})  # fmt: skip
    found = robot_finding(one, ())
    assert found is not None and {each.x_m for each in found.scan} == {round(1.1 + step, 4) for step in STEPS_M}
    assert {each.height_m for each in found.scan} == {0, 0.25, 0.3, 0.5, 0.75, 1} and all(
        each.reached <= 1 for each in found.scan
    )
    assert robot_finding(station(), ()) is None


def test_a_robot_that_cannot_be_is_refused() -> None:
    with pytest.raises(ExperimentError, match=r"robot\.arm"):
        with_robot(robot={"arm": "ur6"})
    with pytest.raises(ExperimentError, match=r"robot\.base_m\.x"):
        with_robot(robot={"base_m": {"x": 9.0}})

"""What a robot rules out of an experiment, and what is said of it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import fatplan, refused
from conftest import PAPER

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.feasibility import omissions
from fatigue_planner.experiment.loader import parse_experiment, read_content
from fatigue_planner.experiment.robot_cell import RobotCell
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.output.reports.shift.card import Told, card
from fatigue_planner.reactions.reaction import Reaction

ON_THE_GROUND = {"arm": "ur5e", "base_m": {"x": 1.1, "y": -0.25, "z": 0.0}}


def with_robot(**robot: Any) -> Experiment:
    content = read_content(PAPER) | {"robot": ON_THE_GROUND | robot}
    return parse_experiment(dict(content), "robot")


def test_planning_has_no_action_that_the_robot_cannot_present(reactions: tuple[Reaction, ...]) -> None:
    experiment = with_robot()
    profiles = cycle_profiles(experiment, reactions)
    assert {name.action for name in profiles} == {"low"}
    condition = experiment.benchmark.conditions["single_novice"]
    assert scenario(experiment, profiles, condition).model.actions == ("low",)
    (said,) = omissions(experiment, profiles, profiles.ruled_out)
    assert said == "The robot cannot present 1 of 2 actions, left out of all conditions: high (out of reach by 18 cm)."


def test_a_reaction_too_near_to_the_arm_is_left_out(reactions: tuple[Reaction, ...]) -> None:
    raised = {"x": 1.1, "y": -0.25, "z": 0.5}
    cell = RobotCell(with_robot(base_m=raised))
    near = {one.name: cell.nearest(one.name, one.motion).distance_m for one in reactions}
    limit = float(np.mean(sorted(near.values())[1:3]))
    kept = cycle_profiles(with_robot(base_m=raised, clearance_m=limit), reactions)
    assert set(kept) == {name for name, distance in near.items() if distance >= limit}
    assert 0 < len(kept) < len(near) and set(kept.ruled_out) == set(near) - set(kept)
    said = omissions(with_robot(base_m=raised, clearance_m=limit), kept, kept.ruled_out)
    count = len({name.action for name in kept.ruled_out})
    start = (
        f"The robot would come nearer than {limit:g} m to average_man in {count} of 2 actions, left out of this worker"
    )
    assert said[0].startswith(start) and "cannot perform" not in said[0]
    nearest = min(near, key=near.__getitem__)
    assert (
        f"{nearest.action} ({100 * near[nearest]:.0f} cm from the " in said[0]
        and f"with {nearest.preference})" in said[0]
    )


def test_the_distance_is_that_of_points_of_arm_and_body(reactions: tuple[Reaction, ...]) -> None:
    """Against a cloud of points on the axes: never nearer than the points say, and within their spacing."""
    cell, one = RobotCell(with_robot()), next(one for one in reactions if one.name.action == "low")
    found = cell.nearest(one.name, one.motion)
    person = with_robot().workers["average_man"].anthropometry()
    capsules, share = capsules_of(person), np.linspace(0, 1, 60)[:, None]
    tick = slice(found.tick, found.tick + 1)
    body = capsules.world_ends(poses_of(tree_of(person), one.motion.configuration[tick]))[0]
    ((pose),) = cell.presented["low"]
    least = np.inf
    for index, name in enumerate(BODIES):
        if name == "right_hand":  # it works, and may touch what the robot holds
            continue
        points = body[index, 0] + share * (body[index, 1] - body[index, 0])
        for ends, radius in zip(pose.ends_m, cell.cell.arm.chain.radius, strict=True):
            others = ends[0] + share * (ends[1] - ends[0])
            apart = np.linalg.norm(points[:, None] - others[None], axis=2).min()
            least = min(least, float(apart) - radius - capsules.radius_m[index])
    assert least - 0.005 < found.distance_m <= least


def test_the_command_says_what_is_reached_and_what_is_in_the_way(cache_folder: Path, tmp_path: Path) -> None:
    place = ("--arm", "ur5e", "--base", 1.1, -0.25, 0)
    said = fatplan("reach", PAPER, "--cache", cache_folder, *place, "--scan")
    assert said.returncode == 0, said.stderr
    assert "1 of 2 actions can be presented." in said.stdout
    assert "high                     NO: out of reach by 18 cm" in said.stdout
    assert "cm from the right forearm" in said.stdout and "Reached of 2, by height" in said.stdout
    document = json.loads(fatplan("reach", PAPER, "--cache", cache_folder, *place, "--json").stdout)
    assert [one["reason"] == "" for one in document["actions"]] == [False, True]
    missing = fatplan("reach", PAPER, "--cache", tmp_path / "empty", *place)
    assert missing.returncode == 0 and "is known only after `fatplan simulate" in missing.stderr


def test_the_card_says_what_the_robot_never_does() -> None:
    page = card(Told(with_robot(clearance_m=0.07), None, "greedy", None))
    assert "does one of 1 action (low)" in page and "never does: high (out of reach by 18 cm)" in page
    assert "nearer than 0.07 m" in page and "That is no safety distance" in page
    without = card(Told(parse_experiment(dict(read_content(PAPER)), "paper"), None, "greedy", None))
    assert "does one of 2 actions (high and low)" in without and "safety distance" not in without


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "--arm and --base: needed, as the experiment has no robot"),
        (("--arm", "ur5e"), "--base: needed"),
        (("--arm", "ur6", "--base", 1, 0, 0), "should be one of ur10e, ur3e, ur5e, or the path of a .urdf file"),
        (("--arm", "ur5e", "--base", 9, 0, 0), "robot: base_m.x = 9.0: input should be less than or equal to 5"),
    ],
)
def test_a_robot_that_cannot_be_is_refused(options: tuple[Any, ...], message: str) -> None:
    assert message in refused(2, "reach", PAPER, *options)

"""`fatplan reach`: what the robot of an experiment can present, and how near it comes to the worker."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import warn
from fatigue_planner.core.errors import MissingReactionsError, SelectionError

if TYPE_CHECKING:
    from fatigue_planner.experiment.robot_cell import Presentation, RobotCell
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.reactions.reaction import Reaction
    from fatigue_planner.robot.scan import Standpoint


def reach(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    arm: Annotated[str | None, typer.Option(help="The arm: ur3e, ur5e, ur10e or a URDF file, not the file's.")] = None,
    base: Annotated[
        tuple[float, float, float] | None,
        typer.Option(metavar="X Y Z", help="Where the base stands, in m from between the worker's feet."),
    ] = None,
    scan: Annotated[bool, typer.Option("--scan", help="Also try other distances and heights of the base.")] = False,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Say what the robot of an EXPERIMENT can present: each action reached or not, and what is in the way.

    With the reactions of `fatplan simulate`, also how near the arm comes to the body in any of them. It is no risk
    assessment: contact forces, speeds and the robot's way from one pose to the next are not looked at.
    """
    from fatigue_planner.experiment.build import load_reactions
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.experiment.robot_cell import RobotCell
    from fatigue_planner.robot.scan import FORWARD_M, HEIGHTS_M

    settings = _with_robot(load_experiment(experiment), arm, base)
    cell = RobotCell(settings)
    reactions: tuple[Reaction, ...] = ()
    simulate = options.command_line("simulate", experiment, cache)
    try:
        reactions = load_reactions(settings, cache, simulate)
    except MissingReactionsError:
        warn([f"How near the arm comes to the body is known only after `{simulate}`."])
    found = cell.presentations(reactions)
    places = cell.scan(FORWARD_M, HEIGHTS_M) if scan else []
    lines = [_headline(cell, found), *map(_line, found), *_scanned(places, len(found))]
    document = {
        "arm": cell.cell.arm.name, "source": cell.cell.arm.source, "base_m": cell.cell.settings.base_m.plain(),
        "actions": found, "scan": places,
    }  # fmt: skip
    options.present(document, "\n".join(lines), as_json)


def _with_robot(experiment: "Experiment", arm: str | None, base: tuple[float, float, float] | None) -> "Experiment":
    """The experiment with the robot that is asked for. Raises SelectionError if there is none, or no place for it."""
    from fatigue_planner.experiment.loader import parse_settings
    from fatigue_planner.robot.settings import RobotSettings

    if arm is None and base is None and experiment.robot is not None:
        return experiment
    said = {} if experiment.robot is None else experiment.robot.model_dump(exclude_unset=True)
    if arm is not None:
        said["arm"] = arm
    if base is not None:
        said["base_m"] = said.get("base_m", {}) | dict(zip("xyz", base, strict=True))
    if missing := [option for key, option in (("arm", "--arm"), ("base_m", "--base")) if key not in said]:
        raise SelectionError(
            f"{' and '.join(missing)}: needed, as the experiment has no robot; such as --arm ur5e --base 1.1 0 0.5, or "
            "the key robot in the file."
        )
    return experiment.model_copy(update={"robot": parse_settings(RobotSettings, said, "robot", SelectionError)})


def _headline(cell: "RobotCell", found: Sequence["Presentation"]) -> str:
    base, presented = cell.cell.settings.base_m, sum(not one.reason for one in found)
    return (
        f"{cell.cell.arm.name}, base {base.x:g} m before the worker, {abs(base.y):g} m to the {base.side}, "
        f"{base.z:g} m high: {presented} of {len(found)} actions can be presented."
    )


def _line(one: "Presentation") -> str:
    if one.reason:
        return f"  {one.action:<24} NO: {one.reason}"
    near = ""
    if one.meeting is not None:
        near = f"; {100 * one.meeting.distance_m:.0f} cm from the {one.meeting.part.replace('_', ' ')}"
    return (
        f"  {one.action:<24} yes: {one.joint_margin_deg:.0f} degrees from a joint's limit ({one.tightest}), "
        f"manipulability {one.manipulability:.2f}{near}"
    )


def _scanned(places: Sequence["Standpoint"], count: int) -> list[str]:
    """A table of the actions reached, by height and distance of the base; clearance is not looked at."""
    if not places:
        return []
    forward = sorted({place.x_m for place in places})
    rows = ["", f"Reached of {count}, by height and distance of the base:"]
    rows.append(f"  {'height':>8}" + "".join(f"{x:>8.2f} m" for x in forward))
    for height in sorted({place.height_m for place in places}, reverse=True):
        reached = [place.reached for x in forward for place in places if (place.x_m, place.height_m) == (x, height)]
        rows.append(f"  {height:>6.2f} m" + "".join(f"{number:>10}" for number in reached))
    return rows

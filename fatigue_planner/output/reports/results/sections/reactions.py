"""The postural reactions: postures, torques, and what one cycle does to fatigue."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fatigue_planner.core.text import format_label, listing, percent, significant
from fatigue_planner.ergonomics.indicators.iso_11226 import arm_hold
from fatigue_planner.experiment.robot_cell import RobotCell
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import build_human
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.output.figures.costs import (
    course_figure,
    entry_label,
    place_figure,
    place_table,
    torque_figure,
    torque_table,
)
from fatigue_planner.output.figures.postures import FEW, posture_figure
from fatigue_planner.output.figures.style import FigureFolder, Picture
from fatigue_planner.output.reports.page import Block, Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.postures import plausibility_blocks
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.study.statistics.pairing import records

LARGEST = 5  # entries of each reaction in the tables
# The joint at the near end of each body, where its load is drawn.
JOINT_OF = {joint.child: joint.name for joint in JOINTS}


def reactions_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """Pictures of the reactions; for a few of them also their torques and cycle maps as tables."""
    blocks: list[Block] = [Text(sentence) for sentence in report_data.omissions]
    blocks += plausibility_blocks(report_data.reactions, {r.name: arm_hold(r) for r in report_data.reactions})
    blocks += draw_reactions(
        figures, report_data.experiment, report_data.reactions, report_data.fatigue, report_data.profiles
    )
    maps = cycle_map_table(report_data)
    file = figures.add_table("cycle_maps", maps)
    if len(report_data.reactions) <= FEW:
        blocks += [_torques(report_data), _maps(report_data, maps, file)]
    else:
        blocks.append(Text(f"What one cycle of each of the {len(report_data.reactions)} reactions does: `{file}`."))
    return Section("The postural reactions", blocks)


def draw_reactions(
    figures: FigureFolder,
    experiment: Experiment,
    reactions: Sequence[Reaction],
    parameters: Mapping[str, FatigueParameters],
    profiles: Mapping[ReactionName, CycleProfile],
) -> list[Picture]:
    """Postures, loads and, for grids of poses, maps."""
    places = place_table(experiment.actions, profiles, experiment.cost.fatigue_cost())
    cell = None if experiment.robot is None else RobotCell(experiment)
    robots = {action: cell.shape(action) for action in experiment.actions} if cell else {}
    pictures = []
    for worker, person in experiment.workers.items():
        several = len(experiment.workers) > 1
        suffix, whose = (f"_{worker}", f" of {format_label(worker)}") if several else ("", "")
        own = [reaction for reaction in reactions if reaction.name.worker == worker]
        if not own:
            continue
        figure, table = posture_figure(build_human(person), own, parameters[worker], robots)
        caption = f"The reactions{whose} in the middle of the work. The discs show the largest load at each joint."
        pictures.append(figures.add(f"reactions{suffix}", figure, table, caption, _heaviest_joints(table)))
        if len(own) <= FEW:
            figure, table = course_figure(own, parameters)
            caption = f"The loads{whose} over the cycle, of the entries with the highest mean load."
            pictures.append(figures.add(f"courses{suffix}", figure, table, caption, _peaks(table)))
        map_figure = place_figure(places, worker, list(experiment.preferences))
        if map_figure is not None:
            table = places[places["worker"] == worker]
            caption = f"The long-run cost{whose} of working at each position of the hand."
            pictures.append(figures.add(f"places{suffix}", map_figure, table, caption, _cheapest_and_dearest(table)))
    figure, table = torque_figure(reactions, parameters)
    caption = "Mean loads during work that exceed the threshold of fatigue, in per cent of the worker's strength."
    return [*pictures, figures.add("torques", figure, table, caption, _heaviest_entries(table))]


def _heaviest_joints(table: pd.DataFrame) -> str:
    joints = table.dropna(subset="share_of_maximum")
    rows = joints.loc[joints.groupby(["action", "preference"], sort=False)["share_of_maximum"].idxmax()]
    return _loads(rows.assign(place=[format_label(JOINT_OF[landmark]) for landmark in rows["landmark"]]))


def _heaviest_entries(table: pd.DataFrame) -> str:
    rows = table.loc[table.groupby(["worker", "action", "preference"], sort=False)["share_of_maximum"].idxmax()]
    return _loads(rows.assign(place=rows["entry"].map(entry_label)))


def _peaks(table: pd.DataFrame) -> str:
    rows = table.loc[table.groupby(["worker", "action", "preference"], sort=False)["share_of_maximum"].idxmax()]
    return "the peaks are: " + _loads(rows.assign(place=rows["entry"].map(entry_label)))


def _loads(rows: pd.DataFrame) -> str:
    shown, several = rows.head(FEW), rows["worker"].nunique() > 1
    listed = [
        f"{_name(row, several)} {percent(row['share_of_maximum'], 0)} of the strength at {row['place']}"
        for row in records(shown)
    ]
    more = len(rows) - len(shown)
    return listing([*listed, *([f"{more} more"] if more > 0 else [])]) + "."


def _name(row: Mapping[str, Any], with_worker: bool) -> str:
    """A reaction, with its worker where there are several."""
    parts = [row["worker"]] if with_worker else []
    return "/".join([*parts, row["action"], row["preference"]])


def _cheapest_and_dearest(table: pd.DataFrame) -> str:
    """The places of a pose map with the least and the most cost of repeating, over all preferences."""
    ordered = records(table.sort_values("long_run_cost", kind="stable"))
    ends = [
        f"{word} {row['action']} with {format_label(row['preference'])} ({significant(row['long_run_cost'])})"
        for word, row in (("cheapest is", ordered[0]), ("dearest is", ordered[-1]))
    ]
    return listing(ends) + "."


def cycle_map_table(report_data: ReportData) -> pd.DataFrame:
    """The affine map of one cycle, f' = gain f + offset, for every entry that a reaction tires."""
    rows = []
    for name, profile in report_data.profiles.items():
        cycle_map = profile.cycle_map()
        for index in np.flatnonzero(cycle_map.offset > 0):
            gain, offset = float(cycle_map.gain[index]), float(cycle_map.offset[index])
            rows.append(
                name._asdict()
                | {
                    "entry": ENTRIES[index], "gain": gain, "offset": offset,
                    "fatigue_if_repeated": offset / (1 - gain) if gain < 1 else 1.0,
                }
            )  # fmt: skip
    return pd.DataFrame(rows)


def _torques(report_data: ReportData) -> Table:
    table = torque_table(report_data.reactions, report_data.fatigue)
    rows = [
        [
            _reaction(row, report_data),
            entry_label(row["entry"]),
            significant(row["mean_torque_nm"]),
            percent(row["share_of_maximum"], 0),
        ]
        for _, group in table.groupby(list(ReactionName._fields), sort=False)
        for row in records(group.nlargest(LARGEST, "share_of_maximum"))
    ]
    caption = f"The {LARGEST} largest mean loads of each reaction during work."
    return Table(caption, ["reaction", "entry", "torque, N·m", "of the strength"], rows, "torques.csv")


def _maps(report_data: ReportData, maps: pd.DataFrame, file: str) -> Table:
    numbers = ("gain", "offset", "fatigue_if_repeated")
    rows = [
        [_reaction(row, report_data), entry_label(row["entry"]), *(significant(row[number]) for number in numbers)]
        for _, group in maps.groupby(list(ReactionName._fields), sort=False)
        for row in records(group.nlargest(LARGEST, "offset"))
    ]
    caption = (
        "What one cycle does to fatigue: f′ = gain · f + offset, exactly (Eq. 2 over the whole cycle); the largest "
        "offsets, and the value at which f settles if the reaction is repeated for ever."
    )
    header = ["reaction", "entry", "gain", "offset", "fatigue if repeated"]
    return Table(caption, header, rows, file)


def _reaction(row: Mapping[str, Any], report_data: ReportData) -> str:
    """The name of a reaction, with its worker where there are several."""
    first = 0 if len(report_data.experiment.workers) > 1 else 1
    return "/".join(row[part] for part in ReactionName._fields[first:])

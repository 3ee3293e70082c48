"""The postural reactions: postures, torques, and what one cycle does to fatigue."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from fatigue_planner.experiment.build import cycle_profiles
from fatigue_planner.fatigue.parameters import ENTRIES
from fatigue_planner.output.figures.postures import FEW
from fatigue_planner.output.figures.torques import entry_label, torque_table
from fatigue_planner.output.reports.html.blocks import Block, Section, Table, Text, percent, significant
from fatigue_planner.output.reports.results.drawings import draw_reactions
from fatigue_planner.output.reports.results.figure_folder import FigureFolder
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.reactions.reaction import ReactionName
from fatigue_planner.study.statistics.pairing import records

LARGEST = 5  # entries of each reaction in the tables


def reactions_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """Pictures of the reactions; for a few of them also their torques and cycle maps as tables."""
    blocks: list[Block] = [Text(sentence) for sentence in report_data.omissions]
    blocks += [*draw_reactions(figures, report_data.experiment, report_data.reactions, report_data.fatigue)]
    maps = cycle_map_table(report_data)
    file = figures.add_table("cycle_maps", maps)
    if len(report_data.reactions) <= FEW:
        blocks += [_torques(report_data), _maps(report_data, maps, file)]
    else:
        blocks.append(Text(f"What one cycle of each of the {len(report_data.reactions)} reactions does: `{file}`."))
    return Section("The postural reactions", blocks)


def cycle_map_table(report_data: ReportData) -> pd.DataFrame:
    """The affine map of one cycle, f' = gain f + offset, for every entry that a reaction tires."""
    rows = []
    for name, profile in cycle_profiles(report_data.experiment, report_data.reactions).items():
        one = profile.cycle_map()
        for place in np.flatnonzero(one.offset > 0):
            gain, offset = float(one.gain[place]), float(one.offset[place])
            rows.append(
                name._asdict()
                | {
                    "entry": ENTRIES[place], "gain": gain, "offset": offset,
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
    return Table(caption, ["reaction", "entry", "torque, N·m", "share of strength"], rows, "torques.csv")


def _maps(report_data: ReportData, maps: pd.DataFrame, file: str) -> Table:
    numbers = ("gain", "offset", "fatigue_if_repeated")
    rows = [
        [_reaction(row, report_data), entry_label(row["entry"]), *(significant(row[number]) for number in numbers)]
        for _, group in maps.groupby(list(ReactionName._fields), sort=False)
        for row in records(group.nlargest(LARGEST, "offset"))
    ]
    caption = (
        "What one cycle does to fatigue: f′ = gain · f + offset, exactly (Eq. 2 over the whole cycle); the largest "
        "offsets, and where f settles if the reaction is repeated for ever."
    )
    header = ["reaction", "entry", "gain", "offset", "fatigue if repeated"]
    return Table(caption, header, rows, file)


def _reaction(row: Mapping[str, Any], report_data: ReportData) -> str:
    """The name of a reaction, with its worker where there are several."""
    first = 0 if len(report_data.experiment.workers) > 1 else 1
    return "/".join(row[part] for part in ReactionName._fields[first:])

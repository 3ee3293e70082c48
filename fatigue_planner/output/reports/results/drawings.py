"""The figures of an experiment's returns and reactions."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from fatigue_planner.experiment.build import cycle_profiles
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import build_human
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.output.figures.pose_map import place_figure, place_table
from fatigue_planner.output.figures.postures import FEW, posture_figure
from fatigue_planner.output.figures.returns import returns_figure
from fatigue_planner.output.figures.style import words
from fatigue_planner.output.figures.torques import course_figure, entry_label, torque_figure
from fatigue_planner.output.reports.html.blocks import Picture, listing, percent, significant
from fatigue_planner.output.reports.results.figure_folder import FigureFolder
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.statistics.comparison import STARS
from fatigue_planner.study.statistics.pairing import cells_of, records

# The joint at the near end of each body, where its load is drawn.
JOINT_OF = {joint.child: joint.name for joint in JOINTS}


def draw_returns(figures: FigureFolder, experiment: Experiment, comparison: pd.DataFrame) -> list[Picture]:
    """The paper's Figure 5: one picture for each that the experiment names."""
    pictures = []
    for name, conditions in experiment.figures.items():
        shown = comparison[comparison["condition"].isin(conditions)]
        figure = returns_figure(comparison, conditions, list(experiment.benchmark.policies))
        caption = (
            f"`{name}`: discounted accumulated reward, mean ± standard deviation over the runs, best policy first. "
            "Between neighbours stands the paper's test: Student's, unpaired, not corrected "
            f"({', '.join(f'{mark} p < {limit:g}' for limit, mark in reversed(STARS))}, ns: p ≥ "
            f"{experiment.statistics.significance_level:g}; none where a policy has one run only)."
        )
        pictures.append(figures.add(name, figure, shown, caption, _best_and_worst(shown)))
    return pictures


def _best_and_worst(comparison: pd.DataFrame) -> str:
    sentences = []
    for condition, n_cycles, cell in cells_of(comparison):
        best, worst = records(cell.iloc[[0, -1]])
        sentences.append(
            f"{words(condition)}, {n_cycles} cycles: from {words(best['policy'])} ({significant(best['mean'])}) to "
            f"{words(worst['policy'])} ({significant(worst['mean'])})"
        )
    return "; ".join(sentences) + "."


def draw_reactions(
    figures: FigureFolder,
    experiment: Experiment,
    reactions: Sequence[Reaction],
    parameters: Mapping[str, FatigueParameters],
) -> list[Picture]:
    """Postures, loads and, for grids of poses, maps."""
    places = place_table(experiment.actions, cycle_profiles(experiment, reactions))
    pictures = []
    for worker, person in experiment.workers.items():
        several = len(experiment.workers) > 1
        suffix, whose = (f"_{worker}", f" of {words(worker)}") if several else ("", "")
        own = [reaction for reaction in reactions if reaction.name.worker == worker]
        if not own:
            continue
        figure, table = posture_figure(build_human(person), own, parameters[worker])
        caption = f"The reactions{whose} in the middle of the work; discs: the largest load at each joint."
        pictures.append(figures.add(f"reactions{suffix}", figure, table, caption, _heaviest_joints(table)))
        if len(own) <= FEW:
            figure, table = course_figure(own, parameters)
            caption = f"Loads{whose} over the cycle: the entries with the highest mean load."
            pictures.append(figures.add(f"courses{suffix}", figure, table, caption, _peaks(table)))
        map_figure = place_figure(places, worker, list(experiment.preferences))
        if map_figure is not None:
            table = places[places["worker"] == worker]
            caption = f"What it costs{whose} to work at each place."
            pictures.append(figures.add(f"places{suffix}", map_figure, table, caption, _cheapest_and_dearest(table)))
    figure, table = torque_figure(reactions, parameters)
    caption = "Mean loads during work above the threshold of fatigue, as share of the worker's strength."
    return [*pictures, figures.add("torques", figure, table, caption, _heaviest_entries(table))]


def _heaviest_joints(table: pd.DataFrame) -> str:
    joints = table.dropna(subset="share_of_maximum")
    rows = joints.loc[joints.groupby(["action", "preference"], sort=False)["share_of_maximum"].idxmax()]
    return _loads(rows.assign(place=[words(JOINT_OF[landmark]) for landmark in rows["landmark"]]))


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
        f"{word} {row['action']} with {words(row['preference'])} ({significant(row['long_run_cost'])})"
        for word, row in (("cheapest is", ordered[0]), ("dearest is", ordered[-1]))
    ]
    return listing(ends) + "."

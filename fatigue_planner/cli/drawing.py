"""The figures of an experiment, drawn into its results folder."""

from collections.abc import Sequence
from pathlib import Path

from fatigue_planner.experiment.resolve import cycle_profiles, worker_fatigue
from fatigue_planner.experiment.results import load_results
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.figures.pose_map import place_figure, place_table
from fatigue_planner.figures.postures import FEW, posture_figure
from fatigue_planner.figures.returns import returns_figure
from fatigue_planner.figures.style import save_figure
from fatigue_planner.figures.torques import course_figure, torque_figure
from fatigue_planner.human.model import build_human
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.statistics.comparison import comparison_table


def draw_returns(settings: Experiment, folder: Path, command: str) -> list[Path]:
    """Figures of the tables that `command` makes; raises as `load_results`."""
    trials = load_results(settings, folder, command).trials
    comparison = comparison_table(trials, settings.statistics.significance_level)
    files = []
    for name, conditions in settings.figures.items():
        figure = returns_figure(comparison, conditions, list(settings.benchmark.policies))
        files += save_figure(folder, name, figure, comparison[comparison["condition"].isin(conditions)])
    return files


def draw_reactions(settings: Experiment, reactions: Sequence[Reaction], folder: Path) -> list[Path]:
    """Postures, loads and, for grids of poses, maps."""
    parameters = worker_fatigue(settings)
    places = place_table(settings.actions, cycle_profiles(settings, reactions))
    files = []
    for worker, person in settings.workers.items():
        suffix = f"_{worker}" if len(settings.workers) > 1 else ""
        own = [reaction for reaction in reactions if reaction.name.worker == worker]
        files += save_figure(
            folder, f"reactions{suffix}", *posture_figure(build_human(person), own, parameters[worker])
        )
        if len(own) <= FEW:
            files += save_figure(folder, f"courses{suffix}", *course_figure(own, parameters))
        figure = place_figure(places, worker, list(settings.preferences))
        if figure is not None:
            files += save_figure(folder, f"places{suffix}", figure, places[places["worker"] == worker])
    files += save_figure(folder, "torques", *torque_figure(reactions, parameters))
    return files

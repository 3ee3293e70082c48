"""The figures of an experiment, drawn into its results folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fatigue_planner.benchmark.table import TRIALS_FILE, read_table
from fatigue_planner.errors import StaleTableError
from fatigue_planner.experiment.resolve import cycle_profiles, reaction_requests, worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.figures.pose_map import place_figure, place_table
from fatigue_planner.figures.postures import FEW, posture_figure
from fatigue_planner.figures.returns import returns_figure
from fatigue_planner.figures.style import save_figure
from fatigue_planner.figures.torques import course_figure, torque_figure
from fatigue_planner.human.model import build_human
from fatigue_planner.provenance import check_manifest
from fatigue_planner.reactions.reaction import Reaction, digests
from fatigue_planner.statistics.comparison import comparison_table

# Settings that a table of trials does not depend on.
NOT_IN_THE_TABLE = ("figures", "statistics")


def draw_returns(settings: Experiment, folder: Path, command: str) -> list[Path]:
    """Figures of a table of trials that `command` makes; raises StaleTableError if it is of other settings."""
    trials = read_table(folder, command)
    _check_origin(check_manifest(folder, "benchmark", TRIALS_FILE, command), settings, folder, command)
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


def _check_origin(note: Mapping[str, Any], settings: Experiment, folder: Path, command: str) -> None:
    """Raise StaleTableError, naming what differs, unless the table was made from these settings and reactions."""
    made, now = note["experiment"], settings.plain()
    changed = [key for key in now if key not in NOT_IN_THE_TABLE and made.get(key) != now[key]]
    if note["reactions"] != digests(reaction_requests(settings)):
        changed.append("reactions")
    if changed:
        raise StaleTableError(
            f"{folder / TRIALS_FILE}: was made with other settings ({', '.join(changed)}). Run `{command}`."
        )

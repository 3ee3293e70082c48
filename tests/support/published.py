"""Results folders as `fatplan benchmark` leaves them."""

from pathlib import Path

from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import Reaction, digests
from fatigue_planner.study.benchmark.comparisons import publish_comparisons
from fatigue_planner.study.benchmark.results import COMPARISON_FILE, CONTRASTS_FILE
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, TRIALS_FILE, publish_table, trial_table

COMMAND = "fatplan benchmark"


def publish(experiment: Experiment, reactions: tuple[Reaction, ...], folder: Path) -> None:
    grid = cells(experiment, cycle_profiles(experiment, reactions))
    done = [cell.run(cell.trial_numbers()) for cell in grid]
    folder.mkdir(parents=True, exist_ok=True)
    trials = trial_table(grid, done)
    publish_table(folder, trials, [TRIALS_FILE, ACTIONS_FILE])
    publish_comparisons(folder, trials, experiment.statistics, experiment.benchmark.seed)
    seal(experiment, folder)


def seal(experiment: Experiment, folder: Path, *further: str) -> None:
    """Note what is there now; `further`: files besides those of every run."""
    note = {
        "actions": dict.fromkeys(experiment.benchmark.conditions, tuple(experiment.actions)),
        "experiment": experiment.plain(),
        "reactions": digests(reaction_requests(experiment)),
        "seed": experiment.benchmark.seed,
        "references": {},
    }
    files = (TRIALS_FILE, ACTIONS_FILE, COMPARISON_FILE, CONTRASTS_FILE, *further)
    publish_manifest(folder, "benchmark", note, [folder / file for file in files])

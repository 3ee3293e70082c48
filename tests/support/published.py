"""Results folders as `fatplan benchmark` leaves them."""

from pathlib import Path

from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import Reaction, digests
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, TRIALS_FILE, publish_table, trial_table

COMMAND = "fatplan benchmark"


def publish(experiment: Experiment, reactions: tuple[Reaction, ...], folder: Path) -> None:
    grid = cells(experiment, cycle_profiles(experiment, reactions))
    done = [cell.run(cell.trial_numbers()) for cell in grid]
    folder.mkdir(parents=True, exist_ok=True)
    publish_table(folder, trial_table(grid, done), [TRIALS_FILE, ACTIONS_FILE])
    seal(experiment, folder)


def seal(experiment: Experiment, folder: Path) -> None:
    conditions = experiment.benchmark.conditions
    note = {
        "actions": dict.fromkeys(conditions, tuple(experiment.actions)),
        "experiment": experiment.plain(),
        "reactions": digests(reaction_requests(experiment)),
        "seed": experiment.benchmark.seed,
        "references": {},
    }
    publish_manifest(folder, "benchmark", note, [folder / TRIALS_FILE, folder / ACTIONS_FILE])

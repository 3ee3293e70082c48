"""From an experiment and files of what was observed to what was learnt of the worker."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fatigue_planner.core.errors import SelectionError, check_known
from fatigue_planner.experiment.build import scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.reactions.reaction import ReactionName
from fatigue_planner.recordings.learning.course import learn
from fatigue_planner.recordings.learning.cycles import read_cycles, read_labelled
from fatigue_planner.recordings.learning.learnt import Learnt, summary
from fatigue_planner.recordings.learning.likelihood import Confusion


def learn_worker(
    experiment: Experiment,
    profiles: Mapping[ReactionName, CycleProfile],
    condition: str | None,
    cycles: Path,
    labelled: Path | None,
) -> Learnt:
    """What the cycles of a file tell of the worker of a condition, None: the first.

    He has the body, the rates (those of the average worker, where they are hidden) and the initial fatigue of the
    condition (its mean, where it is hidden). Without `labelled` repetitions, recognition is as the experiment says.

    Raises SelectionError, RecordingError: option or file, line, value, what is allowed.
    """
    conditions = experiment.benchmark.conditions
    name = next(iter(conditions)) if condition is None else condition
    check_known("condition", name, conditions)
    if len(experiment.preferences) == 1:
        raise SelectionError("the experiment has one preference: there is nothing to choose.")
    task = scenario(experiment, profiles, conditions[name].model_copy(update={"choice_model": None}))
    model = task.model
    if labelled is None:
        confusion, groups = Confusion(model.arrays.observation), np.zeros(len(model.actions), np.int64)
        if len(model.arrays.observation) > 1:
            groups = np.arange(len(model.actions), dtype=np.int64)
    else:
        counts, groups = read_labelled(labelled, model.actions, model.outcomes, model.observations)
        confusion = Confusion.from_counts(counts)
    observed = read_cycles(cycles, model.actions, model.observations)
    start = task.weights @ task.states
    estimator, fit = learn(model, start, observed, confusion, groups[observed.actions])
    return summary(estimator, fit, model.outcomes)

"""What the workers of an experiment can perform, and the part of the experiment that remains.

Eq. 4 lets the worker choose any motion preference after every action: the robot has no say in it. So an action is left
to a worker's conditions only if he can perform it with every preference; a condition whose worker can perform no
action is left out. What else the experiment says stays as it is.
"""

from collections.abc import Container, Iterator

from fatigue_planner.core.errors import FailedMotionError, listed
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import ReactionName


def performable_actions(experiment: Experiment, worker: str, performed: Container[ReactionName]) -> tuple[str, ...]:
    """The actions that a worker can perform with every preference, in the experiment's order."""
    return tuple(
        action
        for action in experiment.actions
        if all(ReactionName(worker, action, preference) in performed for preference in experiment.preferences)
    )


def without_infeasible(experiment: Experiment, performed: Container[ReactionName]) -> Experiment:
    """The experiment without the conditions whose worker can perform no action, in figures and families, too.

    Raises FailedMotionError if no condition remains.
    """
    grid = experiment.benchmark
    conditions = {
        name: condition
        for name, condition in grid.conditions.items()
        if performable_actions(experiment, experiment.worker_of(condition), performed)
    }
    if not conditions:
        raise FailedMotionError(
            f"{listed(grid.conditions)}: no condition can be run. {' '.join(omissions(experiment, performed))} "
            "`fatplan simulate` says why."
        )
    if len(conditions) == len(grid.conditions):
        return experiment
    families = {
        name: family.model_copy(update={"conditions": tuple(item for item in family.conditions if item in conditions)})
        if family.conditions
        else family
        for name, family in experiment.statistics.families.items()
    }
    figures = {name: tuple(item for item in shown if item in conditions) for name, shown in experiment.figures.items()}
    return experiment.model_copy(
        update={
            "benchmark": grid.model_copy(update={"conditions": conditions}),
            "statistics": experiment.statistics.model_copy(
                update={
                    "families": {
                        name: family
                        for name, family in families.items()
                        if family.conditions or not experiment.statistics.families[name].conditions
                    }
                }
            ),
            "figures": {name: shown for name, shown in figures.items() if shown},
        }
    )


def omissions(experiment: Experiment, performed: Container[ReactionName]) -> list[str]:
    """A sentence on every action and every condition that is left out."""
    return [*_actions_left_out(experiment, performed), *_conditions_left_out(experiment, performed)]


def _actions_left_out(experiment: Experiment, performed: Container[ReactionName]) -> Iterator[str]:
    workers = dict.fromkeys(map(experiment.worker_of, experiment.benchmark.conditions.values()))
    for worker in workers:
        failed = {
            action: [
                preference
                for preference in experiment.preferences
                if ReactionName(worker, action, preference) not in performed
            ]
            for action in experiment.actions
        }
        named = [f"{action} (with {' or '.join(preferences)})" for action, preferences in failed.items() if preferences]
        if named and experiment.robot is None:
            yield f"{worker} cannot perform {listed(named)}: left out of this worker's conditions."
        elif named:
            yield (
                f"{worker} cannot perform {listed(named)}, or the robot cannot present it far enough from the body: "
                "left out of this worker's conditions. `fatplan reach` says what the robot can."
            )


def _conditions_left_out(experiment: Experiment, performed: Container[ReactionName]) -> Iterator[str]:
    for name, condition in experiment.benchmark.conditions.items():
        worker = experiment.worker_of(condition)
        if not performable_actions(experiment, worker, performed):
            yield f"Condition {name} is left out: {worker} can perform no action with every preference."

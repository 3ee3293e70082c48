"""What the workers of an experiment can perform, and the part of the experiment that remains.

Eq. 4 lets the worker choose any motion preference after every action: the robot has no say in it. So an action is left
to a worker's conditions only if he can perform it with every preference; a condition whose worker can perform no
action is left out. What else the experiment says stays as it is.
"""

from collections.abc import Container, Iterator, Mapping

from fatigue_planner.core.errors import FailedMotionError, listed
from fatigue_planner.core.text import counted
from fatigue_planner.experiment.robot_cell import RuledOut
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import ReactionName


def performable_actions(experiment: Experiment, worker: str, performed: Container[ReactionName]) -> tuple[str, ...]:
    """The actions that a worker can perform with every preference, in the experiment's order."""
    return tuple(
        action
        for action in experiment.actions
        if all(ReactionName(worker, action, preference) in performed for preference in experiment.preferences)
    )


def without_infeasible(
    experiment: Experiment,
    performed: Container[ReactionName],
    ruled_out: Mapping[ReactionName, RuledOut] | None = None,
) -> Experiment:
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
            f"{listed(grid.conditions)}: no condition can be run. "
            f"{' '.join(omissions(experiment, performed, ruled_out))} `fatplan simulate` says why."
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


def omissions(
    experiment: Experiment,
    performed: Container[ReactionName],
    ruled_out: Mapping[ReactionName, RuledOut] | None = None,
) -> list[str]:
    """A sentence on every action and every condition that is left out; `ruled_out`: reactions that the robot does."""
    ruled = ruled_out or {}
    workers = list(dict.fromkeys(map(experiment.worker_of, experiment.benchmark.conditions.values())))
    return [
        *_not_presented(experiment, ruled),
        *(sentence for worker in workers for sentence in _too_near(experiment, worker, ruled)),
        *(sentence for worker in workers for sentence in _cannot(experiment, worker, performed, ruled)),
        *_conditions_left_out(experiment, performed),
    ]


def _not_presented(experiment: Experiment, ruled: Mapping[ReactionName, RuledOut]) -> Iterator[str]:
    why = {name.action: each.reason for name, each in ruled.items() if each.distance_m is None}
    if why:
        named = listed(f"{action} ({why[action]})" for action in experiment.actions if action in why)
        count = f"{len(why)} of {counted(len(experiment.actions), 'action')}"
        yield f"The robot cannot present {count}, left out of all conditions: {named}."


def _too_near(experiment: Experiment, worker: str, ruled: Mapping[ReactionName, RuledOut]) -> Iterator[str]:
    near: dict[str, tuple[float, str]] = {}  # the nearest of every action
    for name, each in ruled.items():
        if name.worker == worker and each.distance_m is not None:
            said = each.distance_m, f"{each.reason}, with {name.preference}"
            near[name.action] = min(said, near.get(name.action, said))
    if near and experiment.robot is not None:
        named = listed(f"{action} ({near[action][1]})" for action in experiment.actions if action in near)
        yield (
            f"The robot would come nearer than {experiment.robot.clearance_m:g} m to {worker} in {len(near)} of "
            f"{counted(len(experiment.actions), 'action')}, left out of this worker's conditions: {named}."
        )


def _cannot(
    experiment: Experiment, worker: str, performed: Container[ReactionName], ruled: Mapping[ReactionName, RuledOut]
) -> Iterator[str]:
    failed = {
        action: [
            preference
            for preference in experiment.preferences
            if (name := ReactionName(worker, action, preference)) not in performed and name not in ruled
        ]
        for action in experiment.actions
    }
    named = [f"{action} (with {' or '.join(preferences)})" for action, preferences in failed.items() if preferences]
    if named:
        yield f"{worker} cannot perform {listed(named)}: left out of this worker's conditions."


def _conditions_left_out(experiment: Experiment, performed: Container[ReactionName]) -> Iterator[str]:
    for name, condition in experiment.benchmark.conditions.items():
        worker = experiment.worker_of(condition)
        if not performable_actions(experiment, worker, performed):
            yield f"Condition {name} is left out: {worker} can perform no action with every preference."

"""From an experiment to what the layers below work with."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from fatigue_planner.experiment.schema import Condition, Experiment
from fatigue_planner.fatigue.cycle_map import CycleMap, cycle_map
from fatigue_planner.fatigue.parameters import FatigueParameters, fatigue_parameters, fatigue_state
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.motion.simulator import MotionRequest
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp, build_pomdp
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest


def reaction_requests(experiment: Experiment) -> tuple[ReactionRequest, ...]:
    """Every worker with every action and every preference."""
    return tuple(
        ReactionRequest(
            ReactionName(worker_name, action_name, preference_name),
            MotionRequest(
                worker, strength, experiment.tool, experiment.cycle, experiment.controller, action, preference
            ),
            experiment.accuracy,
        )
        for worker_name, worker in experiment.workers.items()
        for strength in [maximum_torque(worker.strength)]
        for action_name, action in experiment.actions.items()
        for preference_name, preference in experiment.preferences.items()
    )


def load_reactions(experiment: Experiment, cache_folder: Path, command: str) -> tuple[Reaction, ...]:
    """The experiment's reactions from the cache; `command` makes them, for the messages.

    Raises MissingLibraryError or DamagedFileError.
    """
    return ReactionCache(cache_folder).load(experiment.name, reaction_requests(experiment), command)


def worker_fatigue(experiment: Experiment) -> dict[str, FatigueParameters]:
    """The fatigue parameters of every worker, by name."""
    return {
        name: fatigue_parameters(experiment.fatigue, maximum_torque(worker.strength))
        for name, worker in experiment.workers.items()
    }


def load_cycle_maps(experiment: Experiment, cache_folder: Path, command: str) -> dict[ReactionName, CycleMap]:
    """What one cycle of every reaction does to fatigue, without keeping the motions in memory.

    Raises as `load_reactions`.
    """
    requests = reaction_requests(experiment)
    return cycle_maps(experiment, ReactionCache(cache_folder).stream(experiment.name, requests, command))


def cycle_maps(experiment: Experiment, reactions: Iterable[Reaction]) -> dict[ReactionName, CycleMap]:
    """What one cycle of each of these reactions does to fatigue."""
    parameters = worker_fatigue(experiment)
    return {
        reaction.name: cycle_map(
            reaction.motion.torque_nm, reaction.motion.time_step_s, parameters[reaction.name.worker]
        )
        for reaction in reactions
    }


def problem(
    experiment: Experiment, maps: Mapping[ReactionName, CycleMap], condition: Condition
) -> tuple[FatiguePomdp, Belief]:
    """The POMDP of a condition and its initial belief."""
    worker = experiment.worker_of(condition)
    own = {(name.action, name.preference): cycle for name, cycle in maps.items() if name.worker == worker}
    start = experiment.initial_beliefs[condition.initial_belief]
    states = np.array([fatigue_state(state.fatigue) for state in start])
    model = build_pomdp(
        tuple(experiment.actions), tuple(experiment.preferences), own, states, condition.expertise, experiment.discount
    )
    probabilities = np.array([state.probability for state in start])
    return model, Belief(np.ascontiguousarray(states[:, model.live]), probabilities / probabilities.sum())

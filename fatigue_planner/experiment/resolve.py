"""From an experiment to what the layers below work with."""

from pathlib import Path

import numpy as np

from fatigue_planner.experiment.schema import Condition, Experiment
from fatigue_planner.fatigue.cycle_map import cycle_map
from fatigue_planner.fatigue.parameters import fatigue_parameters, fatigue_state
from fatigue_planner.motion.simulator import MotionRequest
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp, build_pomdp
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest


def reaction_requests(experiment: Experiment) -> tuple[ReactionRequest, ...]:
    """Every action with every preference."""
    return tuple(
        ReactionRequest(
            ReactionName(action_name, preference_name),
            MotionRequest(
                experiment.worker, experiment.tool, experiment.cycle, experiment.controller, action, preference
            ),
            experiment.accuracy,
        )
        for action_name, action in experiment.actions.items()
        for preference_name, preference in experiment.preferences.items()
    )


def load_reactions(experiment: Experiment, cache_folder: Path, command: str) -> tuple[Reaction, ...]:
    """The experiment's reactions from the cache; `command` makes them, for the messages.

    Raises MissingLibraryError or DamagedFileError.
    """
    return ReactionCache(cache_folder).load(experiment.name, reaction_requests(experiment), command)


def problem(
    experiment: Experiment, reactions: tuple[Reaction, ...], condition: Condition
) -> tuple[FatiguePomdp, Belief]:
    """The POMDP of a condition and its initial belief."""
    parameters = fatigue_parameters(experiment.fatigue, experiment.worker.strength)
    maps = {
        (reaction.name.action, reaction.name.preference): cycle_map(
            reaction.motion.torque_nm, reaction.motion.time_step_s, parameters
        )
        for reaction in reactions
    }
    start = experiment.initial_beliefs[condition.initial_belief]
    states = np.array([fatigue_state(state.fatigue) for state in start])
    model = build_pomdp(
        tuple(experiment.actions), tuple(experiment.preferences), maps, states, condition.expertise, experiment.discount
    )
    probabilities = np.array([state.probability for state in start])
    return model, Belief(np.ascontiguousarray(states[:, model.live]), probabilities / probabilities.sum())

"""From an experiment to what the rooms below work with: requests, parameters, scenarios."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.benchmark_settings import Condition
from fatigue_planner.experiment.feasibility import performable_actions
from fatigue_planner.experiment.robot_cell import RobotCell, RuledOut
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import fatigue_state
from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.pomdp.beliefs.registry import default_belief
from fatigue_planner.pomdp.fatigue_pomdp import build_pomdp, one_worker
from fatigue_planner.pomdp.hidden_worker import WorkerPrior
from fatigue_planner.pomdp.scenario import Scenario, average_worker
from fatigue_planner.pomdp.timing import Timing
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionName, ReactionRequest, Recorded


class CycleProfiles(dict[ReactionName, CycleProfile]):
    """How one cycle of each reaction loads the worker; `ruled_out`: those that the robot rules out, and why."""

    def __init__(self) -> None:
        super().__init__()
        self.ruled_out: dict[ReactionName, RuledOut] = {}


def reaction_requests(experiment: Experiment) -> tuple[ReactionRequest, ...]:
    """A request for every worker, action and preference."""
    recorded = {
        ReactionName(worker, action, preference): Recorded(key, experiment.recording_accuracy)
        for worker, actions in experiment.recorded.items()
        for action, preferences in actions.items()
        for preference, key in preferences.items()
    }
    return tuple(
        ReactionRequest(
            name,
            MotionRequest(
                worker, strength, experiment.tool, experiment.cycle, experiment.controller, action, preference
            ),
            experiment.accuracy,
            recorded.get(name),
        )
        for worker_name, worker in experiment.workers.items()
        for strength in [maximum_torque(worker.strength)]
        for action_name, action in experiment.actions.items()
        for preference_name, preference in experiment.preferences.items()
        for name in [ReactionName(worker_name, action_name, preference_name)]
    )


def load_reactions(experiment: Experiment, cache_folder: Path, command: str) -> tuple[Reaction, ...]:
    """The experiment's reactions from the cache, without those that failed; `command`: what makes them, for messages.

    Raises MissingReactionsError or DamagedFileError.
    """
    stream = ReactionCache(cache_folder).stream(reaction_requests(experiment), command)
    return tuple(reaction for reaction in stream if isinstance(reaction, Reaction))


def worker_fatigue(experiment: Experiment) -> dict[str, FatigueParameters]:
    """The fatigue parameters of every worker, by name."""
    return {
        name: fatigue_parameters(experiment.fatigue, maximum_torque(worker.strength))
        for name, worker in experiment.workers.items()
    }


def load_cycle_profiles(experiment: Experiment, cache_folder: Path, command: str) -> CycleProfiles:
    """How one cycle of every reaction of the conditions' workers loads them, without those that failed.

    One motion at a time is held in memory. Raises what `load_reactions` raises.
    """
    workers = set(map(experiment.worker_of, experiment.benchmark.conditions.values()))
    requests = [request for request in reaction_requests(experiment) if request.name.worker in workers]
    return cycle_profiles(experiment, ReactionCache(cache_folder).stream(requests, command))


def cycle_profiles(experiment: Experiment, reactions: Iterable[Reaction | FailedReaction]) -> CycleProfiles:
    """How one cycle of each of these reactions loads the worker; none for those that failed or the robot rules out."""
    parameters, found = worker_fatigue(experiment), CycleProfiles()
    robot = None if experiment.robot is None else RobotCell(experiment)
    for reaction in reactions:
        if not isinstance(reaction, Reaction):
            continue
        name, motion = reaction.name, reaction.motion
        if robot is not None and (why := robot.left_out(name, motion)):
            found.ruled_out[name] = why
        else:
            found[name] = reaction_profile(experiment, parameters, name.worker, motion)
    return found


def reaction_profile(
    experiment: Experiment, parameters: Mapping[str, FatigueParameters], worker: str, motion: Motion
) -> CycleProfile:
    """How one cycle of a motion loads a worker of the experiment, and what its posture costs."""
    profile = cycle_profile(motion, parameters[worker])
    if not experiment.cost.posture:
        return profile
    cost = experiment.cost.posture_cost(build_human(experiment.workers[worker]), motion)
    return replace(profile, posture_cost=cost)


def scenario(experiment: Experiment, profiles: Mapping[ReactionName, CycleProfile], condition: Condition) -> Scenario:
    """The POMDP of a condition, where it starts and what is hidden; its actions are those of `performable_actions`.

    Raises FailedMotionError if there are none.
    """
    worker = experiment.worker_of(condition)
    actions = performable_actions(experiment, worker, profiles)
    if not actions:
        raise FailedMotionError(f"{worker} can perform no action with every preference; see the reactions' failures.")
    own = {
        (name.action, name.preference): profile
        for name, profile in profiles.items()
        if name.worker == worker and name.action in actions
    }
    start = experiment.initial_beliefs[condition.initial_belief]
    fatigue = np.array([fatigue_state(state.fatigue) for state in start])
    hidden = None if condition.hidden_worker is None else experiment.hidden_workers[condition.hidden_worker]
    prior = None if hidden is None else WorkerPrior(hidden, condition.expertise)
    if prior is None:
        assert condition.expertise is not None
        workers = one_worker(condition.expertise)
    else:
        workers = average_worker(prior)
    preferences = tuple(experiment.preferences)
    observations, matrix = preferences, None
    if experiment.recognition_errs():
        observations, matrix = experiment.recognised(actions)
    choices = None if condition.choice_model is None else experiment.choice_models[condition.choice_model]
    cost = experiment.cost.fatigue_cost()
    parameters = fatigue_parameters(experiment.fatigue, maximum_torque(experiment.workers[worker].strength))
    timing = Timing(experiment.cycle.duration_s, parameters.law.rest(parameters))
    model = build_pomdp(
        actions, preferences, own, fatigue, workers, experiment.discount, matrix, observations, cost, timing,
        None if choices is None else choices.log_odds(preferences),
    )  # fmt: skip
    weights = np.array([state.probability for state in start])
    belief = experiment.belief or default_belief(model.observation_reveals_outcome, prior)
    states = np.array([model.state(levels) for levels in fatigue])
    return Scenario(model, states, weights / weights.sum(), prior, belief)

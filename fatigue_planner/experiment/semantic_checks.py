"""What the types of the schema cannot say: unknown joints and strengths, impossible times and targets."""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from fatigue_planner.core.errors import DataFileError, ExperimentError, listed, told_apart
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.target_checks import target_faults
from fatigue_planner.fatigue.entries import fatigue_state
from fatigue_planner.fatigue.parameters import fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.payload import HandForce
from fatigue_planner.robot.arm import arm_named

# Every point of a grid may be out of every worker's reach.
MAX_TARGET_FAULTS = 1000
# What a number of time steps may be off a whole one by rounding.
WHOLE_STEPS = 1e-6


def semantic_errors(experiment: Experiment) -> list[str]:
    """Everything that is impossible, each with its key."""
    humans: dict[str, Human] = {}
    return list(
        itertools.chain(
            _worker_faults(experiment, humans),
            _belief_faults(experiment),
            _cost_faults(experiment),
            _phase_faults(experiment),
            _tool_faults(experiment),
            _robot_faults(experiment),
            (
                f"benchmark.policies.{name}.{fault}"
                for name, policy in experiment.benchmark.policies.items()
                for fault in policy.faults()
            ),
            (fault for name, action in experiment.actions.items() for fault in _time_faults(experiment, name, action)),
            itertools.islice(target_faults(experiment, humans), MAX_TARGET_FAULTS),
        )
    )


def _worker_faults(experiment: Experiment, humans: dict[str, Human]) -> Iterator[str]:
    """Bodies, strengths, preferences; the humans that can be built are added to `humans`."""
    for name, worker in experiment.workers.items():
        try:
            humans[name] = build_human(worker)
            strength = maximum_torque(worker.strength)
        except DataFileError as error:
            yield f"workers.{name}: {error}"
            continue
        try:
            fatigue_parameters(experiment.fatigue, strength)
        except DataFileError as error:
            yield str(error)
    if humans:
        yield from _preference_faults(experiment, next(iter(humans.values())))


def _robot_faults(experiment: Experiment) -> Iterator[str]:
    if experiment.robot is not None:
        try:
            arm_named(experiment.robot.arm, experiment.robot.link_radius_m)
        except ExperimentError as error:
            yield str(error)


def _preference_faults(experiment: Experiment, human: Human) -> Iterator[str]:
    state = BodyState(human)
    state.update(human.stance, np.zeros(human.model.nv))
    for name, preference in experiment.preferences.items():
        for index, task in enumerate(preference.tasks):
            try:
                task.build_stiffened(human, state, experiment.controller.stiffness_per_s2)
            except DataFileError as error:
                yield f"preferences.{name}.tasks.{index}.{error}"


def _belief_faults(experiment: Experiment) -> Iterator[str]:
    for name, states in experiment.initial_beliefs.items():
        for index, state in enumerate(states):
            try:
                fatigue_state(state.fatigue)
            except DataFileError as error:
                yield f"initial_beliefs.{name}.{index}.{error}"


def _cost_faults(experiment: Experiment) -> Iterator[str]:
    try:
        experiment.cost.fatigue_cost()
    except DataFileError as error:
        yield str(error)


def _phase_faults(experiment: Experiment) -> Iterator[str]:
    """A phase is simulated for whole time steps; all other times are points of curves, which every step reads."""
    step = experiment.controller.time_step_s
    for key in ("reach_s", "work_s", "return_s"):
        duration = getattr(experiment.cycle, key)
        if abs(duration / step - round(duration / step)) > WHOLE_STEPS:
            shorter = math.floor(duration / step)
            near = " or ".join(f"{count * step:.10g}" for count in (shorter, shorter + 1))
            yield (
                f"cycle.{key} = {duration:g}: should be a whole number of time steps (controller.time_step_s = "
                f"{step:g}), such as {near}."
            )


def _tool_faults(experiment: Experiment) -> Iterator[str]:
    hand = experiment.tool.hand
    if hand is None or experiment.tool.mass_kg == 0:
        return
    idle = [name for name, action in experiment.actions.items() if hand not in action.goals()]
    if idle:
        yield (
            f"tool.hand = {hand!r}: this hand has no goal in {listed(f'actions.{name}' for name in idle)}; give it "
            "one, or leave tool.hand out: the tool is then in the hand that works."
        )


def _time_faults(experiment: Experiment, name: str, action: Action) -> Iterator[str]:
    work, whole = experiment.cycle.work_s, experiment.cycle.duration_s
    for side, goal in action.goals().items():
        last = goal.path()[-1].work_time_s
        if last > work:
            latest, end = told_apart(last, work, ".6g")
            yield (
                f"actions.{name}.{side}_hand.waypoints: the last is reached after {latest} s of work; cycle.work_s is "
                f"{end}"
            )
    for index, load in enumerate(action.loads):
        if isinstance(load, HandForce) and load.force_n[-1].cycle_time_s > whole:
            latest, end = told_apart(load.force_n[-1].cycle_time_s, whole, ".6g")
            yield (
                f"actions.{name}.loads.{index}.force_n: cycle_time_s = {latest} is after the end of the cycle ({end} s)"
            )

"""The problems that the searches are compared on."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fatigue_planner.core.executors.processes import LocalProcesses, available_cores
from fatigue_planner.experiment.build import load_cycle_profiles, reaction_requests, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, build_pomdp, one_worker
from fatigue_planner.reactions.cache import ReactionCache

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Problem:
    """A model and the belief that a decision is made from."""

    name: str
    model: FatiguePomdp
    belief: ExactBelief


def experiment_problems(experiment: str) -> list[Problem]:
    """The conditions of an experiment, its reactions simulated where the cache lacks them."""
    loaded, cache = load_experiment(ROOT / "experiments" / f"{experiment}.yaml"), ROOT / "cache"
    ReactionCache(cache).complete(reaction_requests(loaded), LocalProcesses(min(2, available_cores())), lambda _: None)
    profiles = load_cycle_profiles(loaded, cache, "fatplan simulate")
    problems = []
    for name, condition in loaded.benchmark.conditions.items():
        task = scenario(loaded, profiles, condition)
        problems.append(Problem(name, task.model, ExactBelief(task.model, task.states, task.weights)))
    return problems


def synthetic_problem(entries: int = 78, actions: int = 2, expertise: float = 0.0) -> Problem:
    """Random affine maps of `entries` active entries with two reactions to every action, from a rested worker."""
    rng = np.random.default_rng(1)
    gain = rng.uniform(0.6, 0.99, (actions, 2, entries))
    offset = rng.uniform(0, 0.1, gain.shape) * (1 - gain)
    model = affine_model(gain, offset, expertise, 0.95, entries)
    kind = "expert" if expertise else "novice"
    return Problem(f"{entries} entries, {actions} actions, {kind}", model, rested(model))


def affine_model(gain: np.ndarray, offset: np.ndarray, expertise: float, discount: float, entries: int) -> FatiguePomdp:
    """The POMDP of cycle maps (A, U, L) of the active among `entries` entries; preferences are always recognised."""
    actions, preferences, active = gain.shape
    names = [f"action_{a}" for a in range(actions)], [f"preference_{u}" for u in range(preferences)]
    nothing = np.zeros((1, active))
    unused = DoseProfile(np.ones((1, active)), nothing, nothing, np.zeros(active), np.zeros(active), np.zeros(active))
    profiles = {(a, u): unused for a in names[0] for u in names[1]}
    blank = build_pomdp(*names, profiles, nothing, one_worker(expertise), discount)
    scaled = replace(blank, entries=entries)
    return scaled.with_maps(gain[None], offset[None], one_worker(expertise))


def rested(model: FatiguePomdp) -> ExactBelief:
    """The belief in a worker without fatigue."""
    return ExactBelief(model, model.state(np.zeros(model.active_entries.size))[None], np.ones(1))

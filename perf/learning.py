"""How well learning finds what a worker is like.

    python perf/learning.py beta [--runs 1000] [--cycles 200]
    python perf/learning.py regret [--workers 100]

`beta`: workers of 200 cycles, utilities that differ by 0.5 to 2.5 either way, 10 and 15 % of reactions confused, known
from 140 labelled repetitions of each, an unknown offset of 0.4, the model `offset`: how often the 95 % interval of beta
holds it, and the bias of the estimate, with and without what `recordings/learning/bias.py` takes off.

`regret` (after `fatplan simulate paper`): workers of the paper's task with a beta that makes usual utilities differ by
0.5 to 2.5, an offset from a standard normal distribution and, every other one, an inertia from another. Each is learnt
from 100 cycles with actions at random, recognised with the same confusion, known from as many repetitions. From the
state he is then in, the next 7 cycles are planned for who was learnt and for who he is, both by the whole tree of
actions and reactions, beta believed anew after each; what the plans cost the true worker is computed by the same tree.
State and reactions are seen in these 7 cycles, so that only what was learnt matters.
"""

import argparse
import math
import sys
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing import Pool
from pathlib import Path

import numpy as np

from fatigue_planner.experiment.build import load_cycle_profiles, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.planners.bounds.task import Task
from fatigue_planner.pomdp.choices.inertia import InertiaChoice
from fatigue_planner.pomdp.choices.offset import OffsetChoice
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.reactions.reaction import ReactionName
from fatigue_planner.recordings.learning.course import costs_along, learn
from fatigue_planner.recordings.learning.cycles import Cycles
from fatigue_planner.recordings.learning.estimate import MODELS
from fatigue_planner.recordings.learning.learnt import learnt_worker
from fatigue_planner.recordings.learning.likelihood import Confusion

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from simulated_choices import ERRS, simulated

ROOT = Path(__file__).parents[1]
EXPERIMENT, CACHE = ROOT / "experiments" / "paper.yaml", ROOT / "cache"
SEED, CYCLES, HORIZON = 18, 100, 7


@dataclass(frozen=True)
class Worker:
    """A worker as he is or is believed to be: betas (S,) in 1 / cost with weights (S,), factors (1 or 1 + U, U)."""

    betas: np.ndarray
    weights: np.ndarray
    factors: np.ndarray

    def after(self, last: np.ndarray) -> np.ndarray:
        """The factors (N, 1, U) after preferences (N,)."""
        return self.factors[1 + last if len(self.factors) > 1 else np.zeros_like(last)][:, None]


@cache
def profiles() -> dict[ReactionName, CycleProfile]:
    """The paper's reactions."""
    return dict(load_cycle_profiles(load_experiment(EXPERIMENT), CACHE, "fatplan simulate paper"))


def usual_difference(model: FatiguePomdp, start: np.ndarray) -> float:
    """How far the costs of two reactions are apart, over 1,000 cycles of any actions and any reactions."""
    actions = np.random.default_rng(SEED).integers(0, len(model.actions), 1000)
    even = np.full((1000, len(model.outcomes)), 1 / len(model.outcomes))
    costs = costs_along(model, start, Cycles(actions, actions, None), even)
    return float(np.sqrt(np.square(costs[:, 1] - costs[:, 0]).mean()))


def one(arguments: tuple[int, int]) -> tuple[float, float, float, float]:
    """The most likely beta, that without bias, and the interval of one worker."""
    estimator = simulated(*arguments)
    fit = estimator.fit("offset")
    interval = estimator.interval(fit, "offset", 0)
    return fit.beta, interval.estimate, interval.low, interval.high


def beta(runs: int, cycles: int) -> None:
    """Print coverage and bias; the true beta is 1."""
    with Pool() as pool:  # a process per core
        found = np.array(pool.map(one, [(seed, cycles) for seed in range(runs)], chunksize=5))
    likely, estimate, low, high = found.T
    covered = ((low <= 1) & (high >= 1)).mean()
    print(f"{runs} workers of {cycles} cycles; beta is 1")
    print(f"95 % intervals that hold it: {100 * covered:.1f} %; above it {100 * (low > 1).mean():.1f} %, below "
          f"{100 * (high < 1).mean():.1f} %")  # fmt: skip
    for name, values in (("without bias", estimate), ("most likely", likely)):
        finite = values[np.isfinite(values)]
        print(f"{name}: mean {finite.mean():.4f} (standard error {finite.std() / math.sqrt(finite.size):.4f}), median "
              f"{np.median(values):.4f}, endless {values.size - finite.size}")  # fmt: skip


def worker(seed: int) -> tuple[float, float]:
    """What planning with the learnt worker costs more than with the true one, and with Eq. 4 at his true beta alone."""
    rng = np.random.default_rng([SEED, seed])
    experiment = load_experiment(EXPERIMENT)
    task = scenario(experiment, profiles(), experiment.benchmark.conditions["single_novice"])
    model, size = task.model, len(task.model.outcomes)
    beta = rng.uniform(0.5, 2.5) / usual_difference(model, task.weights @ task.states)
    offset, inertia = rng.normal(), rng.normal() * (seed % 2)
    habit = np.vstack([np.zeros(size), inertia * np.eye(size)]) + np.append(offset, np.zeros(size - 1))
    true = Worker(np.array([beta]), np.ones(1), np.exp(habit))
    state, last, done, seen = task.weights @ task.states, -1, [], []
    for _ in range(CYCLES):
        action = int(rng.integers(len(model.actions)))
        costs = np.array([-model.transition(state, action, u)[1] for u in range(size)])
        odds = habit[1 + last] - beta * (costs - costs.min())
        chances = np.exp(odds - odds.max())
        last = int(rng.choice(size, p=chances / chances.sum()))
        state = model.transition(state, action, last)[0]
        done.append(action)
        seen.append(int(rng.choice(size, p=ERRS[0, last])))
    labelled = Confusion.from_counts(np.array([[rng.multinomial(140, row) for row in ERRS[0]]], float))
    cycles = Cycles(np.array(done), np.array(seen), None)
    estimator, largest = learn(model, task.weights @ task.states, cycles, labelled, np.zeros(CYCLES, np.int64))
    fits = {name: largest if name == "inertia" else estimator.fit(name) for name in MODELS}
    chosen = min(fits, key=lambda name: fits[name].aic)
    told = learnt_worker(estimator, fits[chosen], chosen, model.outcomes)
    expertise = told["hidden_workers"]["learnt"]["expertise"]
    liked = np.zeros((1, size))
    if "choice_models" in told:
        settings = dict(told["choice_models"]["learnt"])
        kind = {"offset": OffsetChoice, "inertia": InertiaChoice}[settings["kind"]]
        liked = kind(**settings).log_odds(model.outcomes)
    learnt = Worker(np.array(expertise["values"]), np.array(expertise["probabilities"]), np.exp(liked))
    plain = Worker(true.betas, true.weights, np.ones((1, size)))
    active = model.active_entries.size
    shape = (len(model.actions), size, -1)
    known = Task(
        model.arrays.gain.reshape(shape)[:, :, :active], model.arrays.offset.reshape(shape)[:, :, :active],
        state[:active], model.arrays.cost.weight[:active] / model.entries, model.posture_cost, beta, model.discount,
        np.ones((1, size)),
    )  # fmt: skip
    best = cost_of(known, true, true, last)
    return cost_of(known, learnt, true, last) / best - 1, cost_of(known, plain, true, last) / best - 1


def cost_of(task: Task, believed: Worker, true: Worker, last: int) -> float:
    """The true worker's expected cost over HORIZON cycles of whoever minimises the believed one's: the whole tree."""
    actions, size, _ = task.gain.shape
    states, before = task.start[None], np.array([last])
    weights, chances, levels = believed.weights[None], np.ones(1), []
    for _ in range(HORIZON):
        after = task.gain * states[:, None, None] + task.offset
        cost = np.square(after) @ task.cost_weight + task.posture_cost  # (N, A, U)
        own = [replace(task, expertise=b).choice(cost, believed.after(before)) for b in believed.betas]
        joint = weights[:, :, None, None] * np.stack(own, axis=1)  # (N, S, A, U)
        truly = chances[:, None, None] * replace(task, expertise=true.betas[0]).choice(cost, true.after(before))
        levels.append((joint.sum(axis=1), truly, cost))
        states = after.reshape(-1, states.shape[1])
        weights = np.moveaxis(joint, 1, -1).reshape(-1, believed.betas.size)
        chances = truly.ravel()
        before = np.tile(np.arange(size), actions * before.size)
    planned, paid = np.zeros(chances.size), np.zeros(chances.size)  # each times its probability
    for joint, truly, cost in reversed(levels):
        future = planned.reshape(cost.shape), paid.reshape(cost.shape)
        expected = (joint * cost + task.discount * future[0]).sum(axis=-1)
        choice = expected.argmin(axis=-1)[:, None]
        planned = np.take_along_axis(expected, choice, 1)[:, 0]
        paid = np.take_along_axis((truly * cost + task.discount * future[1]).sum(axis=-1), choice, 1)[:, 0]
    return float(paid[0])


def regret(workers: int) -> None:
    """Print what planning with learnt workers costs more than being told."""
    with Pool() as pool:
        found = 100 * np.array(pool.map(worker, range(workers), chunksize=1))
    print(f"{workers} workers, {CYCLES} cycles of learning each, then {HORIZON} cycles planned and evaluated exactly")
    for name, losses in zip(("learnt", "told beta, but neither offset nor inertia"), found.T, strict=True):
        print(f"{name}: mean regret {losses.mean():.4f} % (standard error {losses.std() / math.sqrt(workers):.4f}), "
              f"95 % of workers below {np.quantile(losses, 0.95):.4f} %, most {losses.max():.4f} %")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["beta", "regret"])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--cycles", type=int, default=200)
    parser.add_argument("--workers", type=int, default=100)
    chosen = parser.parse_args()
    if chosen.what == "beta":
        beta(chosen.runs, chosen.cycles)
    else:
        regret(chosen.workers)

"""A decision of the lookahead where plans, workers or poses are many, and a bound for a worker of some expertise.

    python perf/search/lookaheads.py

CPU time, medians of interleaved rounds, and as multiples of the first row; whole decisions after a warm-up, small ones
several times in a row.
"""

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}
sys.path.append(str(Path(__file__).parents[1]))

import numpy as np
from problems import ROOT, affine_model, experiment_problems
from speed import interleaved

from fatigue_planner.experiment.build import load_cycle_profiles, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.planners.bounds.cost_bound import cost_lower_bound
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.hidden_worker import HiddenWorker

ROUNDS = 9
AT_LEAST_S = 0.02  # of a row in a round
# Continuous rates with the spread of those in experiments/hidden_worker.yaml.
RATES = {"kind": "lognormal", "median": 1.0, "sigma": 0.456}


def around(belief: ExactBelief, states: int) -> ExactBelief:
    """So many states about the first one of a belief: each entry up to half as much higher or lower."""
    model, rng = belief.model, np.random.default_rng(1)
    fatigue = np.repeat(belief.states[:1], states, axis=0)
    fatigue[:, :-1] = np.clip(fatigue[:, :-1] * rng.uniform(0.5, 1.5, fatigue[:, :-1].shape), 0, 1)
    return ExactBelief(model, fatigue, np.full(states, 1 / states))


def hundred_poses(states: int) -> ExactBelief:
    """100 poses with three reactions each, random maps of 32 entries."""
    rng = np.random.default_rng(2)
    gain = rng.uniform(0.6, 0.99, (100, 3, 32))
    model = affine_model(gain, rng.uniform(0, 0.1, gain.shape) * (1 - gain), 0.0, 0.95, 78)
    fatigue = np.hstack([rng.uniform(0, 0.1, (states, 32)), np.zeros((states, 1))])
    return ExactBelief(model, fatigue, np.full(states, 1 / states))


def hidden_rates() -> Belief:
    """300 particles of a worker whose rates are hidden, before the first cycle."""
    loaded = load_experiment(ROOT / "experiments" / "hidden_worker.yaml")
    rates = HiddenWorker.model_validate({"fatigue_rate_factor": RATES, "recovery_rate_factor": RATES}, strict=False)
    changed = loaded.model_copy(update={"hidden_workers": {**loaded.hidden_workers, "rates": rates}})
    experiment_problems("paper")  # simulates what the cache lacks
    profiles = load_cycle_profiles(changed, ROOT / "cache", "fatplan simulate hidden_worker")
    task = scenario(changed, profiles, changed.benchmark.conditions["hidden_rates"])
    return task.initial_belief("prior", task.model, np.random.default_rng(0))


def decision(belief: Belief, depth: int) -> Callable[[], object]:
    policy = LookaheadSettings(kind="lookahead", depth=depth, leaf_value="bound").build()
    return partial(policy.act, belief, np.random.default_rng(0))


def after_rejuvenation(belief: Belief) -> Callable[[], object]:
    """The first decision with new workers, whose plans are to be valued; the belief's own update is not in it."""
    policy, rng = LookaheadSettings(kind="lookahead", depth=2, leaf_value="bound").build(), np.random.default_rng(0)
    fresh = [belief.rejuvenated(rng) for _ in range(ROUNDS + 1)]
    return lambda: policy.act(fresh.pop(), rng)


def repeat(task: Callable[[], object], times: int) -> None:
    for _ in range(times):
        task()


def bound() -> None:
    """Two poses with four reactions, 100 cycles, a worker of expertise 1000."""
    rng = np.random.default_rng(3)
    gain = rng.uniform(0.6, 0.99, (2, 4, 41))
    maps = gain, rng.uniform(0, 0.1, gain.shape) * (1 - gain)
    rest = np.zeros((1, 41)), np.ones(1), 0.95, 78
    cost_lower_bound(*maps, 1000.0, *rest, 2)  # compiles
    begin = time.process_time()
    cost_lower_bound(*maps, 1000.0, *rest, 100)
    print(f"bound, 2 poses x 4 reactions, expertise 1000, 100 cycles: {time.process_time() - begin:.1f} s")


def main() -> None:
    paper, grid = experiment_problems("paper"), experiment_problems("pose_grid")[0]
    problems = {problem.name: problem.belief for problem in paper}
    rng, started = np.random.default_rng(0), dict(problems, pose_grid=grid.belief)
    for name, belief in started.items():
        for cycle in range(5):
            belief = belief.update(cycle % len(belief.model.actions), 0, rng)  # noqa: PLW2901
        started[name] = belief
    particles, many = hidden_rates(), hundred_poses(1000)
    rows = {
        "paper, novice, 2 cycles": decision(started["single_novice"], 2),
        "paper, expert, 2 cycles": decision(started["single_expert"], 2),
        "pose_grid, 2 cycles": decision(started["pose_grid"], 2),
        "300 states of the paper's novice, 2 cycles": decision(around(started["single_novice"], 300), 2),
        "300 states of the paper's novice, 4 cycles": decision(around(started["single_novice"], 300), 4),
        "300 states of the paper's expert, 2 cycles": decision(around(started["single_expert"], 300), 2),
        "hidden rates, 300 particles, 2 cycles": decision(particles, 2),
        "hidden rates, after a rejuvenation, 2 cycles": after_rejuvenation(particles),
        "100 poses x 3, 1000 states, 1 cycle": decision(many, 1),
        "100 poses x 3, 1000 states, 2 cycles": decision(many, 2),
    }
    rows_of_one = {"hidden rates, after a rejuvenation, 2 cycles"}
    times = {}
    for name, row in rows.items():
        row()  # compiles
        begin = time.process_time()
        if name not in rows_of_one:
            row()
        spent = time.process_time() - begin
        times[name] = 1 if name in rows_of_one else max(1, int(AT_LEAST_S / max(spent, 1e-6)))
    medians = interleaved({name: partial(repeat, row, times[name]) for name, row in rows.items()}, ROUNDS)
    each = {name: seconds / times[name] for name, seconds in medians.items()}
    first = next(iter(each.values()))
    for name, seconds in each.items():
        print(f"{name}: {seconds * 1e3:.3f} ms, {seconds / first:.1f} x")
    bound()


if __name__ == "__main__":
    main()

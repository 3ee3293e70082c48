"""Milliseconds of one decision of every policy: the paper's two actions, and the pose grid's 25.

    python perf/search/decisions.py

Medians of interleaved rounds in CPU time, of whole decisions after a warm-up, from the belief after some
cycles. The bar is 50 ms per decision for what the documentation recommends.
"""

import os
import statistics
import time

os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}

import numpy as np
from problems import Problem, experiment_problems

from fatigue_planner.planners.baselines import GreedySettings
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings

CYCLES_BEFORE = 5
ROUNDS = 15


def policies(descents: int) -> dict[str, PolicySettings]:
    """The policies compared, by the name under which they are printed."""
    found: dict[str, PolicySettings] = {"greedy": GreedySettings(kind="greedy")}
    for depth in (1, 2):
        found[f"lookahead, {depth} + bound"] = LookaheadSettings(kind="lookahead", depth=depth, leaf_value="bound")
    for backup, exploration, leaf in (
        ("mean", "fixed", "none"),
        ("max", "fixed", "none"),
        ("exact", "scaled", "none"),
        ("exact", "scaled", "bound"),
        ("exact", "scaled", "greedy_rollout"),
    ):
        found[f"pomcp, {descents} descents, {backup}, {exploration}, leaf {leaf}"] = PomcpSettings(
            kind="pomcp", backup=backup, exploration=exploration, leaf_value=leaf,
            exploration_constant=0.1 if exploration == "fixed" else 1.0, descents=descents,
        )  # fmt: skip
    return found


def report(problem: Problem, descents: int) -> None:
    """Print the milliseconds of all policies."""
    rng = np.random.default_rng(0)
    belief = problem.belief
    for cycle in range(CYCLES_BEFORE):
        belief = belief.update(cycle % len(problem.model.actions), 0, rng)
    chosen = {name: settings.build() for name, settings in policies(descents).items()}
    seconds: dict[str, list[float]] = {name: [] for name in chosen}
    for turn in range(ROUNDS + 1):
        for name, policy in chosen.items():
            begin = time.process_time()
            policy.act(belief, rng)
            if turn > 0:
                seconds[name].append(time.process_time() - begin)
    print(f"{problem.name}: {len(problem.model.actions)} actions, {len(problem.model.outcomes)} preferences")
    for name, values in seconds.items():
        print(f"  {statistics.median(values) * 1e3:8.3f} ms  {name}")


def main() -> None:
    paper = experiment_problems("paper")
    report(paper[0], 5000)
    report(next(problem for problem in paper if "expert" in problem.name), 5000)
    report(experiment_problems("pose_grid")[0], 2000)


if __name__ == "__main__":
    main()

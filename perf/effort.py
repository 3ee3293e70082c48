"""How long decisions may take by the estimate that an experiment is checked by, and how long they take.

    python perf/effort.py

CPU time, the quickest of three. The estimate is doubled for slower machines and counts all cyclic plans, of which those
that are nowhere the best are left out: there it may be ten times too high. Where a worker's choices may be sure, a
search is taken to follow one path, as it does if hardly anything is explored and leaves are valued as a novice's;
elsewhere its tree is even, and the estimate hundreds of times too high. It must never be too low.
"""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}
sys.path.append(str(Path(__file__).parent / "search"))

import numpy as np
from problems import affine_model

from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.study.benchmark.effort import seconds_of

EXPERT = np.inf


def belief(actions: int, preferences: int, entries: int, expertise: float, states: int, noisy: bool) -> ExactBelief:
    """Random maps; `noisy`: one preference in ten is taken for another one."""
    rng = np.random.default_rng(1)
    gain = rng.uniform(0.6, 0.99, (actions, preferences, entries))
    model = affine_model(gain, rng.uniform(0, 0.1, gain.shape) * (1 - gain), expertise, 0.95, entries)
    if noisy:
        errors = np.full((preferences, preferences), 0.1 / (preferences - 1))
        np.fill_diagonal(errors, 0.9)
        arrays = model.arrays._replace(observation=errors[None], observation_reveals_outcome=False)
        model = replace(model, arrays=arrays, observation_reveals_outcome=False)
    fatigue = np.zeros((states, model.arrays.gain.shape[1] + 1))
    fatigue[:, :entries] = rng.uniform(0, 0.1, (states, entries))
    return ExactBelief(model, fatigue, np.full(states, 1 / states))


def lookahead(depth: int, leaf_value: str) -> LookaheadSettings:
    return LookaheadSettings(kind="lookahead", depth=depth, leaf_value=leaf_value)


def pomcp(descents: int, constant: float, leaf_value: str) -> PomcpSettings:
    return PomcpSettings(
        kind="pomcp", backup="max", exploration_constant=constant, descents=descents, leaf_value=leaf_value
    )


# Actions, preferences, entries, expertise, states, recognised with error; and what plans.
CASES = [
    ((2, 2, 16, 0.0, 1, False), lookahead(10, "none")),
    ((2, 2, 80, EXPERT, 1, False), lookahead(15, "none")),
    ((2, 2, 16, 40.0, 1, True), lookahead(6, "none")),
    ((10, 3, 32, 0.0, 1, False), lookahead(4, "none")),
    ((2, 2, 16, 0.0, 1, False), lookahead(8, "bound")),
    ((30, 3, 32, 0.0, 1, False), lookahead(2, "bound")),
    ((100, 3, 32, 0.0, 1000, False), lookahead(2, "bound")),
    ((10, 3, 32, 40.0, 100, False), lookahead(2, "bound")),
    ((5, 3, 80, 40.0, 50, True), lookahead(2, "bound")),
    ((2, 2, 16, EXPERT, 1, False), lookahead(10, "greedy_rollout")),
    ((2, 2, 80, 0.0, 1, False), lookahead(6, "greedy_rollout")),
    ((2, 2, 80, 40.0, 1, False), lookahead(6, "random_rollout")),
    ((2, 2, 16, 0.0, 1, False), pomcp(100_000, 0.01, "none")),
    ((2, 2, 80, EXPERT, 1, False), pomcp(5000, 0.001, "none")),
    ((25, 3, 40, 0.0, 1, False), pomcp(2000, 0.1, "greedy_rollout")),
    ((2, 2, 16, EXPERT, 1, False), pomcp(5000, 0.001, "bound")),
    ((2, 2, 16, EXPERT, 1, False), pomcp(5000, 0.0, "bound")),
    ((2, 2, 16, EXPERT, 1, False), pomcp(50_000, 0.0, "bound")),
    ((2, 2, 80, EXPERT, 1, False), pomcp(5000, 0.0, "bound")),
    ((2, 2, 16, EXPERT, 50, False), pomcp(5000, 0.0, "bound")),
    ((3, 2, 16, EXPERT, 1, True), pomcp(5000, 0.0, "bound")),
]


def main() -> None:
    print("poses x preferences, entries, expertise, states, recognition: measured, estimated, ratio")
    for case, settings in CASES:
        start, policy, rng = belief(*case), settings.build(), np.random.default_rng(0)
        policy.act(start, rng)  # compiles
        spent = []
        for _ in range(3):
            begin = time.process_time()
            policy.act(start, rng)
            spent.append(time.process_time() - begin)
        estimate, seconds = seconds_of(settings, start), min(spent)
        actions, preferences, entries, expertise, states, noisy = case
        budget = f"{settings.depth} cycles" if settings.kind == "lookahead" else f"{settings.descents} descents"
        print(
            f"{actions} x {preferences}, {entries}, {expertise:g}, {states}, {'noisy' if noisy else 'certain'}; "
            f"{settings.kind}, {budget}, {settings.leaf_value}: {seconds * 1e3:.1f} ms, {estimate * 1e3:.1f} ms, "
            f"{estimate / seconds:.1f} x", flush=True,
        )  # fmt: skip
        assert estimate >= seconds, "the estimate is too low"


if __name__ == "__main__":
    main()

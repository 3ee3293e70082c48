"""Speed as ratios, each pair measured in one interleaved run (CPU time, medians).

python benchmarks/speed.py
"""

import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import cycle_maps, load_reactions, problem, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.quadratic_program import QuadraticProgram
from fatigue_planner.motion.simulator import phases_of, simulate
from fatigue_planner.planners.registry import PolicySettings, PomcpSettings, build_policy
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp
from fatigue_planner.reactions.cache import ReactionCache

ROOT = Path(__file__).parents[1]
PAPER, CACHE = ROOT / "experiments" / "paper.yaml", ROOT / "cache"
ROUNDS = 7


def interleaved(tasks: dict[str, Callable[[], object]], rounds: int = ROUNDS) -> dict[str, float]:
    """Median CPU seconds of each task, taken in turn."""
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(rounds):
        for name, task in tasks.items():
            begin = time.process_time()
            task()
            seconds[name].append(time.process_time() - begin)
    return {name: statistics.median(values) for name, values in seconds.items()}


def tick(paper: Experiment) -> None:
    """A whole tick of the simulation against the bare solution of its quadratic programs."""
    request = reaction_requests(paper)[2].motion
    ticks = phases_of(request.cycle, request.controller.time_step_s)[-1].stop
    solving: list[float] = []
    solve = QuadraticProgram.solve

    def timed(self: QuadraticProgram) -> object:
        begin = time.process_time()
        solution = solve(self)
        solving.append(time.process_time() - begin)
        return solution

    QuadraticProgram.solve = timed  # type: ignore[method-assign, assignment]
    try:
        whole = interleaved({"motion": lambda: simulate(request)}, 3)["motion"] / ticks
    finally:
        QuadraticProgram.solve = solve  # type: ignore[method-assign]
    bare = statistics.fmean(solving)
    ratio = whole / bare
    print(f"whole tick {whole * 1e3:.3f} ms = {ratio:.2f} x its quadratic program; {1 / whole:.0f} ticks/s, one core")


def decide(model: FatiguePomdp, belief: Belief, settings: PolicySettings) -> None:
    build_policy(model, settings).act(belief, np.random.default_rng(0))


def searches(paper: Experiment) -> None:
    """One decision of every search against POMCP's with c = 0.1."""
    requests = reaction_requests(paper)
    ReactionCache(CACHE).complete(paper.name, requests, 2, lambda _: None)
    reactions = load_reactions(paper, CACHE, "fatplan simulate")
    for condition in ("single_novice", "single_expert"):
        model, belief = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions[condition])
        for settings in paper.benchmark.policies.values():
            decide(model, belief, settings)
        tasks = {
            name: partial(decide, model, belief, settings)
            for name, settings in paper.benchmark.policies.items()
            if isinstance(settings, PomcpSettings)
        }
        medians = interleaved(tasks, 21)
        for name, seconds in medians.items():
            ratio = seconds / medians["pomcp_0.1"]
            print(f"{condition} {name}: {seconds * 1e3:.2f} ms per decision, {ratio:.2f} x pomcp_0.1")


if __name__ == "__main__":
    experiment = load_experiment(PAPER)
    tick(experiment)
    searches(experiment)

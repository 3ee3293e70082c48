"""Speed of the digital human and of the planners, as ratios, each measured in one interleaved run.

    python perf/speed.py

CPU time and medians where one process works; wall time where several do. Everything counts except imports
and compilation (one warm-up run).
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

# One thread of linear algebra, as in `fatplan simulate`.
os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}

import numpy as np

from fatigue_planner.core.executors.processes import LocalProcesses, available_cores
from fatigue_planner.experiment.build import load_cycle_profiles, reaction_requests, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.simulator import Simulator, simulate
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.reactions.cache import ReactionCache, simulated
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.environments.vector import VectorEnvironment

ROOT = Path(__file__).parents[1]
EXPERIMENTS, CACHE = ROOT / "experiments", ROOT / "cache"
ROUNDS = 7
CORES = min(available_cores(), 2)


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
    """A whole tick of the simulation against the mere solution of its quadratic program by the same solver.

    The program is the whole one, with the limits of torques and contact forces, from every tenth tick of a motion;
    only its solution is timed. The program that is solved first, without these limits, is timed as well.
    """
    for request in reaction_requests(paper):
        simulator = Simulator(request.motion)
        wholes, frees = [], []
        for index in range(simulator.ticks):
            simulator.prepare(index)
            step = simulator.body.controller.step()
            assert step is not None
            if index % 10 == 0:
                controller = simulator.body.controller
                controller.fill_whole_program()
                for kept, program in ((wholes, controller.program), (frees, controller.free)):
                    kept.append({name: values.copy() for name, values in program._arrays.items()})
            simulator.advance(step.acceleration)
        controller = simulator.body.controller

        def solve_all(program: object, kept: list[dict[str, np.ndarray]]) -> float:
            spent = 0.0
            for data in kept:
                for name, values in data.items():
                    program._arrays[name][:] = values
                begin = time.process_time()
                program._evaluate()
                spent += time.process_time() - begin
            return spent / len(kept)

        whole, free, own = [], [], []
        for _ in range(ROUNDS):
            whole.append(solve_all(controller.program, wholes))
            free.append(solve_all(controller.free, frees))
            begin = time.process_time()
            simulate(request.motion)
            own.append((time.process_time() - begin) / simulator.ticks)
        all_, bare, first = (statistics.median(values) for values in (own, whole, free))
        print(
            f"{request.name}: {all_ * 1e3:.3f} ms per tick, {1 / all_:.0f} ticks/s, a 16 s motion in "
            f"{all_ * simulator.ticks:.2f} s; bare program {bare * 1e3:.3f} ms (without limits {first * 1e3:.3f}); "
            f"everything but the solve {(all_ - first) / bare:.2f} x the bare program"
        )


def library(grid: Experiment) -> None:
    """The reactions of the pose grid from nothing: one process against two, and memory against their number."""
    requests = reaction_requests(grid)
    simulate(requests[0].motion)
    seconds = {}
    for jobs, count in ((1, 25), (CORES, 25), (CORES, 50), (CORES, 75)):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            outcomes = ReactionCache(Path(folder)).complete(requests[:count], LocalProcesses(jobs), lambda _: None)
            seconds[jobs, count] = time.perf_counter() - begin
        assert all(outcome.verdict == "ok" for outcome in outcomes)
        own, workers = (
            resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )
        print(
            f"{count} reactions, {jobs} processes: {seconds[jobs, count]:.1f} s wall, "
            f"{seconds[jobs, count] / count * 1e3:.0f} ms each; peak memory {own:.0f} MB, a worker {workers:.0f} MB"
        )
    # starting the processes costs the same for any number of reactions: the slope is the cost of a reaction
    marginal = (seconds[CORES, 75] - seconds[CORES, 25]) / 50
    whole = interleaved({"one": lambda: simulated(requests[0])}, 3)["one"]
    efficiency = seconds[1, 25] / (CORES * seconds[CORES, 25])
    print(f"parallel efficiency on {CORES} cores with 25 reactions, start included: {efficiency:.0%}; ")
    print(f"one more reaction costs {marginal * 1e3:.0f} ms on {CORES} cores; alone {whole * 1e3:.0f} ms: "
          f"{whole / (CORES * marginal):.0%}")  # fmt: skip


def decide(belief: Belief, settings: PolicySettings) -> None:
    settings.build().act(belief, np.random.default_rng(0))


def searches(paper: Experiment) -> None:
    """One decision of every search against POMCP's with c = 0.1."""
    requests = reaction_requests(paper)
    ReactionCache(CACHE).complete(requests, LocalProcesses(CORES), lambda _: None)
    profiles = load_cycle_profiles(paper, CACHE, "fatplan simulate")
    for condition in ("single_novice", "single_expert"):
        task = scenario(paper, profiles, paper.benchmark.conditions[condition])
        belief = task.initial_belief("prior", task.model, np.random.default_rng(0))
        for settings in paper.benchmark.policies.values():
            decide(belief, settings)
        tasks = {
            name: partial(decide, belief, settings)
            for name, settings in paper.benchmark.policies.items()
            if isinstance(settings, PomcpSettings)
        }
        medians = interleaved(tasks, 21)
        for name, seconds in medians.items():
            ratio = seconds / medians["pomcp_0.1"]
            print(f"{condition} {name}: {seconds * 1e3:.2f} ms per decision, {ratio:.2f} x pomcp_0.1")


def outside(paper: Experiment) -> None:
    """Trials of policies without search, all at once against one by one; steps of environments (single novice)."""
    profiles = load_cycle_profiles(paper, CACHE, "fatplan simulate")
    task = scenario(paper, profiles, paper.benchmark.conditions["single_novice"])
    lookahead = {"kind": "lookahead", "depth": 1, "leaf_value": "bound"}
    runs, cycles, spent = 10_000, 100, 0.0
    for name, settings in {"greedy": "greedy", "periodic": "periodic", "lookahead_1_bound": lookahead}.items():
        cell = Cell("single_novice", cycles, name, policy(settings), task, paper.benchmark.seed, runs)
        for run in (cell.run, cell.run_one_by_one):
            run([0])
        medians = interleaved(
            {"all": partial(cell.run, range(runs)), "one": partial(cell.run_one_by_one, range(50))}, 3
        )
        spent += medians["all"]
        ratio = medians["one"] / 50 / (medians["all"] / runs)
        print(f"{name}: {runs} runs of {cycles} cycles in {medians['all']:.2f} s, {ratio:.0f} x faster than one by one")
    print(f"all three: {spent:.2f} s")
    for count in (1, 1000):
        tasks = VectorEnvironment(task, count, cycles)
        tasks.reset(seed=1)
        steps = 10 * (cycles + 1)
        seconds = interleaved({"steps": partial(take_steps, tasks, steps)}, 3)["steps"]
        print(f"vector environment of {count}: {steps * count / seconds:,.0f} steps/s")


START = """
import time
begin = time.process_time()
import sys
from pathlib import Path
import numpy as np
from fatigue_planner.experiment.build import load_cycle_profiles, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.planners.registry import policy
loaded = load_experiment(Path("paper"))
profiles = load_cycle_profiles(loaded, Path(sys.argv[1]), "fatplan simulate")
task = scenario(loaded, profiles, loaded.benchmark.conditions["single_novice"])
rng = np.random.default_rng(0)
settings = {"lookahead": {"kind": "lookahead", "depth": 2, "leaf_value": "bound"}}.get(sys.argv[2])
chosen = policy(settings) if settings else loaded.benchmark.policies[sys.argv[2]]
chosen.build().act(task.initial_belief("prior", task.model, rng), rng)
print(time.process_time() - begin)
"""


def starts() -> None:
    """CPU seconds from the first import to the first decision, with an empty and with a warm cache of kernels."""
    for name in ("pomcpMax_0.1", "lookahead"):
        with tempfile.TemporaryDirectory() as folder:
            seconds = [
                float(subprocess.run(
                    [sys.executable, "-c", START, CACHE, name], env=os.environ | {"XDG_CACHE_HOME": folder},
                    check=True, capture_output=True, text=True,
                ).stdout)
                for _ in range(1 + ROUNDS)
            ]  # fmt: skip
        cold, warm = seconds[0], statistics.median(seconds[1:])
        print(
            f"first decision of {name}: {cold:.1f} s with no compiled kernels, {warm:.2f} s with; {cold / warm:.1f} x"
        )


def take_steps(tasks: VectorEnvironment, steps: int) -> None:
    actions = np.zeros(tasks.num_envs, int)
    for _ in range(steps):
        tasks.step(actions)


if __name__ == "__main__":
    experiment = load_experiment(EXPERIMENTS / "paper.yaml")
    tick(experiment)
    library(load_experiment(EXPERIMENTS / "pose_grid.yaml"))
    searches(experiment)
    outside(experiment)
    starts()

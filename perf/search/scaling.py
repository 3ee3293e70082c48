"""Cost of a descent against tree size, number of actions and active entries: `python scaling.py FILE` draws it."""

import statistics
import sys
import time
from pathlib import Path

import matplotlib as mpl
import numpy as np
from by_hand import CompilerMissingError, SearchByHand
from cases import Case, by_hand, ours
from problems import Problem, synthetic_problem

from fatigue_planner.planners.pomcp.policy import PomcpPolicy

mpl.use("Agg")
import matplotlib.pyplot as plt

DESCENTS = (300, 1000, 3000, 10_000, 30_000, 100_000)
ACTIONS = (2, 3, 4, 6, 8, 12, 16)
ENTRIES = (8, 16, 32, 64, 78, 128, 256)
DESCENTS_OF_A_DECISION = 5000
ROUNDS = 9
CONSTANT = 0.1

# search: (microseconds per descent, microseconds per step)
Costs = dict[str, tuple[float, float]]


def costs(problem: Problem, descents: int) -> Costs:
    """Medians of interleaved rounds, for ours and, where there is a compiler, C++."""
    case = Case(problem, CONSTANT, "mean", descents)
    policy = PomcpPolicy(case.settings)
    tasks = {"ours": lambda seed: policy.act(problem.belief, np.random.default_rng(seed))}
    depth = {"ours": ours(case, 0).depth}
    try:
        search = SearchByHand(problem.model)
        tasks["C++"] = lambda seed: by_hand(search, case, seed)
        depth["C++"] = by_hand(search, case, 0).depth
    except CompilerMissingError:
        pass
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for seed in range(ROUNDS + 1):
        for name, task in tasks.items():
            begin = time.process_time()
            task(seed)
            if seed > 0:
                seconds[name].append(time.process_time() - begin)
    each = {name: statistics.median(values) / descents * 1e6 for name, values in seconds.items()}
    return {name: (each[name], each[name] / depth[name]) for name in tasks}


def measure() -> dict[str, dict[int, Costs]]:
    """Costs by the quantity that is varied and its value."""
    return {
        "descents": {n: costs(synthetic_problem(32), n) for n in DESCENTS},
        "actions": {n: costs(synthetic_problem(32, n), DESCENTS_OF_A_DECISION) for n in ACTIONS},
        "active entries": {n: costs(synthetic_problem(n), DESCENTS_OF_A_DECISION) for n in ENTRIES},
    }


def report(measured: dict[str, dict[int, Costs]]) -> None:
    """Print the bars: flat in tree size apart from depth, at most linear in active entries."""
    by_size, by_entries = measured["descents"], measured["active entries"]
    for name in by_size[DESCENTS[0]]:
        small, large = by_size[1000][name], by_size[DESCENTS[-1]][name]
        print(
            f"{name}: a descent in a tree of 100,000 costs {large[0] / small[0]:.2f} x one in a tree of 1,000, "
            f"a step {large[1] / small[1]:.2f} x"
        )
        few, many = by_entries[ENTRIES[0]][name][1], by_entries[ENTRIES[-1]][name][1]
        growth = np.log(many / few) / np.log(ENTRIES[-1] / ENTRIES[0])
        print(
            f"{name}: a step with {ENTRIES[-1]} active entries costs {many / few:.2f} x one with {ENTRIES[0]}: "
            f"as their number to the power {growth:.2f}"
        )


def write_figure(path: Path) -> None:
    """Measure, print the bars and draw one panel per quantity: solid per descent, dashed per step of it."""
    measured = measure()
    report(measured)
    figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained", sharey=True)
    for panel, (varied, table) in zip(panels, measured.items(), strict=True):
        for colour, name in zip(("C0", "C1"), next(iter(table.values())), strict=False):
            values = np.array([table[n][name] for n in table])
            panel.loglog(list(table), values[:, 0], "o-", color=colour, ms=3, label=f"{name}, per descent")
            panel.loglog(list(table), values[:, 1], "o--", color=colour, ms=3, label=f"{name}, per step")
        panel.set_xlabel(varied)
        if varied != "descents":
            panel.set_xticks(list(table), [str(n) for n in table])
            panel.minorticks_off()
        panel.grid(which="both", alpha=0.3)
    panels[0].set_ylabel("CPU time [µs]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=8)
    figure.savefig(path, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    write_figure(Path(sys.argv[1]))

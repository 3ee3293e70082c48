"""How the values at the root of a search converge to the exact ones: docs/images/search_convergence.png.

    python perf/search_convergence.py

Without leaf values a search's horizon grows with its tree, an exact lookahead's is fixed. To compare like
with like, both problems here end: there is no reward after the last cycle. So the lookahead to that depth is
exact, and the search converges to it.
"""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from fatigue_planner.core.executors.processes import LocalProcesses, available_cores
from fatigue_planner.core.jit import compiled
from fatigue_planner.experiment.build import load_cycle_profiles, reaction_requests, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.output.figures.style import COLOURS, MARKERS, house_style, new_figure, publish_png
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings
from fatigue_planner.planners.pomcp.policy import PomcpPolicy, PomcpSettings
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatigueArrays, preference_probabilities, react, recognition
from fatigue_planner.pomdp.problem import Dynamics, Pomdp
from fatigue_planner.reactions.cache import ReactionCache

ROOT = Path(__file__).parents[1]
FIGURE = ROOT / "docs" / "images" / "search_convergence.png"
CYCLES = 6
BACKUPS = ("mean", "max", "exact")
CONSTANTS = (0.001, 0.01, 0.1)
DESCENTS = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
SEARCHES = 20


class Ending(NamedTuple):
    """A problem and its number of cycles; a state is the problem's own and the cycles done."""

    inner: FatigueArrays
    cycles: int


@compiled
def probabilities_before_the_end(ending: Ending, state: Any, action: int, probabilities: Any) -> None:
    preference_probabilities(ending.inner, state[:-1], action, probabilities)


@compiled
def advance_to_the_end(ending: Ending, state: Any, action: int, preference: int) -> float:
    reward = react(ending.inner, state[:-1], action, preference)
    state[-1] += 1
    return reward if state[-1] <= ending.cycles else 0.0


@compiled
def recognition_before_the_end(ending: Ending, state: Any, action: int, preference: int, observation: int) -> float:
    return float(recognition(ending.inner, state[:-1], action, preference, observation))


ENDING = Dynamics(probabilities_before_the_end, advance_to_the_end, recognition_before_the_end)


def single_novice() -> ExactBelief:
    """The paper's condition, with an end."""
    paper = load_experiment(ROOT / "experiments" / "paper.yaml")
    ReactionCache(ROOT / "cache").complete(reaction_requests(paper), LocalProcesses(available_cores()), lambda _: None)
    profiles = load_cycle_profiles(paper, ROOT / "cache", "fatplan simulate")
    task = scenario(paper, profiles, paper.benchmark.conditions["single_novice"])
    task_names = {field: getattr(task.model, field) for field in ("actions", "outcomes", "observations", "discount")}
    model = Pomdp(**task_names, arrays=Ending(task.model.arrays, CYCLES), dynamics=ENDING)
    return ExactBelief(model, np.pad(task.states, [(0, 0), (0, 1)]), task.weights)


def errors(belief: ExactBelief, exact: float, backup: str, c: float, descents: int) -> np.ndarray:
    """The errors of the best value at the root in SEARCHES searches."""
    settings = PomcpSettings(kind="pomcp", backup=backup, exploration_constant=c, descents=descents)
    seeds = (np.random.default_rng(seed) for seed in range(SEARCHES))
    return np.array([PomcpPolicy(settings).act(belief, rng).values.max() - exact for rng in seeds])


def draw(axes: Axes, belief: ExactBelief, c: float) -> None:
    settings = LookaheadSettings(kind="lookahead", depth=CYCLES)
    values = np.sort(LookaheadPolicy(settings).values(belief, np.random.default_rng(0)))
    exact, gap = float(values[-1]), float(values[-1] - values[-2])
    for look, backup in enumerate(BACKUPS):
        found = [errors(belief, exact, backup, c, descents) for descents in DESCENTS]
        rms = [math.sqrt(np.mean(error**2)) / abs(exact) for error in found]
        print(f"c = {c:g}, {backup}:", "  ".join(f"{100 * error:.3f} %" for error in rms))
        axes.loglog(DESCENTS, rms, color=COLOURS[look], marker=MARKERS[look], markersize=4, label=backup)
    axes.axhline(gap / abs(exact), color="0.5", linewidth=0.8, linestyle="--")
    axes.text(DESCENTS[0], 1.15 * gap / abs(exact), "actions differ by", fontsize=7, color="0.4")
    axes.set_title(f"c = {c:g}")
    axes.set_xlabel("descents")


@house_style()
def main() -> None:
    belief = single_novice()
    figure = new_figure(9.0, 3.0)
    panels = figure.subplots(1, len(CONSTANTS), sharey=True)
    for axes, c in zip(panels, CONSTANTS, strict=True):
        draw(axes, belief, c)
    panels[0].set_ylabel(
        f"error of the value of {CYCLES} cycles\n(root mean square of {SEARCHES} searches, as a fraction)"
    )
    panels[0].set_ylim(1e-5, 1)  # the exact backup ends at the rounding error, far below
    panels[-1].legend(title="backup", frameon=False, loc="lower left")
    publish_png(FIGURE, figure)


if __name__ == "__main__":
    main()

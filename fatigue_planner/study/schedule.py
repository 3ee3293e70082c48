"""The best schedule for one or several workers, what it is worth, and for whom it would not be the best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import SelectionError, listed
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.planners.baselines import GreedySettings
from fatigue_planner.planners.fixed import FixedSettings
from fatigue_planner.planners.lookahead import LookaheadSettings, reference_for
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.robust_periodic import SPREAD
from fatigue_planner.planners.schedules.cost import MeanCost, ScheduleCost, schedule_cost
from fatigue_planner.planners.schedules.policy import best_schedule_for
from fatigue_planner.planners.schedules.search import Plan, Schedule, best_schedule
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import replay
from fatigue_planner.study.benchmark.tables import trial_table
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.statistics.inference import standard_error
from fatigue_planner.study.statistics.multiple_testing import Pair
from fatigue_planner.study.statistics.savings import Saving, savings

Vector = NDArray[np.float64]

# The policies that are run: the schedule, and what it is compared with.
SCHEDULE, BEST_FIXED, ERGONOMIC, GREEDY, PLANNING = "schedule", "best_fixed", "ergonomic", "greedy", "planning"
# One standard deviation of the logarithm of a rate, as measured.
FACTOR = float(np.exp(SPREAD.sigma))


@dataclass(frozen=True)
class Rotation:
    """A schedule for several workers.

    actions: by name, in order. exact: all that are no longer were looked at. own: by condition, that worker's own best,
    and what of its cost the common one costs more (endless task, expected).
    """

    actions: tuple[str, ...]
    exact: bool
    own: Mapping[str, tuple[tuple[str, ...], float]]


@dataclass(frozen=True)
class Worth:
    """What a schedule does for the worker of a condition.

    cost, standard_error: mean discounted cost of the runs (the error is 0 where all are the same).
    spared: by entry of the fatigue, the peak over the cycles of its mean under the best fixed action, and under the
    schedule. misjudged: by kind of worker, what of the cost of that worker's own best schedule this one costs more
    (endless task, expected).
    """

    condition: str
    cost: float
    standard_error: float
    best_fixed: str
    savings: Mapping[str, Saving]
    spared: Mapping[str, tuple[float, float]]
    misjudged: Mapping[str, float]


def find_rotation(scenarios: Mapping[str, Scenario], longest: int) -> Rotation:
    """The schedule with the lowest mean cost over the conditions, of actions that all their workers can perform.

    Raises SelectionError if there is no such action.
    """
    beliefs = {name: start_of(scenario) for name, scenario in scenarios.items()}
    all_actions = [belief.model.actions for belief in beliefs.values()]
    common = [action for action in all_actions[0] if all(action in actions for actions in all_actions)]
    if not common:
        raise SelectionError(f"no action can be performed by the workers of all of {listed(scenarios)}.")
    costs: dict[str, ScheduleCost] = {name: schedule_cost(belief) for name, belief in beliefs.items()}
    numbers = {name: np.array([belief.model.actions.index(a) for a in common]) for name, belief in beliefs.items()}
    found = best_schedule(MeanCost([(costs[name], numbers[name]) for name in beliefs]), len(common), longest)
    own = {}
    for name, belief in beliefs.items():
        best = best_schedule_for(belief, longest)
        own[name] = tuple(belief.model.actions[a] for a in best.actions), _loss(costs[name], numbers[name], found, best)
    return Rotation(tuple(common[a] for a in found.actions), found.exact, own)


def start_of(scenario: Scenario) -> Belief:
    """What is known before the first cycle."""
    return scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))


def _loss(cost: ScheduleCost, numbers: NDArray[np.intp], found: Schedule, best: Schedule) -> float:
    return _above(float(cost.costs(numbers[[list(found.actions)]])[0]), best.cost)


def _above(cost: float, least: float) -> float:
    """By what part of the least cost a cost is above it; searches may end a little above each other's."""
    return max(cost / least - 1, 0.0) if least > 0 else 0.0


def rotation_cells(
    scenarios: Mapping[str, Scenario], actions: tuple[str, ...], n_cycles: int, seed: int, trials: int
) -> list[Cell]:
    """The runs of the schedule, and of what it is compared with, in every condition."""
    cells = []
    for condition, scenario in scenarios.items():
        reference = reference_for(start_of(scenario))
        planning = LookaheadSettings(
            kind="lookahead", depth=reference.depth, leaf_value=reference.leaf_value,
            rollout_cycles=reference.rollout_cycles,
        )  # fmt: skip
        policies: dict[str, PolicySettings] = {
            SCHEDULE: PeriodicSettings(kind="periodic", sequence=actions),
            BEST_FIXED: PeriodicSettings(kind="periodic", longest=1),
            ERGONOMIC: FixedSettings(kind="fixed"),
            GREEDY: GreedySettings(kind="greedy"),
            PLANNING: planning,
        }
        cells += [Cell(condition, n_cycles, name, chosen, scenario, seed, trials) for name, chosen in policies.items()]
    return cells


def worth_of(
    cells: Sequence[Cell], results: Sequence[dict[int, TrialResult]], settings: StatisticsSettings, longest: int
) -> list[Worth]:
    """What the schedule does in every condition, from the runs of `rotation_cells`."""
    table, seed = trial_table(cells, results), cells[0].seed
    runs = {(cell.condition, cell.policy): (cell, done) for cell, done in zip(cells, results, strict=True)}
    found = []
    for cell in cells:
        if cell.policy != SCHEDULE:
            continue
        pairs = [Pair(cell.condition, cell.n_cycles, SCHEDULE, o) for o in (BEST_FIXED, ERGONOMIC, GREEDY, PLANNING)]
        saved = savings(table, pairs, settings, seed)
        fixed_cell, fixed_runs = runs[cell.condition, BEST_FIXED]
        own_runs = runs[cell.condition, SCHEDULE][1]
        costs = np.array([-run.discounted_return for run in own_runs.values()])
        actions = cell.scenario.model.actions
        assert isinstance(cell.settings, PeriodicSettings) and cell.settings.sequence is not None
        plan = tuple(actions.index(name) for name in cell.settings.sequence)
        found.append(
            Worth(
                cell.condition,
                float(costs.mean()),
                standard_error(costs) if costs.size > 1 else 0.0,
                actions[next(iter(fixed_runs.values())).actions[0]],
                {saving.over: saving for saving in saved},
                _spared(_peaks(fixed_cell, fixed_runs), _peaks(cell, own_runs)),
                _misjudged(cell.scenario, plan, longest),
            )
        )
    return found


def _peaks(cell: Cell, runs: Mapping[int, TrialResult]) -> Vector:
    """The highest of the cycles' mean fatigues, (entries,)."""
    courses = [replay(cell, trial, run.actions).fatigue for trial, run in runs.items()]
    return np.asarray(np.mean(courses, axis=0).max(axis=0))


def _spared(fixed: Vector, schedule: Vector) -> dict[str, tuple[float, float]]:
    """Both peaks of every entry that tires, the most spared first."""
    order = np.argsort(schedule - fixed, kind="stable")
    return {ENTRIES[j]: (float(fixed[j]), float(schedule[j])) for j in order if max(fixed[j], schedule[j]) > 0}


def _misjudged(scenario: Scenario, plan: Plan, longest: int) -> dict[str, float]:
    """What the schedule loses with workers that differ from the assumed one in one respect."""
    workers = scenario.model.workers
    k, r, beta = workers.fatigue_rate_factor, workers.recovery_rate_factor, workers.expertise
    others = {
        f"tires {FACTOR:.2f} times as fast": workers._replace(fatigue_rate_factor=k * FACTOR),
        f"tires {1 / FACTOR:.2f} times as fast": workers._replace(fatigue_rate_factor=k / FACTOR),
        f"recovers {FACTOR:.2f} times as fast": workers._replace(recovery_rate_factor=r * FACTOR),
        f"recovers {1 / FACTOR:.2f} times as fast": workers._replace(recovery_rate_factor=r / FACTOR),
        "reacts blindly (novice)": workers._replace(expertise=np.zeros_like(beta)),
        "reacts in the least tiring way (expert)": workers._replace(expertise=np.full_like(beta, np.inf)),
    }
    found, one_way = {}, len(scenario.model.outcomes) == 1
    for name, other in others.items():
        if not np.array_equal(other._replace(expertise=beta) if one_way else other, workers):
            belief = ExactBelief(scenario.model.for_workers(other), scenario.states, scenario.weights)
            own = float(schedule_cost(belief).costs(np.array([plan], dtype=np.intp))[0])
            found[name] = _above(own, best_schedule_for(belief, longest).cost)
    return found

"""What planning with sensing adds over the best schedule: who sees how a worker works can choose places by it.

The worker takes any way that may be used, all equally likely, as the paper's novice does (Eq. 4); the robot sees which.
It looks two cycles ahead over everything that can happen, then values what is left by the best cyclic plans; the
schedule is the best one for the same worker, repeated whatever happens. Both meet the same random choices.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from fatigue_planner.ergonomics.result import Level
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.planners.bounds.cost_bound import bound_of
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.schedules.policy import best_schedule_for
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.fatigue_pomdp import build_pomdp, one_worker
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import Doing, Sensing
from fatigue_planner.station.examine import Examined
from fatigue_planner.station.judging import profile
from fatigue_planner.station.rotation import DISCOUNT, LONGEST, combinations_of
from fatigue_planner.station.schema import Way
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.schedule import start_of
from fatigue_planner.study.statistics.multiple_testing import Pair
from fatigue_planner.study.statistics.savings import savings

# How far the robot looks ahead, how many cycles a run has, and how many runs there are.
DEPTH, CYCLES, TRIALS = 2, 100, 200
# Over so many cycles the cost of every plan is bounded; what comes later is discounted to 4 in 100,000.
BOUND_CYCLES = 200
SEED = 0
SCHEDULE, PLANNING = "schedule", "planning"
POLICIES: dict[str, PolicySettings] = {
    SCHEDULE: PeriodicSettings(kind="periodic", longest=LONGEST),
    PLANNING: LookaheadSettings(kind="lookahead", depth=DEPTH, leaf_value="bound"),
}


def sensing_of(found: Examined, cache: ReactionCache, command: str) -> Sensing | None:
    """What planning with sensing saves of the cost of the best schedule; None where there is no choice of places.

    Raises what `ReactionCache.stream` raises.
    """
    if len(combinations_of(found)) < 2:
        return None
    if all(len(set(ways)) == 1 for worker in found.station.workers for ways in ways_of(found, worker)):
        return Sensing(0.0, 0.0, 0.0, 0.0, certain=True)
    rows, least, scheduled = [], [], []
    for worker in found.station.workers:
        scenario = scenario_of(found, worker, cache, command)
        least.append(bound_of(scenario, BOUND_CYCLES).cost)
        scheduled.append(best_schedule_for(start_of(scenario), LONGEST).cost)
        for name, settings in POLICIES.items():
            cell = Cell(worker, CYCLES, name, settings, scenario, SEED, TRIALS)
            done = cell.run(range(TRIALS))
            rows += [{"policy": name, "trial": trial, "discounted_return": run.discounted_return}
                     for trial, run in done.items()]  # fmt: skip
    # the mean over the workers, trial by trial
    table = pd.DataFrame(rows).groupby(["policy", "trial"], as_index=False)["discounted_return"].mean()
    table = table.assign(condition=found.station.name, n_cycles=CYCLES, deterministic=False)
    (saved,) = savings(table, [Pair(found.station.name, CYCLES, PLANNING, SCHEDULE)], StatisticsSettings(), SEED)
    most = 1 - float(np.sum(least) / np.sum(scheduled)) if np.sum(scheduled) > 0 else 0.0
    return Sensing(saved.share, saved.low, saved.high, max(most, 0.0), certain=False)


def scenario_of(found: Examined, worker: str, cache: ReactionCache, command: str) -> Scenario:
    """The task of a robot that presents one of the best combinations of places in every cycle, to a rested worker."""
    names = [str(index) for index in range(len(combinations_of(found)))]
    known: dict[tuple[Doing, ...], CycleProfile] = {}
    profiles: dict[tuple[str, str], CycleProfile] = {}
    for name, by_way in zip(names, ways_of(found, worker), strict=True):
        for way, doings in zip(found.station.ways, by_way, strict=True):
            if doings not in known:
                known[doings] = profile(found.case(doings, cache, command))
            profiles[name, way] = known[doings]
    rested = np.zeros((1, len(ENTRIES)))
    model = build_pomdp(names, found.station.ways, profiles, rested, one_worker(0.0), DISCOUNT)
    return Scenario(model, np.array([model.state(rested[0])]), np.ones(1), None, ExactSettings(kind="exact"), worker)


def ways_of(found: Examined, worker: str) -> list[tuple[tuple[Doing, ...], ...]]:
    """By combination of places: what the worker does in a cycle for every way of working, as far as it may be used.

    Where a way may not be used, the worker takes the best one there.
    """
    return [
        tuple(_cycle(found, worker, places, way) for way in found.station.ways) for places in combinations_of(found)
    ]


def _cycle(found: Examined, worker: str, places: Sequence[str], way: Way) -> tuple[Doing, ...]:
    at = dict(zip(found.station.operations, places, strict=True))
    best = found.doings(worker, at)
    wished = [Doing(worker, operation, place, way) for operation, place in at.items()]
    return tuple(one if _may_be_used(found, one) else other for one, other in zip(wished, best, strict=True))


def _may_be_used(found: Examined, doing: Doing) -> bool:
    judged = found.judged.get(doing)
    return judged is not None and judged.level < Level.NOT_ACCEPTABLE

"""Another place in every cycle: the best sequence of allowed places, repeated, by the search of `fatplan schedule`."""

import math

import numpy as np

from fatigue_planner.core.settings import MAX_NAME_LENGTH
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.planners.schedules.cost import MeanCost, schedule_cost
from fatigue_planner.planners.schedules.search import best_schedule
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.fatigue_pomdp import build_pomdp, one_worker
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import Rotation
from fatigue_planner.station.examine import Examined
from fatigue_planner.station.judging import profile
from fatigue_planner.station.recommendation import Places
from fatigue_planner.study.schedule import start_of

# A sequence has no more lines than people keep in mind; of many combinations of places, the best are considered.
LONGEST, MOST = 6, 8
# The paper's discount factor of a cycle.
DISCOUNT = 0.95
WAY = "best"


def best_rotation(found: Examined, cache: ReactionCache, command: str) -> Rotation | None:
    """The best sequence of combinations of places, each of which is allowed; None where there is no choice of them."""
    combinations = list(named_combinations(found).values())
    if len(combinations) < 2:
        return None
    scenarios, numbers = rotation_scenarios(found, cache, command), np.arange(len(combinations))
    mean = MeanCost([(schedule_cost(start_of(scenario)), numbers) for scenario in scenarios.values()])
    schedule = best_schedule(mean, len(combinations), LONGEST)
    fixed = float(mean.costs(numbers[:, None]).min())
    saving = 1 - schedule.cost / fixed if fixed > 0 else 0.0
    return Rotation(tuple(combinations[index] for index in schedule.actions), max(saving, 0.0), schedule.exact)


def rotation_scenarios(found: Examined, cache: ReactionCache, command: str) -> dict[str, Scenario]:
    """By worker, the task in which every cycle has an allowed combination of places, each done in the best way.

    Empty if none is allowed.
    """
    combinations, scenarios = named_combinations(found), {}
    for worker in found.station.workers if combinations else ():
        profiles = {
            (name, WAY): profile(found.case(found.doings(worker, places), cache, command))
            for name, places in combinations.items()
        }
        rested = np.zeros((1, len(ENTRIES)))
        model = build_pomdp(list(combinations), (WAY,), profiles, rested, one_worker(math.inf), DISCOUNT)
        state = np.array([model.state(rested[0])])
        scenarios[worker] = Scenario(model, state, np.ones(1), None, ExactSettings(kind="exact"), worker)
    return scenarios


def named_combinations(found: Examined) -> dict[str, dict[str, str]]:
    """The combinations between which planning chooses, by operation, under names that an action may have."""
    named = [dict(zip(found.station.operations, each, strict=True)) for each in combinations_of(found)]
    names = [".".join(places.values()) for places in named]
    if len(set(names)) < len(names) or any(len(name) > MAX_NAME_LENGTH for name in names):
        names = [f"places_{number}" for number in range(1, len(named) + 1)]
    return dict(zip(names, named, strict=True))


def combinations_of(found: Examined) -> list[Places]:
    """The places between which planning chooses: the best of the combinations that are allowed."""
    return [each.places for each in found.ranking[:MOST]]

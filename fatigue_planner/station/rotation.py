"""Another place in every cycle: the best sequence of allowed places, repeated, by the search of `fatplan schedule`."""

import numpy as np

from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.planners.schedules.cost import MeanCost, ScheduleCost, schedule_cost
from fatigue_planner.planners.schedules.search import best_schedule
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import build_pomdp, one_worker
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import Rotation
from fatigue_planner.station.examine import Examined
from fatigue_planner.station.judging import profile
from fatigue_planner.station.recommendation import Places

# A sequence has no more lines than people keep in mind; of many combinations of places, the best are considered.
LONGEST, MOST = 6, 8
# The paper's discount factor of a cycle.
DISCOUNT = 0.95
WAY = "best"


def best_rotation(found: Examined, cache: ReactionCache, command: str) -> Rotation | None:
    """The best sequence of combinations of places, each of which is allowed; None where there is no choice of them."""
    combinations = [dict(zip(found.station.operations, each, strict=True)) for each in combinations_of(found)]
    if len(combinations) < 2:
        return None
    names = [str(index) for index in range(len(combinations))]
    costs: list[tuple[ScheduleCost, np.ndarray]] = []
    for worker in found.station.workers:
        profiles = {
            (name, WAY): profile(found.case(found.doings(worker, places), cache, command))
            for name, places in zip(names, combinations, strict=True)
        }
        rested = np.zeros((1, len(ENTRIES)))
        model = build_pomdp(names, (WAY,), profiles, rested, one_worker(0.0), DISCOUNT)
        belief = ExactBelief(model, np.array([model.state(rested[0])]), np.ones(1))
        costs.append((schedule_cost(belief), np.arange(len(names))))
    mean = MeanCost(costs)
    schedule = best_schedule(mean, len(names), LONGEST)
    fixed = float(mean.costs(np.arange(len(names))[:, None]).min())
    saving = 1 - schedule.cost / fixed if fixed > 0 else 0.0
    return Rotation(tuple(combinations[index] for index in schedule.actions), max(saving, 0.0), schedule.exact)


def combinations_of(found: Examined) -> list[Places]:
    """The places between which planning chooses: the best of the combinations that are allowed."""
    return [each.places for each in found.ranking[:MOST]]

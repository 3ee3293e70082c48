"""Measures of a worker's shift that remember its hours, by body region: ratios of load to acceptable load.

Only the dose is a sum over the slots. What of the others is acceptable depends on all of the shift: the maximum
acceptable effort on the time under load, the cumulative strain index on the order of the tasks by their strain. Neither
fatigue law of the package (Ma, 3CC-r) is here: both forget within minutes.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from fatigue_planner.ergonomics.hand_strain import SAFE
from fatigue_planner.ergonomics.indicators.acceptable_effort import acceptable_effort
from fatigue_planner.ergonomics.indicators.duet import CUT_POINT
from fatigue_planner.ergonomics.lifting_equation import Duration, duration_class
from fatigue_planner.ergonomics.strain_equation import composite_index, hours_multiplier
from fatigue_planner.fatigue.entries import JOINT_GROUPS
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.station.line.demands import PERCENTS, Demand
from fatigue_planner.station.line.spans import Counts, Vector

# The day to which the maximum acceptable effort refers; a shorter shift leaves the rest of it free.
DAY_S = 28_800.0
HOUR_S = 3600.0
# So many spans are computed at a time, for the memory's sake.
CHUNK = 1000

# Counts of slots (n, stations), what each station asks of the worker, and the length of a slot in s, to ratios (n,) by
# body region.
Measure = Callable[[Counts, Sequence[Demand], float], dict[str, Vector]]


def effort_ratios(counts: Counts, demands: Sequence[Demand], slot_s: float) -> dict[str, Vector]:
    """Effort over the maximum acceptable effort (Potvin 2012) of the joints: duty cycles add up over the shift.

    As in the indicator: for every x, the time with a load of at least x has to be acceptable for x.
    """
    duty = np.stack([demand.duty for demand in demands]) * slot_s / DAY_S
    found = {group: np.zeros(len(counts)) for group in JOINT_GROUPS}
    for group, indices in JOINT_GROUPS.items():
        loaded = [index for index in indices if duty[:, index].any()]
        own = duty[:, loaded].reshape(len(demands), -1)
        percent = np.tile(PERCENTS, len(loaded))
        for start in range(0, len(counts) if loaded else 0, CHUNK):
            whole = np.minimum(counts[start : start + CHUNK] @ own, 1.0)
            ratio = np.where(whole > 0, percent / 100 / acceptable_effort(whole), 0.0)
            found[group][start : start + CHUNK] = ratio.max(axis=1)
    return found


def dose_ratios(counts: Counts, demands: Sequence[Demand], slot_s: float) -> dict[str, Vector]:
    """The dose of damage over DUET's cut point (Gallagher et al. 2018): a sum over all cycles of the shift."""
    per_slot = {
        region: np.array([demand.dose[region] * slot_s / demand.cycle_s for demand in demands])
        for region in demands[0].dose
    }
    return {region: np.asarray(counts @ dose) / CUT_POINT for region, dose in per_slot.items()}


def strain_ratios(counts: Counts, demands: Sequence[Demand], slot_s: float) -> dict[str, Vector]:
    """The cumulative strain index of the hands (Garg, Moore & Kapellusch 2017) over 10.

    As `cumulative_index` for every row of counts at once: the worst first, then what each other adds by its hours.
    """
    hours = slot_s / HOUR_S * np.arange(1, 1 + counts.sum(axis=1).max(initial=1))
    multiplier = np.array([0.0, *map(hours_multiplier, hours)])
    found: dict[str, Vector] = {}
    for side in SIDES:
        composite = np.array([[0.0, *(composite_index(demand.efforts[side], h) for h in hours)] for demand in demands])
        at_work = np.array([bool(demand.efforts[side]) for demand in demands])
        index = np.zeros(len(counts))
        for start in range(0, len(counts), CHUNK):
            own = counts[start : start + CHUNK] * at_work
            at_each = composite[np.arange(len(demands)), own]
            worst_first = np.argsort(-at_each, axis=1, kind="stable")
            at_each, own = (np.take_along_axis(values, worst_first, axis=1) for values in (at_each, own))
            added = np.diff(multiplier[np.cumsum(own, axis=1)], axis=1, prepend=0.0)
            # where no slot is, nothing is added
            index[start : start + CHUNK] = (at_each / multiplier[np.maximum(own, 1)] * added).sum(axis=1)
        found[f"{side}_hand"] = index / SAFE
    return found


MEASURES: Mapping[str, Measure] = {
    "acceptable_effort": effort_ratios,
    "dose": dose_ratios,
    "cumulative_strain_index": strain_ratios,
}


def largest(ratios: Mapping[str, Vector]) -> Vector:
    """The largest ratio of any body region, (n,)."""
    return np.asarray(np.max(np.stack(list(ratios.values())), axis=0))


def lifting_class(
    places: Sequence[int], lifting: Sequence[bool], slots_h: Sequence[tuple[float, float]]
) -> Duration | None:
    """NIOSH's duration class of a worker's shift; None: more than 8 h of lifting. "short" without any lifting.

    places: the station of each slot, -1 where free; lifting: by station, whether it lifts; slots_h: of each slot its
    length and the break after it in h. Slots in which nothing is lifted are light work, which counts as rest.
    """
    sessions: list[tuple[float, float]] = []
    for place, (work_h, break_h) in zip(places, slots_h, strict=True):
        lifts = place >= 0 and lifting[place]
        if lifts:
            sessions.append((work_h, break_h))
        elif sessions:
            sessions[-1] = (sessions[-1][0], sessions[-1][1] + work_h + break_h)
    return duration_class(sessions)

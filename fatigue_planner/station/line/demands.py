"""What a station asks of a worker, cycle by cycle, as far as measures need it that remember the hours of a shift."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.ergonomics.hand_strain import effort_of
from fatigue_planner.ergonomics.held_posture import working
from fatigue_planner.ergonomics.indicators.acceptable_effort import LEAST_SHARE
from fatigue_planner.ergonomics.indicators.duet import dose_per_cycle
from fatigue_planner.ergonomics.indicators.holding_time import entry_shares
from fatigue_planner.ergonomics.indicators.niosh_lifting import LIFTED
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.strain_equation import Effort
from fatigue_planner.fatigue.entries import ENTRIES, JOINT_GROUPS
from fatigue_planner.human.skeleton import SIDES

Array = NDArray[np.float64]

# Loads are rounded up to whole percents of the strength, from those that count as load on.
PERCENTS = np.arange(round(100 * LEAST_SHARE), 101)
# The OMNI-RES rating that a whole strength is.
WHOLE_STRENGTH = 10.0


@dataclass(frozen=True)
class Demand:
    """What one cycle of a station asks of a worker.

    cycle_s  from one beginning of the cycle to the next
    duty     share of the cycle's time in which each entry of the fatigue state bears at least so many PERCENTS of its
        strength, (2N, percents)
    efforts  by side, the efforts of the hand as the strain index counts them
    dose     by body region the damage of a cycle: DUET's of the hands as `<side>_hand`; of the joints by the same
        curve, with the largest load during the work as the rating (assumed: DUET is for hands)
    lifts    whether it is stated that a load is lifted or lowered
    """

    cycle_s: float
    duty: Array
    efforts: Mapping[str, tuple[Effort, ...]]
    dose: Mapping[str, float]
    lifts: bool = False

    @classmethod
    def of(cls, job: Job) -> "Demand":
        """That of the operations of a cycle. Inputs that are not stated count as in the indicators at their low end."""
        dose = dict.fromkeys(JOINT_GROUPS, 0.0) | {f"{side}_hand": 0.0 for side in SIDES}
        for operation in job.operations:
            for group, load in region_loads(operation).items():
                rated = operation.stated.model_copy(update={"omni_effort": WHOLE_STRENGTH * min(load, 1.0)})
                changed = Operation(operation.name, operation.request, operation.motion, rated, operation.step_s)
                if load >= LEAST_SHARE:
                    dose[group] += dose_per_cycle(changed, 0.0)
        for side in SIDES:
            dose[f"{side}_hand"] = sum(dose_per_cycle(one, 0.0) for one in job.working_with(side))
        efforts = {
            side: tuple(effort_of(one, side, job.cycle_s, 0.0) for one in job.working_with(side)) for side in SIDES
        }
        lifts = any(operation.stated.handling in LIFTED for operation in job.operations)
        return cls(job.cycle_s, duty_of(job), efforts, dose, lifts)


def duty_of(job: Job) -> Array:
    """See Demand.duty."""
    duty = np.zeros((len(ENTRIES), len(PERCENTS)))
    for operation in job.operations:
        percent = np.ceil(100 * entry_shares(operation) - 1e-9)
        percent[percent < PERCENTS[0]] = 0
        share = operation.seconds_per_cycle / job.cycle_s / len(percent)
        duty += share * (np.minimum(percent, PERCENTS[-1])[..., None] >= PERCENTS).sum(axis=0)
    return np.minimum(duty, 1.0)


def region_loads(operation: Operation) -> dict[str, float]:
    """By group of joints, the largest load of any of its entries during the work, as a share of its strength."""
    largest = entry_shares(operation)[working(operation)].max(axis=0, initial=0.0)
    return {group: float(largest[indices].max()) for group, indices in JOINT_GROUPS.items()}

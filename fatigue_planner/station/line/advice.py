"""What a rotation gains: the best rota beside staying and beside going on every hour, what pauses are worth, and where
no rotation helps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fatigue_planner.station.line.demands import Demand
from fatigue_planner.station.line.measures import HOUR_S, MEASURES, largest
from fatigue_planner.station.line.program import TOLERANCE, Rota, best_rota, counts_of, least_burden
from fatigue_planner.station.line.slots import FREE
from fatigue_planner.station.line.spans import Counts, Crew, Vector

# A gain below this share is none: it is less than the rounding of loads to whole percents.
NO_GAIN = 0.01
# Up to this ratio of load to acceptable load a shift is acceptable.
ACCEPTABLE = 1.0


@dataclass(frozen=True)
class LineLoad:
    """A shift at a line, in numbers.

    demands   by worker and station what a cycle asks of the worker; None where he or she may not work
    slots     how many slots the working time is divided into, slot_s long each
    measure   the kind of the measure: a key of MEASURES
    """

    demands: Sequence[Sequence[Demand | None]]
    slots: int
    slot_s: float
    measure: str

    def crew(self) -> Crew:
        """The crew with its burdens. Raises ValueError if there are fewer workers than stations."""
        may = np.array([[demand is not None for demand in own] for own in self.demands])
        return Crew.of(self.slots, may, [self.burden(worker) for worker in range(len(self.demands))])

    def without_load(self, station: int) -> "LineLoad":
        """The same line if that station asked nothing of anybody."""
        return replace(self, demands=[
            [_eased(demand) if index == station else demand for index, demand in enumerate(own)]
            for own in self.demands
        ])  # fmt: skip

    def burden(self, worker: int) -> "_Burden":
        """The burden of a worker."""
        return _Burden(self, self.known(worker))

    def known(self, worker: int) -> list[Demand]:
        """What each station asks; where the worker may not work, anything, as it is never counted. Empty: nowhere."""
        own = self.demands[worker]
        any_ = next((demand for demand in own if demand is not None), None)
        return [] if any_ is None else [demand or any_ for demand in own]


@dataclass(frozen=True)
class _Burden:
    line: LineLoad
    demands: Sequence[Demand]

    def __call__(self, counts: Counts) -> Vector:
        """The largest ratio of any region; a station that is not allowed has no slot in any of the counts."""
        if not self.demands:
            return np.zeros(len(counts))
        return largest(MEASURES[self.line.measure](counts, self.demands, self.line.slot_s))


def _eased(demand: Demand | None) -> Demand | None:
    if demand is None:
        return None
    nothing = dict.fromkeys(demand.dose, 0.0)
    return replace(demand, duty=np.zeros_like(demand.duty), efforts=dict.fromkeys(demand.efforts, ()), dose=nothing)


@dataclass(frozen=True)
class Advice:
    """What is to be said of rotation at a line. Burdens are ratios of load to acceptable load, of the worst worker.

    best       the best rota
    staying    the burden if everybody stays where it is best for the crew; None if nobody can stay
    usual      the burden if everybody goes on to the next station every hour; None if that sends somebody where he or
        she may not work
    too_much   stations of which one slot alone, and nothing else all shift, is too much for all who may work there
    redesign   the station without whose load the burden falls most, and the burden then; None if the burden is
        acceptable
    """

    best: Rota
    staying: float | None
    usual: float | None
    too_much: tuple[int, ...]
    redesign: tuple[int, float] | None

    @property
    def helps(self) -> bool:
        """Whether rotation lowers the burden, and no station is too much for everybody in any share."""
        gains = self.staying is None or self.best.largest < self.staying * (1 - NO_GAIN)
        return gains and not self.too_much


def advise(line: LineLoad) -> Advice | None:
    """The advice for a line; None if its stations cannot be manned. Raises ValueError as LineLoad.crew."""
    crew = line.crew()
    best = best_rota(crew)
    if best is None:
        return None
    moving = (crew.spans > 0).sum(axis=1) + (crew.spans.sum(axis=1) < crew.slots) > 1
    staying = least_burden(replace(crew, burden=np.where(moving, np.inf, crew.burden)))
    usual = burden_of(line, usual_places(crew.workers, crew.stations, line.slots, line.slot_s))
    redesign = None
    if best.largest > ACCEPTABLE:
        # the hardest first: then few others have to be looked at closely
        for station in np.argsort([-alone for alone in slots_alone(line)], kind="stable").tolist():
            eased = least_burden(line.without_load(station).crew(), np.inf if redesign is None else redesign[1])
            redesign = redesign if eased is None else (station, eased)
    return Advice(best, staying, usual, too_much(line), redesign)


def usual_places(workers: int, stations: int, slots: int, slot_s: float) -> Counts:
    """Every hour of work to the next station, (workers, slots); after the last one free, as far as workers are more.

    Who goes on does so at the end of the slot that is nearest to the hour; of longer slots, at the end of each.
    """
    hour = np.ceil(np.arange(slots) * slot_s / HOUR_S - 0.5 - TOLERANCE)
    moves = np.cumsum(np.diff(hour, prepend=0) > 0)
    place = (np.arange(workers)[:, None] + moves) % workers
    return np.where(place < stations, place, FREE)


def burden_of(line: LineLoad, places: Counts) -> float | None:
    """The largest burden of a worker with some rota, (workers, slots); None where it is not allowed."""
    worst = 0.0
    for worker, row in enumerate(counts_of(places, len(line.demands[0]))):
        if any(n and line.demands[worker][station] is None for station, n in enumerate(row)):
            return None
        worst = max(worst, float(line.burden(worker)(row[None, :])[0]))
    return worst


def too_much(line: LineLoad) -> tuple[int, ...]:
    """The stations of which a single slot is more than acceptable to everybody who may work there."""
    return tuple(station for station, alone in enumerate(slots_alone(line)) if alone > ACCEPTABLE)


def slots_alone(line: LineLoad) -> list[float]:
    """By station the burden of a single slot there, and nothing else all shift, for whom it is least; 0: nobody may."""
    once = np.eye(len(line.demands[0]), dtype=np.int64)
    return [
        min(
            (float(line.burden(w)(row[None])[0]) for w, own in enumerate(line.demands) if own[station] is not None),
            default=0.0,
        )
        for station, row in enumerate(once)
    ]


def pause_worth(line: LineLoad, places: Counts, pause_s: float) -> float:
    """By what share of itself the burden of a rota rises without a pause, whose time is then worked in all slots."""
    with_pause, without = (
        burden_of(line, places),
        burden_of(replace(line, slot_s=line.slot_s + pause_s / line.slots), places),
    )
    if not with_pause or without is None:
        return 0.0
    return without / with_pause - 1

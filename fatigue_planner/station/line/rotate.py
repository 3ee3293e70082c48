"""Rotation at a line: every worker is simulated at every station, once, then rotas are compared."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.examine import Examined, examine
from fatigue_planner.station.judging import stated
from fatigue_planner.station.line.advice import Advice, LineLoad, advise, pause_worth
from fatigue_planner.station.line.demands import Demand
from fatigue_planner.station.line.loader import LoadedLine
from fatigue_planner.station.line.measures import MEASURES
from fatigue_planner.station.line.program import counts_of
from fatigue_planner.station.line.slots import FREE
from fatigue_planner.station.outcomes import Task, tasks_of


@dataclass(frozen=True)
class CrewRotation:
    """What is to be said of rotation at a line.

    cannot   by worker the stations where he or she cannot or may not work: out of reach, too weak, or stated
    advice   the best rota beside others; None if the stations cannot be manned
    ratios   by worker, measure and body region the ratio of load to acceptable load of the best rota
    pauses   by what share of itself the largest burden of the best rota rises without each break of the shift
    """

    line: LoadedLine
    cannot: Mapping[str, tuple[str, ...]]
    advice: Advice | None
    ratios: Mapping[str, Mapping[str, Mapping[str, float]]]
    pauses: tuple[float, ...]

    def place(self, worker: int, slot: int) -> str:
        """The name of the station where a worker is in a slot; empty where free."""
        assert self.advice is not None
        number = int(self.advice.best.places[worker, slot])
        return "" if number == FREE else list(self.line.stations)[number]


def motions_of(line: LoadedLine) -> list[list[Task]]:
    """The motions of every station."""
    return [tasks_of(station) for station in line.stations.values()]


def rotation_of(
    line: LoadedLine,
    tasks: Sequence[Sequence[Task]],
    cache: ReactionCache,
    executor: Executor,
    command: str,
    progress: Callable[[Simulated], None],
) -> CrewRotation:
    """Everything that is to be said of rotation; motions are found in the cache or simulated.

    Raises what `examine` raises.
    """
    found = examine(list(line.stations.values()), cache, executor, command, progress, tasks)
    by_station = dict(zip(line.stations, found, strict=True))
    demands = [
        [
            None
            if station in member.not_at
            else demand_of(by_station[station], worker, line.cycle_s(station), cache, command)
            for station in line.stations
        ]
        for worker, member in line.line.crew.items()
    ]
    load = LineLoad(demands, line.line.slots, line.line.slot_s, line.line.measure)
    cannot = {
        worker: tuple(station for station, demand in zip(line.stations, own, strict=True) if demand is None)
        for worker, own in zip(line.line.crew, demands, strict=True)
    }
    advice = advise(load)
    if advice is None:
        return CrewRotation(line, cannot, None, {}, ())
    places = advice.best.places
    ratios = {}
    for number, worker in enumerate(line.line.crew):
        counts, own = counts_of(places, len(line.stations))[[number]], load.known(number)
        ratios[worker] = {
            kind: {region: float(values[0]) for region, values in measure(counts, own, load.slot_s).items()}
            if own
            else {}
            for kind, measure in (MEASURES.items() if own else ())
        }
    worth = partial(pause_worth, load, places)
    return CrewRotation(line, cannot, advice, ratios, tuple(worth(60 * one.minutes) for one in line.line.shift.breaks))


def demand_of(found: Examined, worker: str, cycle_s: float, cache: ReactionCache, command: str) -> Demand | None:
    """What a cycle asks of a worker at the places that are recommended, or else at the own best; None if out of reach.

    Raises what `ReactionCache.stream` raises.
    """
    doings = found.doings(worker, found.best.places)
    if not doings:
        return None
    case = found.case(doings, cache, command)
    operations = tuple(
        Operation(doing.operation, task.request.motion, reaction.motion, stated(found.station, doing.operation))
        for doing, task, reaction in zip(doings, case.tasks, case.reactions(), strict=True)
    )
    return Demand.of(Job(operations, Shift(cycle_s=cycle_s)))

"""Rotation at a line: every worker is simulated at every station, once, then rotas are compared."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.ergonomics.lifting_equation import Duration
from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.examine import examine
from fatigue_planner.station.line.advice import Advice, LineLoad, advise, pause_worth
from fatigue_planner.station.line.loader import LoadedLine
from fatigue_planner.station.line.measures import MEASURES, lifting_class
from fatigue_planner.station.line.posts import STATED, Post, post_of
from fatigue_planner.station.line.program import counts_of
from fatigue_planner.station.line.schema import MINUTES
from fatigue_planner.station.line.slots import FREE
from fatigue_planner.station.line.spans import Counts
from fatigue_planner.station.outcomes import Task, tasks_of


@dataclass(frozen=True)
class Lifting:
    """For how long a worker is at stations where loads are lifted or lowered.

    duration  NIOSH's class of these hours; None: more than 8 h, for which the equation is not
    judged    what the equation then says of each of these stations alone
    """

    hours: float
    duration: Duration | None
    judged: Mapping[str, Judgement] = field(default_factory=dict)


@dataclass(frozen=True)
class CrewRotation:
    """What is to be said of rotation at a line.

    posts    by worker and station what the work there asks, or why it cannot be done
    advice   the best rota beside others; None if the stations cannot be manned
    ratios   by worker, measure and body region the ratio of load to acceptable load of the best rota
    lifting  by worker who lifts or lowers loads, for how many h of the best rota, and what that makes of the lifts
    pauses   by what share of itself the largest burden of the best rota rises without each break of the shift
    """

    line: LoadedLine
    posts: Mapping[str, Mapping[str, Post]]
    advice: Advice | None
    ratios: Mapping[str, Mapping[str, Mapping[str, float]]]
    lifting: Mapping[str, Lifting]
    pauses: tuple[float, ...]

    @property
    def cannot(self) -> dict[str, tuple[str, ...]]:
        """By worker the stations where he or she cannot or may not work."""
        return {
            worker: tuple(station for station, post in own.items() if post.demand is None)
            for worker, own in self.posts.items()
        }

    @property
    def lifted(self) -> dict[str, Judgement]:
        """By station where loads are lifted or lowered NIOSH's lifting index with the hours of the rota, of the worker
        for whom it is worst.
        """
        found: dict[str, Judgement] = {}
        for own in self.lifting.values():
            for station, judgement in own.judged.items():
                if station not in found or _index(judgement) > _index(found[station]):
                    found[station] = judgement
        return found

    def place(self, worker: int, slot: int) -> str:
        """The name of the station where a worker is in a slot; empty where free."""
        assert self.advice is not None
        number = int(self.advice.best.places[worker, slot])
        return "" if number == FREE else list(self.line.stations)[number]


def _index(judgement: Judgement) -> float:
    return -1.0 if judgement.value is None else judgement.value.high


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
    posts = {
        worker: {
            station: STATED
            if station in member.not_at
            else post_of(
                by_station[station], worker, line.cycle_s(station), cache, command, line.line.forbidden == "left_out"
            )
            for station in line.stations
        }
        for worker, member in line.line.crew.items()
    }
    demands = [[post.demand for post in own.values()] for own in posts.values()]
    load = LineLoad(demands, line.line.slots, line.line.slot_s, line.line.measure)
    advice = advise(load)
    if advice is None:
        return CrewRotation(line, posts, None, {}, {}, ())
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
    pauses = tuple(worth(60 * one.minutes) for one in line.line.shift.breaks)
    return CrewRotation(line, posts, advice, ratios, lifting_of(line, posts, places), pauses)


def lifting_of(line: LoadedLine, posts: Mapping[str, Mapping[str, Post]], places: Counts) -> dict[str, Lifting]:
    """See CrewRotation.lifting; places: a rota."""
    pieces = [(slot, *span) for slot, spans in enumerate(line.line.slot_times()) for span in spans]
    begins = [begin for _, begin, _ in pieces[1:]] + [MINUTES * line.line.shift.hours]
    times_h = [((end - begin) / MINUTES, (after - end) / MINUTES)
               for (_, begin, end), after in zip(pieces, begins, strict=True)]  # fmt: skip
    found = {}
    for (worker, own), row in zip(posts.items(), places, strict=True):
        lifts = [post.demand is not None and post.demand.lifts for post in own.values()]
        where = [int(row[slot]) for slot, _, _ in pieces]
        hours = sum(work_h for place, (work_h, _) in zip(where, times_h, strict=True) if place >= 0 and lifts[place])
        if hours:
            duration = lifting_class(where, lifts, times_h)
            judged = {
                station: post.lifting[duration]
                for number, (station, post) in enumerate(own.items())
                if duration is not None and duration in post.lifting and number in where
            }
            found[worker] = Lifting(hours, duration, judged)
    return found

"""The assessment of a station: what was examined, who of a population can, what would help, and what to say first."""

from collections.abc import Callable
from dataclasses import dataclass

from fatigue_planner import __version__
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.files import digest_of
from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import StationAssessment, WholeCycle
from fatigue_planner.station.changes import changed_stations, changes_of
from fatigue_planner.station.examine import Examined, examine
from fatigue_planner.station.judging import judge
from fatigue_planner.station.kept_shares import reach_shares
from fatigue_planner.station.outcomes import Task, tasks_of
from fatigue_planner.station.robot_reach import robot_finding
from fatigue_planner.station.rotation import best_rotation
from fatigue_planner.station.schema import Station
from fatigue_planner.station.sensing import sensing_of
from fatigue_planner.station.statements import assumptions_of, headline_of
from fatigue_planner.station.workers import facts_of


@dataclass(frozen=True)
class Plan:
    """What is to be examined: a station and, if that is asked for, what it is with one thing changed; all motions."""

    stations: tuple[Station, ...]
    changes: tuple[Phrase, ...]
    tasks: tuple[tuple[Task, ...], ...]


def planned(station: Station, with_changes: bool = False) -> Plan:
    """The plan of an assessment; with_changes: also what single changes of the station would do."""
    changed = changed_stations(station) if with_changes else []
    stations = (station, *(each for _, each in changed))
    return Plan(stations, tuple(phrase for phrase, _ in changed), tuple(tuple(tasks_of(each)) for each in stations))


def assess(
    plan: Plan,
    cache: ReactionCache,
    executor: Executor,
    command: str,
    progress: Callable[[Simulated], None] = lambda _: None,
    asked: Callable[[], None] = lambda: None,
) -> StationAssessment:
    """Everything that is to be said of a station.

    Motions are found in the cache or simulated. command: what makes them, for messages; asked: hears of every place and
    sex of the population that is done.

    Raises OutputFolderError if the cache cannot be written, DamagedFileError if what was written is damaged.
    """
    station = plan.stations[0]
    found, *others = examine(plan.stations, cache, executor, command, progress, plan.tasks)
    cycles = whole_cycles(found, cache, command)
    return StationAssessment(
        station=station,
        workers=tuple(facts_of(station, name) for name in station.workers),
        outcomes=tuple(found.outcomes),
        judged=tuple(found.judged.values()),
        places=tuple(found.places),
        summaries=tuple(found.summaries),
        best=found.best,
        cycles=cycles,
        shares=tuple(reach_shares(station, cache.folder, executor, asked)),
        changes=changes_of(plan.changes, found, others),
        rotation=best_rotation(found, cache, command),
        sensing=sensing_of(found, cache, command),
        headline=headline_of(station, found.places, found.summaries, found.best, cycles),
        assumptions=assumptions_of(station),
        station_digest=digest_of(station.plain()),
        version=__version__,
        robot=robot_finding(station, tuple(found.robot)),
    )


def whole_cycles(found: Examined, cache: ReactionCache, command: str) -> tuple[WholeCycle, ...]:
    """The whole cycle of every worker who can do all operations: at the recommended places, or else at the own best."""
    cycles = []
    for worker in found.station.workers:
        if doings := found.doings(worker, found.best.places):
            several = len(doings) > 1
            verdict = judge(found.case(doings, cache, command)) if several else found.verdicts[doings[0]]
            recommended = bool(found.best.places)
            cycles.append(WholeCycle(worker, doings, recommended, verdict.level, verdict.fatigue, verdict.judgements))
    return tuple(cycles)

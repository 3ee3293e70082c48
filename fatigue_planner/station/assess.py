"""The assessment of a station: simulate, judge, recommend, and say the most important first."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fatigue_planner import __version__
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.files import digest_of
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import (
    BestPlaces,
    Doing,
    Judged,
    Outcome,
    PlaceForWorker,
    StationAssessment,
    WholeCycle,
)
from fatigue_planner.station.judging import Case, Verdict, judged
from fatigue_planner.station.outcomes import Task, simulate_all, tasks_of
from fatigue_planner.station.population_reach import reach_shares
from fatigue_planner.station.recommendation import places_for_workers, recommend, summaries
from fatigue_planner.station.schema import Station
from fatigue_planner.station.statements import assumptions_of, headline_of
from fatigue_planner.station.workers import facts_of


def assess(
    station: Station,
    cache: ReactionCache,
    executor: Executor,
    command: str,
    progress: Callable[[Simulated], None] = lambda _: None,
) -> StationAssessment:
    """Everything that is to be said of a station.

    Motions are found in the cache or simulated. command: what makes them, for messages. Raises OutputFolderError if the
    cache cannot be written, DamagedFileError if what was written is damaged.
    """
    tasks = {task.doing: task for task in tasks_of(station)}
    outcomes = simulate_all(list(tasks.values()), cache, executor, progress)
    reached = [tasks[each.doing] for each in outcomes if each.kind == "reached"]
    cases = [Case(station, (task,), cache.folder, command) for task in reached]
    verdicts = {reached[index].doing: verdict for index, verdict in judged(cases, executor)}
    outcomes = [_with_breaches(each, verdicts) for each in outcomes]
    alone = {each.doing: _judged(each, verdicts[each.doing]) for each in outcomes if each.usable}
    courses = {doing: verdicts[doing].courses[0] for doing in alone}
    places = places_for_workers(station, outcomes, alone)
    summary, best = summaries(station, places, alone), recommend(station, places, alone, courses)
    cycles = whole_cycles(station, places, best, tasks, verdicts, (cache.folder, command, executor))
    facts = tuple(facts_of(station, name) for name in station.workers)
    shares = reach_shares(station, executor)
    return StationAssessment(
        station=station,
        workers=facts,
        outcomes=tuple(outcomes),
        judged=tuple(alone[each.doing] for each in outcomes if each.doing in alone),
        places=tuple(places),
        summaries=tuple(summary),
        best=best,
        cycles=tuple(cycles),
        shares=tuple(shares),
        changes=(),
        rotation=None,
        headline=headline_of(station, places, summary, best, cycles),
        assumptions=assumptions_of(station),
        station_digest=digest_of(station.plain()),
        version=__version__,
    )


def _with_breaches(outcome: Outcome, verdicts: Mapping[Doing, Verdict]) -> Outcome:
    if outcome.doing not in verdicts:
        return outcome
    return replace(outcome, breaches=verdicts[outcome.doing].breaches)


def _judged(outcome: Outcome, verdict: Verdict) -> Judged:
    return Judged(outcome.doing, verdict.level, verdict.by, verdict.fatigue, verdict.judgements)


def whole_cycles(
    station: Station,
    places: Sequence[PlaceForWorker],
    best: BestPlaces,
    tasks: Mapping[Doing, Task],
    verdicts: Mapping[Doing, Verdict],
    store: tuple[Path, str, Executor],
) -> list[WholeCycle]:
    """The whole cycle of every worker who can do all operations: at the recommended places, or else at the own best."""
    chosen = {worker: _doings(station, places, best, verdicts, worker) for worker in station.workers}
    able = {worker: doings for worker, doings in chosen.items() if doings}
    folder, command, executor = store
    several = [worker for worker, doings in able.items() if len(doings) > 1]
    cases = [Case(station, tuple(tasks[doing] for doing in able[worker]), folder, command) for worker in several]
    together = {several[index]: verdict for index, verdict in judged(cases, executor)}
    found = []
    for worker, doings in able.items():
        verdict = together.get(worker) or verdicts[doings[0]]
        found.append(WholeCycle(worker, doings, bool(best.places), verdict.level, verdict.fatigue, verdict.judgements))
    return found


def _doings(
    station: Station, places: Sequence[PlaceForWorker], best: BestPlaces, verdicts: Mapping[Doing, Verdict], worker: str
) -> tuple[Doing, ...]:
    """What a worker does in a cycle; nothing if there is an operation that he or she cannot do anywhere."""
    doings = []
    for operation in station.operations:
        own = [each for each in places if (each.worker, each.operation) == (worker, operation) and each.way is not None]
        if best.places:
            own = [each for each in own if each.place == best.places[operation]]
        if not own:
            return ()
        found = [(verdicts[each.outcome.doing], each.outcome.doing) for each in own]
        doings.append(min(found, key=lambda pair: (pair[0].level, pair[0].fatigue.cost))[1])
    return tuple(doings)

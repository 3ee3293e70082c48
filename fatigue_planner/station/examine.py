"""Examine a station: simulate every motion, judge those that are reached, and recommend places."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import (
    BestPlaces,
    Doing,
    Judged,
    Outcome,
    PlaceForWorker,
    PlaceSummary,
    RobotPlace,
)
from fatigue_planner.station.judging import Case, Verdict, judge
from fatigue_planner.station.outcomes import Task, simulate_all, tasks_of
from fatigue_planner.station.recommendation import Considered, best_of, excluded, places_for_workers, ranked, summaries
from fatigue_planner.station.robot_reach import robot_places, ruled_out
from fatigue_planner.station.schema import Station

# So many combinations of places that are allowed as whole cycles are looked for, from the least tiring one on.
ENOUGH = 20
FORBIDDEN_TOGETHER = (
    "The operations together are not acceptable for {worker} by {rules}, wherever they are done, each in the way "
    "that is best alone"
)


@dataclass(frozen=True)
class Examined:
    """A station with the outcome of every motion, what is to be said of it, and what follows.

    verdicts: of the motions that are reached; judged: of those that may be used; ranking: of the combinations of places
    that are allowed, the best first.
    """

    station: Station
    tasks: Mapping[Doing, Task]
    outcomes: Sequence[Outcome]
    verdicts: Mapping[Doing, Verdict]
    judged: Mapping[Doing, Judged]
    places: Sequence[PlaceForWorker]
    summaries: Sequence[PlaceSummary]
    ranking: Sequence[Considered]
    best: BestPlaces
    robot: Sequence[RobotPlace] = ()

    def doings(self, worker: str, places: Mapping[str, str]) -> tuple[Doing, ...]:
        """What a worker does in a cycle at some places, each in the best way; nothing where one cannot be reached.

        Operations without a place are done at the worker's own best.
        """
        found, out = [], ruled_out(self.robot)
        for operation in self.station.operations:
            own = [each for each in self.places if (each.worker, each.operation) == (worker, operation)]
            own = [each for each in own if (operation, each.place) not in out]
            own = [each for each in own if each.way is not None and places.get(operation, each.place) == each.place]
            if not own:
                return ()
            verdicts = [(self.verdicts[each.outcome.doing], each.outcome.doing) for each in own]
            found.append(min(verdicts, key=lambda pair: (pair[0].level, pair[0].fatigue.cost))[1])
        return tuple(found)

    def case(self, doings: Sequence[Doing], cache: ReactionCache, command: str) -> Case:
        """These motions as a cycle to be judged."""
        return Case(self.station, tuple(self.tasks[doing] for doing in doings), cache, command)


def examine(
    stations: Sequence[Station],
    cache: ReactionCache,
    executor: Executor,
    command: str,
    progress: Callable[[Simulated], None],
    known: Sequence[Sequence[Task]] | None = None,
) -> list[Examined]:
    """Examine stations, all their motions at once; known: the motions of each, where they were made out already.

    Raises OutputFolderError if the cache cannot be written, DamagedFileError if what was written is damaged.
    """
    tasks = [tasks_of(station) for station in stations] if known is None else known
    outcomes = iter(simulate_all([task for own in tasks for task in own], cache, executor, progress))
    return [
        _examined(station, own, [next(outcomes) for _ in own], cache, command)
        for station, own in zip(stations, tasks, strict=True)
    ]


def _examined(
    station: Station, tasks: Sequence[Task], outcomes: Sequence[Outcome], cache: ReactionCache, command: str
) -> Examined:
    reached = [task for task, outcome in zip(tasks, outcomes, strict=True) if outcome.kind == "reached"]
    verdicts = {task.doing: judge(Case(station, (task,), cache, command)) for task in reached}
    outcomes = [
        replace(each, breaches=verdicts[each.doing].breaches) if each.doing in verdicts else each for each in outcomes
    ]
    alone = {each.doing: _judged(each, verdicts[each.doing]) for each in outcomes if each.usable}
    courses = {doing: verdicts[doing].courses[0] for doing in alone}
    places = places_for_workers(station, outcomes, alone)
    robot = robot_places(station, reached, cache, command)
    out = {**ruled_out(robot), **excluded(station, places, alone)}
    found = Examined(
        station,
        {task.doing: task for task in tasks},
        outcomes,
        verdicts,
        alone,
        places,
        summaries(station, places, alone),
        ranked(station, places, out, courses),
        best_of(station, (), out, None),
        robot,
    )
    ranking, together = _allowed_together(found, cache, command)
    return replace(found, ranking=ranking, best=best_of(station, ranking, out, together))


def _allowed_together(found: Examined, cache: ReactionCache, command: str) -> tuple[list[Considered], Phrase | None]:
    """Of the combinations that tire least, those whose whole cycle no rule forbids to any worker; if none, the rules.

    A rule may forbid a cycle whose operations it allows one by one: it adds up how often a posture is taken.
    """
    if len(found.station.operations) == 1:
        return list(found.ranking), None
    allowed, forbidden = [], None
    for each in found.ranking:
        places = dict(zip(found.station.operations, each.places, strict=True))
        for worker in found.station.workers:
            verdict = judge(found.case(found.doings(worker, places), cache, command))
            if verdict.level == Level.NOT_ACCEPTABLE:
                rules = ", ".join(rule.title for rule in verdict.by)
                forbidden = forbidden or Phrase(FORBIDDEN_TOGETHER, {"worker": worker, "rules": rules})
                break
        else:
            allowed.append(each)
        if len(allowed) == ENOUGH:
            break
    return allowed, None if allowed else forbidden


def _judged(outcome: Outcome, verdict: Verdict) -> Judged:
    return Judged(outcome.doing, verdict.level, verdict.by, verdict.warned_by, verdict.fatigue, verdict.judgements)

"""A worker at a station of a line: what the work there asks, or why he or she cannot do it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from fatigue_planner.ergonomics.indicators.niosh_lifting import NioshLifting
from fatigue_planner.ergonomics.lifting_equation import LONGEST_H, Duration
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assessment import Fatigue
from fatigue_planner.station.examine import Examined
from fatigue_planner.station.judging import judge, stated
from fatigue_planner.station.line.demands import Demand
from fatigue_planner.station.robot_reach import ruled_out
from fatigue_planner.station.statements import rules_named, why_not


@dataclass(frozen=True)
class Post:
    """A worker at a station, at the places that are recommended there, or else at the own best.

    demand     what a cycle asks of the worker; None if he or she cannot or does not work there
    why_not    why the worker cannot; empty if that is only stated
    level      the worst level of the whole cycle that is certain by a binding indicator
    rules      the indicators that forbid the cycle even so; empty if none does
    fatigue    what repeating the cycle does within minutes
    lifting    what NIOSH's lifting equation says of the cycle, by its class of hours; empty if nothing is lifted
    """

    demand: Demand | None
    why_not: tuple[Phrase, ...] = ()
    level: Level | None = None
    rules: str = ""
    fatigue: Fatigue | None = None
    lifting: Mapping[Duration, Judgement] = field(default_factory=dict)


# Of a worker who, as the file says, does not work there.
STATED = Post(None)
# Why there is none where the file leaves out what a rule forbids.
FORBIDDEN = "the work is not acceptable by {rules}, even at the best place"


def post_of(
    found: Examined, worker: str, cycle_s: float, cache: ReactionCache, command: str, as_allowed: bool = False
) -> Post:
    """A worker at a station that was examined, whose cycle lasts so long.

    as_allowed: what a rule forbids is not done. Raises what `ReactionCache.stream` raises.
    """
    doings = found.doings(worker, found.best.places)
    if not doings:
        return Post(None, tuple(_obstacles(found, worker)))
    case = found.case(doings, cache, command)
    operations = tuple(
        Operation(doing.operation, task.request.motion, reaction.motion, stated(found.station, doing.operation))
        for doing, task, reaction in zip(doings, case.tasks, case.reactions(), strict=True)
    )
    verdict = judge(case)
    rules = rules_named(verdict.by) if verdict.level == Level.NOT_ACCEPTABLE else ""
    if rules and as_allowed:
        return Post(None, (Phrase(FORBIDDEN, {"rules": rules}),), verdict.level)
    demand = Demand.of(Job(operations, Shift(cycle_s=cycle_s)))
    lifting = {
        duration: NioshLifting().assess(Job(operations, Shift(cycle_s=cycle_s, hours=hours)))
        for duration, hours in LONGEST_H.items()
        if demand.lifts
    }
    return Post(demand, (), verdict.level, rules, verdict.fatigue, lifting)


def _obstacles(found: Examined, worker: str) -> Iterator[Phrase]:
    """Of every operation that the worker can do at no place, what is in the way at each."""
    out = ruled_out(found.robot)
    for operation in found.station.operations:
        own = [each for each in found.places if (each.worker, each.operation) == (worker, operation)]
        if not any(each.way is not None and (operation, each.place) not in out for each in own):
            yield from (out.get((operation, each.place)) or why_not(found.station, each.outcome) for each in own)

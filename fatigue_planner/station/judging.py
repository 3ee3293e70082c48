"""What is to be said of motions that follow each other in a cycle: indicators, limits, and what repeating it does."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Level
from fatigue_planner.ergonomics.stated import Circumstances, Shift, Spell
from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.station.assessment import Fatigue, Rule
from fatigue_planner.station.cycles import Course, Stretch, cost, peak, settled, shortfall
from fatigue_planner.station.limits import Breach, breaches
from fatigue_planner.station.outcomes import Task
from fatigue_planner.station.schema import Station

T = TypeVar("T")

MINUTES_PER_HOUR = 60.0


@dataclass(frozen=True)
class Case:
    """A worker's motions that make a cycle, in their order, to be judged from the cache folder."""

    station: Station
    tasks: tuple[Task, ...]
    cache: ReactionCache
    command: str

    @property
    def rest_s(self) -> float:
        """What is left of the cycle in s."""
        names = [task.doing.operation for task in self.tasks]
        busy_s = sum(self.station.operation_s(name) * often for name, often in zip(names, self.times, strict=True))
        return max(self.station.cycle.duration_s - busy_s, 0.0)

    @property
    def times(self) -> list[int]:
        """How often every motion is made in a cycle."""
        return [self.station.operations[task.doing.operation].times_per_cycle for task in self.tasks]

    def reactions(self) -> list[Reaction]:
        """The motions as they are stored. Raises what `ReactionCache.stream` raises."""
        stored = self.cache.stream([task.request for task in self.tasks], self.command)
        found = [reaction for reaction in stored if isinstance(reaction, Reaction)]
        assert len(found) == len(self.tasks), "only what was reached is judged"
        return found

    def parameters(self) -> FatigueParameters:
        """How the worker tires: by the paper's law."""
        return fatigue_parameters(FatigueSettings(), self.tasks[0].request.motion.maximum_torque)


class Verdict(NamedTuple):
    """What was found of a case: its courses (one for each task), fatigue, indicators by kind, limits that it breaks;
    binding: the kinds of indicators that exclude.
    """

    courses: tuple[Course, ...]
    fatigue: Fatigue
    judgements: Mapping[str, Judgement]
    breaches: tuple[Breach, ...]
    binding: tuple[str, ...]

    @property
    def level(self) -> Level:
        """The worst level that is certain by a binding indicator."""
        levels = (level_of(each) for kind, each in self.judgements.items() if kind in self.binding)
        return max(levels, default=Level.ACCEPTABLE)

    @property
    def by(self) -> tuple[Rule, ...]:
        """The binding indicators that give this level, where it is above acceptable."""
        worst = self.level
        return self._rules(worst, binding=True) if worst > Level.ACCEPTABLE else ()

    @property
    def warned_by(self) -> tuple[Rule, ...]:
        """The other indicators that find it not acceptable."""
        return self._rules(Level.NOT_ACCEPTABLE, binding=False)

    def _rules(self, level: Level, binding: bool) -> tuple[Rule, ...]:
        return tuple(
            Rule(kind, each.title, level, each.times.not_acceptable_s if each.times else None, _part(each))
            for kind, each in self.judgements.items()
            if (kind in self.binding) == binding and level_of(each) == level
        )


def _part(judgement: Judgement) -> str:
    return f"{judgement.worst.side} {judgement.worst.part}".strip() if judgement.worst else ""


def level_of(judgement: Judgement) -> Level:
    """The level that is certain: at the low end of the range."""
    return judgement.levels[0] if judgement.applies and judgement.levels else Level.ACCEPTABLE


def judge(case: Case) -> Verdict:
    """Everything that is to be said of a case. Raises what `ReactionCache.stream` raises."""
    station, reactions, parameters = case.station, case.reactions(), case.parameters()
    courses = tuple(Course.of(reaction.motion, parameters) for reaction in reactions)
    times = case.times
    ends = settled(repeated(courses, times), case.rest_s)
    highest, entry = peak(ends)
    short = shortfall(repeated([reaction.motion for reaction in reactions], times), case.rest_s, parameters)
    fatigue = Fatigue(highest, entry, cost(ends), short.cycle if short else None, short.entry if short else "")
    operations = [
        Operation(task.doing.operation, task.request.motion, reaction.motion, stated(station, task.doing.operation))
        for task, reaction in zip(case.tasks, reactions, strict=True)
    ]
    found = {each.indicator: each for each in evaluate(operations, shift_of(station))}
    broken = [
        breach
        for task, reaction, often in zip(case.tasks, reactions, times, strict=True)
        for breach in breaches(station.limits, task.request.motion.worker.anthropometry(), reaction.motion, often)
    ]
    return Verdict(courses, fatigue, found, tuple(broken), station.binding)


def profile(case: Case) -> CycleProfile:
    """How the whole cycle of a case loads the worker, for planners. Raises what `ReactionCache.stream` raises."""
    motions = repeated([reaction.motion for reaction in case.reactions()], case.times)
    parts = [*map(Stretch.of, motions), Stretch.rest(motions[-1], case.rest_s)]
    return cycle_profile(Stretch.joined(parts), case.parameters())


def repeated(items: Sequence[T], times: Sequence[int]) -> list[T]:
    """Every item so many times."""
    return [item for item, often in zip(items, times, strict=True) for _ in range(often)]


def stated(station: Station, operation: str) -> Circumstances:
    """What is stated of an operation, for the indicators."""
    said = station.operations[operation]
    return Circumstances(**{key: getattr(said, key) for key in Circumstances.model_fields})


def shift_of(station: Station) -> Shift:
    """The shift, for the indicators: hours at work, and every time of work with the break after it."""
    shift = station.shift
    if shift is None:
        return Shift(cycle_s=station.cycle.duration_s)
    begin, spells = 0.0, []
    for at_min, minutes in [
        *((each.at_min, each.minutes) for each in shift.breaks),
        (MINUTES_PER_HOUR * shift.hours, 0),
    ]:
        if at_min > begin:
            work_h, break_h = (at_min - begin) / MINUTES_PER_HOUR, minutes / MINUTES_PER_HOUR
            spells.append(Spell(work_h=work_h, break_h=break_h))
        elif spells:  # a break right after another one
            spells[-1] = Spell(work_h=spells[-1].work_h, break_h=spells[-1].break_h + minutes / MINUTES_PER_HOUR)
        begin = at_min + minutes
    hours = sum(spell.work_h for spell in spells)
    others = tuple(shift.other_work.values())
    return Shift(cycle_s=station.cycle.duration_s, hours=hours, spells=tuple(spells), other_work=others)

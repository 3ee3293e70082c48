"""Methods that judge, part by part, what of a posture is held or repeated: what they have in common."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.posture import runs
from fatigue_planner.ergonomics.result import Assessment, Decides, Level, Moment, Phrase, Span, Times
from fatigue_planner.ergonomics.stated import Circumstances

Integers = NDArray[np.int64]

# A posture is held, and not passed, if it lasts for more than 4 s (ISO 11226).
HELD_S = 4.0


class Judged(NamedTuple):
    """A rule on a part of the body, with its side if it has one, and its level at every instant, (n,)."""

    part: str
    side: str
    level: Integers


class Sum(NamedTuple):
    """Seconds per cycle in each level, those of each part that are not acceptable, and where that is worst."""

    times: Times
    parts: dict[str, float]
    worst: Moment | None

    @property
    def level(self) -> Level:
        """The level of the whole cycle."""
        if self.times.not_acceptable_s > 0:
            return Level.NOT_ACCEPTABLE
        return Level.INVESTIGATE if self.times.investigate_s > 0 else Level.ACCEPTABLE


class HeldPosture(Indicator):
    """The value is the time per cycle that is not acceptable by any rule, in s."""

    # The method's own words for the three levels.
    words: ClassVar[tuple[str, str, str]]

    visible_deg: float = Field(
        default=10,
        gt=0,
        lt=90,
        description="From where on a twist, a side bend, an arm behind the body (ISO 11226: or across it) counts, in "
        "degrees; the standards give no number, 10 is clearly visible.",
    )
    head_turned_deg: float = Field(
        default=45,
        gt=0,
        lt=90,
        description="From where on the head counts as turned against the chest, in degrees; ISO 11226 gives no number, "
        "45 is that of EN 1005-4 (recalled).",
    )

    @abstractmethod
    def judged(self, job: Job, stated: Sequence[Circumstances]) -> list[list[Judged]]:
        """Every rule on every operation, under circumstances in which all that matters is stated."""

    @abstractmethod
    def remarks(self) -> tuple[Phrase, ...]:
        """What has to be known beside the value."""

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess. The only input that can be unknown is whether the shoulder is raised."""
        low, high = (self._summed(job, raised) for raised in (False, True))
        best, most = low.times.not_acceptable_s, high.times.not_acceptable_s
        raised = Decides("shoulder_raised", Phrase("with a raised shoulder"), most)
        return self.answer(
            value=Span(best, most),
            digits=1,
            unit="s",
            levels=(low.level, high.level),
            words=(self.words[low.level], self.words[high.level]),
            decides=(raised,) if most > best else (),
            times=low.times,
            times_most=high.times,
            worst=low.worst,
            parts=low.parts,
            remarks=(
                *self.remarks(),
                Phrase("The ways there and back are movements: what is held is held during the work, or all the time."),
            ),
        )

    def _summed(self, job: Job, shoulder_raised: bool) -> Sum:
        stated = [operation.stated for operation in job.operations]
        update = {"shoulder_raised": shoulder_raised}
        known = [one.model_copy(update=update) if one.shoulder_raised is None else one for one in stated]
        seconds = np.zeros(len(Level))
        parts: dict[str, float] = {}
        worst_s, worst = 0.0, None
        for operation, rules in zip(job.operations, self.judged(job, known), strict=True):
            each_s = operation.seconds_per_cycle / len(operation.posture.time_s)
            level = np.max([rule.level for rule in rules], axis=0)
            seconds += np.bincount(level, minlength=len(Level)) * each_s
            for rule in rules:
                bad = rule.level == Level.NOT_ACCEPTABLE
                if bad.any():
                    name = f"{rule.side} {rule.part}".strip()
                    parts[name] = parts.get(name, 0.0) + float(bad.sum()) * each_s
                if float(bad.sum()) * each_s > worst_s:
                    worst_s = float(bad.sum()) * each_s
                    first, last = runs(bad)
                    longest = int((last - first).argmax())
                    time_s = float(operation.posture.time_s[(first[longest] + last[longest]) // 2])
                    worst = Moment(operation.name, time_s, rule.side, rule.part)
        return Sum(Times(*seconds.tolist()), parts, worst)


def holds(inside: NDArray[np.bool_], operation: Operation) -> Iterator[slice]:
    """Where a posture is held: for more than 4 s without a break.

    inside (n,): whether the posture is had. The ways there and back are movements and no part of a hold, unless the
    posture is had all the time, so that it goes on from cycle to cycle.
    """
    still = inside if inside.all() else inside & working(operation)
    for first, last in zip(*runs(still), strict=True):
        if (last - first) * operation.posture.step_s > HELD_S:
            yield slice(first, last)


def working(operation: Operation) -> NDArray[np.bool_]:
    """Whether it is an instant of the work, (n,)."""
    work = operation.motion.phase("work")
    ticks = np.arange(len(operation.posture.time_s)) * operation.stride
    return np.asarray((ticks >= work.start) & (ticks < work.stop))

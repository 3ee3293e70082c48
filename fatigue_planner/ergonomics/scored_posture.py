"""Methods that give a score to the posture of each instant and each side: what they have in common."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.posture import runs
from fatigue_planner.ergonomics.result import Assessment, Decides, Level, Moment, Phrase, Span, Times
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.human.skeleton import SIDES

Vector = NDArray[np.float64]
Integers = NDArray[np.int64]


class Scores(NamedTuple):
    """Scores (n, 2) of both sides at n instants, and the points they are made of, each (n,) or (n, 2), by part."""

    total: Integers
    points: Mapping[str, Integers]


class Option(NamedTuple):
    """What an input that is not stated may be, and how that is said."""

    key: str
    value: Any
    condition: Phrase


# A posture is static if it is held for more than a minute (McAtamney & Corlett 1993; Hignett & McAtamney 2000). It is
# held while no joint is faster than this, in degrees per s (assumed).
STATIC_S, STILL_DEGPS = 60.0, 3.0
# The mildest that may be true of what is not stated.
MILDEST = {
    "actions_per_minute": 0.0, "shock": False, "rapid_changes": False, "shoulder_raised": False, "coupling": "good",
}  # fmt: skip
REPEATED = Option("actions_per_minute", 5.0, Phrase("if repeated more than 4 times a minute"))
SHOCK = Option("shock", True, Phrase("with shocks"))
SHOULDER_RAISED = Option("shoulder_raised", True, Phrase("with a raised shoulder"))
# A foot that bears less than this share of the weight does not support the body evenly (assumed).
UNEVEN = 0.1
# Actions per minute above which work is repeated (both papers).
REPEATED_PER_MINUTE = 4.0


class ScoredPosture(Indicator):
    """A score of the posture at each instant. Inputs that are not stated are first as mild as they can be."""

    # Where the levels begin in which the method finds that a change may be needed, or wants it soon or at once; and its
    # own words from each score on.
    bounds: ClassVar[tuple[int, int]]
    words: ClassVar[Mapping[int, str]]
    # The fewest points of each part of the body, to say which is worst.
    least_points: ClassVar[Mapping[str, int]]

    @abstractmethod
    def scores(self, operation: Operation, stated: Circumstances) -> Scores:
        """The scores of an operation, under circumstances in which all that matters is stated."""

    def options(self, operation: Operation) -> Sequence[Option]:
        """What an input that matters and is not stated may be, each but the mildest; the worst of an input last."""
        return ()

    def mildest(self, operation: Operation, times_per_minute: float = 0.0) -> Circumstances:
        """The circumstances with everything that is not stated as mild as it can be.

        An operation that is done so many times per minute has at least as many actions.
        """
        stated = operation.stated
        update = {key: value for key, value in MILDEST.items() if getattr(stated, key) is None}
        actions = max(stated.actions_per_minute or 0.0, times_per_minute)
        return stated.model_copy(update=update | {"actions_per_minute": actions})

    def remarks(self, job: Job) -> tuple[Phrase, ...]:
        """What has to be known beside the score."""
        return ()

    def level_of(self, score: ArrayLike) -> Integers:
        """The level of scores, on the common scale."""
        return np.searchsorted(np.array(self.bounds), np.asarray(score), side="right")

    def words_of(self, score: float) -> str:
        """The method's own words for a score."""
        return self.words[max(start for start in self.words if start <= score)]

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess: the worst of all instants, sides and operations, at both ends of what is unknown."""
        mild = [self.mildest(operation, job.times_per_minute(operation)) for operation in job.operations]
        low = [self.scores(operation, stated) for operation, stated in zip(job.operations, mild, strict=True)]
        high = []
        decides: dict[tuple[str, str], Decides] = {}
        best = max(int(scores.total.max()) for scores in low)
        for operation, stated in zip(job.operations, mild, strict=True):
            options = self.options(operation)
            for option in options:
                alone = self.scores(operation, stated.model_copy(update={option.key: option.value}))
                known = decides.get((option.key, str(option.condition)))
                value = max(int(alone.total.max()), known.value if known else best)
                if value > best:
                    decides[option.key, str(option.condition)] = Decides(option.key, option.condition, value)
            everything = stated.model_copy(update={option.key: option.value for option in options})
            high.append(self.scores(operation, everything))
        most = max(int(scores.total.max()) for scores in high)
        found = int(np.argmax([scores.total.max() for scores in low]))
        side = int(low[found].total.max(axis=0).argmax())
        instant = _middle_of_longest(low[found].total[:, side] == best)
        parts = {name: int(_of_side(points, side)[instant]) for name, points in low[found].points.items()}
        one_sided = any(points.ndim > 1 for points in low[found].points.values())
        return self.answer(
            value=Span(best, most),
            levels=(Level(int(self.level_of(best))), Level(int(self.level_of(most)))),
            words=(self.words_of(best), self.words_of(most)),
            decides=tuple(decides.values()),
            times=self._times(job, low),
            times_most=self._times(job, high),
            worst=Moment(
                operation=job.operations[found].name,
                time_s=float(job.operations[found].posture.time_s[instant]),
                side=SIDES[side] if one_sided else "",
                part=self._worst_part(parts),
            ),
            parts=parts,
            remarks=self.remarks(job),
        )

    def _times(self, job: Job, scores: Sequence[Scores]) -> Times:
        """Seconds per cycle in each level, of the worse side."""
        seconds = np.zeros(len(Level))
        for operation, found in zip(job.operations, scores, strict=True):
            share = np.bincount(self.level_of(found.total.max(axis=1)), minlength=len(Level)) / len(found.total)
            seconds += share * operation.seconds_per_cycle
        return Times(*seconds.tolist())

    def _worst_part(self, parts: Mapping[str, int]) -> str:
        """The part of the body with the most points above the fewest that it can have."""
        return max(self.least_points, key=lambda name: parts[name] - self.least_points[name])


class JointThresholds(ScoredPosture):
    """The thresholds that RULA and REBA leave open, and what both count alike."""

    twisted_deg: float = Field(
        default=20,
        gt=0,
        lt=90,
        description="From where on trunk or neck count as twisted, in degrees; the paper gives no number.",
    )
    side_bent_deg: float = Field(
        default=10,
        gt=0,
        lt=90,
        description="From where on trunk or neck count as bent sideways, in degrees; the paper gives no number.",
    )
    abducted_deg: float = Field(
        default=30,
        gt=0,
        lt=90,
        description="From where on the upper arm counts as abducted, in degrees; the paper gives no number.",
    )
    deviated_deg: float = Field(
        default=20,
        gt=0,
        lt=90,
        description="From where on the wrist counts as bent from its midline, in degrees; the paper gives no number.",
    )
    tolerance_deg: float = Field(
        default=5,
        ge=0,
        lt=20,
        description="Up to where a joint counts as straight, in degrees; the paper says 0, where nobody stands.",
    )

    def turned(self, twist_deg: Vector, side_deg: Vector) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether trunk or neck are twisted, and whether they are bent sideways, each (n,)."""
        return np.abs(twist_deg) > self.twisted_deg, np.abs(side_deg) > self.side_bent_deg

    def remarks(self, job: Job) -> tuple[Phrase, ...]:
        """See ScoredPosture.remarks."""
        values = {"twisted": self.twisted_deg, "bent": self.side_bent_deg, "abducted": self.abducted_deg}
        return (
            Phrase(
                "Twisted from {twisted:g}°, bent sideways from {bent:g}°, abducted from {abducted:g}°, wrist deviated "
                "from {deviated:g}°: the paper gives no numbers.",
                values | {"deviated": self.deviated_deg},
            ),
        )


def upper_arm_points(to_trunk_deg: Vector) -> Integers:
    """Points of the upper arm against the trunk, negative backwards: RULA and REBA."""
    raised = 1 + (to_trunk_deg > 20).astype(np.int64) + (to_trunk_deg > 45) + (to_trunk_deg > 90)
    return np.asarray(np.where(to_trunk_deg < -20, 2, raised))


def lower_arm_points(elbow_deg: Vector) -> Integers:
    """Points of the lower arm: RULA and REBA."""
    return np.asarray(np.where((elbow_deg >= 60) & (elbow_deg <= 100), 1, 2))


def one_foot(operation: Operation) -> NDArray[np.bool_]:
    """Whether one foot bears nearly all of the weight, (n,)."""
    return np.asarray(operation.posture.foot_share.min(axis=1) < UNEVEN)


def _middle_of_longest(taken: NDArray[np.bool_]) -> int:
    """The middle of the longest run."""
    first, last = runs(taken)
    longest = int((last - first).argmax())
    return int(first[longest] + last[longest]) // 2


def is_static(operation: Operation) -> bool:
    """Whether a posture is held for more than a minute."""
    first, last = runs(operation.posture.speed_degps <= STILL_DEGPS)
    return int((last - first).max(initial=0)) * operation.posture.step_s > STATIC_S


def _of_side(points: Integers, side: int) -> Integers:
    return points if points.ndim == 1 else points[:, side]

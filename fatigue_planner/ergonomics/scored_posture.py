"""Methods that give a score to the posture of each instant and each side: what they have in common."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Decides, Level, Moment, Phrase, Span, Times
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.human.skeleton import SIDES

Vector = NDArray[np.float64]
Integers = NDArray[np.int64]

# A posture is static if it is held for more than a minute (McAtamney & Corlett 1993; Hignett & McAtamney 2000). It is
# held while no joint is faster than this, in degrees per s (assumed).
STATIC_S, STILL_DEGPS = 60.0, 3.0
# Actions per minute above which work is repeated (both papers).
REPEATED_PER_MINUTE = 4.0


class Scores(NamedTuple):
    """Scores (n, 2) of both sides at n instants, and the points they are made of, each (n,) or (n, 2), by part."""

    total: Integers
    points: Mapping[str, Integers]


class Option(NamedTuple):
    """What an input that is not stated may be, and how that is said."""

    key: str
    value: Any
    condition: Phrase


class ScoredPosture(Indicator):
    """A score of the posture at each instant. Inputs that are not stated are first as mild as they can be."""

    # Where the levels INVESTIGATE and NOT_ACCEPTABLE begin, and the method's own words from each score on.
    bounds: ClassVar[tuple[int, int]]
    words: ClassVar[Mapping[int, str]]
    # The fewest and the most points of each part of the body, to say which is worst.
    most_points: ClassVar[Mapping[str, tuple[int, int]]]

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

    @abstractmethod
    def scores(self, operation: Operation, stated: Circumstances) -> Scores:
        """The scores of an operation, under circumstances in which all that matters is stated."""

    @abstractmethod
    def options(self, operation: Operation) -> Sequence[Option]:
        """What an input that matters and is not stated may be, each but the mildest; the worst of an input last."""

    @abstractmethod
    def mildest(self, operation: Operation) -> Circumstances:
        """The circumstances with everything that is not stated as mild as it can be."""

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
        mild = [self.mildest(operation) for operation in job.operations]
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
        instant, side = np.unravel_index(int(low[found].total.argmax()), low[found].total.shape)
        parts = {name: int(_of_side(points, int(side))[instant]) for name, points in low[found].points.items()}
        one_sided = any(points.ndim > 1 for points in low[found].points.values())
        return Assessment(
            indicator=self.kind,
            title=self.title,
            edition=self.edition,
            origin=self.origin,
            value=Span(best, most),
            levels=(Level(int(self.level_of(best))), Level(int(self.level_of(most)))),
            words=(self.words_of(best), self.words_of(most)),
            decides=tuple(decides.values()),
            times=self._times(job, low),
            times_most=self._times(job, high),
            worst=Moment(
                operation=job.operations[found].name,
                time_s=float(job.operations[found].posture.time_s[instant]),
                side=SIDES[int(side)] if one_sided else "",
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
        """The part of the body with the largest share of the points that it can have."""
        share = {name: (parts[name] - least) / (most - least) for name, (least, most) in self.most_points.items()}
        return max(share, key=lambda name: share[name])


def is_static(operation: Operation) -> bool:
    """Whether a posture is held for more than a minute."""
    fast = operation.posture.speed_degps > STILL_DEGPS
    edges = np.flatnonzero(np.diff(np.concatenate([[True], fast, [True]])))
    longest = int((edges[1::2] - edges[::2]).max(initial=0))
    return longest * operation.posture.step_s > STATIC_S


def _of_side(points: Integers, side: int) -> Integers:
    return points if points.ndim == 1 else points[:, side]

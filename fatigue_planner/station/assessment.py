"""What is found out about a station: plain data, for files and pages. Sentences are keys with values, never text.

Every worker does every operation at every place in every way: an outcome each. What was reached is judged by the
indicators; the best of it makes the recommendation.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.motion.plausibility import Finding
from fatigue_planner.motion.settings import Side
from fatigue_planner.robot.scan import Standpoint
from fatigue_planner.station.limits import Breach
from fatigue_planner.station.schema import Station, Way
from fatigue_planner.station.workers import WorkerFacts

# reached: with a motion that a person would make. missed: the hand does not get there. too_weak: it would without the
# load. implausible: it gets there as nobody would, or into the body.
Kind = Literal["reached", "missed", "too_weak", "implausible"]


class Doing(NamedTuple):
    """Who does what, where and how."""

    worker: str
    operation: str
    place: str
    way: Way


@dataclass(frozen=True)
class Outcome:
    """What became of one motion.

    hands        those that work
    missed_m     how far the hand stays from the place; None if it is not known, or reached
    joint        where the worker is too weak
    load_share   the largest mean load of a joint during work as a share of its strength, and `load_joint`
    findings     what is implausible: measure, value and bar in the measure's unit, and what it means
    detail       the program's own words for what failed, in English; empty if nothing did
    breaches     limits of the station that the motion breaks
    digest       of the motion in the cache; empty if it needed no simulation
    """

    doing: Doing
    hands: tuple[Side, ...]
    kind: Kind
    missed_m: float | None = None
    joint: str = ""
    load_share: float | None = None
    load_joint: str = ""
    findings: tuple[Finding, ...] = ()
    detail: str = ""
    breaches: tuple[Breach, ...] = ()
    digest: str = ""

    @property
    def usable(self) -> bool:
        """Whether what follows may use the motion."""
        return self.kind == "reached" and not self.breaches


@dataclass(frozen=True)
class Fatigue:
    """What repeating a cycle for ever does, by the paper's law: the cycle settles.

    peak         the highest fatigue of any joint in the settled cycle, a share of its strength, and `entry` it is of
    cost         mean squared fatigue in the settled cycle (Eq. 5), at the ends of the work
    shortfall_cycle  the first cycle in which a joint cannot give what is asked, and its `shortfall_entry`; None if
        all can
    """

    peak: float
    entry: str
    cost: float
    shortfall_cycle: int | None = None
    shortfall_entry: str = ""


class Rule(NamedTuple):
    """An indicator that finds a worse level than acceptable: its kind and title, the level, seconds per cycle that are
    not acceptable (None of a method that does not judge postures), and the part of the body where it is worst.
    """

    kind: str
    title: str
    level: Level
    not_acceptable_s: float | None
    part: str


@dataclass(frozen=True)
class Judged:
    """A motion that may be used, judged alone, as if the rest of the cycle were rest.

    level        the worst level that is certain by a binding indicator
    by           the binding indicators that give this level, where it is above acceptable
    warned_by    the other indicators that find it not acceptable
    judgements   all indicators, by kind
    """

    doing: Doing
    level: Level
    by: tuple[Rule, ...]
    warned_by: tuple[Rule, ...]
    fatigue: Fatigue
    judgements: Mapping[str, Judgement]


@dataclass(frozen=True)
class PlaceForWorker:
    """A place of an operation for a worker: the way of working there that is judged best, if there is any.

    outcome      the nearest to being reached of all ways, if none can be used
    """

    worker: str
    operation: str
    place: str
    way: Way | None
    level: Level | None
    outcome: Outcome


@dataclass(frozen=True)
class PlaceSummary:
    """A place of an operation for all workers, each in the way that is best for him or her.

    reached_by   workers who reach it in some way that may be used; missed_by: the others
    level        the worst level of those who reach it; None if nobody does
    by           the binding indicators that say so, each with the seconds of the worker for whom they are most
    warned_by    the other indicators that find it not acceptable for one of those who reach it
    peak, entry  the highest fatigue of those who reach it; cost: their mean cost of fatigue
    """

    operation: str
    place: str
    reached_by: tuple[str, ...]
    missed_by: tuple[str, ...]
    level: Level | None
    by: tuple[Rule, ...]
    warned_by: tuple[Rule, ...]
    peak: float | None
    entry: str
    cost: float | None


@dataclass(frozen=True)
class BestPlaces:
    """The places that are recommended, one for every operation: of those that all workers reach and no rule forbids the
    combination with the lowest mean cost of fatigue.

    places       by operation; empty if there is no such combination
    peak         the highest fatigue of any worker with it
    next_places  the second best combination, and what its cost of fatigue is above that of the best, as a share of it
    excluded     by operation and place: why it is none of them
    together     why places that are allowed one by one are not in one cycle; None if they are
    """

    places: Mapping[str, str]
    peak: float | None
    cost: float | None
    next_places: Mapping[str, str]
    next_above: float | None
    excluded: Mapping[tuple[str, str], Phrase]
    together: Phrase | None = None


@dataclass(frozen=True)
class WholeCycle:
    """The recommended cycle of a worker, or the best that he or she alone could do."""

    worker: str
    doings: tuple[Doing, ...]
    recommended: bool
    level: Level
    fatigue: Fatigue
    judgements: Mapping[str, Judgement]


@dataclass(frozen=True)
class ReachShare:
    """Who of a population reaches a place, with a motion that a person would make, and is strong enough for it.

    shortest_m, tallest_m  the statures between which it is reached; None where none that was tried does
    share        of the women or men of the population, and what it is with arms 3 cm shorter or longer; with empty
        hands where the median strength cannot bear the load
    strong_share those with the strength for it, at the stature of the median; `weakest_joint` is empty where nobody is
    """

    operation: str
    place: str
    sex: Sex
    shortest_m: float | None
    tallest_m: float | None
    share: float
    share_low: float
    share_high: float
    strong_share: float | None
    weakest_joint: str


@dataclass(frozen=True)
class Change:
    """What one change of the station would do, computed: the recommendation after it beside the one before it.

    places, peak, cost  what is recommended after it, as in BestPlaces
    saving       what of the cost of fatigue before it saves at the recommended places, as a share; None without a
        recommendation before or after
    saving_everywhere  the same of the mean cost of all places that somebody reaches before and after
    reached_by_all, allowed, of_places  how many places of operations all workers can use, how many are allowed, of all
    """

    change: Phrase
    places: Mapping[str, str]
    peak: float | None
    cost: float | None
    saving: float | None
    saving_everywhere: float | None
    reached_by_all: int
    allowed: int
    of_places: int


@dataclass(frozen=True)
class Rotation:
    """The best repeated sequence of places where every cycle may have others, and what it saves over the best places
    for ever, as a share of the cost of fatigue. exact: all sequences that are no longer were looked at.
    """

    sequence: tuple[Mapping[str, str], ...]
    saving: float
    exact: bool


@dataclass(frozen=True)
class Sensing:
    """What of the best schedule's cost of fatigue a robot saves that sees how the worker works, as the mean over all
    workers, with its 95 % interval (paired, common random numbers).

    most         what no plan can save more than, whatever it sees and computes: the proven bound of the cost
    certain      no worker has more than one way to work, so that there is nothing to see
    """

    saving: float
    low: float
    high: float
    most: float
    certain: bool


class RobotMeeting(NamedTuple):
    """The nearest that the arm comes to a worker in any way of working: to which part of the body, and when."""

    worker: str
    way: Way
    distance_m: float
    part: str
    time_s: float


@dataclass(frozen=True)
class RobotPlace:
    """What the robot can make of a place of an operation.

    reason       why the arm does not get there; empty where it does
    angles_deg   of its joints, there or as near as it comes; `joint_margin_deg`: from the nearest limit, of `tightest`
    manipulability  sqrt(det J J^T) in m^3
    meeting      None where the arm or every worker does not get there
    left_out     why nothing that is planned or recommended has this place; None if it may
    """

    operation: str
    place: str
    reason: str
    angles_deg: tuple[float, ...]
    joint_margin_deg: float
    tightest: str
    manipulability: float
    meeting: RobotMeeting | None
    left_out: Phrase | None


@dataclass(frozen=True)
class RobotFinding:
    """The robot of a station: what ships of the arm, its places, and how many places it reaches from elsewhere."""

    arm: str
    source: str
    payload_kg: float | None
    places: tuple[RobotPlace, ...]
    scan: tuple[Standpoint, ...]


@dataclass(frozen=True)
class StationAssessment:
    """Everything that is found out about a station.

    headline     the first lines, the most important first; assumptions: what has to be known beside them
    station_digest  of the file's content, for signatures; version: of the program
    """

    station: Station
    workers: tuple[WorkerFacts, ...]
    outcomes: tuple[Outcome, ...]
    judged: tuple[Judged, ...]
    places: tuple[PlaceForWorker, ...]
    summaries: tuple[PlaceSummary, ...]
    best: BestPlaces
    cycles: tuple[WholeCycle, ...]
    shares: tuple[ReachShare, ...]
    changes: tuple[Change, ...]
    rotation: Rotation | None
    sensing: Sensing | None
    headline: tuple[Phrase, ...]
    assumptions: tuple[Phrase, ...]
    station_digest: str
    version: str
    robot: RobotFinding | None = None

    def outcome(self, doing: Doing) -> Outcome:
        """The outcome of a motion."""
        return next(outcome for outcome in self.outcomes if outcome.doing == doing)

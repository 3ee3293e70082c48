"""Who of a population reaches a place, and who is strong enough for it: found by trying statures."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.load import loads
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Worker
from fatigue_planner.human.population import People, median_mass_kg, percentile_of, stature_m
from fatigue_planner.human.strength_sets import Direction, at_percentile, strength_spread
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.settings import Accuracy, Side
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure
from fatigue_planner.reactions.reaction import ReactionRequest
from fatigue_planner.station.assessment import ReachShare
from fatigue_planner.station.experiments import SIDES, Part, experiment_of
from fatigue_planner.station.outcomes import odd_postures
from fatigue_planner.station.schema import Station

SEXES: tuple[Sex, ...] = ("female", "male")
# Where a stature is looked for that reaches a place, the likeliest first; ends of what is looked at.
MEDIAN = 50.0
PERCENTILES = (MEDIAN, 25.0, 75.0, 5.0, 95.0, 1.0, 99.0)
LOWEST, HIGHEST = 1.0, 99.0
# How closely the shortest and the tallest are found, and how much people of a stature differ in reach (one SD), in m.
PRECISION_M, REACH_SD_M = 0.005, 0.03
# A place is reached if the hand can be held there for so long.
HOLD_S = 0.5
# What a worker of the simulation can be.
STATURES_M = (1.4, 2.1)


@dataclass(frozen=True)
class Question:
    """Who of a sex reaches a place of an operation."""

    station: Station
    operation: str
    place: str
    sex: Sex

    @property
    def is_loaded(self) -> bool:
        """Whether there is something in the hands."""
        return self.station.tool_at(self.operation, self.place) is not None

    @property
    def people(self) -> People | None:
        """The people of the station's own population; None for ANSUR's."""
        return self.station.population.people(self.sex) if self.station.population else None

    def stature(self, percentile: float) -> float:
        """The stature in m of a percentile of these people, as far as it can be simulated."""
        return float(np.clip(stature_m(percentile, self.sex, self.people), *STATURES_M))


def questions(station: Station) -> Iterator[Question]:
    """Every place of every operation, for the women and the men of the population."""
    for operation, said in station.operations.items():
        for place in said.places:
            for sex in SEXES:
                if station.population is None or station.population.people(sex) is not None:
                    yield Question(station, operation, place, sex)


def answered(question: Question) -> ReachShare:
    """Try statures of the median mass and strength, in every way, until the shortest and the tallest are found.

    Where none of them can bear the load, reach is that of empty hands: what is missing is strength.
    """
    known: dict[float, Motion | None] = {}

    def reaches(stature: float) -> bool:
        if stature not in known:
            known[stature] = _reaching(question, stature)
        return known[stature] is not None

    tried = [question.stature(percentile) for percentile in PERCENTILES]
    if question.is_loaded and not reaches(tried[0]):
        # a load that is too heavy takes long to fail: empty hands say first which stature can get there at all
        bare = replace(question, station=emptied(question.station))
        there = next((each for each in tried if _reaching(bare, each)), None)
        if there is not None and not reaches(there):
            return _without_the_load(question, bare, there)
        tried = [] if there is None else [there]
    first = next(filter(reaches, tried), None)
    if first is None:
        return ReachShare(question.operation, question.place, question.sex, None, None, 0.0, 0.0, 0.0, None, "")
    shortest = _edge(first, question.stature(LOWEST), reaches)
    tallest = _edge(first, question.stature(HIGHEST), reaches)
    motion = known[first]
    assert motion is not None
    strong, joint = strong_share(motion, _worker(question, first))
    shares = [_share(question, shortest, tallest, longer) for longer in (0.0, -REACH_SD_M, REACH_SD_M)]
    return ReachShare(
        question.operation,
        question.place,
        question.sex,
        shortest,
        tallest,
        shares[0],
        min(shares),
        max(shares),
        strong,
        joint,
    )


def _without_the_load(question: Question, bare: Question, stature: float) -> ReachShare:
    """What of a load that the median strength cannot bear: who reaches the place without it, and who is so strong.

    A worker of the highest strength that is looked at shows what the work asks of each joint; if even that is too
    little, nobody is strong enough.
    """
    motion = _reaching(question, stature, HIGHEST)
    strong, joint = (0.0, "") if motion is None else strong_share(motion, _worker(question, stature))
    return replace(answered(bare), strong_share=strong, weakest_joint=joint)


def emptied(station: Station) -> Station:
    """The station with nothing in the hands."""
    places = {name: each.model_copy(update={"tool": None}) for name, each in station.places.items()}
    operations = {name: each.model_copy(update={"tool": None}) for name, each in station.operations.items()}
    return station.model_copy(update={"places": places, "operations": operations})


def _edge(inside: float, end: float, reaches: Callable[[float], bool]) -> float:
    """The stature nearest to the end that reaches the place, between one that does and the end."""
    if reaches(end):
        return end
    outside = end
    while abs(outside - inside) > PRECISION_M:
        middle = round((inside + outside) / 2, 4)
        inside, outside = (middle, outside) if reaches(middle) else (inside, middle)
    return inside


def _share(question: Question, shortest: float, tallest: float, longer_m: float) -> float:
    """The share of the population between two statures; where arms are longer, shorter people reach as far.

    Beyond the first and the last percentile that were looked at, people are taken to be as those are.
    """
    own = (question.sex, question.people)
    below = percentile_of(shortest - longer_m, *own) if percentile_of(shortest, *own) > LOWEST + 1e-6 else 0.0
    above = percentile_of(tallest + longer_m, *own) if percentile_of(tallest, *own) < HIGHEST - 1e-6 else 100.0
    return max(above - below, 0.0) / 100


def _worker(question: Question, stature: float, strength_percentile: float = 50.0) -> Worker:
    mass = float(np.clip(median_mass_kg(stature, question.sex, question.people), 40, 150))
    usual = Worker(human="natural", height_m=stature, mass_kg=mass, sex=question.sex)
    return usual.model_copy(update={"strength": at_percentile(usual.strength, strength_percentile)})


def _reaching(question: Question, stature: float, strength_percentile: float = 50.0) -> Motion | None:
    """A motion in which a worker of this stature holds the hand at the place as a person would, in any way."""
    for request in requests_of(question, stature, strength_percentile):
        motion = _tried(request.motion, request.accuracy)
        if motion is not None:
            return motion
    return None


def requests_of(question: Question, stature: float, strength_percentile: float = 50.0) -> Sequence[ReactionRequest]:
    """The motions that a worker of this stature tries: every way of holding the hand at the place."""
    operation = question.station.operations[question.operation]
    if operation.hand in ("either", "other"):  # as most people, the better hand is the right one
        operation = operation.model_copy(update={"hand": "right" if operation.hand == "either" else "left"})
    hands: tuple[Side, ...] = (
        SIDES if operation.hand == "both" else ("left",) if operation.hand == "left" else ("right",)
    )
    short = operation.model_copy(update={"places": (question.place,), "seconds": HOLD_S})
    station = question.station.model_copy(update={"operations": {question.operation: short}})
    part = Part(station, question.operation, hands, ("anybody",))
    return reaction_requests(experiment_of(part, {"anybody": _worker(question, stature, strength_percentile)}))


def _tried(request: MotionRequest, accuracy: Accuracy) -> Motion | None:
    try:
        motion = simulate(request)
    except FailedMotionError:
        return None
    quality = measure(request, motion)
    return None if odd_postures(quality) or quality.verdict(accuracy) == "failed" else motion


def strong_share(motion: Motion, worker: Worker) -> tuple[float, str]:
    """The share of people of the worker's sex with the strength that the work asks of each joint; the entry of least.

    Strength is taken for normal with the worker's as mean (see `strength_spread`).
    """
    strength = np.concatenate(maximum_torque(worker.strength).vectors())
    share = loads(motion.torque_nm[motion.phase("work")]).max(axis=0) / strength
    able = [1 - NormalDist().cdf((share[i] - 1) / _spread(name)) for i, name in enumerate(ENTRIES)]
    least = int(np.argmin(able))
    return float(able[least]), ENTRIES[least]


def _spread(entry: str) -> float:
    freedom, _, direction = entry.partition(":")
    way: Direction = "positive" if direction == "positive" else "negative"
    return strength_spread((freedom, way))

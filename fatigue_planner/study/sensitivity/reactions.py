"""The postural reactions of all points: each is found in the cache or simulated once, whatever the number of points."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from fatigue_planner.core.errors import LostWorkError
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.experiment.build import reaction_profile, reaction_requests, worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.reactions.cache import Outcome, ReactionCache
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest, Recorded, digests
from fatigue_planner.study.sensitivity.design import Point

Profiles = dict[ReactionName, CycleProfile]


@dataclass(frozen=True)
class Reacted:
    """The cycle profiles of a point's reactions, or None and the reason why some cannot be performed."""

    point: Point
    profiles: Profiles | None
    reason: str = ""


def unique_requests(points: Sequence[Point]) -> list[ReactionRequest]:
    """Every reaction that some point needs, once for each accuracy."""
    found = {
        request.asked: request
        for point in points
        if point.experiment is not None
        for request in reaction_requests(point.experiment)
    }
    return list(found.values())


def unique_digests(points: Sequence[Point]) -> dict[str, str]:
    """Digest of every reaction that any point needs, by a name that contains part of it, as names repeat."""
    return digests(replace(request, name=_own_name(request)) for request in unique_requests(points))


def react(
    points: Sequence[Point],
    cache: ReactionCache,
    executor: Executor,
    progress: Callable[[Outcome], None],
    command: str,
) -> list[Reacted]:
    """All points with the cycle profiles of their reactions.

    Reactions not in the cache are simulated and stored there. A point with a failed reaction has no profiles. Only one
    motion at a time is held in memory. `progress` is called for every reaction; `command` is what the user ran, for
    messages. Raises OutputFolderError, or, once all other reactions are stored, LostWorkError if simulations killed
    their workers: that says nothing about the points.
    """
    requests = unique_requests(points)
    outcomes = cache.complete(requests, executor, progress)
    lost = dict.fromkeys(f"{outcome.name}: {outcome.failure}" for outcome in outcomes if not outcome.kept)
    if lost:
        raise LostWorkError("\n".join(lost) + "\nAll other reactions are kept; the same command tries these again.")
    failures = {
        request.asked: outcome.failure
        for request, outcome in zip(requests, outcomes, strict=True)
        if outcome.verdict == "failed"
    }
    good = [request for request in requests if request.asked not in failures]
    needs: dict[tuple[str, Accuracy, Recorded | None], list[tuple[Point, Experiment, ReactionName]]] = {}
    reasons: dict[str, list[str]] = {}
    for point in points:
        if point.experiment is None:
            continue
        for request in reaction_requests(point.experiment):
            key = request.asked
            needs.setdefault(key, []).append((point, point.experiment, request.name))
            if key in failures:
                reasons.setdefault(point.name, []).append(f"{request.name}: {failures[key]}")
    profiles: dict[str, Profiles] = {point.name: {} for point in points}
    for request, reaction in zip(good, cache.stream(good, command), strict=True):
        assert isinstance(reaction, Reaction)  # failed ones are not among the good
        for point, experiment, name in needs[request.asked]:
            if point.name not in reasons:
                parameters = worker_fatigue(experiment)
                own = reaction_profile(experiment, parameters, name.worker, reaction.motion)
                profiles[point.name][name] = own
    return [_reacted(point, profiles[point.name], reasons.get(point.name, [])) for point in points]


def _reacted(point: Point, profiles: Profiles, reasons: list[str]) -> Reacted:
    if point.experiment is None or reasons:
        return Reacted(point, None, point.reason or " ".join(reasons))
    order = [request.name for request in reaction_requests(point.experiment)]
    return Reacted(point, {name: profiles[name] for name in order})


def _own_name(request: ReactionRequest) -> ReactionName:
    return request.name._replace(worker=f"{request.name.worker}_{request.digest[:DIGEST_LENGTH]}")

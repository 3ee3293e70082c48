"""Checks of what is said to a session: nothing that is no observation, time or pseudonym changes anything."""

import math
import re
from collections.abc import Mapping

from fatigue_planner.core.errors import CycleError, EvidenceError, SelectionError, listed, shortened
from fatigue_planner.live.events import UNCLEAR, Observed, Skipped
from fatigue_planner.live.limits import LATE_CYCLES, MAX_SECONDS
from fatigue_planner.live.shift import Shift
from fatigue_planner.pomdp.problem import Pomdp

MAX_PSEUDONYM_LENGTH = 64
MAX_UNSEEN_LIMIT = 10_000
KEY = re.compile(r"[0-9A-Za-z._-]{1,40}")


def check_cycle(cycle: object, shift: Shift) -> None:
    """Raise CycleError unless something may be said of this cycle."""
    if isinstance(cycle, bool) or not isinstance(cycle, int) or cycle < 1:
        raise CycleError(f"cycle {shortened(cycle)}: should be a number from 1.")
    if cycle != shift.cycle and shift.recent(cycle) is None:
        raise CycleError(
            f"cycle {cycle}: cannot be observed; the cycle going on is {shift.cycle}, and "
            f"only the last {LATE_CYCLES} before it may be told late."
        )


def check_action(name: str, action: object, model: Pomdp) -> None:
    """Raise EvidenceError for what is no action of the experiment."""
    if not isinstance(action, str) or action not in model.actions:
        raise EvidenceError(f"{name} {shortened(action)}: should be one of {listed(model.actions)}.")


def observed(
    cycle: int, executed: str, observation: object, likelihood: object, duration_s: object, model: Pomdp
) -> Observed:
    """What was seen of a cycle. Raises EvidenceError."""
    check_action("executed", executed, model)
    if observation is not None and likelihood is not None:
        raise EvidenceError("observation and likelihood: give one of them.")
    known = (*model.observations, UNCLEAR)
    if observation is not None and (not isinstance(observation, str) or observation not in known):
        raise EvidenceError(
            f"observation {shortened(observation)}: should be one of {listed(model.observations)}, or {UNCLEAR} for "
            "none of these."
        )
    return Observed(
        cycle=cycle,
        executed=executed,
        observation=None if observation is None else str(observation),
        likelihood=None if likelihood is None else likelihoods(likelihood, model.outcomes),
        duration_s=None if duration_s is None else seconds("duration_s", duration_s),
    )


def says_the_same(event: Observed, before: Observed | Skipped) -> bool:
    """Whether what is said of a cycle is what was said before."""
    return isinstance(before, Observed) and event == before.model_copy(update={"idle_s": 0.0, "late": False})


def seconds(name: str, value: object) -> float:
    """A number of seconds. Raises EvidenceError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= MAX_SECONDS:
        raise EvidenceError(f"{name} {shortened(value)}: should be a number of seconds from 0 to {MAX_SECONDS:.0f}.")
    return float(value)


def key(given: object) -> str | None:
    """What names a pause, None: nothing does. Raises EvidenceError."""
    if given is not None and not (isinstance(given, str) and KEY.fullmatch(given)):
        raise EvidenceError(
            f"key {shortened(given)}: should be a text of 1 to 40 letters, digits and ._- that names a pause."
        )
    return given


def likelihoods(given: object, outcomes: tuple[str, ...]) -> dict[str, float]:
    """Likelihoods by preference. Raises EvidenceError."""
    what = f"should be numbers from 0 to 1, not all 0, by preference: {listed(outcomes)}"
    if not isinstance(given, Mapping) or not given:
        raise EvidenceError(f"likelihood {shortened(given)}: {what}.")
    for name, value in given.items():
        if name not in outcomes:
            raise EvidenceError(f"likelihood.{shortened(name)}: {what}.")
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
            raise EvidenceError(f"likelihood.{name} = {shortened(value)}: {what}.")
    if not any(given.values()):
        raise EvidenceError(f"likelihood: {what}.")
    return {name: float(value) for name, value in given.items()}


def pseudonym(given: object) -> str:
    """A worker's pseudonym. Raises SelectionError."""
    is_text = isinstance(given, str) and 0 < len(given.strip()) <= MAX_PSEUDONYM_LENGTH
    if not is_text or any("\ud800" <= letter <= "\udfff" for letter in str(given)):
        raise SelectionError(
            f"pseudonym {shortened(given)}: should be a text of 1 to {MAX_PSEUDONYM_LENGTH} characters."
        )
    return str(given)


def deadline(given: object) -> float:
    """After how many seconds an answer is late. Raises SelectionError."""
    if isinstance(given, bool) or not isinstance(given, int | float) or not 0 < given < math.inf:
        raise SelectionError(f"deadline_s = {shortened(given)}: should be a positive number of seconds.")
    return float(given)


def unseen_limit(given: object) -> int:
    """After how many cycles that were not seen the schedule decides. Raises SelectionError."""
    if isinstance(given, bool) or not isinstance(given, int) or not 1 <= given <= MAX_UNSEEN_LIMIT:
        raise SelectionError(
            f"unseen_limit = {shortened(given)}: should be a number of cycles from 1 to {MAX_UNSEEN_LIMIT}."
        )
    return given

"""How likely joints are above a limit of fatigue, the pause that helps, and what no choice of the robot can help.

At rest an entry fades as df/dt = g - q f under every law, so from f it has fallen to a level L after

    ln((f - g / q) / (L - g / q)) / q  seconds,

by its own worker's rates. A belief has one such time per state; the pause that is told is long enough for ENOUGH of it.

A cycle maps an entry as f' = a f + o, towards its fixed point o / (1 - a). Whatever the robot does and the worker
chooses, an entry that is above the least of these fixed points stays above it. If that is above the limit, another
place, load or pace of the work helps, and the robot does not: that is a matter of work design.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.random_streams import Vector
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

Array = NDArray[np.float64]

# Assumptions, all four: no source says how sure an alarm should be, or how far a pause should go.
# An alarm is raised where the limit is passed with at least this probability, and cleared at the other or below.
RAISED, CLEARED = 0.5, 0.1
# A pause brings an entry to this fraction of the limit; else it would be wanted again at once.
RELIEF = 0.8
# With this probability a pause is long enough. Not less than 1 - CLEARED, so that the pause that is told clears.
ENOUGH = 0.9
# What comes is told so many cycles ahead: by then the paper's task has forgotten 90 % of the fatigue of now.
AHEAD = 12


@dataclass(frozen=True)
class JointLevel:
    """An entry against the limit, at the end of the last cycle.

    probability: that it is above the limit. pause_s: after which it is relieved; None if it never is.
    """

    entry: str
    probability: float
    pause_s: float | None


@dataclass(frozen=True)
class Passing(JointLevel):
    """An entry that is going to pass the limit: in so many cycles, if nothing more were seen; the pause needed then."""

    in_cycles: int


@dataclass(frozen=True)
class Levels:
    """All entries of a belief against a limit; those whose limit no action keeps are a matter of work design."""

    robot: tuple[JointLevel, ...]
    work_design: tuple[JointLevel, ...]


def levels(belief: Belief, limit: float) -> Levels:
    """How a belief stands against a limit of fatigue: the entries that may be above it, and those no action helps."""
    above, unaided = _above(belief, limit), _work_design(belief, limit)
    chosen = np.flatnonzero(unaided | (above > CLEARED))
    found = zip(chosen, pauses_s(belief, chosen, RELIEF * limit), strict=True)
    of: dict[bool, list[JointLevel]] = {True: [], False: []}
    for number, pause in found:
        of[bool(unaided[number])].append(JointLevel(_name(belief, number), float(above[number]), pause))
    return Levels(tuple(of[False]), tuple(of[True]))


def passings(
    belief: Belief, limit: float, plan: Callable[[Belief, int], int], rng: np.random.Generator
) -> tuple[Passing, ...]:
    """The entries that pass the limit within AHEAD cycles under a plan, if nothing more is seen; the first one first.

    plan(belief, n): the action of the n-th cycle from now, from 0. It may raise to break off.
    """
    told = _work_design(belief, limit) | (_above(belief, limit) >= RAISED)
    found: list[Passing] = []
    for n in range(AHEAD):
        belief = belief.predict(plan(belief, n), rng)
        above = _above(belief, limit)
        passed = np.flatnonzero((above >= RAISED) & ~told)
        for number, pause in zip(passed, pauses_s(belief, passed, RELIEF * limit), strict=True):
            found.append(Passing(_name(belief, number), float(above[number]), pause, in_cycles=n + 1))
        told |= above >= RAISED
    return tuple(found)


def pauses_s(belief: Belief, chosen: NDArray[np.intp], level: float) -> list[float | None]:
    """The pauses after which active entries (k,) are at a level or below, each with probability ENOUGH; None: never."""
    if not chosen.size:
        return []
    worker = belief.states[:, -1].astype(np.intp)
    fade, grow = (table[:, chosen][worker] for table in _model(belief).rest_rates())
    times = fading_s(belief.states[:, chosen], level, fade, grow)
    found: list[float | None] = []
    for column in times.T:
        order = np.argsort(column, kind="stable")
        reached = np.cumsum(belief.weights[order])
        enough = column[order[min(int(np.searchsorted(reached, ENOUGH * reached[-1])), order.size - 1)]]
        found.append(float(enough) if np.isfinite(enough) else None)
    return found


def fading_s(fatigue: Array, level: float, fade: Array, grow: Array) -> Array:
    """The times after which fatigues have fallen to a level, all of one shape; 0 where they are there, inf: never."""
    floor = np.divide(grow, fade, out=np.full_like(fade, np.inf), where=fade > 0)
    falls = (fatigue > level) & (floor < level)
    times = np.where(fatigue > level, np.inf, 0.0)
    times[falls] = np.log((fatigue[falls] - floor[falls]) / (level - floor[falls])) / fade[falls]
    return times


def half_life_s(model: FatiguePomdp) -> float:
    """The time in which half of the fatigue fades at rest, of the most enduring entry and worker."""
    fade, _ = model.rest_rates()
    return float(np.log(2) / fade[:, : model.active_entries.size].min())


def _above(belief: Belief, limit: float) -> Vector:
    """The probabilities that active entries are above a limit, (n,)."""
    fatigue = belief.states[:, : _model(belief).active_entries.size]
    return np.asarray(belief.weights @ (fatigue > limit))


def _work_design(belief: Belief, limit: float) -> NDArray[np.bool_]:
    """Which active entries no action keeps below the limit, whatever the reactions, for most of the belief, (n,)."""
    model = _model(belief)
    shape = (len(model.workers.expertise), -1, model.arrays.gain.shape[1])
    gain, offset = (table.reshape(shape)[..., : model.active_entries.size] for table in model.arrays[:2])
    least = np.divide(offset, 1 - gain, out=np.full_like(offset, np.inf), where=gain < 1).min(axis=1)
    own = least[belief.states[:, -1].astype(np.intp)]
    return np.asarray(belief.weights @ (own > limit) >= RAISED)


def _model(belief: Belief) -> FatiguePomdp:
    assert isinstance(belief.model, FatiguePomdp)
    return belief.model


def _name(belief: Belief, number: np.intp) -> str:
    return ENTRIES[int(_model(belief).active_entries[number])]

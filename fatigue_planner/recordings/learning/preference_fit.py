"""Which weights and stiffnesses of a preference bring the digital human closest to recorded motions.

The inverse of a simulation: of every task of the preference a weight and a stiffness are sought such that the angles of
the simulated motions are least off the recorded ones, in the root of the mean square over recordings, ticks and degrees
of freedom. The search is Nelder and Mead's (1965, The Computer Journal 7:308) in logarithms of both, from the
preference as it is: it finds a local optimum. That a preference fits what it was fitted to is no proof; so its error
is also told of people to whom it was not fitted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fatigue_planner.core.errors import FailedMotionError, LostWorkError
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.simulator import Simulator, simulate
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.reactions.reaction import ReactionName

Array = NDArray[np.float64]

# A weight or stiffness is changed by at most this factor (assumed).
MOST = 100.0
# The first step of the search, as a factor, and when it ends, in shares and in degrees.
STEP, NEAR, FLAT_DEG = 2.0, 0.01, 0.001
# How far a motion counts as off that cannot be simulated.
FAILED_DEG = 180.0
DIGITS = 3  # of what is found


class Example(NamedTuple):
    """A recorded reaction: its name, the request of a simulated one in its place, and its angles (T, 39) in degrees."""

    name: ReactionName
    request: MotionRequest
    angles_deg: Array


@dataclass(frozen=True)
class PreferenceFit:
    """What was found.

    preference  fitted to all recordings
    names       of the recordings (n,)
    before_deg, after_deg  root of the mean square over a recording's ticks of how far the angles are off (n, 39), with
        the preference as it was, and with the fitted one
    others_deg  the same with the preference fitted to the recordings of other people; None if there is only one person
    """

    preference: Preference
    names: tuple[ReactionName, ...]
    before_deg: Array
    after_deg: Array
    others_deg: Array | None

    @property
    def helps(self) -> bool | None:
        """Whether people are met better to whom it was not fitted; None if that is not known."""
        return None if self.others_deg is None else rms(self.others_deg) < rms(self.before_deg)


def rms(values: Array) -> float:
    """The root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def searches(examples: Sequence[Example]) -> dict[str, list[Example]]:
    """What the preference is fitted to: all recordings, by ""; and by person, if there are several, those of others."""
    people = dict.fromkeys(example.name.worker for example in examples)
    without = {person: [example for example in examples if example.name.worker != person] for person in people}
    return {"": list(examples)} | (without if len(people) > 1 else {})


def fit_preference(
    examples: Sequence[Example], evaluations: int, executor: Executor, searched: Callable[[], object] = lambda: None
) -> PreferenceFit:
    """The fit to recordings of one preference, which has tasks; each search simulates every motion so many times.

    `searched` is called after each of the `searches`. Raises FailedMotionError if no motion can be simulated with the
    preference as it is: a search could not tell where to go from there. LostWorkError if one is lost with its worker.
    """
    before, parts = examples[0].request.preference, searches(examples)
    _check_begin(examples)
    found: dict[str, Preference] = {}
    for index, made in executor.run(partial(_searched, evaluations=evaluations), list(parts.values())):
        if isinstance(made, Lost):
            raise LostWorkError(f"A search was given up: {made.reason}.")
        found[list(parts)[index]] = made
        searched()
    others = None
    if len(parts) > 1:
        others = np.array([off_deg(found[example.name.worker], example) for example in examples])
    return PreferenceFit(
        found[""],
        tuple(example.name for example in examples),
        np.array([off_deg(before, example) for example in examples]),
        np.array([off_deg(found[""], example) for example in examples]),
        others,
    )


def _check_begin(examples: Sequence[Example]) -> None:
    """Raise FailedMotionError, with the reasons, if no motion can be simulated with the preference as it is."""
    reasons = ""
    for example in examples:
        try:
            simulate(example.request)
        except FailedMotionError as error:
            reasons += f"\n  {example.name}: {error}"
        else:
            return
    raise FailedMotionError(f"No motion can be simulated with the preference as it is, where a search begins:{reasons}")


def off_deg(preference: Preference, example: Example) -> Array:
    """How far the angles of a simulated motion are off the recorded ones, RMS over the ticks (39,)."""
    try:
        motion = simulate(replace(example.request, preference=preference))
    except FailedMotionError:
        return np.full(example.angles_deg.shape[1], FAILED_DEG)
    return np.asarray(np.sqrt(np.mean((angles_deg(motion) - example.angles_deg) ** 2, axis=0)))


def angles_deg(motion: Motion) -> Array:
    """The joint angles (T, 39) of a motion in degrees."""
    return np.degrees(motion.configuration[:, BASE_DOF + 1 :])


def scaled(preference: Preference, stiffness_per_s2: Sequence[float], factors: Array) -> Preference:
    """The preference with weights and stiffnesses times these factors (tasks, 2), in few digits."""
    tasks = [
        task.model_copy(
            update={"weight": _short(task.weight * weight), "stiffness_per_s2": _short(stiffness * stiffer)}
        )
        for task, stiffness, (weight, stiffer) in zip(preference.tasks, stiffness_per_s2, factors, strict=True)
    ]
    return preference.model_copy(update={"tasks": tuple(tasks)})


def stiffnesses_of(request: MotionRequest) -> list[float]:
    """The stiffness of every task of a request's preference, its own or the controller's, in 1/s^2."""
    body, stiffness = Simulator(request).body, request.controller.stiffness_per_s2
    return [task.build_stiffened(body.human, body.state, stiffness).stiffness for task in request.preference.tasks]


def _searched(examples: Sequence[Example], evaluations: int) -> Preference:
    before, stiffness_per_s2 = examples[0].request.preference, stiffnesses_of(examples[0].request)

    def made(logarithms: Array) -> Preference:
        return scaled(before, stiffness_per_s2, np.exp(logarithms).reshape(-1, 2))

    def off(logarithms: Array) -> float:
        preference = made(logarithms)
        return rms(np.array([off_deg(preference, example) for example in examples]))

    start = np.zeros(2 * len(before.tasks))
    simplex = np.vstack([start, start + np.log(STEP) * np.eye(len(start))])
    found = minimize(
        off,
        start,
        method="Nelder-Mead",
        bounds=[(-np.log(MOST), np.log(MOST))] * len(start),
        options={"maxfev": evaluations, "xatol": NEAR, "fatol": FLAT_DEG, "initial_simplex": simplex},
    )
    return made(found.x)


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")

"""What was learnt of a worker: parameters, models compared, what the data cannot tell, and a worker to plan with."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fatigue_planner.core.text import counted, listing
from fatigue_planner.recordings.learning.estimate import CRITICAL, MODELS, Estimator, Fit, Interval
from fatigue_planner.recordings.learning.likelihood import UNSEEN

# Half the width of a 95 % interval in standard errors; the same and 80 % power.
HALF, DETECTED = math.sqrt(CRITICAL), math.sqrt(CRITICAL) + 0.841621
# Models whose AIC differs by less are as good as each other (Burnham and Anderson 2002, section 2.6).
AS_GOOD = 2.0
# More cycles than that are as good as none that would do.
ENDLESS = 1_000_000
POINTS, LEAST_WEIGHT = 7, 1e-3


@dataclass(frozen=True)
class Parameter:
    """A parameter and its interval, told from 0 or not.

    more_cycles: about how many more of the same kind would tell it from 0 in 4 of 5 cases, were it as large as
    estimated; 0 if it is told already, None where that cannot be said: the estimate is 0, endless, or too near to 0.
    """

    name: str
    interval: Interval
    more_cycles: int | None

    @property
    def is_told(self) -> bool:
        """Whether the interval leaves 0 out."""
        return self.interval.low > 0 or self.interval.high < 0


@dataclass(frozen=True)
class Learnt:
    """All of it. fits: by model; chosen: the model with the lowest AIC; as_good: others that are as good as it."""

    parameters: tuple[Parameter, ...]
    fits: dict[str, Fit]
    chosen: str
    as_good: tuple[str, ...]
    cycles: int
    seen: int
    worker: dict[str, Any]

    def sentences(self) -> list[str]:
        """What the data cannot tell, and what would."""
        found = []
        beta = self.parameters[0]
        for parameter in self.parameters:
            if parameter.is_told:
                continue
            more = (
                "how many more cycles would cannot be said"
                if parameter.more_cycles is None
                else f"about {counted(parameter.more_cycles, 'more cycle')} of this kind would, were it as estimated"
            )
            found.append(f"The data cannot tell {parameter.name} from 0: {more}.")
        if math.isinf(beta.interval.high):
            found.append(
                "The data cannot tell beta from infinity, an expert's: no choice against the costs was certain."
            )
        if self.as_good:
            found.append(f"The data cannot tell whether {self.chosen} or {listing(self.as_good)} is the better model.")
        return found


def summary(estimator: Estimator, largest: Fit, preferences: Sequence[str]) -> Learnt:
    """What the cycles of an estimator say; `largest` is its fit of the model with all parameters."""
    fits = {name: largest if name == "inertia" else estimator.fit(name) for name in MODELS}
    order = sorted(fits, key=lambda name: fits[name].aic)
    chosen = order[0]
    as_good = tuple(name for name in order[1:] if fits[name].aic - fits[chosen].aic < AS_GOOD)
    names = ["beta", *(f"the offset of {name}" for name in preferences[1:]), "inertia"]
    seen = int((estimator.choices.seen != UNSEEN).sum())
    parameters = []
    for index, name in enumerate(names):
        interval = estimator.interval(largest, "inertia", index)
        parameters.append(Parameter(name, interval, _more(interval, len(estimator.choices.seen))))
    worker = learnt_worker(estimator, fits[chosen], chosen, preferences)
    return Learnt(tuple(parameters), fits, chosen, as_good, len(estimator.choices.seen), seen, worker)


def _more(interval: Interval, cycles: int) -> int | None:
    """See Parameter.more_cycles: standard errors fall with the root of the number of cycles."""
    if interval.low > 0 or interval.high < 0:
        return 0
    estimate = abs(interval.estimate)
    end = interval.low if interval.estimate > 0 else interval.high  # the one beyond 0
    other = interval.high if interval.estimate > 0 else interval.low
    width = abs(end - interval.estimate) if end != 0 else abs(other - interval.estimate)
    if estimate == 0 or not math.isfinite(width) or math.isinf(estimate):
        return None
    more = cycles * ((DETECTED * width / HALF / estimate) ** 2 - 1)
    return max(1, math.ceil(more)) if more < ENDLESS else None


def learnt_worker(estimator: Estimator, fit: Fit, model: str, preferences: Sequence[str]) -> dict[str, Any]:
    """The worker as `hidden_workers` and `choice_models` of an experiment; betas by their profile likelihood."""
    interval = estimator.interval(fit, model, 0)
    unit, most = estimator.scale, estimator.most_beta
    low, high = interval.low * unit, min(interval.high * unit, most)
    if math.isinf(interval.high):
        points = np.append(np.geomspace(max(low, most / 1000), most, POINTS)[:-1], most)
    else:
        points = np.linspace(low, high, POINTS)
    weights = []
    start = fit.point
    for point in points:
        there = estimator.fit(model, {0: float(point)}, start)
        weights.append(math.exp(min(0.0, there.log_likelihood - fit.log_likelihood)))
    kept = [(p, w) for p, w in zip(points, weights, strict=True) if w > LEAST_WEIGHT * max(weights)]
    total = sum(w for _, w in kept)
    values = [math.inf if math.isinf(interval.high) and p == points[-1] else float(f"{p / unit:.6g}") for p, _ in kept]
    chances = [w / total for _, w in kept]
    worker: dict[str, Any] = {
        "hidden_workers": {"learnt": {"expertise": {"kind": "choice", "values": values, "probabilities": chances}}}
    }
    offsets = {name: round(float(w), 4) for name, w in zip(preferences, fit.offsets, strict=True)}
    if model == "offset":
        worker["choice_models"] = {"learnt": {"kind": "offset", "offsets": offsets}}
    elif model == "inertia":
        inertia = round(fit.inertia, 4)
        worker["choice_models"] = {"learnt": {"kind": "inertia", "inertia": inertia, "offsets": offsets}}
    return worker

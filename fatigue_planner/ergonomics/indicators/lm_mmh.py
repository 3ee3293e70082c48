"""Liberty Mutual's equations: the share of people for whom a lift, lower, push, pull or carry is acceptable for 8 h."""

from typing import ClassVar, Literal

from pydantic import Field

from fatigue_planner.ergonomics.indicators.niosh_lifting import end_height_m, place_of, work_of
from fatigue_planner.ergonomics.indicators.percent_capable import CapableShare
from fatigue_planner.ergonomics.liberty_mutual import EQUATIONS, LEAST_PER_MINUTE, Kind, limits
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Moment, Origin, Phrase, Span
from fatigue_planner.human.skeleton import SIDES

KINDS: dict[str, tuple[Kind, ...]] = {
    "lift": ("lift",), "lower": ("lower",), "carry": ("carry",), "push": ("push initial", "push sustained"),
    "pull": ("pull initial", "pull sustained"),
}  # fmt: skip


class LibertyMutual(CapableShare):
    """The share of people of the worker's sex; the least of all handling in the cycle.

    A push or pull is judged by its initial and its sustained force, both as large as the stated load; a load in kg is a
    force / 9.81.
    """

    title: ClassVar[str] = "percent capable by Liberty Mutual"
    edition: ClassVar[str] = "LM-MMH equations, Potvin et al. 2021; the limit of a quarter is recalled"
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["lm_mmh"] = Field(default="lm_mmh", description="Liberty Mutual equations (Potvin et al. 2021).")

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        least, worst, parts = 101.0, None, {}
        handled = [operation for operation in job.operations if operation.stated.handling != "none"]
        if not handled:
            return self.does_not_apply(Phrase("no load is lifted, lowered, pushed, pulled or carried"))
        for operation in handled:
            for kind in KINDS[operation.stated.handling]:
                found = capable(operation, kind, job.cycle_s)
                if isinstance(found, Phrase):
                    return self.does_not_apply(found)
                if found["percent"] < least:
                    least, parts = found["percent"], found
                    time_s = float(operation.posture.time_s[work_of(operation)[0]])
                    worst = Moment(operation.name, time_s, "", kind)
        level = self.level_of(least)
        return self.answer(
            value=Span(least, least),
            unit="%",
            levels=(level, level),
            words=(self.words[level],) * 2,
            worst=worst,
            parts=parts,
            remarks=(
                Phrase("Of people of the worker's sex; for 8 h, with handles, smooth and without twisting."),
                Phrase("To be read with care where many tasks follow each other."),
            ),
        )


def capable(operation: Operation, kind: Kind, cycle_s: float) -> dict[str, float] | Phrase:
    """The share in % and what it is made of, or why the equations may not be used."""
    sex, stated = operation.request.worker.sex, operation.stated
    if len(operation.request.action.goals()) < len(SIDES):
        return Phrase("one hand works; the equations are for two")
    begin, end = work_of(operation)
    place = place_of(operation, begin)
    per_minute = max(60 * stated.times_per_cycle / cycle_s, LEAST_PER_MINUTE)
    middle_m = 0.0
    if kind in ("lift", "lower"):
        end_m = end_height_m(operation)
        if end_m is None:
            return Phrase("where the load is set down is not stated (end_height_m)")
        hands_m, way_m, middle_m = (
            place.horizontal / 100,
            abs(end_m - place.height / 100),
            (end_m + place.height / 100) / 2,
        )
    else:
        if stated.moved_m is None:
            return Phrase("how far the load is moved is not stated (moved_m)")
        hands_m, way_m = place.height / 100, stated.moved_m
    allowed = limits(kind, sex)
    inputs = {
        "reach" if kind in ("lift", "lower") else "height of the hands": (hands_m, *allowed.hands_m, "m"),
        "way": (way_m, *allowed.way_m, "m"),
        "frequency": (per_minute, 0.0, allowed.most_per_minute, "a minute"),
        "speed": (way_m * per_minute, 0.0, allowed.most_speed_m_per_minute, "m a minute"),
    }
    for name, (value, low, high, unit) in inputs.items():
        if not low <= value <= high:
            values: dict[str, str | float] = {"name": name, "value": value, "low": low, "high": high, "unit": unit}
            return Phrase("{name} is {value:.3g} {unit}; the equations are for {low:g} to {high:g}", values)
    load_kg = float(operation.load_kg[begin : end + 1].sum(axis=1).max())
    equation = EQUATIONS[kind, sex]
    median_kg = equation.median_kg(hands_m, way_m, per_minute, middle_m)
    return {
        "percent": equation.capable_percent(load_kg, median_kg),
        "load_kg": load_kg,
        "acceptable for half_kg": median_kg,
        "hands_m": hands_m,
        "way_m": way_m,
        "per_minute": per_minute,
    }

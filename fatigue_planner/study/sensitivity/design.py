"""The points of a study: one factor at a time, and all at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.experiment.loader import parse_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.semantic_checks import semantic_errors
from fatigue_planner.study.sensitivity.factors import Level, level_text
from fatigue_planner.study.sensitivity.study import Study

Design = Literal["base", "one at a time", "space filling"]


@dataclass(frozen=True)
class Point:
    """A level for every factor.

    factor: the factor that differs from the base experiment, where only one does; experiment: None where the levels
    make no valid experiment, and `reason` says why.
    """

    name: str
    design: Design
    factor: str
    levels: Mapping[str, Level]
    experiment: Experiment | None
    reason: str = ""


def design(study: Study) -> list[Point]:
    """The base experiment, each factor's other levels alone, and, if asked for, combinations of levels of all factors.

    The combinations are the first points of a scrambled Sobol sequence, so a study with twice as many points begins
    with the same ones (if it has the same factors).
    """
    base = study.base_levels()
    points = [_point(study, "base", "base", "", {}, base)]
    for name, factor in study.settings.factors.items():
        others = [level for level in factor.all_levels() if level != base[name]]
        points += [
            _point(study, f"{name}={level_text(level)}", "one at a time", name, {name: level}, base | {name: level})
            for level in others
        ]
    for number, positions in enumerate(_unit_cube(study)):
        factors = study.settings.factors.items()
        levels = {name: factor.level_at(position) for (name, factor), position in zip(factors, positions, strict=True)}
        points.append(_point(study, f"combination {number + 1}", "space filling", "", levels, levels))
    return points


def _point(
    study: Study, name: str, kind: Design, factor: str, changes: Mapping[str, Level], levels: Mapping[str, Level]
) -> Point:
    try:
        experiment = parse_experiment(study.changed(changes), name)
    except ExperimentError as error:
        return Point(name, kind, factor, levels, None, str(error).replace("\n", "; "))
    errors = semantic_errors(experiment)
    return Point(name, kind, factor, levels, None if errors else experiment, "; ".join(errors))


def _unit_cube(study: Study) -> list[list[float]]:
    """Points (n, factors) in [0, 1)."""
    from scipy.stats import qmc  # noqa: PLC0415 - takes half a second

    filling = study.settings.space_filling
    if filling is None:
        return []
    sequence = qmc.Sobol(len(study.settings.factors), rng=random_stream(filling.seed, "space filling"))
    return [list(map(float, row)) for row in sequence.random(filling.points)]

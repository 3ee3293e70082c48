"""The body and the strength of a station's workers."""

from dataclasses import dataclass

from pydantic import ValidationError

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.model import Worker
from fatigue_planner.human.population import median_mass_kg, percentile_of, stature_m
from fatigue_planner.human.strength_sets import at_percentile
from fatigue_planner.motion.settings import Side
from fatigue_planner.station.schema import Station


@dataclass(frozen=True)
class WorkerFacts:
    """A worker as the results show him or her.

    stature_percentile: of the women or men of the population, of people who were measured, too; measured: whether the
    stature was given. strength: the name of the set, at its percentile.
    """

    name: str
    sex: Sex
    stature_m: float
    mass_kg: float
    stature_percentile: float
    strength_percentile: float
    strength: str
    handedness: Side
    measured: bool


def facts_of(station: Station, name: str) -> WorkerFacts:
    """The worker of a name, with what follows from percentile and population."""
    said = station.workers[name]
    own = station.population.people(said.sex) if station.population else None
    stature = said.height_m
    if stature is None:
        assert said.percentile is not None
        stature = round(stature_m(said.percentile, said.sex, own), 4)
    mass = round(median_mass_kg(stature, said.sex, own), 1) if said.mass_kg is None else said.mass_kg
    average = said.strength or ("average_woman" if said.sex == "female" else "average_man")
    return WorkerFacts(
        name,
        said.sex,
        stature,
        mass,
        percentile_of(stature, said.sex, own),
        said.strength_percentile,
        at_percentile(average, said.strength_percentile),
        said.handedness,
        said.height_m is not None,
    )


def worker_of(station: Station, name: str) -> Worker:
    """The worker of a name for an experiment. Raises DataFileError for a body that cannot be simulated."""
    facts = facts_of(station, name)
    return make_worker(facts.stature_m, facts.mass_kg, facts.sex, facts.strength)


def make_worker(stature: float, mass: float, sex: Sex, strength: str) -> Worker:
    """A worker of these measures. Raises DataFileError for a body that cannot be simulated."""
    try:
        return Worker(human="natural", height_m=stature, mass_kg=mass, sex=sex, strength=strength)
    except ValidationError as error:
        fault = error.errors()[0]
        raise DataFileError(f"{fault['loc'][0]} = {fault['input']:g}: {fault['msg'].lower()}.") from error

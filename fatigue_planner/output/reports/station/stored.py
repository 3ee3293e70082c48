"""What a comparison reads of an assessment that was written: `assessment.json`."""

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from fatigue_planner.core.errors import MissingTableError, StaleTableError
from fatigue_planner.ergonomics.result import Level
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.station.assessment import Outcome
from fatigue_planner.station.tables import ASSESSMENT
from fatigue_planner.station.workers import WorkerFacts


class _Stored(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class StoredRule(_Stored):
    """See station.assessment.Rule."""

    title: str
    not_acceptable_s: float | None


class StoredFatigue(_Stored):
    """See station.assessment.Fatigue."""

    peak: float
    entry: str


class Graded(_Stored):
    """Something that has a level, by its name."""

    level: str | None

    def grade(self) -> Level | None:
        """The level. Raises KeyError for one that is unknown."""
        return None if self.level is None else Level[self.level.upper()]


class StoredPlace(Graded):
    """See station.assessment.PlaceSummary."""

    operation: str
    place: str
    missed_by: tuple[str, ...]
    by: tuple[StoredRule, ...]
    peak: float | None
    entry: str

    @property
    def seconds(self) -> float:
        """The seconds of a cycle that are not acceptable by the rule that finds most."""
        return max((rule.not_acceptable_s or 0.0 for rule in self.by), default=0.0)


class StoredPlaceForWorker(Graded):
    """See station.assessment.PlaceForWorker."""

    worker: str
    operation: str
    place: str
    way: str | None
    outcome: Outcome


class StoredShare(_Stored):
    """See station.assessment.ReachShare."""

    operation: str
    place: str
    sex: Sex
    share: float
    strong_share: float | None


class StoredCycle(Graded):
    """See station.assessment.WholeCycle."""

    worker: str
    fatigue: StoredFatigue


class StoredBest(_Stored):
    """See station.assessment.BestPlaces."""

    places: dict[str, str]


class StoredAssessment(_Stored):
    """See station.assessment.StationAssessment."""

    station: dict[str, Any]
    workers: tuple[WorkerFacts, ...]
    places: tuple[StoredPlaceForWorker, ...]
    summaries: tuple[StoredPlace, ...]
    shares: tuple[StoredShare, ...]
    cycles: tuple[StoredCycle, ...]
    best: StoredBest
    station_digest: str
    version: str


def is_assessment(path: Path) -> bool:
    """Whether a path is the folder of an assessment, or its file."""
    return path.suffix == ".json" or (path / ASSESSMENT).is_file()


def read_assessment(path: Path) -> StoredAssessment:
    """The assessment of a folder, or of its file.

    Raises MissingTableError if there is none, StaleTableError if it is not as this version writes it.
    """
    file = path if path.suffix == ".json" else path / ASSESSMENT
    try:
        found = StoredAssessment.model_validate_json(file.read_bytes())
        _ = [each.grade() for each in (*found.places, *found.summaries, *found.cycles)]
    except OSError as error:
        raise MissingTableError(f"{file}: cannot be read. Run `fatplan assess` first.") from error
    except (ValidationError, KeyError) as error:
        raise StaleTableError(f"{file}: is not an assessment of this version. Run `fatplan assess` again.") from error
    return found

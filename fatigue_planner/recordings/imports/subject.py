"""Who was recorded: a file about a person, and the worker of an experiment that he or she is."""

from pathlib import Path

from pydantic import Field

from fatigue_planner.core.errors import RecordingError, listed
from fatigue_planner.core.settings import Name, Settings, load_data
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.anthropometry import Sex


class Subject(Settings):
    """Content of a subject file. It has no place for a name, a date of birth or anything else that says who it is."""

    worker: Name | None = Field(
        default=None, description="Which worker of the experiment it is. Default: the one who has this body."
    )
    height_m: float = Field(ge=1.4, le=2.1, description="Stature in m.")
    mass_kg: float = Field(ge=40, le=150, description="Body mass in kg, with empty hands.")
    sex: Sex = Field(description="Decides how the mass is distributed over the segments (de Leva 1996).")
    static: tuple[str, ...] = Field(
        default=(),
        max_length=2,
        description="Files of a static trial, beside this one: the markers of the person who stands as in the stance, "
        "and perhaps the plates. Default: none.",
    )


def load_subject(path: Path) -> Subject:
    """The subject of a YAML file. Raises DataFileError: every key that is wrong."""
    return load_data(path, Subject)


def static_files(path: Path, subject: Subject) -> list[Path]:
    """The files of the static trial that a subject file names, relative to its folder."""
    return [path.parent / name for name in subject.static]


def worker_of(experiment: Experiment, subject: Subject, source: Path) -> str:
    """The worker of the experiment who has the subject's body. Raises RecordingError if there is none, or several."""
    alike = [name for name, worker in experiment.workers.items() if not _differences(subject, worker)]
    if subject.worker is None:
        if len(alike) == 1:
            return alike[0]
        told = f"{listed(alike)} have" if alike else "no worker of the experiment has"
        raise RecordingError(
            f"{source}: {told} this body: {subject.height_m:g} m, {subject.mass_kg:g} kg, {subject.sex}. "
            + ("Say which one with `worker`." if alike else "Torques are a body's own: give the worker the subject's.")
        )
    if subject.worker not in experiment.workers:
        raise RecordingError(
            f"{source}: worker = {subject.worker!r}: is not one of the experiment's {listed(experiment.workers)}."
        )
    if differences := _differences(subject, experiment.workers[subject.worker]):
        raise RecordingError(
            f"{source}: the experiment's {subject.worker} has another body: {'; '.join(differences)}. Torques are a "
            "body's own: give the worker the subject's."
        )
    return subject.worker


def _differences(subject: Subject, worker: Settings) -> list[str]:
    return [
        f"{key} = {getattr(worker, key)}, not {getattr(subject, key)}"
        for key in ("height_m", "mass_kg", "sex")
        if getattr(worker, key) != getattr(subject, key)
    ]

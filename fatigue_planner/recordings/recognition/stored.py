"""The file of a recogniser: JSON, whole, with the key of what decided it; read without trust."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from fatigue_planner.core.errors import RecognitionError
from fatigue_planner.core.files import digest_of, digests_of_package, publish_with_checksum, read_with_checksum
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.core.settings import Name, Settings
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.recordings.recognition.action_model import ActionModel
from fatigue_planner.recordings.recognition.confusion import Confusion
from fatigue_planner.recordings.recognition.recogniser import KnownAction, Recogniser
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, CaptureError

MAX_BYTES = 200_000_000
SOURCES = ("recordings/recognition", "core/random_streams.py")

Row = tuple[float, ...]
Table = tuple[Row, ...]


class StoredAction(Settings):
    """What is known of the reactions to an action; see `KnownAction` and `ActionModel`, whose arrays these are."""

    preferences: tuple[Name, ...] = Field(min_length=1)
    degrees_of_freedom: tuple[str, ...]
    mean_deg: tuple[Table, ...]
    variance_deg2: tuple[Annotated[float, Field(gt=0)], ...]
    correlation: Table
    people: tuple[Annotated[int, Field(ge=2)], ...]
    told_apart: Table
    groups: tuple[Annotated[int, Field(ge=0)], ...]
    recognised: tuple[Name, ...] = Field(min_length=1)
    counts: tuple[tuple[Annotated[int, Field(ge=0)], ...], ...]
    effective: tuple[Annotated[float, Field(gt=0)], ...]
    lapse: float = Field(gt=0, lt=1)

    @model_validator(mode="after")
    def _check(self) -> Self:
        """Shapes that fit, known names, and a covariance that is one."""
        n, joints = len(self.preferences), len(self.degrees_of_freedom)
        shapes = {
            "mean_deg": (n, N_PARTS, joints), "variance_deg2": (joints,), "correlation": (N_PARTS, N_PARTS),
            "people": (n,), "told_apart": (n, n), "groups": (n,), "counts": (n, len(self.recognised)),
            "effective": (n,),
        }  # fmt: skip
        for name, shape in shapes.items():
            if np.array(getattr(self, name)).shape != shape:
                raise ValueError(f"{name}: has not the shape {shape}")
        if unknown := set(self.degrees_of_freedom) - set(DEGREES_OF_FREEDOM):
            raise ValueError(
                f"degrees_of_freedom: {', '.join(sorted(unknown))}: the digital human has none of this name"
            )
        if set(self.groups) != set(range(len(self.recognised))):
            raise ValueError("groups: are not those of `recognised`")
        if not np.array(self.counts).sum(axis=1).all():
            raise ValueError("counts: a preference was never shown")
        if not np.linalg.eigvalsh(np.array(self.correlation)).min() > 0:
            raise ValueError("correlation: is no covariance")
        return self

    @classmethod
    def of(cls, known: KnownAction) -> Self:
        """The values of what is known."""
        model, confusion = known.model, known.confusion
        return cls.model_validate(
            {
                "preferences": model.preferences,
                "degrees_of_freedom": [DEGREES_OF_FREEDOM[joint] for joint in model.joints],
                "mean_deg": model.mean_deg.tolist(),
                "variance_deg2": model.variance_deg2.tolist(),
                "correlation": model.correlation.tolist(),
                "people": model.people.tolist(),
                "told_apart": known.apart.tolist(),
                "groups": known.groups.tolist(),
                "recognised": confusion.recognised,
                "counts": confusion.counts.tolist(),
                "effective": confusion.effective.tolist(),
                "lapse": known.lapse,
            }
        )

    def known(self) -> KnownAction:
        """What is known, with arrays."""
        joints = np.array([DEGREES_OF_FREEDOM.index(name) for name in self.degrees_of_freedom], np.int64)
        model = ActionModel(
            self.preferences, joints, np.array(self.mean_deg), np.array(self.variance_deg2),
            np.array(self.correlation), np.array(self.people),
        )  # fmt: skip
        confusion = Confusion(self.preferences, self.recognised, np.array(self.counts), np.array(self.effective))
        return KnownAction(model, np.array(self.told_apart), np.array(self.groups), confusion, self.lapse)


class StoredRecogniser(Settings):
    """A recogniser and what decided it.

    reactions: the digest of every reaction that it was trained with, by name, or, where `capture` is None, of every
    recorded repetition, by who does what how and its number; sources and versions: of the program.
    """

    format: Literal[1] = 1
    experiment: Name
    reactions: dict[str, str]
    capture: CaptureError | None
    told_apart_from: float
    sources: dict[str, str]
    versions: dict[str, str]
    cycle: Cycle
    temperature: Annotated[tuple[Annotated[float, Field(ge=1)], ...], Field(min_length=N_PARTS, max_length=N_PARTS)]
    actions: dict[Name, StoredAction]

    @property
    def is_simulated(self) -> bool:
        """Whether it was trained with simulated reactions."""
        return self.capture is not None

    @property
    def key(self) -> str:
        """SHA-256, in hex, of what decided it."""
        deciding = self.plain()
        return digest_of(
            {name: deciding[name] for name in ("reactions", "capture", "told_apart_from", "sources", "versions")}
        )

    @classmethod
    def of(
        cls,
        recogniser: Recogniser,
        experiment: str,
        reactions: dict[str, str],
        capture: CaptureError | None,
        told_apart: float,
    ) -> Self:
        """The recogniser that this program has trained with these reactions."""
        return cls(
            experiment=experiment,
            reactions=reactions,
            capture=capture,
            told_apart_from=told_apart,
            sources=digests_of_package(*SOURCES),
            versions=versions_of("numpy", "scipy"),
            cycle=recogniser.cycle,
            temperature=tuple(recogniser.temperature.tolist()),
            actions={action: StoredAction.of(known) for action, known in recogniser.actions.items()},
        )

    def recogniser(self) -> Recogniser:
        """The recogniser, ready to be asked."""
        known = {action: stored.known() for action, stored in self.actions.items()}
        return Recogniser(self.cycle, known, np.array(self.temperature))

    def publish(self, path: Path) -> None:
        """Write the file, whole or not at all. Raises OutputFolderError."""
        publish_with_checksum(path, {**self.plain(), "key": self.key})


def load_recogniser(path: Path) -> StoredRecogniser:
    """The recogniser in a file. Raises RecognitionError, naming what is wrong, if it is none or was changed."""
    how = "Make it again with `fatplan record recognise`."
    try:
        size = path.stat().st_size if path.is_file() else None
    except OSError:
        size = None
    if size is None:
        raise RecognitionError(f"{path}: is no file. {how}")
    if size > MAX_BYTES:
        raise RecognitionError(f"{path}: has {size} bytes; a recogniser has at most {MAX_BYTES}.")
    content: dict[str, Any] | None = read_with_checksum(path)
    if content is None:
        raise RecognitionError(f"{path}: is not what was written. {how}")
    key = content.pop("key", None)
    try:
        stored = StoredRecogniser.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise RecognitionError(f"{path}: {place}: {first['msg']}. {how}") from None
    if key != stored.key:
        raise RecognitionError(f"{path}: key: is not that of its content. {how}")
    return stored

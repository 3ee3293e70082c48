"""Which label stands for which place on the body: mappings that ship, or that users write."""

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import DataFileError, RecordingError, listed
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.skeleton import BODIES, SIDES

Vector = NDArray[np.float64]
DATA = Path(__file__).parent / "data"
MIRROR = np.array([1.0, -1.0, 1.0])
_NUMBER = re.compile(r"\d+")


class Landmark(Settings):
    """A place on a body of the right side or the middle, (3,) m in the body's frame; loose: only roughly known."""

    body: str
    at_m: tuple[float, float, float]
    loose: bool = False


class LandmarkTable(Settings):
    """Content of data/landmarks.yaml."""

    stature_m: float
    landmarks: dict[str, Landmark]


@cache
def landmark_table() -> LandmarkTable:
    """The places at which markers stick."""
    return load_data(DATA / "landmarks.yaml", LandmarkTable)


@dataclass(frozen=True)
class Place:
    """What a label stands for: a landmark, the body it is on, and where in the body's frame, (3,) m at a stature."""

    landmark: str
    side: str
    body: str
    at_m: Vector
    loose: bool


class Mapping(Settings):
    """A mapping file. Labels are compared without case, blanks and punctuation; # stands for a number."""

    about: str = Field(description="What it is for, in a sentence.")
    sides: dict[str, tuple[str, ...]] = Field(description="What may stand for {s} on the side right, and on left.")
    endings: tuple[str, ...] = Field(default=(), description="What may follow every label, such as study.")
    landmarks: dict[str, tuple[str, ...]] = Field(description="Labels by landmark; {s} stands for the side.")

    @cached_property
    def places(self) -> dict[str, Place]:
        """Places by label, as `plain_label` writes it."""
        return {label: _place(landmark, side) for label, landmark, side, _ in reversed(self._labels())}

    @cached_property
    def _others(self) -> dict[str, str]:
        """The label of the same place on the other side, by label, both as `plain_label` writes them."""
        return {label: other for label, _, _, other in reversed(self._labels())}

    def _labels(self) -> list[tuple[str, str, str, str]]:
        """Each label that it knows, its landmark and side, and the label on the other side; the first of two counts."""
        found = []
        for landmark, templates in self.landmarks.items():
            for template in templates:
                for side, other in (SIDES, SIDES[::-1]) if "{s}" in template else (("", ""),):
                    own, others = (self.sides.get(which, ("",)) for which in (side, other))
                    for index, said in enumerate(own):
                        across = others[min(index, len(others) - 1)] if others else said
                        for ending in ("", *self.endings):
                            label, twin = (
                                plain_label(template.replace("{s}", name) + ending) for name in (said, across)
                            )
                            found.append((label, landmark, side, twin))
        return found

    def place(self, label: str) -> Place | None:
        """What a label stands for; None if it is unknown."""
        plain = plain_label(label)
        return self.places.get(plain) or self.places.get(_NUMBER.sub("#", plain))

    def across(self, label: str) -> str:
        """The label of the same place on the other side, as `plain_label` writes it; of a middle or unknown one: it."""
        plain = plain_label(label)
        if plain in self._others:
            return self._others[plain]
        other = self._others.get(_NUMBER.sub("#", plain))
        if other is None:
            return plain
        numbers = iter(_NUMBER.findall(plain))
        return re.sub("#", lambda _: next(numbers), other)

    def nearest(self, label: str) -> str:
        """A known label that looks like an unknown one; empty if there is none."""
        return next(iter(difflib.get_close_matches(plain_label(label), self.places, n=1, cutoff=0.7)), "")

    def missing(self, labels: Iterable[str]) -> list[str]:
        """Bodies, except neck, head and hands, on which none of the labels is."""
        there = {place.body for label in labels if (place := self.place(label))}
        return [body for body in BODIES if body not in there]


def plain_label(label: str) -> str:
    """A label as it is compared."""
    return re.sub(r"[^0-9a-z#]", "", label.casefold())


def _place(landmark: str, side: str) -> Place:
    told = landmark_table().landmarks[landmark]
    body = told.body if told.body in BODIES else f"{side}_{told.body}"
    at = np.array(told.at_m) * (MIRROR if side == "left" else 1)
    return Place(landmark, side, body, at, told.loose)


def shipped() -> list[str]:
    """Names of the mappings that ship."""
    return sorted(path.stem for path in (DATA / "mappings").glob("*.yaml"))


@cache
def load_mapping(name: str) -> Mapping:
    """A mapping by its name or its file. Raises RecordingError if it is unknown or says what is not allowed."""
    path = DATA / "mappings" / f"{name}.yaml" if name in shipped() else Path(name)
    if not path.is_file():
        raise RecordingError(f"{name}: neither a file nor a mapping that ships: {listed(shipped())}.")
    try:
        mapping = load_data(path, Mapping)
    except DataFileError as error:
        raise RecordingError(str(error)) from error
    known = landmark_table().landmarks
    for landmark, templates in mapping.landmarks.items():
        if landmark not in known:
            near = difflib.get_close_matches(landmark, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else f"; known are {listed(known)}."
            raise RecordingError(f"{path}: landmarks.{landmark} is no landmark{hint}")
        sided = known[landmark].body not in BODIES or known[landmark].at_m[1] != 0
        if wrong := [template for template in templates if sided and "{s}" not in template]:
            raise RecordingError(f"{path}: landmarks.{landmark}: {wrong[0]} does not say the side; write {{s}} for it.")
    if mapping.sides.keys() - set(SIDES):
        raise RecordingError(f"{path}: sides are right and left.")
    return mapping


def choose_mapping(labels: Sequence[str]) -> str | None:
    """The mapping that knows most of the labels; None if none knows three."""
    known = {name: sum(load_mapping(name).place(label) is not None for label in labels) for name in shipped()}
    best = max(known, key=lambda name: known[name])
    return best if known[best] >= 3 else None

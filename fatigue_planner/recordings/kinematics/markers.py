"""The markers of a recording that are on a body, and where on it they are."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed
from fatigue_planner.human.skeleton import JOINTS, ROOT_BODY
from fatigue_planner.recordings.mapping import landmark_table, load_mapping
from fatigue_planner.recordings.recording import Recording

Vector = NDArray[np.float64]

# How far a marker may be from where the table has it on this body: 3 cm, or along a limb.
FIRM_M, LOOSE_M = 0.03, 0.08
# How well the place of a marker is known once it is calibrated: skin over bone. One at a joint behind which nothing is
# seen stays there: away from it, it would seem to show how that body turns.
SKIN_M, AT_JOINT_M = 0.01, 1e-4
# Bodies without which there is no posture.
NEEDED = ("pelvis", "thorax", "right_thigh", "left_thigh", "right_shank", "left_shank")


@dataclass(frozen=True)
class Markers:
    """Labels (k), the body of each, its place there (k, 3) m, how well that is known (k,) m, and its landmark.

    landmarks (k), by the mapping; none, if markers are not by a mapping.
    """

    labels: tuple[str, ...]
    bodies: tuple[str, ...]
    local_m: Vector
    sigma_m: Vector
    landmarks: tuple[str, ...] = ()

    @property
    def shown(self) -> tuple[str, ...]:
        """The body (k) whose turning each shows: its own, or the one before where it is at a joint behind which
        nothing is seen.
        """
        if not self.landmarks:
            return self.bodies
        known = landmark_table().landmarks
        away = [any(known[landmark].at_m) for landmark in self.landmarks]
        turned = {ROOT_BODY, *(body for body, is_away in zip(self.bodies, away, strict=True) if is_away)}
        for joint in reversed(JOINTS):
            if joint.child in turned.union(self.bodies):
                turned.add(joint.parent)
        before = {joint.child: joint.parent for joint in JOINTS}
        return tuple(body if body in turned else before[body] for body in self.bodies)

    @property
    def place_sigma_m(self) -> Vector:
        """How far a calibration may move each place (k,) m."""
        own = [shown == body for shown, body in zip(self.shown, self.bodies, strict=True)]
        return np.where(own, self.sigma_m, AT_JOINT_M)

    def of(self, labels: tuple[str, ...]) -> tuple["Markers", list[int]]:
        """Those with these labels, and where each is among the labels."""
        keep = [index for index, label in enumerate(self.labels) if label in labels]
        own = Markers(
            tuple(self.labels[i] for i in keep),
            tuple(self.bodies[i] for i in keep),
            self.local_m[keep],
            self.sigma_m[keep],
            tuple(self.landmarks[i] for i in keep if self.landmarks),
        )
        return own, [labels.index(label) for label in own.labels]

    def at(self, local_m: Vector) -> "Markers":
        """The same markers at calibrated places."""
        return replace(self, local_m=local_m, sigma_m=np.full(len(self.labels), SKIN_M))


def markers_of(recording: Recording, mapping: str | None, stature_m: float) -> Markers:
    """The markers that a mapping knows, where the table has them on somebody of this stature.

    Raises RecordingError if there is no mapping, or a body without which there is no posture has no marker.
    """
    if mapping is None:
        raise RecordingError("no mapping knows its labels; say one with --mapping.")
    known = load_mapping(mapping)
    found = [(label, place) for label in recording.labels if (place := known.place(label))]
    there = {place.body for _, place in found}
    if missing := [body for body in NEEDED if body not in there]:
        raise RecordingError(f"no marker is on {listed(missing)}; there is no posture without.")
    scale = stature_m / landmark_table().stature_m
    return Markers(
        tuple(label for label, _ in found),
        tuple(place.body for _, place in found),
        scale * np.array([place.at_m for _, place in found]),
        np.array([LOOSE_M if place.loose else FIRM_M for _, place in found]),
        tuple(place.landmark for _, place in found),
    )


def unmarked_joints(shown: Collection[str]) -> tuple[str, ...]:
    """The joints with none of the bodies that markers show beyond them, as the wrist without markers on the hand.

    Their postures are assumed, and no torque is reported of them: a guess would be taken for a measurement.
    """
    beyond = set(shown)
    for joint in reversed(JOINTS):
        if joint.child in beyond:
            beyond.add(joint.parent)
    return tuple(joint.name for joint in JOINTS if joint.child not in beyond)

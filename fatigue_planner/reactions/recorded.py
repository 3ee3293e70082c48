"""Recorded reactions: how good a recording is, phase by phase, and what it must fulfil for its torques to be used."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from fatigue_planner.core.errors import told_apart
from fatigue_planner.core.settings import Settings
from fatigue_planner.core.text import listing, percent
from fatigue_planner.human.joint_data import MaximumTorque
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Verdict

Positive = Annotated[float, Field(gt=0, le=1e9)]
MAX_LABEL = 100  # characters of a marker's name


class RecordingAccuracy(Settings):
    """What a recorded motion must fulfil, in each phase, to be used; docs/recordings.md gives the reasons."""

    marker_rms_m: Positive = Field(
        default=0.04, description="Largest distance in m, RMS over all markers, between a marker and its place."
    )
    worst_marker_m: Positive = Field(
        default=0.08, description="Largest distance in m, RMS over the frames, between one marker and its place."
    )
    unseen_s: Positive = Field(default=0.5, description="For how long in s a part of the body may have no marker.")
    residual_force_share: Positive = Field(
        default=0.1, description="Largest force that no plate explains, RMS, as a fraction of the body weight."
    )
    residual_moment_nm: Positive = Field(
        default=75.0, description="Largest moment about the hips in N.m that no plate explains, RMS."
    )
    unmeasured_share: Positive = Field(
        default=0.1, description="Largest fraction of a phase in which somebody or something unmeasured carries."
    )
    one_plate_share: Positive = Field(
        default=0.1, description="Largest fraction of a phase in which both feet are on one plate."
    )
    foot_slide_m: Positive = Field(default=0.05, description="How far in m a foot on the ground may slide.")
    stretch: Positive = Field(
        default=3.0,
        description="By which factor, without unit, a phase may last longer or shorter than in the recording.",
    )
    place_m: Positive = Field(
        default=0.15, description="Largest mean distance in m, during work, between a hand and the action's place."
    )
    wrist_load_kg: float = Field(
        default=0.0,
        ge=0,
        le=30,
        description="Mass in kg that a hand without markers may hold: its wrist's torques are assumed ones.",
    )


def largest_load(strength: MaximumTorque, motion: Motion) -> tuple[float, str]:
    """The largest mean load of a joint during work, as a share of its strength, and which joint bears it."""
    positive, negative = strength.vectors()
    at_work = motion.torque_nm[motion.phase("work")]
    mean = np.maximum(at_work / positive, -at_work / negative).mean(axis=0)
    return float(mean.max()), DEGREES_OF_FREEDOM[int(mean.argmax())]


class Bar(NamedTuple):
    """How a measure is said, its unit and factor, up to where a recording is good, and how precisely that is said."""

    text: str
    good: float
    unit: str
    factor: float = 1.0
    digits: str = ".0f"


# Up to `good` there is nothing to say: OpenSim's checklist (marker RMS 2 cm, largest 4 cm; moments 50 N.m RMS) and
# Hicks 2015 (5 % of the external force); the others are assumed.
BARS = {
    "marker_rms_m": Bar("markers are away from their places by", 0.02, "mm", 1000),
    "worst_marker_m": Bar("a marker is away from its place by", 0.04, "mm", 1000),
    "unseen_s": Bar("a part of the body shows no marker for", 0.2, "s", digits=".2f"),
    "residual_force_share": Bar("no plate explains a force of", 0.05, "% of the weight", 100, ".1f"),
    "residual_moment_nm": Bar("no plate explains a moment of", 50.0, "N·m", digits=".1f"),
    "unmeasured_share": Bar("an unmeasured contact carries during", 0.0, "% of the time", 100),
    "one_plate_share": Bar("both feet are on one plate during", 0.0, "% of the time", 100),
    "foot_slide_m": Bar("a foot slides by", 0.02, "cm", 100, ".1f"),
    "stretch": Bar("the cycle's pace differs from the recorded one by a factor of", 1.5, "", digits=".2f"),
}
# Two measures that differ by less are the same: 0.3 s is not more than 1.5 times the time from 1.3 s to 1.5 s.
ROUNDING = 1e-9


@dataclass(frozen=True)
class PhaseQuality:
    """What is seen in one phase of a recording (SI); None where no plate measured.

    from_s, to_s: when it was recorded; worst_marker, unseen_body: which; stretch: the ratio of the longer to the
    shorter of the cycle's and the recorded duration.
    """

    name: str
    from_s: float
    to_s: float
    marker_rms_m: float
    worst_marker_m: float
    worst_marker: str
    unseen_s: float
    unseen_body: str
    residual_force_share: float | None
    residual_moment_nm: float | None
    unmeasured_share: float | None
    one_plate_share: float | None
    foot_slide_m: float
    stretch: float

    def beyond(self, limits: RecordingAccuracy | None) -> Iterator[str]:
        """What is beyond the limits or, if none are given, not good, in words."""
        for measure, bar in BARS.items():
            value = getattr(self, measure)
            limit = bar.good if limits is None else getattr(limits, measure)
            if value is not None and not value <= limit * (1 + ROUNDING):
                shown, most = told_apart(value * bar.factor, limit * bar.factor, bar.digits)
                which = {"worst_marker_m": self.worst_marker, "unseen_s": self.unseen_body}.get(measure, "")
                named = f" ({which.replace('_', ' ')})" if which else ""
                unit = f" {bar.unit}" if bar.unit else ""
                called = "good" if limits is None else "allowed"
                yield f"{self.name}: {bar.text} {shown}{unit}{named} ({called}: {most})"


@dataclass(frozen=True)
class RecordedQuality:
    """How good a recording is: its phases, and what holds for all of it.

    work_hand_error_m: mean distance of a hand from the action's place during work, the larger of both; assumed_joints:
    those that no marker shows, so that their torques are those of an assumed posture (a wrist's of a hand in line with
    the forearm); wrist_load_kg: the most that a hand without markers holds; largest_load_share: as of a simulated
    motion; length_factors: how many times as long as the stature says the person's segments are, in the order of the
    calibration.
    """

    phases: tuple[PhaseQuality, ...]
    work_hand_error_m: float
    assumed_joints: tuple[str, ...]
    wrist_load_kg: float
    largest_load_share: float
    largest_load_joint: str
    length_factors: tuple[float, ...]

    @property
    def has_plates(self) -> bool:
        """Whether the ground's forces were measured."""
        return all(phase.residual_force_share is not None for phase in self.phases)

    def faults(self, required: RecordingAccuracy) -> list[str]:
        """Why its torques cannot be believed, in words; empty for a recording that can be used."""
        faults = [text for phase in self.phases for text in phase.beyond(required)]
        if not self.work_hand_error_m <= required.place_m:
            shown, most = told_apart(100 * self.work_hand_error_m, 100 * required.place_m, ".0f")
            faults.append(f"the hand works {shown} cm from the action's place (allowed: {most} cm)")
        if self.wrist_load_kg > required.wrist_load_kg:
            faults.append(
                f"a hand without markers holds {self.wrist_load_kg:g} kg, so that its wrist's torques are unknown "
                f"(allowed: {required.wrist_load_kg:g} kg)"
            )
        return [*faults, "`recording_accuracy` of the experiment says what is accepted"] if faults else []

    def verdict(self, required: RecordingAccuracy) -> Verdict:
        """failed; degraded: used, but something is not good; or ok."""
        return "failed" if self.faults(required) else self.kept_as()

    def kept_as(self) -> Verdict:
        """The verdict on a recording that is used."""
        return "degraded" if self.remarks() else "ok"

    def remarks(self) -> list[str]:
        """What is not good."""
        found = [text for phase in self.phases for text in phase.beyond(None)]
        if not self.has_plates:
            found.append("no plate measured the ground: how both feet share it, and so the legs' torques, is assumed")
        if self.assumed_joints:
            found.append(
                f"no marker shows {listing([joint.replace('_', ' ') for joint in self.assumed_joints])}: no torque is "
                "reported there; planning uses those of an assumed posture"
            )
        if self.largest_load_share > 1:
            joint = self.largest_load_joint.replace("_", " ")
            found.append(f"{joint} bears {percent(self.largest_load_share, 0)} of the worker's strength during work")
        return found

    def degradation(self) -> str:
        """What is not good, in one sentence; empty if all is."""
        return "; ".join(self.remarks())

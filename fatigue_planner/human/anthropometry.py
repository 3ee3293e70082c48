"""Segment masses, centres of mass, inertias and joint centres of a worker, scaled from data files."""

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.skeleton import DATA, without_side

Sex = Literal["female", "male"]
# The two digital humans: the paper's, to the letter of its text, and one with the physiology that it leaves out.
HumanKind = Literal["natural", "paper"]
Vector = NDArray[np.float64]


class SegmentParameters(Settings):
    """One row of de Leva's table for one sex."""

    mass_percent: float = Field(gt=0)
    com_percent: float = Field(gt=0, lt=100)
    radius_sagittal_percent: float = Field(gt=0)
    radius_transverse_percent: float = Field(gt=0)
    radius_longitudinal_percent: float = Field(gt=0)
    length_m: float = Field(gt=0)


class SourcedValue(Settings):
    """A number and where it comes from."""

    value: float
    source: str


class SegmentTable(Settings):
    """Content of data/segments.yaml."""

    source: str
    reference_stature_m: dict[Sex, float]
    segments: dict[str, dict[Sex, SegmentParameters]]
    neck_mass_percent: SourcedValue


@cache
def segment_table() -> SegmentTable:
    """The segment parameters of de Leva (1996)."""
    return load_data(DATA / "segments.yaml", SegmentTable)


class SourcedShare(Settings):
    """A length as a fraction of stature, of both sexes or of each, and where it comes from."""

    value: float | dict[Sex, float]
    source: str


@cache
def geometry(kind: HumanKind) -> dict[str, SourcedShare]:
    """Joint centres and landmarks of a human as fractions of stature, from data/geometry."""
    own = load_data(DATA / "geometry" / f"{kind}.yaml", dict[str, SourcedShare])
    return own if kind == "paper" else geometry("paper") | own


@dataclass(frozen=True)
class Segment:
    """A rigid body: mass, centre of mass and principal inertia at the centre of mass.

    `com_m` (3,) is in the body's frame, whose origin is the proximal joint's centre; `inertia_kgm2`
    (3,) holds the moments about x, y and z, which are the principal axes (de Leva gives no products).
    """

    mass_kg: float
    com_m: Vector
    inertia_kgm2: Vector


# Body of the skeleton -> row of de Leva's table (section 1.1 of his paper; neck: see body_segments).
_ROW = {
    "pelvis": "lower_trunk",
    "abdomen": "mid_trunk",
    "thorax": "upper_trunk",
    "head": "head",
    "upper_arm": "upper_arm",
    "forearm": "forearm",
    "hand": "hand",
    "thigh": "thigh",
    "shank": "shank",
    "foot": "foot",
}


@dataclass(frozen=True)
class Anthropometry:
    """A body of a given stature, mass and sex, with the geometry of the paper's human or of the natural one."""

    stature_m: float
    mass_kg: float
    sex: Sex
    human: HumanKind = "natural"

    def length(self, name: str) -> float:
        """A length of data/geometry in metres."""
        value = geometry(self.human)[name].value
        return (value[self.sex] if isinstance(value, dict) else value) * self.stature_m

    def joint_centre(self, joint: str) -> Vector:
        """Centre of a compound joint in its parent body's frame at the anatomical zero, (3,) m."""
        side = {"right": -1.0, "left": 1.0}.get(joint.split("_", maxsplit=1)[0], 0.0)
        thorax_height = self._hip_height() + self.length("lumbar_above_hip") + self.length("thoracic_above_lumbar")
        centre = {
            "lumbar": (0, 0, self.length("lumbar_above_hip")),
            "thoracic": (0, 0, self.length("thoracic_above_lumbar")),
            "neck": (0, 0, self.length("neck_above_thoracic")),
            "head": (0, 0, self.length("head_above_neck")),
            "shoulder": (0, side * self.length("shoulder_half_width"), self.length("shoulder_height") - thorax_height),
            "elbow": (0, 0, -self.length("upper_arm_length")),
            "wrist": (0, 0, -self.length("forearm_length")),
            "hip": (0, side * self.length("hip_half_width"), 0),
            "knee": (0, 0, -self.length("thigh_length")),
            "ankle": (0, 0, -self.length("shank_length")),
        }[without_side(joint)]
        return np.array(centre, dtype=float)

    def sole_rectangle(self) -> Vector:
        """Heel x, toe x, half breadth and height of the sole in the foot's frame (ankle), (4,) m."""
        heel = -self.length("heel_behind_ankle")
        return np.array(
            [
                heel,
                heel + self.length("foot_length"),
                self.length("foot_breadth") / 2,
                -self.length("ankle_height"),
            ]
        )

    def grip_m(self) -> Vector:
        """Centre of the closed fist in the hand's frame (wrist), (3,) m."""
        return np.array([0.0, 0.0, -self.length("grip_beyond_wrist")])

    def segment(self, body: str) -> Segment:
        """Mass, centre of mass and inertia of a body of the skeleton."""
        kind = without_side(body)
        if kind == "neck":
            return self._neck()
        row = segment_table().segments[_ROW[kind]][self.sex]
        mass = row.mass_percent / 100 * self.mass_kg
        if kind == "thorax":
            mass -= segment_table().neck_mass_percent.value / 100 * self.mass_kg
        along = row.com_percent / 100
        length = row.length_m / segment_table().reference_stature_m[self.sex] * self.stature_m
        sagittal, transverse, longitudinal = (
            row.radius_sagittal_percent / 100,
            row.radius_transverse_percent / 100,
            row.radius_longitudinal_percent / 100,
        )
        radii = np.array([sagittal, transverse, longitudinal])
        match kind:
            case "foot":  # lies along x, from the heel; its height at half the ankle's is assumed
                length = self.length("foot_length")
                heel, _, _, sole = self.sole_rectangle()
                com = np.array([heel + along * length, 0.0, sole / 2])
                radii = np.array([longitudinal, transverse, sagittal])
            case "pelvis" | "abdomen" | "thorax" | "head":
                com = np.array([0.0, 0.0, self._trunk_com_height(kind, along) - self.origin_height(kind)])
            case _:  # limbs hang from their proximal joint along -z
                length = self.length(f"{kind}_length")
                com = np.array([0.0, 0.0, -along * length])
        return Segment(mass, com, mass * (radii * length) ** 2)

    def _neck(self) -> Segment:
        """The neck as a uniform solid cylinder between its joints, as wide as long (assumed)."""
        mass = segment_table().neck_mass_percent.value / 100 * self.mass_kg
        length = self.length("head_above_neck")
        radius = length / 2
        transverse = mass * (3 * radius**2 + length**2) / 12
        return Segment(mass, np.array([0, 0, length / 2]), np.array([transverse, transverse, mass * radius**2 / 2]))

    def _hip_height(self) -> float:
        return self.length("ankle_height") + self.length("shank_length") + self.length("thigh_length")

    def origin_height(self, body: str) -> float:
        """Height of a trunk body's frame above the ground when standing straight."""
        steps = ["lumbar_above_hip", "thoracic_above_lumbar", "neck_above_thoracic", "head_above_neck"]
        count = ["pelvis", "abdomen", "thorax", "neck", "head"].index(body)
        return self._hip_height() + sum(self.length(step) for step in steps[:count])

    def _trunk_com_height(self, body: str, along: float) -> float:
        """Height of a trunk body's centre of mass, by de Leva's landmarks stacked on the mid-hip."""
        reference = segment_table().reference_stature_m[self.sex]
        scaled = {
            name: rows[self.sex].length_m / reference * self.stature_m
            for name, rows in segment_table().segments.items()
        }
        omphalion = self._hip_height() + scaled["lower_trunk"]
        xiphion = omphalion + scaled["mid_trunk"]
        cervicale = xiphion + scaled["upper_trunk"]
        top = {"pelvis": omphalion, "abdomen": xiphion, "thorax": cervicale, "head": self.stature_m}[body]
        return top - along * scaled[_ROW[body]]

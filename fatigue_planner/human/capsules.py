"""The parts of the body as capsules, and which of them may not pass through each other."""

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.anthropometry import Anthropometry, Sex
from fatigue_planner.human.kinematics import Poses
from fatigue_planner.human.skeleton import BODIES, DATA, JOINTS, SIDES, without_side

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]


class _Build(Settings):
    stature_m: float = Field(gt=0)
    mass_kg: float = Field(gt=0)


class _Part(Settings):
    radius_m: dict[Sex, float]
    half_width_m: dict[Sex, float] = Field(default={"male": 0.0, "female": 0.0})
    follows: Literal["girth", "stature"]
    source: str


class CapsuleTable(Settings):
    """Content of data/capsules.yaml."""

    reference: dict[Sex, _Build]
    parts: dict[str, _Part]


@cache
def capsule_table() -> CapsuleTable:
    """Radii and half widths of the parts of the body, with their sources."""
    return load_data(DATA / "capsules.yaml", CapsuleTable)


@dataclass(frozen=True)
class Capsules:
    """One capsule per body of the skeleton, in the order of `skeleton.BODIES`.

    `ends_m` (17, 2, 3): the ends of the axis in the body's frame; `radius_m` (17,); `pairs` (p, 2): indices of the
    bodies that may not pass through each other.
    """

    ends_m: Vector
    radius_m: Vector
    pairs: Indices

    @property
    def joined(self) -> NDArray[np.bool_]:
        """Which pairs (p,) share a joint: their flesh may meet beside it in the stance, more so in stout people."""
        return np.array([_neighbours(BODIES[a], BODIES[b]) for a, b in self.pairs])

    def world_ends(self, poses: Poses) -> Vector:
        """The ends of all axes in the world, (n, 17, 2, 3) m."""
        return np.asarray(np.einsum("nbij,bej->nbei", poses.rotation, self.ends_m) + poses.origin_m[:, :, None])


def capsules_of(person: Anthropometry) -> Capsules:
    """The capsules of a worker."""
    sizes = [_size(body, person) for body in BODIES]
    ends = [_ends(body, person, *size) for body, size in zip(BODIES, sizes, strict=True)]
    pairs = [[BODIES.index(a), BODIES.index(b)] for a, b in checked_pairs()]
    return Capsules(np.array(ends, dtype=float), np.array([radius for radius, _ in sizes]), np.array(pairs))


def _size(body: str, person: Anthropometry) -> tuple[float, float]:
    """Radius and half width of a body in m."""
    part, build = capsule_table().parts[without_side(body)], capsule_table().reference[person.sex]
    taller = person.stature_m / build.stature_m
    factor = taller if part.follows == "stature" else float(np.sqrt(person.mass_kg / build.mass_kg / taller))
    return factor * part.radius_m[person.sex], factor * part.half_width_m[person.sex]


def _ends(body: str, person: Anthropometry, radius: float, half_width: float) -> list[list[float]]:
    """Both ends of the axis in the body's frame, each (3,) m. Heights within the trunk: the middle of each part."""
    kind = without_side(body)
    across = {"pelvis": "lumbar", "abdomen": "thoracic", "thorax": "neck"}
    along = {"neck": "head", "upper_arm": "right_elbow", "forearm": "right_wrist", "thigh": "right_knee"}
    along |= {"shank": "right_ankle"}
    if kind in across:
        middle = float(person.joint_centre(across[kind])[2]) / 2
        return [[0, -half_width, middle], [0, half_width, middle]]
    if kind in along:
        return [[0, 0, 0], list(person.joint_centre(along[kind]))]
    if kind == "head":  # from the chin to the vertex
        chin = person.length("chin_height") - person.origin_height("head")
        return [[0, 0, chin + radius], [0, 0, person.stature_m - person.origin_height("head") - radius]]
    if kind == "hand":
        return [[0, 0, 0], list(person.grip_m())]
    heel, toe, _, sole = person.sole_rectangle()
    return [[heel + radius, 0, sole + radius], [toe - radius, 0, sole + radius]]


_NEIGHBOURS = "they share a joint"
_STIFF = "the ranges of the spine keep them apart"
_FIRST = "other pairs meet first"
_SOFT = "soft tissue gives way where they meet"
_STANDING = "the feet stand still"

# Pairs of parts that are not checked, by kind, whatever their sides, and why.
_EXCLUDED = {
    ("pelvis", "thorax"): _STIFF, ("pelvis", "neck"): _STIFF, ("pelvis", "head"): _STIFF, ("abdomen", "neck"): _STIFF,
    ("abdomen", "head"): _STIFF, ("thorax", "head"): _STIFF,
    ("neck", "upper_arm"): _SOFT, ("head", "upper_arm"): _SOFT, ("abdomen", "thigh"): _SOFT,
    ("neck", "thigh"): _FIRST, ("head", "thigh"): _FIRST, ("upper_arm", "upper_arm"): _FIRST,
    ("upper_arm", "shank"): _FIRST, ("upper_arm", "foot"): _FIRST, ("forearm", "foot"): _FIRST,
    **{(part, leg): _FIRST for part in ("pelvis", "abdomen", "thorax", "neck", "head") for leg in ("shank", "foot")},
    ("foot", "foot"): _STANDING, ("shank", "foot"): _STANDING, ("thigh", "foot"): _STANDING,
}  # fmt: skip
# The same where both are of one side.
_EXCLUDED_ON_ONE_SIDE = {("upper_arm", "hand"): "the range of the elbow keeps them apart"}
# Neighbours that can pass through each other beside their joint all the same.
_CHECKED_NEIGHBOURS = ("thorax", "upper_arm")


def _neighbours(first: str, second: str) -> bool:
    """Whether two bodies share a joint."""
    return any({joint.parent, joint.child} == {first, second} for joint in JOINTS)


def exclusion(first: str, second: str) -> str:
    """Why two bodies, in the order of the skeleton, are not checked against each other; empty if they are."""
    kinds = without_side(first), without_side(second)
    if _neighbours(first, second) and kinds != _CHECKED_NEIGHBOURS:
        return _NEIGHBOURS
    ordered = min(kinds, kinds[::-1], key=lambda pair: pair not in _EXCLUDED)
    one_side = any(first.startswith(side) and second.startswith(side) for side in SIDES)
    return _EXCLUDED.get(ordered, "") or (_EXCLUDED_ON_ONE_SIDE.get(kinds, "") if one_side else "")


def checked_pairs() -> list[tuple[str, str]]:
    """The pairs of bodies that may not pass through each other."""
    return [pair for pair in itertools.combinations(BODIES, 2) if not exclusion(*pair)]

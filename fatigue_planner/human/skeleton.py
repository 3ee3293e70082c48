"""The tree of the digital human: 17 bodies, 16 compound joints, 39 revolute degrees of freedom.

World and body axes at the anatomical zero (standing, arms along the body, palms inward):
x forward, y left, z up. All bodies are aligned with the world there, so an axis below is the axis of
a degree of freedom in its parent's frame, signed so that the anatomical direction in its name (or in
`data/ranges_of_motion.yaml`) is positive.
Structure: paper, section III-C (17 bodies, 16 joints, 7 per arm, 7 per leg, 11 back and head).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]

# The tables of the human body that ship with the package.
DATA = Path(__file__).parent / "data"

ROOT_BODY = "pelvis"


@dataclass(frozen=True)
class DegreeOfFreedom:
    """One revolute joint with one actuator."""

    name: str
    axis: Axis


@dataclass(frozen=True)
class CompoundJoint:
    """One to three revolute degrees of freedom about one centre, between two bodies."""

    name: str
    parent: str
    child: str
    degrees_of_freedom: tuple[DegreeOfFreedom, ...]


def _joint(name: str, parent: str, child: str, **axes: Axis) -> CompoundJoint:
    return CompoundJoint(name, parent, child, tuple(DegreeOfFreedom(dof, axis) for dof, axis in axes.items()))


_MIRRORED: dict[Axis, Axis] = {"+x": "-x", "-x": "+x", "+y": "+y", "-y": "-y", "+z": "-z", "-z": "+z"}


def _side(side: str, joint: CompoundJoint) -> CompoundJoint:
    """A right-hand joint as the joint of `side`: mirrored in the sagittal plane on the left."""
    bodies = [body if body in {"thorax", "pelvis"} else f"{side}_{body}" for body in (joint.parent, joint.child)]
    freedoms = tuple(
        DegreeOfFreedom(f"{side}_{dof.name}", dof.axis if side == "right" else _MIRRORED[dof.axis])
        for dof in joint.degrees_of_freedom
    )
    return CompoundJoint(f"{side}_{joint.name}", bodies[0], bodies[1], freedoms)


_SPINE = (
    _joint("lumbar", "pelvis", "abdomen", lumbar_flexion="+y", lumbar_lateral="+x", lumbar_rotation="+z"),
    _joint("thoracic", "abdomen", "thorax", thoracic_flexion="+y", thoracic_lateral="+x", thoracic_rotation="+z"),
    _joint("neck", "thorax", "neck", neck_flexion="+y", neck_lateral="+x", neck_rotation="+z"),
    _joint("head", "neck", "head", head_flexion="+y", head_lateral="+x"),
)
_RIGHT_ARM = (
    _joint("shoulder", "thorax", "upper_arm", shoulder_flexion="-y", shoulder_abduction="-x", shoulder_rotation="+z"),
    _joint("elbow", "upper_arm", "forearm", elbow_flexion="-y", forearm_pronation="+z"),
    _joint("wrist", "forearm", "hand", wrist_flexion="+x", wrist_deviation="-y"),
)
_RIGHT_LEG = (
    _joint("hip", "pelvis", "thigh", hip_flexion="-y", hip_abduction="-x", hip_rotation="+z"),
    _joint("knee", "thigh", "shank", knee_flexion="+y"),
    _joint("ankle", "shank", "foot", ankle_flexion="-y", ankle_inversion="+x", ankle_rotation="+z"),
)

SIDES = ("right", "left")
JOINTS: tuple[CompoundJoint, ...] = (
    *_SPINE,
    *(_side(side, joint) for side in SIDES for joint in _RIGHT_ARM),
    *(_side(side, joint) for side in SIDES for joint in _RIGHT_LEG),
)
BODIES: tuple[str, ...] = (ROOT_BODY, *(joint.child for joint in JOINTS))
DEGREES_OF_FREEDOM: tuple[str, ...] = tuple(dof.name for joint in JOINTS for dof in joint.degrees_of_freedom)


def without_side(name: str) -> str:
    """The name shared by the left and right twins of a body, joint or degree of freedom."""
    for side in SIDES:
        name = name.removeprefix(f"{side}_")
    return name

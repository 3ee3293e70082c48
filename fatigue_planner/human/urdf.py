"""The digital human as a URDF, for other engines and viewers, with simple shapes to be seen and to collide."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, JOINTS, ROOT_BODY, without_side

Vector = NDArray[np.float64]

DENSITY_KGPM3 = 1000.0  # of the shapes: about that of the body, which nearly floats
# Bodies drawn as capsules from their upper joint to the next one.
_CAPSULES = {"neck": "head", "upper_arm": "elbow", "forearm": "wrist", "thigh": "knee", "shank": "ankle"}

# Read by MuJoCo only: without it, its importer refuses the massless links between the axes of a joint.
_MUJOCO = {"balanceinertia": "false", "boundmass": "1e-14", "boundinertia": "1e-14", "discardvisual": "true"}


def urdf_text(human: Human, strength: tuple[Vector, Vector], velocity_limit_radps: float) -> str:
    """A human's model as URDF: one link per body, massless links between the axes of compound joints.

    The root link (the pelvis) is free: add the floating joint where the file is loaded. URDF has one
    effort limit per joint, so the larger of both directions is written. A tool in the model is part of
    the hand's link. Joints are written in the order of `skeleton.DEGREES_OF_FREEDOM`, as in all motions; a comment
    lists it, for many programs sort them in another way.
    """
    model = human.model
    robot = ElementTree.Element("robot", name=model.name)
    order = f" Joints in the order of fatplan's motions: {' '.join(DEGREES_OF_FREEDOM)} "
    robot.append(ElementTree.Comment(order))
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", _MUJOCO)
    body_of = {joint.degrees_of_freedom[-1].name: joint.child for joint in JOINTS} | {"root": ROOT_BODY}
    links = ["universe", *(body_of.get(model.names[i], f"{model.names[i]}_axis") for i in range(1, model.njoints))]
    for index in range(1, model.njoints):
        link = _add_link(robot, links[index], model.inertias[index])
        if links[index] in BODIES:
            _add_shapes(link, links[index], human.anthropometry)
    axes = {dof.name: dof.axis for joint in JOINTS for dof in joint.degrees_of_freedom}
    for index in range(2, model.njoints):
        name = model.names[index]
        joint = ElementTree.SubElement(robot, "joint", name=name, type="revolute")
        ElementTree.SubElement(joint, "parent", link=links[model.parents[index]])
        ElementTree.SubElement(joint, "child", link=links[index])
        ElementTree.SubElement(joint, "origin", xyz=_numbers(model.jointPlacements[index].translation), rpy="0 0 0")
        sign, letter = axes[name]
        ElementTree.SubElement(joint, "axis", xyz=_numbers([float(sign + "1") * (letter == x) for x in "xyz"]))
        joint_number = index - 2
        limits = {
            "lower": model.lowerPositionLimit[7 + joint_number],
            "upper": model.upperPositionLimit[7 + joint_number],
            "effort": max(strength[0][joint_number], strength[1][joint_number]),
            "velocity": velocity_limit_radps,
        }
        ElementTree.SubElement(joint, "limit", {key: repr(float(value)) for key, value in limits.items()})
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode") + "\n"


def _add_link(robot: ElementTree.Element, name: str, inertia: pin.Inertia) -> ElementTree.Element:
    link = ElementTree.SubElement(robot, "link", name=name)
    if inertia.mass == 0:
        return link
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(inertia.lever), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    moments = inertia.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ElementTree.SubElement(inertial, "inertia", {key: repr(float(moments[axes])) for key, axes in names.items()})
    return link


def _add_shapes(link: ElementTree.Element, body: str, person: Anthropometry) -> None:
    """Draw a body, for the eye and for collisions; the mechanics is in the inertia alone.

    Limbs and neck are capsules as long as the limb; the foot is a box on its sole; trunk, head and hand are the boxes
    that have the body's mass, centre of mass and moments of inertia, as uniform solids would.
    """
    segment, kind = person.segment(body), without_side(body)
    if kind in _CAPSULES:
        side = body.removesuffix(kind)
        end = person.joint_centre(f"{side}{_CAPSULES[kind]}")
        length = float(np.linalg.norm(end))
        radius = float(np.sqrt(segment.mass_kg / (DENSITY_KGPM3 * np.pi * length)))
        _add_shape(link, end / 2, "cylinder", radius=repr(radius), length=repr(length))
        for point in (np.zeros(3), end):
            _add_shape(link, point, "sphere", radius=repr(radius))
    elif kind == "foot":
        heel, toe, half_breadth, height = person.sole_rectangle()
        size = _numbers([toe - heel, 2 * half_breadth, -height])
        _add_shape(link, np.array([(heel + toe) / 2, 0, height / 2]), "box", size=size)
    else:
        moments = segment.inertia_kgm2
        size = _numbers(np.sqrt(6 * (moments.sum() - 2 * moments) / segment.mass_kg))
        _add_shape(link, segment.com_m, "box", size=size)


def _add_shape(link: ElementTree.Element, centre_m: Vector, kind: str, **size: str) -> None:
    for use in ("visual", "collision"):
        shape = ElementTree.SubElement(link, use)
        ElementTree.SubElement(shape, "origin", xyz=_numbers(centre_m), rpy="0 0 0")
        ElementTree.SubElement(ElementTree.SubElement(shape, "geometry"), kind, size)


def _numbers(values: Vector | list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)

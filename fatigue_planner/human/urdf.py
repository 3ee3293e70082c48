"""The digital human as a URDF, for other engines and viewers."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.skeleton import JOINTS, ROOT_BODY

Vector = NDArray[np.float64]

# Read by MuJoCo only: without it, its importer refuses the massless links between the axes of a joint.
_MUJOCO = {"balanceinertia": "false", "boundmass": "1e-14", "boundinertia": "1e-14", "discardvisual": "true"}


def urdf_text(model: pin.Model, strength: tuple[Vector, Vector], velocity_limit_radps: float) -> str:
    """A human's model as URDF: one link per body, massless links between the axes of compound joints.

    The root link (the pelvis) is free: add the floating joint where the file is loaded. URDF knows one
    effort limit per joint, so the larger of both directions is written. A tool in the model is part of
    the hand's link.
    """
    robot = ElementTree.Element("robot", name=model.name)
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", _MUJOCO)
    body_of = {joint.degrees_of_freedom[-1].name: joint.child for joint in JOINTS} | {"root": ROOT_BODY}
    links = ["universe", *(body_of.get(model.names[i], f"{model.names[i]}_axis") for i in range(1, model.njoints))]
    for index in range(1, model.njoints):
        _add_link(robot, links[index], model.inertias[index])
    axes = {dof.name: dof.axis for joint in JOINTS for dof in joint.degrees_of_freedom}
    for index in range(2, model.njoints):
        name = model.names[index]
        joint = ElementTree.SubElement(robot, "joint", name=name, type="revolute")
        ElementTree.SubElement(joint, "parent", link=links[model.parents[index]])
        ElementTree.SubElement(joint, "child", link=links[index])
        ElementTree.SubElement(joint, "origin", xyz=_numbers(model.jointPlacements[index].translation), rpy="0 0 0")
        sign, letter = axes[name]
        ElementTree.SubElement(joint, "axis", xyz=_numbers([float(sign + "1") * (letter == x) for x in "xyz"]))
        place = index - 2
        limits = {
            "lower": model.lowerPositionLimit[7 + place],
            "upper": model.upperPositionLimit[7 + place],
            "effort": max(strength[0][place], strength[1][place]),
            "velocity": velocity_limit_radps,
        }
        ElementTree.SubElement(joint, "limit", {key: repr(float(value)) for key, value in limits.items()})
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode") + "\n"


def _add_link(robot: ElementTree.Element, name: str, inertia: pin.Inertia) -> None:
    link = ElementTree.SubElement(robot, "link", name=name)
    if inertia.mass == 0:
        return
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(inertia.lever), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    moments = inertia.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ElementTree.SubElement(inertial, "inertia", {key: repr(float(moments[place])) for key, place in names.items()})


def _numbers(values: Vector | list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)

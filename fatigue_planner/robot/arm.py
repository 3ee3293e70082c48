"""A robot arm as numbers: its joints, its limits, its body as capsules, what it can carry."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple, Self

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ExperimentError, listed, shortened
from fatigue_planner.core.settings import Name, Settings, load_data

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

DATA = Path(__file__).parent / "data"
BASE = "base"
MAX_JOINTS = 12

Point = Annotated[tuple[float, float, float], Field(description="x, y and z in m.")]


class _Joint(Settings):
    name: Name
    position_m: Point
    rotation_rad: tuple[float, float, float]
    limits_deg: tuple[float, float]


class _Capsule(Settings):
    link: Name
    from_m: Point
    to_m: Point
    radius_m: float = Field(gt=0)


class _ArmFile(Settings):
    """Content of data/*.yaml: each joint turns about the z axis of its frame, given in that of the joint before."""

    name: str
    joints: tuple[_Joint, ...] = Field(min_length=1, max_length=MAX_JOINTS)
    kinematics_source: str
    payload_kg: float = Field(gt=0)
    payload_source: str
    capsules: tuple[_Capsule, ...]
    capsules_source: str

    @model_validator(mode="after")
    def _check_links(self) -> Self:
        links = [BASE, *(joint.name for joint in self.joints)]
        if unknown := {capsule.link for capsule in self.capsules} - set(links):
            raise ValueError(f"capsules: {listed(sorted(unknown))}: not among the links {listed(links)}")
        return self


class Chain(NamedTuple):
    """What compiled functions need of an arm of n joints and c capsules.

    `placement` (n, 4, 4): each joint's frame in that of the joint before, at angle 0; it turns about its z. `lower` and
    `upper` (n,) rad. `tip` (4, 4): the flange in the last frame, pointing along its z. `link` (c,): the frame that
    carries a capsule, 0 for the base; `ends` (c, 2, 3) m in it; `radius` (c,) m. `pairs` (p, 2): capsules that may not
    meet.
    """

    placement: Vector
    lower: Vector
    upper: Vector
    tip: Vector
    link: Indices
    ends: Vector
    radius: Vector
    pairs: Indices


@dataclass(frozen=True)
class Arm:
    """A robot arm. `payload_kg` None: not known."""

    name: str
    joints: tuple[str, ...]
    chain: Chain
    payload_kg: float | None
    source: str


def shipped_arms() -> tuple[str, ...]:
    """The names of the arms that ship with fatplan."""
    return tuple(sorted(file.stem for file in DATA.glob("*.yaml")))


def load_arm(name: str) -> Arm:
    """An arm that ships. Raises ExperimentError for another name."""
    if name not in shipped_arms():
        raise ExperimentError(
            f"robot.arm {shortened(name)}: should be one of {listed(shipped_arms())}, or the path of a .urdf file."
        )
    file = load_data(DATA / f"{name}.yaml", _ArmFile)
    links = [BASE, *(joint.name for joint in file.joints)]
    placement = np.array([_placement(joint.position_m, joint.rotation_rad) for joint in file.joints])
    limits = np.radians([joint.limits_deg for joint in file.joints])
    link = np.array([links.index(capsule.link) for capsule in file.capsules])
    chain = Chain(
        placement=placement, lower=limits[:, 0].copy(), upper=limits[:, 1].copy(), tip=np.eye(4), link=link,
        ends=np.array([(capsule.from_m, capsule.to_m) for capsule in file.capsules], dtype=float),
        radius=np.array([capsule.radius_m for capsule in file.capsules]), pairs=apart(link),
    )  # fmt: skip
    source = f"{file.kinematics_source}; capsules: {file.capsules_source}; payload: {file.payload_source}"
    return Arm(file.name, tuple(links[1:]), chain, file.payload_kg, source)


def arm_named(named: str, link_radius_m: float) -> Arm:
    """An arm that ships, or that of a URDF file, whose links are as thick as is said.

    Raises ExperimentError if it is neither, or if the file's robot is no chain of joints that turn.
    """
    if Path(named).suffix != ".urdf":
        return load_arm(named)
    return arm_from_urdf(Path(named), link_radius_m)


def arm_from_urdf(path: Path, link_radius_m: float) -> Arm:
    """The arm of a URDF file: joints that turn, one after the other; links straight from one to the next.

    The flange is the frame of the last link. Joints without limits may turn once either way. Raises ExperimentError.
    """
    if not path.is_file():
        raise ExperimentError(f"robot.arm {path}: there is no such file.")
    try:
        model = pin.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise ExperimentError(
            f"robot.arm {path}: is no URDF file of a robot: {' '.join(str(error).split())}."
        ) from error
    names = list(model.names)[1:]
    if not 0 < len(names) <= MAX_JOINTS:
        raise ExperimentError(f"robot.arm {path}: {len(names)} joints that move; an arm has from 1 to {MAX_JOINTS}.")
    placements, lower, upper = [], [], []
    turned = np.eye(3)  # from the frame of the joint before to one whose z is the axis
    for index, name in enumerate(names, start=1):
        joint = model.joints[index]
        if joint.nv != 1 or not joint.shortname().startswith("JointModelR") or model.parents[index] != index - 1:
            raise ExperimentError(
                f"robot.arm {path}: joint {name} does not turn, or does not follow the one before; an arm is a chain "
                "of joints that turn."
            )
        if joint.nq == 1:
            lower.append(float(model.lowerPositionLimit[joint.idx_q]))
            upper.append(float(model.upperPositionLimit[joint.idx_q]))
        else:
            lower.append(-2 * np.pi)
            upper.append(2 * np.pi)
        align = _turn_z_to(_axis_of(model, index))
        at = model.jointPlacements[index]
        placements.append(pin.SE3(turned.T @ at.rotation @ align, turned.T @ at.translation).homogeneous)
        turned = align
    last = [frame for frame in model.frames if frame.type == pin.FrameType.BODY and frame.parentJoint == len(names)][-1]
    tip = pin.SE3(turned.T @ last.placement.rotation, turned.T @ last.placement.translation).homogeneous
    points = [*(placement[:3, 3] for placement in placements), tip[:3, 3]]
    link = np.arange(len(names) + 1)
    chain = Chain(
        placement=np.array(placements), lower=np.array(lower), upper=np.array(upper), tip=tip, link=link,
        ends=np.array([(np.zeros(3), point) for point in points]),
        radius=np.full(link.size, link_radius_m), pairs=apart(link),
    )  # fmt: skip
    return Arm(model.name, tuple(names), chain, None, f"{path.name}; links as capsules from joint to joint")


def _axis_of(model: pin.Model, joint: int) -> Vector:
    """The axis (3,) of a joint that turns, in its own frame."""
    jacobian = pin.computeJointJacobian(model, model.createData(), pin.neutral(model), joint)
    return np.asarray(jacobian[3:, model.joints[joint].idx_v])


def _turn_z_to(axis: Vector) -> Vector:
    """A rotation (3, 3) whose z is the axis."""
    z = axis / np.linalg.norm(axis)
    x = np.eye(3)[int(np.abs(z).argmin())]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def apart(link: Indices) -> Indices:
    """Pairs (p, 2) of capsules that may not meet: those with a link between them; neighbours always touch."""
    count = link.size
    pairs = [(a, b) for a in range(count) for b in range(a + 1, count) if abs(link[a] - link[b]) > 1]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _placement(position_m: Point, rotation_rad: tuple[float, float, float]) -> Vector:
    """The frame at a position, turned by roll, pitch and yaw in rad (about the fixed x, y and z, as in URDF)."""
    return np.asarray(pin.SE3(pin.rpy.rpyToMatrix(np.array(rotation_rad)), np.array(position_m)).homogeneous)

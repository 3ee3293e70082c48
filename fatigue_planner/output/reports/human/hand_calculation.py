"""Static moments by hand: weights times horizontal distances in the sagittal plane.

Independent of the rigid-body library and of the model's frames: masses and centres of mass come from de
Leva's table, lengths from the joint centres' table, directions from plane trigonometry.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians, sin

from fatigue_planner.human.anthropometry import Anthropometry, segment_table
from fatigue_planner.human.model import GRAVITY_MPS2

TRUNK = ("mid_trunk", "upper_trunk", "head")  # above L5/S1; the upper trunk holds the neck's mass too
ARM = ("upper_arm", "forearm", "hand")


@dataclass(frozen=True)
class PlanarPosture:
    """Inclinations in radians: of the trunk from upright, forward; of each arm's segments from hanging, forward."""

    trunk: float
    right_arm: tuple[float, float, float]
    left_arm: tuple[float, float, float]


def planar_posture(angles_deg: Mapping[str, float]) -> PlanarPosture:
    """The inclinations of a posture given by joint angles; a name without side sets both."""

    def angle(name: str, side: str = "right") -> float:
        return radians(angles_deg.get(f"{side}_{name}", angles_deg.get(name, 0.0)))

    trunk = angle("hip_flexion") - angle("knee_flexion") + angle("ankle_flexion") + angle("lumbar_flexion")

    def arm(side: str) -> tuple[float, float, float]:
        upper = angle("shoulder_flexion", side) - trunk
        fore = upper + angle("elbow_flexion", side)
        return upper, fore, fore + angle("wrist_deviation", side)

    return PlanarPosture(trunk, arm("right"), arm("left"))


def static_moments_nm(body: Anthropometry, angles_deg: Mapping[str, float], tool_kg: float) -> dict[str, float]:
    """Moments in N.m that hold the right wrist, elbow and shoulder and the back (L5/S1) against gravity.

    Positive ones lift: flexion of elbow and shoulder, radial deviation of the wrist, extension of the
    back. The tool is a point mass in the right fist; the trunk above L5/S1 is rigid.
    """
    posture = planar_posture(angles_deg)
    right = _arm(body, posture.right_arm, tool_kg)
    left = _arm(body, posture.left_arm, 0.0)
    shoulder = sin(posture.trunk) * _above_lumbar_m(body, body.length("shoulder_height"))
    trunk = [(mass, sin(posture.trunk) * _above_lumbar_m(body, height)) for mass, height in _trunk_masses(body, TRUNK)]
    arms = [(mass, shoulder + x) for mass, x in right.masses + left.masses]
    return {
        "back": GRAVITY_MPS2 * sum(mass * x for mass, x in trunk + arms),
        "shoulder": right.moment_about(0),
        "elbow": right.moment_about(1),
        "wrist": right.moment_about(2),
    }


@dataclass(frozen=True)
class _Arm:
    """Masses (kg) with their distance before the shoulder (m); distances of shoulder, elbow and wrist."""

    masses: list[tuple[float, float]]
    joints: tuple[float, float, float]

    def moment_about(self, joint: int) -> float:
        """Moment of what lies beyond a joint (0 shoulder, 1 elbow, 2 wrist) about it, in N.m."""
        return GRAVITY_MPS2 * sum(mass * (x - self.joints[joint]) for mass, x in self.masses[joint:])


def _arm(body: Anthropometry, inclinations: tuple[float, float, float], tool_kg: float) -> _Arm:
    table = segment_table().segments
    start, joints, masses = 0.0, [], []
    for name, inclination in zip(ARM, inclinations, strict=True):
        row = table[name][body.sex]
        length = body.length(f"{name}_length") * sin(inclination)
        joints.append(start)
        masses.append((row.mass_percent / 100 * body.mass_kg, start + row.com_percent / 100 * length))
        start += length
    fist = joints[2] + body.length("grip_beyond_wrist") * sin(inclinations[2])
    return _Arm([*masses, (tool_kg, fist)], (joints[0], joints[1], joints[2]))


def _above_lumbar_m(body: Anthropometry, height_m: float) -> float:
    """Distance of a point of the trunk above L5/S1, from its height standing straight."""
    return height_m - _hip_height_m(body) - body.length("lumbar_above_hip")


def _hip_height_m(body: Anthropometry) -> float:
    return body.length("ankle_height") + body.length("shank_length") + body.length("thigh_length")


def _trunk_masses(body: Anthropometry, names: tuple[str, ...]) -> list[tuple[float, float]]:
    """Masses (kg) and heights of their centres (m) of trunk segments, standing straight.

    De Leva's segments are stacked on the mid-hip; the head hangs from the vertex. The neck's mass, part
    of the upper trunk in his table, lies half-way between its joints.
    """
    table = segment_table()
    scale = body.stature_m / table.reference_stature_m[body.sex]
    neck = table.neck_mass_percent.value
    found, top = {}, _hip_height_m(body)
    for name in ("lower_trunk", "mid_trunk", "upper_trunk"):
        row = table.segments[name][body.sex]
        top += row.length_m * scale
        share = row.mass_percent - (neck if name == "upper_trunk" else 0)
        found[name] = [(share / 100 * body.mass_kg, top - row.com_percent / 100 * row.length_m * scale)]
    below_neck = ("lumbar_above_hip", "thoracic_above_lumbar", "neck_above_thoracic")
    middle = _hip_height_m(body) + sum(body.length(step) for step in below_neck) + body.length("head_above_neck") / 2
    found["upper_trunk"].append((neck / 100 * body.mass_kg, middle))
    head = table.segments["head"][body.sex]
    height = body.stature_m - head.com_percent / 100 * head.length_m * scale
    found["head"] = [(head.mass_percent / 100 * body.mass_kg, height)]
    return [pair for name in names for pair in found[name]]


def standing_masses(body: Anthropometry) -> list[tuple[float, float]]:
    """Masses (kg) and heights of their centres (m) of the whole body, standing straight with hanging arms."""
    table = segment_table().segments
    pairs = _trunk_masses(body, ("lower_trunk", *TRUNK))
    limbs = {"thigh": _hip_height_m(body), "upper_arm": body.length("shoulder_height")}
    limbs["shank"] = limbs["thigh"] - body.length("thigh_length")
    limbs["forearm"] = limbs["upper_arm"] - body.length("upper_arm_length")
    limbs["hand"] = limbs["forearm"] - body.length("forearm_length")
    for name, proximal in limbs.items():
        row = table[name][body.sex]
        height = proximal - row.com_percent / 100 * body.length(f"{name}_length")
        pairs.append((2 * row.mass_percent / 100 * body.mass_kg, height))
    foot = table["foot"][body.sex].mass_percent / 100 * body.mass_kg
    return [*pairs, (2 * foot, body.length("ankle_height") / 2)]

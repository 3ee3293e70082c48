"""Static moments by hand: weights times horizontal distances in the sagittal plane.

Independent of the rigid-body library and of the model's frames: masses and centres of mass come from de
Leva's table, lengths from the joint centres' table, directions from plane trigonometry.
"""

from collections.abc import Mapping
from math import radians, sin

from fatigue_planner.human.anthropometry import Anthropometry, segment_table
from fatigue_planner.human.multibody import GRAVITY_MPS2

ARM = ("upper_arm", "forearm", "hand")

# A mass in kg and where it is, in m: a height, or a horizontal distance.
PointMass = tuple[float, float]


def static_moments_nm(body: Anthropometry, angles_deg: Mapping[str, float], tool_kg: float) -> dict[str, float]:
    """Moments in N.m that hold the right wrist, elbow and shoulder and the back (L5/S1) against gravity.

    Positive ones lift: flexion of elbow and shoulder, radial deviation of the wrist, extension of the
    back. The tool is a point mass in the right fist; the trunk above L5/S1 is rigid. An angle without a
    side holds for both.
    """
    # by how much the trunk is inclined forward
    trunk = (
        _angle(angles_deg, "hip_flexion") - _angle(angles_deg, "knee_flexion")
        + _angle(angles_deg, "ankle_flexion") + _angle(angles_deg, "lumbar_flexion")
    )  # fmt: skip
    lumbar = _hip_height_m(body) + body.length("lumbar_above_hip")
    shoulder = sin(trunk) * (body.length("shoulder_height") - lumbar)
    right, joints = _arm(body, angles_deg, trunk, "right", tool_kg)
    left, _ = _arm(body, angles_deg, trunk, "left", 0.0)
    above = [pair for name, pair in _trunk_masses(body).items() if name != "lower_trunk"]
    loads = [
        *((mass, sin(trunk) * (height - lumbar)) for mass, height in above),
        *((mass, shoulder + x) for mass, x in right + left),
    ]
    moments = {"back": GRAVITY_MPS2 * sum(mass * x for mass, x in loads)}
    for number, (name, joint) in enumerate(zip(("shoulder", "elbow", "wrist"), joints, strict=True)):
        moments[name] = GRAVITY_MPS2 * sum(mass * (x - joint) for mass, x in right[number:])
    return moments


def _angle(angles_deg: Mapping[str, float], name: str, side: str = "right") -> float:
    return radians(angles_deg.get(f"{side}_{name}", angles_deg.get(name, 0.0)))


def _arm(
    body: Anthropometry, angles_deg: Mapping[str, float], trunk: float, side: str, tool_kg: float
) -> tuple[list[PointMass], list[float]]:
    """Masses before the shoulder from the upper arm to the tool; distances of shoulder, elbow and wrist."""
    upper = _angle(angles_deg, "shoulder_flexion", side) - trunk
    fore = upper + _angle(angles_deg, "elbow_flexion", side)
    inclinations = (upper, fore, fore + _angle(angles_deg, "wrist_deviation", side))
    start, joints, masses = 0.0, [], []
    for name, inclination in zip(ARM, inclinations, strict=True):
        row = segment_table().segments[name][body.sex]
        length = body.length(f"{name}_length") * sin(inclination)
        joints.append(start)
        masses.append((row.mass_percent / 100 * body.mass_kg, start + row.com_percent / 100 * length))
        start += length
    return [*masses, (tool_kg, joints[2] + body.length("grip_beyond_wrist") * sin(inclinations[2]))], joints


def _hip_height_m(body: Anthropometry) -> float:
    return body.length("ankle_height") + body.length("shank_length") + body.length("thigh_length")


def _trunk_masses(body: Anthropometry) -> dict[str, PointMass]:
    """Masses and heights of their centres of the trunk, the neck and the head, standing straight.

    De Leva's segments are stacked on the mid-hip; the head hangs from the vertex. The neck's mass, part
    of the upper trunk in his table, lies half-way between its joints.
    """
    table = segment_table()
    scale = body.stature_m / table.reference_stature_m[body.sex]
    neck = table.neck_mass_percent.value
    masses, top = {}, _hip_height_m(body)
    for name in ("lower_trunk", "mid_trunk", "upper_trunk"):
        row = table.segments[name][body.sex]
        top += row.length_m * scale
        percent = row.mass_percent - (neck if name == "upper_trunk" else 0)
        masses[name] = (percent / 100 * body.mass_kg, top - row.com_percent / 100 * row.length_m * scale)
    below_neck = ("lumbar_above_hip", "thoracic_above_lumbar", "neck_above_thoracic")
    middle = _hip_height_m(body) + sum(body.length(step) for step in below_neck) + body.length("head_above_neck") / 2
    masses["neck"] = (neck / 100 * body.mass_kg, middle)
    head = table.segments["head"][body.sex]
    height = body.stature_m - head.com_percent / 100 * head.length_m * scale
    return masses | {"head": (head.mass_percent / 100 * body.mass_kg, height)}


def standing_masses(body: Anthropometry) -> list[PointMass]:
    """Masses and heights of their centres of the whole body, standing straight with hanging arms."""
    table = segment_table().segments
    limbs = {"thigh": _hip_height_m(body), "upper_arm": body.length("shoulder_height")}
    limbs["shank"] = limbs["thigh"] - body.length("thigh_length")
    limbs["forearm"] = limbs["upper_arm"] - body.length("upper_arm_length")
    limbs["hand"] = limbs["forearm"] - body.length("forearm_length")
    pairs = list(_trunk_masses(body).values())
    for name, proximal in limbs.items():
        row = table[name][body.sex]
        height = proximal - row.com_percent / 100 * body.length(f"{name}_length")
        pairs.append((2 * row.mass_percent / 100 * body.mass_kg, height))
    foot = table["foot"][body.sex].mass_percent / 100 * body.mass_kg
    return [*pairs, (2 * foot, body.length("ankle_height") / 2)]

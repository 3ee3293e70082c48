"""A second reading of a posture: MuJoCo moves the exported body, and angles come from points and Euler angles."""

import mujoco
import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.human.urdf import urdf_text
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.reaction import Reaction

SIDES = ("right", "left")


def angle_between(first: np.ndarray, second: np.ndarray) -> float:
    """The angle between two lines in degrees, by the arc tangent."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)))


def readings(reaction: Reaction, stride: int) -> dict[int, dict[str, float]]:
    """What is seen of a motion at every so many ticks, by tick."""
    if (reaction.digest, stride) not in _READ:
        reader = Reader(build_human(reaction.key.motion_request().worker))
        ticks = range(0, len(reaction.motion.configuration), stride)
        _READ[reaction.digest, stride] = {tick: reader.read(reaction.motion, tick) for tick in ticks}
    return _READ[reaction.digest, stride]


_READ: dict[tuple[str, int], dict[int, dict[str, float]]] = {}


class Reader:
    """The body of a worker in MuJoCo."""

    def __init__(self, human: Human) -> None:
        text = urdf_text(human, maximum_torque("average_man").vectors(), 10.0)
        specification = mujoco.MjSpec.from_string(text)
        specification.body("pelvis").add_freejoint(name="root")
        self.model = specification.compile()
        self.data = mujoco.MjData(self.model)
        self.places = [self.model.joint(name).qposadr[0] for name in DEGREES_OF_FREEDOM]
        self.grip = human.anthropometry.grip_m()

    def read(self, motion: Motion, tick: int) -> dict[str, float]:
        """All angles of a tick in degrees; of a side under `right_` and `left_`."""
        q = motion.configuration[tick]
        self.data.qpos[:3], self.data.qpos[3:7], self.data.qpos[self.places] = q[:3], q[[6, 3, 4, 5]], q[7:]
        mujoco.mj_kinematics(self.model, self.data)
        dof = dict(zip(DEGREES_OF_FREEDOM, np.degrees(q[7:]), strict=True))
        trunk = (self.axes("pelvis").inv() * self.axes("thorax")).as_euler("YXZ", degrees=True)
        neck = (self.axes("thorax").inv() * self.axes("head")).as_euler("YXZ", degrees=True)
        hips = (self.place("right_thigh") + self.place("left_thigh")) / 2
        feet = {side: motion.wrench[tick, 6 * i + 2] for i, side in enumerate(SIDES)}
        found = {
            "trunk": self.inclined(self.place("neck") - hips, "pelvis"),
            "trunk_side": trunk[1], "trunk_twist": trunk[2],
            "neck": neck[0], "neck_side": neck[1], "neck_twist": neck[2],
            "head": self.inclined(self.axes("head").apply([0, 0, 1.0]), "head"),
        }  # fmt: skip
        for side in SIDES:
            out = np.array([0, -1.0 if side == "right" else 1.0, 0])
            shoulder, elbow, wrist = (self.place(f"{side}_{body}") for body in ("upper_arm", "forearm", "hand"))
            arm = self.axes("thorax").inv().apply(elbow - shoulder)
            behind = -arm[0] > abs(arm[1])
            hand = wrist + self.axes(f"{side}_hand").apply(self.grip)
            across = self.axes("thorax").inv().apply(hand - self.place("thorax")) @ out
            found |= {
                f"{side}_arm": angle_between(arm, np.array([0, 0, -1.0])) * (-1 if behind else 1),
                f"{side}_arm_abducted": 90 - angle_between(arm, out),
                f"{side}_arm_forward": 90 - angle_between(arm, np.array([1.0, 0, 0])),
                f"{side}_arm_raised": angle_between(elbow - shoulder, np.array([0, 0, -1.0])),
                f"{side}_elbow": angle_between(elbow - shoulder, wrist - elbow),
                f"{side}_hand_out_m": across,
                f"{side}_hand_height_m": hand[2],
                f"{side}_foot_share": feet[side] / sum(feet.values()),
                f"{side}_pronation": dof[f"{side}_forearm_pronation"],
                f"{side}_wrist": dof[f"{side}_wrist_flexion"],
                f"{side}_deviation": dof[f"{side}_wrist_deviation"],
                f"{side}_knee": angle_between(
                    self.place(f"{side}_shank") - self.place(f"{side}_thigh"),
                    self.place(f"{side}_foot") - self.place(f"{side}_shank"),
                ),
            }
        return {name: float(value) for name, value in found.items()}

    def axes(self, body: str) -> Rotation:
        return Rotation.from_matrix(self.data.body(body).xmat.reshape(3, 3))

    def place(self, body: str) -> np.ndarray:
        return np.asarray(self.data.body(body).xpos).copy()

    def inclined(self, line: np.ndarray, body: str) -> float:
        """Against the vertical; negative if the line leans more than 5 degrees back, as seen from the body's side."""
        left = self.axes(body).apply([0, 1.0, 0])
        heading = np.arctan2(-left[0], left[1])
        ahead = pin.utils.rotate("z", -heading) @ line
        sagittal = np.degrees(np.arctan2(ahead[0], ahead[2]))
        return angle_between(line, np.array([0, 0, 1.0])) * (-1 if sagittal < -5 else 1)

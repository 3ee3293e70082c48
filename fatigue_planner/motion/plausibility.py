"""Whether a person would move so: what a stored motion shows, beside bars for people."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion import posture_measures as posture
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.schedule import runs_of

Vector = NDArray[np.float64]

# A joint is at the end of its range within this; muscles push it there with more than both of these.
AT_END_DEG = 1.0
PUSHING_NM, PUSHING_SHARE = 1.0, 0.02
# Torque steps are changes within STEP_S; phases shorter than UNHURRIED_S are as brisk as their own course.
STEP_S = 0.04
UNHURRIED_S = 3.0
# Values that differ by less are equal, so that the name of the largest does not depend on rounding.
DIGITS = 9


@dataclass(frozen=True)
class Plausibility:
    """What is seen of a motion, as magnitudes.

    In the middle of the work, in degrees: twist and side bend of the trunk, its lean, the angle between gaze and
    object, the roll of the head and, of a hand without a goal, the upper arm from the vertical (0 if both have one).
    During work: how far an upper arm is turned beyond its range. At any tick: how deep two parts of the body are in
    each other, and which (neighbours: deeper than in the stance); for how long which joint is at an end of its range
    with muscles that push it there; the largest torque step of which joint within 40 ms, in phases of 3 s and more. At
    the last tick: how far which joint is from the stance, and the largest speed. At the first, in the stance: the
    largest load of a joint as a share of its strength.
    """

    trunk_twist_deg: float
    side_bend_deg: float
    lean_deg: float
    gaze_deg: float
    head_roll_deg: float
    free_arm_deg: float
    shoulder_turn_deg: float
    penetration_m: float
    penetration_parts: str
    pushing_s: float
    pushing_joint: str
    torque_step_nm: float
    torque_step_joint: str
    end_pose_deg: float
    end_pose_joint: str
    end_speed_degps: float
    stance_load_share: float
    stance_load_joint: str

    def findings(self) -> list["Finding"]:
        """Everything that is beyond its bar; empty for a plausible motion."""
        return [
            Finding(name, value, bar.most, bar.describe(value, getattr(self, bar.named_by, "")))
            for name, bar in BARS.items()
            if not (value := getattr(self, name)) <= bar.most
        ]


class Bar(NamedTuple):
    """The most that passes for a person's, in the unit of the measure; the rest makes a sentence of it."""

    most: float
    text: str
    unit: str = "°"
    factor: float = 1.0
    digits: int = 0
    named_by: str = ""
    reason: str = ""

    def describe(self, value: float, name: str) -> str:
        """What is seen, how much of it, and how much is allowed."""
        # rounded away from the bar, so that what is beyond it reads so
        scale = 10**self.digits
        shown, most = np.ceil(value * self.factor * scale) / scale, self.most * self.factor
        text = self.text.format(name=name.replace("_", " "))
        return f"{text} {shown:.{self.digits}f} {self.unit} (at most {most:g})".replace(" °", "°")


# The bars: what people do in one-handed reaching, with a margin (docs/human.md gives their sources).
BARS = {
    "trunk_twist_deg": Bar(
        15, "trunk twisted by",
        reason="half of what a standing person can turn the trunk, 32.6° (Montgomery 2011)",
    ),
    "side_bend_deg": Bar(15, "trunk bent sideways by", reason="assumed; in EN 1005-4 10° is clearly visible"),
    "gaze_deg": Bar(
        30, "face turned away from the work by", reason="assumed: the eyes take 20° down and 10° up, the head the rest"
    ),
    "head_roll_deg": Bar(15, "head tilted sideways by", reason="assumed: people keep the head level"),
    "free_arm_deg": Bar(
        20, "free upper arm away from the vertical by", reason="assumed: it hangs; ISO 11226 accepts up to 20°"
    ),
    "shoulder_turn_deg": Bar(
        0, "shoulder the wrong way round: upper arm turned beyond its range by",
        reason="the shoulder's range of rotation",
    ),
    "penetration_m": Bar(
        0.005, "{name} in each other by", "mm", 1000, named_by="penetration_parts",
        reason="what soft tissue gives way by, assumed; capsules of measured girths",
    ),
    "pushing_s": Bar(
        0, "muscles push {name} into its end of range for", "s", digits=2, named_by="pushing_joint",
        reason="nobody works against the end of a joint: within 1° of it, by more than 1 N·m and 2 % of the strength",
    ),
    "torque_step_nm": Bar(
        10, "torque step within 40 ms at {name} of", "N.m", digits=1, named_by="torque_step_joint",
        reason="assumed: muscle torque rises smoothly; only in phases of 3 s and more",
    ),
    "end_pose_deg": Bar(
        1, "ends away from the stance, {name} by", digits=1, named_by="end_pose_joint",
        reason="the next cycle begins in the stance",
    ),
    "end_speed_degps": Bar(1, "ends while moving with", "°/s", digits=1, reason="the next cycle begins at rest"),
    "stance_load_share": Bar(
        0.08, "{name} loaded in the stance with", "% of its strength", 100, 1, "stance_load_joint",
        reason="no joint should tire from standing: the paper's threshold of 10 %, less 2",
    ),
}  # fmt: skip


class Finding(NamedTuple):
    """A measure that is beyond its bar, both in its unit, and what it means in words."""

    measure: str
    value: float
    bar: float
    text: str


def measure_plausibility(request: MotionRequest, motion: Motion) -> Plausibility:
    """See what an observer would, from the stored arrays alone."""
    person = request.worker.anthropometry()
    poses = poses_of(tree_of(person), motion.configuration)
    middle = slice(motion.middle("work"), motion.middle("work") + 1)
    now = type(poses)(poses.rotation[middle], poses.origin_m[middle])
    working = request.action.goals()
    fists = np.mean([now.points(f"{side}_hand", person.grip_m()) for side in working], axis=0)
    at_work = type(poses)(*(part[motion.phase("work")] for part in poses))
    free = [posture.upper_arm_elevation(now, side)[0] for side in SIDES if side not in working]
    capsules = capsules_of(person)
    apart_m = posture.distances(poses, capsules)
    in_stance_m = np.where(capsules.joined, np.minimum(apart_m[0], 0.0), 0.0)
    nearest = apart_m.min(axis=0) - in_stance_m
    depth, pair = _largest(-nearest, [f"{BODIES[a]} and {BODIES[b]}" for a, b in capsules.pairs])
    pushed = _pushed(request, motion).sum(axis=0) * motion.time_step_s
    home = np.degrees(np.abs(motion.configuration[-1, BASE_DOF + 1 :] - motion.configuration[0, BASE_DOF + 1 :]))
    positive, negative = request.maximum_torque.vectors()
    standing = np.maximum(motion.torque_nm[0] / positive, -motion.torque_nm[0] / negative)
    pushing_s, pushing_joint = _largest(pushed, DEGREES_OF_FREEDOM)
    step_nm, step_joint = _largest(_torque_steps(request, motion), DEGREES_OF_FREEDOM)
    end_pose, end_joint = _largest(home, DEGREES_OF_FREEDOM)
    load, load_joint = _largest(standing, DEGREES_OF_FREEDOM)
    return Plausibility(
        trunk_twist_deg=abs(float(posture.trunk_twist(now)[0])),
        side_bend_deg=abs(float(posture.side_bend(now)[0])),
        lean_deg=float(posture.lean(now)[0]),
        gaze_deg=float(posture.gaze(now, person, fists)[0]),
        head_roll_deg=abs(float(posture.head_roll(now)[0])),
        free_arm_deg=float(max(free, default=0.0)),
        shoulder_turn_deg=float(max(posture.shoulder_turn(at_work, side).max() for side in SIDES)),
        penetration_m=depth,
        penetration_parts=pair,
        pushing_s=pushing_s,
        pushing_joint=pushing_joint,
        torque_step_nm=step_nm,
        torque_step_joint=step_joint,
        end_pose_deg=end_pose,
        end_pose_joint=end_joint,
        end_speed_degps=float(np.degrees(np.abs(motion.velocity[-1, BASE_DOF:]).max())),
        stance_load_share=load,
        stance_load_joint=load_joint,
    )


def _largest(values: Vector, names: Sequence[str]) -> tuple[float, str]:
    """The largest of some values and its name; 0 and no name if none is positive."""
    index = int(np.round(values, DIGITS).argmax())
    return (float(values[index]), names[index]) if not values[index] <= 0 else (0.0, "")


def _pushed(request: MotionRequest, motion: Motion) -> NDArray[np.bool_]:
    """Where (T, 39) a joint is at an end of its range and its muscles push it outward."""
    angles, (lower, upper) = motion.configuration[:, BASE_DOF + 1 :], position_limits()
    near = np.radians(AT_END_DEG)
    out_up, out_down = (
        np.maximum(PUSHING_NM, PUSHING_SHARE * strength) for strength in request.maximum_torque.vectors()
    )
    at_upper, at_lower = angles > upper - near, angles < lower + near
    return np.asarray((at_upper & (motion.torque_nm > out_up)) | (at_lower & (motion.torque_nm < -out_down)))


def _torque_steps(request: MotionRequest, motion: Motion) -> Vector:
    """The largest change of every joint's torque (39,) within STEP_S, in phases that are not hurried.

    What a mass that is taken up or put down changes is not the body's doing.
    """
    ticks = max(1, round(STEP_S / motion.time_step_s))
    change = np.abs(motion.torque_nm[ticks:] - motion.torque_nm[:-ticks])
    judged = np.ones(len(change), dtype=bool)
    for phase in motion.phases:
        if (phase.stop - phase.start) * motion.time_step_s < UNHURRIED_S:
            judged[max(0, phase.start - ticks) : phase.stop] = False
    for run in runs_of(request.tool, request.action, motion.phases)[1:]:
        judged[max(0, run.start - ticks) : run.start] = False
    return np.asarray(change[judged].max(axis=0, initial=0.0))

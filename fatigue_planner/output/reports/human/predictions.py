"""What people do in experiments that the model was not made for, beside what the natural human does: met or not."""

from collections.abc import Callable

import numpy as np

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.core.text import fixed
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Tool, Worker, joint_index
from fatigue_planner.motion.action import Action, HandGoal, Position
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.payload import CarriedMass
from fatigue_planner.motion.posture_measures import lean
from fatigue_planner.motion.settings import Accuracy, Controller, Cycle, Segment
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.tasks.segment_upright import SegmentUpright
from fatigue_planner.output.reports.human.tables import SourcedTable

# The styles of lifting: with the back and the pelvis upright, with straight legs and hanging arms, and as one likes.
_STYLES: dict[str, tuple[Segment, ...]] = {
    "squat": ("thorax", "pelvis"),
    "stoop": ("right_upper_arm", "left_upper_arm"),
    "free": (),
}
WEIGHT = 10.0
# Where a box is grasped: in front of the toes, hands as far apart as a box is wide.
AHEAD_M, ASIDE_M = 0.45, 0.2
CYCLE = Cycle(reach_s=3.0, work_s=2.0, return_s=3.0)
KINGMA_KG, VON_ARX_KG, VON_ARX_HEIGHT_M = 10.5, 15.0, 0.15
# Kingma's standard deviation; what counts as none, all or between of an index; leaning that is seen.
SPREAD, NONE, ALL, SEEN_DEG = 0.09, 0.15, 0.85, 3.0


def predictions(worker: Worker) -> SourcedTable:
    """One row per finding about people: what they do, what the natural human of the worker's build does, and whether
    that agrees.
    """
    human = worker.model_validate(worker.model_dump(exclude={"human", "natural_posture_deg"}) | {"human": "natural"})
    table = SourcedTable(["finding", "people", "model", "met"])
    for name, people, ask in _FINDINGS:
        try:
            model, met = ask(human)
        except FailedMotionError as error:
            model, met = f"cannot be performed: {error}", False
        table.rows.append([name, people, model, "yes" if met else "**no**"])
        table.inside[name] = met
    return table


def _lift(worker: Worker, style: str, height_m: float, mass_kg: float = 0.0) -> Motion:
    """Both hands go to a box, hold it for two seconds, and bring it to the body."""
    hands = {
        side: HandGoal(position_m=Position(x=AHEAD_M, y=sign * ASIDE_M, z=height_m))
        for side, sign in (("right", -1), ("left", 1))
    }
    loads = tuple(
        CarriedMass(kind="mass", hand=side, mass_kg=mass_kg / 2, during=("work", "return"))
        for side in ("right", "left")
        if mass_kg > 0
    )  # fmt: skip
    return simulate(_request(worker, style, Action(right_hand=hands["right"], left_hand=hands["left"], loads=loads)))


def _request(worker: Worker, style: str, action: Action) -> MotionRequest:
    tasks = tuple(SegmentUpright(kind="segment_upright", segment=segment, weight=WEIGHT) for segment in _STYLES[style])
    strength, tool = maximum_torque(worker.strength), Tool(mass_kg=0.0)
    return MotionRequest(worker, strength, tool, CYCLE, Controller(), action, Preference(tasks=tasks))


def _back_moment_nm(motion: Motion) -> float:
    """Extension moment at L5/S1, of muscles and tissue, while the box is held."""
    tick, lumbar = motion.middle("work"), joint_index("lumbar_flexion")
    return float(-(motion.torque_nm + motion.tissue_nm)[tick, lumbar])


def _angle_deg(motion: Motion, name: str) -> float:
    return float(np.degrees(motion.configuration[motion.middle("work"), 7 + joint_index(name)]))


def _kingma(height_m: float, expected: float) -> Callable[[Worker], tuple[str, bool]]:
    def ask(worker: Worker) -> tuple[str, bool]:
        lifts = {style: _lift(worker, style, height_m, KINGMA_KG) for style in ("squat", "stoop")}
        squat, stoop = (_back_moment_nm(motion) for motion in lifts.values())
        share = squat / stoop
        text = f"{fixed(squat, 0)} N·m in the squat, {fixed(stoop, 0)} in the stoop: {fixed(share, 2)} times as much"
        for style, motion in lifts.items():
            if (miss := float(motion.hand_error_m[motion.phase("work")].max())) > Accuracy().hand_error_m:
                text += f"; in the {style} the hands stay up to {fixed(1000 * miss, 0)} mm from the box"
        return text, abs(share - expected) <= SPREAD

    return ask


def _lordosis(worker: Worker) -> tuple[str, bool]:
    lumbar = 7 + joint_index("lumbar_flexion")
    ranges = {
        style: float(np.degrees(np.ptp(_lift(worker, style, VON_ARX_HEIGHT_M, VON_ARX_KG).configuration[:, lumbar])))
        for style in ("free", "squat", "stoop")
    }
    text = ", ".join(f"{style} {fixed(value, 0)}°" for style, value in ranges.items())
    return text, ranges["stoop"] - max(ranges["free"], ranges["squat"]) >= SEEN_DEG


def _postural_index(worker: Worker) -> tuple[str, bool]:
    """Knee over ankle, hip and lumbar flexion: 0 in a stoop, 1 in a squat."""

    def index(style: str, height_m: float) -> float:
        motion = _lift(worker, style, height_m)
        others = ("right_ankle_flexion", "right_hip_flexion", "lumbar_flexion")
        return _angle_deg(motion, "right_knee_flexion") / sum(_angle_deg(motion, name) for name in others)

    stoop, squat, low, high = index("stoop", 0.3), index("squat", 0.3), index("free", 0.09), index("free", 0.63)
    text = (
        f"stoop {fixed(stoop, 2)}, squat {fixed(squat, 2)}; as he likes {fixed(low, 2)} at 9 cm, {fixed(high, 2)} at 63"
    )
    return text, stoop < NONE and squat > ALL and all(NONE < value < ALL for value in (low, high))


def _tired_shoulder(worker: Worker) -> tuple[str, bool]:
    return "the motion does not depend on fatigue: the same in every cycle", False


def _early_lean(worker: Worker) -> tuple[str, bool]:
    """One hand, level with the shoulder, at nine tenths of the arm's length."""
    person = worker.anthropometry()
    arm = sum(person.length(name) for name in ("upper_arm_length", "forearm_length", "grip_beyond_wrist"))
    goal = HandGoal(position_m=Position(x=0.9 * arm, y=-ASIDE_M, z=person.length("shoulder_height")))
    request = _request(worker, "free", Action(right_hand=goal))
    motion = simulate(request)
    poses = poses_of(tree_of(person), motion.configuration)
    neck, hip = (poses.points(body, np.zeros(3)) for body in ("neck", "pelvis"))
    tick = motion.middle("work")
    forward = float(lean(poses)[tick] * np.sign((neck - hip)[tick, 0]))
    return f"leans {fixed(forward, 1)}° forward at 90 % of the arm's length", forward >= SEEN_DEG


_FINDINGS: tuple[tuple[str, str, Callable[[Worker], tuple[str, bool]]], ...] = (
    (
        "moment at L5/S1, 10.5 kg from 5 cm, feet behind the box",
        "1.20 times as much (SD .09) in the squat as in the stoop (Kingma 2004, Ergonomics 47:1365)",
        _kingma(0.05, 1.2),
    ),
    ("the same from 50 cm", "no difference (Kingma 2004)", _kingma(0.5, 1.0)),
    (
        "range of lordosis, 15 kg",
        "free 24°, squat 25°, stoop 36°: widest in the stoop (von Arx 2021)",
        _lordosis,
    ),
    (
        "postural index: knee over ankle, hip and lumbar flexion",
        "stoop about 0, squat about 1, people in between, from 9 to 63 cm (Burgess-Limerick & Abernethy 1997)",
        _postural_index,
    ),
    (
        "a tired shoulder",
        "is spared by more flexion and rotation of the trunk (Dupuis 2021)",
        _tired_shoulder,
    ),
    ("reaching forward", "people lean before they must (Mark 1997)", _early_lean),
)

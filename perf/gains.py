"""The effect of the stiffnesses that the paper leaves open on the four reactions (docs/deviations.md, 4).

For each set of stiffnesses (1/s^2): how far the hand stays from its target during work, how far the line from
mid-hip to C7, the thorax and the upper arm lean from the vertical at mid-work, the right knee, the two torques that
the preferences are about, the neck's sideways bend, and how far the last posture is from the first.

    python perf/gains.py
"""

from pathlib import Path

import numpy as np
import pinocchio as pin

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human, joint_index
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.simulator import simulate

PAPER = Path(__file__).parents[1] / "experiments" / "paper.yaml"
# (hand, arm's thorax, back's upper arm, posture); the experiment's own choice first
SETS = (
    (1600, 80, 10, 4), (1600, 10, 10, 4), (1600, 20, 20, 4), (1600, 40, 40, 4), (1600, 160, 10, 4), (1000, 80, 10, 4),
)  # fmt: skip


def with_stiffness(experiment: Experiment, hand: float, arm: float, back: float, posture: float) -> Experiment:
    """The experiment with these stiffnesses; the centre of mass has the upper arm's."""
    gains = experiment.controller.stiffness_per_s2.model_copy(
        update={"hand": hand, "segment": back, "centre_of_mass": back, "posture": posture}
    )
    thorax = experiment.preferences["arm"].tasks[0].model_copy(update={"stiffness_per_s2": arm})
    arms = experiment.preferences["arm"].model_copy(update={"tasks": (thorax,)})
    return experiment.model_copy(
        update={
            "controller": experiment.controller.model_copy(update={"stiffness_per_s2": gains}),
            "preferences": {**experiment.preferences, "arm": arms},
        }
    )


def describe(request: MotionRequest, motion: Motion) -> str:
    human = build_human(request.worker)
    data = human.model.createData()
    work = motion.phase("work")
    middle = motion.middle("work")
    pin.framesForwardKinematics(human.model, data, motion.configuration[middle])

    def lean(segment: str) -> float:
        return float(np.degrees(np.arccos(data.oMf[human.model.getFrameId(segment)].rotation[2, 2])))

    spine = (
        data.oMf[human.model.getFrameId("neck")].translation - data.oMf[human.model.getFrameId("pelvis")].translation
    )
    stoop = np.degrees(np.arccos(spine[2] / np.linalg.norm(spine)))
    torque = motion.torque_nm[middle]
    shoulder = np.hypot(*torque[[joint_index("right_shoulder_flexion"), joint_index("right_shoulder_abduction")]])
    back = -torque[joint_index("lumbar_flexion")]
    knee, neck = np.degrees(
        motion.configuration[middle, 7 + np.array([joint_index("right_knee_flexion"), joint_index("neck_lateral")])]
    )
    closing = np.degrees(np.abs(motion.configuration[-1, 7:] - motion.configuration[0, 7:]).max())
    return (
        f"{motion.hand_error_m[work].max() * 1000:5.1f} | {stoop:3.0f} | {lean('thorax'):3.0f} | "
        f"{lean('right_upper_arm'):3.0f} | {knee:3.0f} | {back:4.0f} | {shoulder:3.0f} | {neck:4.0f} | {closing:4.1f}"
    )


def main() -> None:
    paper = load_experiment(PAPER)
    columns = "hand mm | C7 deg | thorax deg | arm deg | knee deg | lumbar N.m | shoulder N.m | neck deg | end deg"
    print(f"hand/arm/back/posture | reaction | {columns}")
    print(" | ".join(["---"] * 11))
    for hand, arm, back, posture in SETS:
        for request in reaction_requests(with_stiffness(paper, hand, arm, back, posture)):
            try:
                row = describe(request.motion, simulate(request.motion))
            except FailedMotionError as error:
                row = str(error)
            print(f"{hand}/{arm}/{back}/{posture} | {request.name} | {row}")


if __name__ == "__main__":
    main()

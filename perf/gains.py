"""The effect of the stiffnesses that the paper leaves open on the four reactions (docs/deviations.md, 4).

For each set of stiffnesses (1/s^2): how far the hand stays from its target during work, how far back
and upper arm lean from the vertical at mid-work, the two torques that the preferences are about, and how
far the last posture is from the first.

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
# (hand, segment and centre of mass, posture); the experiment's own choice first
SETS = ((1600, 10, 4), (1000, 4, 4), (1000, 10, 4), (1600, 20, 4), (1600, 40, 4))


def with_stiffness(experiment: Experiment, hand: float, segment: float, posture: float) -> Experiment:
    update = {"hand": hand, "segment": segment, "centre_of_mass": segment, "posture": posture}
    stiffness = experiment.controller.stiffness_per_s2.model_copy(update=update)
    return experiment.model_copy(
        update={"controller": experiment.controller.model_copy(update={"stiffness_per_s2": stiffness})}
    )


def describe(request: MotionRequest, motion: Motion) -> str:
    human = build_human(request.worker)
    data = human.model.createData()
    work = motion.phase("work")
    middle = motion.middle("work")
    pin.framesForwardKinematics(human.model, data, motion.configuration[middle])

    def lean(segment: str) -> float:
        return float(np.degrees(np.arccos(data.oMf[human.model.getFrameId(segment)].rotation[2, 2])))

    torque = motion.torque_nm[middle]
    shoulder = np.hypot(*torque[[joint_index("right_shoulder_flexion"), joint_index("right_shoulder_abduction")]])
    back = -torque[joint_index("lumbar_flexion")]
    neck = np.degrees(motion.configuration[middle, 7 + joint_index("neck_lateral")])
    closing = np.degrees(np.abs(motion.configuration[-1, 7:] - motion.configuration[0, 7:]).max())
    return (
        f"{motion.hand_error_m[work].max() * 1000:5.1f} | {lean('thorax'):3.0f} | {lean('right_upper_arm'):3.0f} | "
        f"{back:4.0f} | {shoulder:3.0f} | {neck:4.0f} | {closing:4.1f}"
    )


def main() -> None:
    paper = load_experiment(PAPER)
    columns = "hand mm | back deg | arm deg | lumbar N.m | shoulder N.m | neck deg | end deg"
    print(f"hand/segment/posture | reaction | {columns}")
    print("--- | --- | --- | --- | --- | --- | --- | --- | ---")
    for hand, segment, posture in SETS:
        for request in reaction_requests(with_stiffness(paper, hand, segment, posture)):
            try:
                row = describe(request.motion, simulate(request.motion))
            except FailedMotionError as error:
                row = str(error)
            print(f"{hand}/{segment}/{posture} | {request.name} | {row}")


if __name__ == "__main__":
    main()

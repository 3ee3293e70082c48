"""A whole tick of the simulation against the same controller in placo, on the same robot.

    python perf/placo/compare.py

Both sides simulate the paper's four cycles in turn, in interleaved rounds; CPU time of a cycle over its
ticks, set-up included. Ours is `simulate` as it is. The other side is controller.py, in a separate
environment, made when it is first needed; without it this benchmark ends with a message.

Equal on both sides: the robot (our exported URDF, tool in the hand), stance, time step and semi-implicit
integration; the tasks with their references, gains and weights (centre of mass, hand, upright segment,
posture); the unknowns (acceleration, one wrench per sole); soles held by hard constraints of the same
gains; sole rectangle and friction pyramid; the weight of the wrenches; what is recorded.
Different, as placo's limits and weights cannot be changed:
- joint range: placo bounds the next velocity by the one from which it can still brake, and its torques chatter
  there by some 10 N.m; ours bounds the acceleration (Del Prete), at most by the braking acceleration;
- torque limits: placo's are symmetric (the larger of both directions), ours are not;
- torque regularisation: placo has one weight for all joints, ours is relative to each joint's strength;
- contact: placo does not bound the yaw torque of a sole (9 rows per sole, ours has 16);
- ours solves without the limits of torques and contact forces first, and with them where they are violated; placo
  always with them;
- ours checks every solution for optimality and has a fallback solver; placo trusts its only solver;
- references: the placo side computes those of the whole cycle at once, before its first tick.
"""

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

# One thread of linear algebra, as in `fatplan simulate`; the other side inherits it.
os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}
sys.path.append(str(Path(__file__).parents[1]))

import numpy as np
import pinocchio as pin
from environments import PeerMissingError, environment_of

from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.urdf import urdf_text
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure

HERE = Path(__file__).parent
PAPER = HERE.parents[1] / "experiments" / "paper.yaml"
REQUIREMENTS = HERE / "requirements.txt"
ROUNDS = 7
JOINTS = ("lumbar_flexion", "right_shoulder_flexion", "right_wrist_deviation", "right_knee_flexion")


class Placo:
    """controller.py as a running process: one line of JSON in, one out."""

    def __init__(self, python: Path) -> None:
        self.process = subprocess.Popen(
            [python, HERE / "controller.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def simulate(self, request: dict[str, Any]) -> dict[str, Any]:
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        reply: dict[str, Any] = json.loads(line) if line else {"error": "the process of placo ended"}
        if "error" in reply:
            raise RuntimeError(reply["error"])
        return reply

    def close(self) -> None:
        self.process.communicate()


def with_frames(urdf: str, human: Human) -> str:
    """The URDF with fist and soles as links, which placo's tasks refer to."""
    robot = ElementTree.fromstring(urdf)
    for side in ("right", "left"):
        for point, body in (("grip", "hand"), ("sole", "foot")):
            name = f"{side}_{point}"
            offset = human.model.frames[human.model.getFrameId(name)].placement.translation
            ElementTree.SubElement(robot, "link", name=name)
            joint = ElementTree.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
            ElementTree.SubElement(joint, "parent", link=f"{side}_{body}")
            ElementTree.SubElement(joint, "child", link=name)
            ElementTree.SubElement(joint, "origin", xyz=" ".join(repr(float(x)) for x in offset), rpy="0 0 0")
    return ElementTree.tostring(robot, encoding="unicode")


def message(request: MotionRequest) -> dict[str, Any]:
    """The same problem for controller.py. The tool must be held for the whole cycle, and the hand not led home."""
    assert request.tool.held == "cycle" and request.cycle.return_hand == "free"
    human = build_human(request.worker, request.tool.mass_kg)
    settings, cycle = request.controller, request.cycle
    positive, negative = (
        settings.torque_limit_factor * torque for torque in maximum_torque(request.worker.strength).vectors()
    )
    hand = request.action.right_hand
    turn = hand.orientation_deg
    rotation = pin.rpy.rpyToMatrix(np.radians([turn.x, turn.y, turn.z]))
    target = pin.SE3(rotation, np.array([hand.position_m.x, hand.position_m.y, hand.position_m.z]))
    ends = np.cumsum([0, cycle.reach_s, cycle.work_s, cycle.return_s]) / settings.time_step_s
    regularisation, weight_n = settings.regularisation, human.mass_kg * GRAVITY_MPS2
    strength_squared = np.maximum(*maximum_torque(request.worker.strength).vectors()) ** 2
    return {
        "urdf": with_frames(urdf_text(human, (positive, negative), settings.velocity_limit_radps), human),
        "stance": {
            "base": pin.XYZQUATToSE3(human.stance[:7]).homogeneous.tolist(),
            "joints": dict(zip(list(human.model.names)[2:], human.stance[7:].tolist(), strict=True)),
        },
        "target": target.homogeneous.tolist(),
        "time_step_s": settings.time_step_s,
        "phases": [
            {"duration_s": duration, "ticks": int(ticks)}
            for duration, ticks in zip(
                (cycle.reach_s, cycle.work_s, cycle.return_s), np.diff(np.rint(ends)), strict=True
            )
        ],
        "weights": settings.weights.model_dump(),
        "stiffness_per_s2": settings.stiffness_per_s2.model_dump(),
        "upright": [
            (task.segment, task.weight, task.stiffness_per_s2 or settings.stiffness_per_s2.segment)
            for task in request.preference.tasks
        ],
        "sole_length_m": 2 * human.sole_half_length_m,
        "sole_breadth_m": 2 * human.sole_half_breadth_m,
        "pyramid_friction": settings.friction_coefficient / np.sqrt(2),  # the pyramid inside the cone, as ours
        "braking_radps2": settings.acceleration_limit_radps2,
        # one weight for all joints: ours, relative to strength, of the median joint
        "torque_weight": regularisation.relative_torque / float(np.median(strength_squared)),
        "force_weight": regularisation.relative_wrench / weight_n**2,
        "moment_weight": regularisation.relative_wrench / (weight_n * human.sole_half_length_m) ** 2,
    }


def summary(request: MotionRequest, motion: Motion) -> dict[str, Any]:
    """The same of our motion as controller.py reports of placo's."""
    names = list(build_human(request.worker).model.names)[2:]
    work = motion.phase("work")
    middle, half_second = motion.middle("work"), round(0.5 / motion.time_step_s)
    second = slice(middle - half_second, middle + half_second)
    return {
        "work_hand_error_m": motion.hand_error_m[work].max(),
        "foot_displacement_m": measure(request, motion).foot_displacement_m,
        "torque_nm": dict(zip(names, motion.torque_nm[second].mean(axis=0), strict=True)),
        "angle_rad": dict(zip(names, motion.configuration[second, 7:].mean(axis=0), strict=True)),
    }


def compare(placo: Placo) -> None:
    requests = reaction_requests(load_experiment(PAPER))
    messages = [message(request.motion) for request in requests]
    seconds: dict[str, list[list[float]]] = {"ours": [], "placo": []}
    table = []
    for index in range(ROUNDS + 1):  # the first round warms up and is not counted
        times: dict[str, list[float]] = {"ours": [], "placo": []}
        for request, text in zip(requests, messages, strict=True):
            begin = time.process_time()
            motion = simulate(request.motion)
            times["ours"].append((time.process_time() - begin) / motion.phases[-1].stop)
            theirs = placo.simulate(text)
            times["placo"].append(theirs["cpu_s"] / theirs["ticks"])
            if index == 0:
                table.append((str(request.name), summary(request.motion, motion), theirs))
        if index > 0:
            for side, values in times.items():
                seconds[side].append(values)
    show_equality(table)
    show_speed([name for name, *_ in table], {side: np.array(values) for side, values in seconds.items()})


def show_equality(table: list[tuple[str, dict[str, Any], dict[str, Any]]]) -> None:
    """Show that the same tasks have the same outcome: hand, feet, and torques and angles at mid-work."""
    print("Ours / placo: worst hand error during work and worst foot displacement in mm; joint torques in N.m and")
    print("the largest difference of all joint angles in degrees, both means over the second around mid-work.")
    print(" | ".join(["motion", "hand", "foot", *JOINTS, "angle"]))
    for name, ours, theirs in table:
        lengths = [
            f"{ours[key] * 1e3:.2f} / {theirs[key] * 1e3:.2f}" for key in ("work_hand_error_m", "foot_displacement_m")
        ]
        torques = [f"{ours['torque_nm'][joint]:.1f} / {theirs['torque_nm'][joint]:.1f}" for joint in JOINTS]
        joint, angle = max(
            ((joint, abs(value - theirs["angle_rad"][joint])) for joint, value in ours["angle_rad"].items()),
            key=lambda pair: pair[1],
        )
        print(" | ".join([name, *lengths, *torques, f"{np.degrees(angle):.1f} ({joint})"]))


def show_speed(names: list[str], seconds: dict[str, np.ndarray]) -> None:
    ours, theirs = seconds["ours"], seconds["placo"]
    print(f"CPU time per tick, medians of {ROUNDS} interleaved rounds (ours; placo; ratio):")
    for i, name in enumerate(names):
        mine, other = statistics.median(ours[:, i]), statistics.median(theirs[:, i])
        print(f"  {name}: {mine * 1e3:.3f} ms; {other * 1e3:.3f} ms; {mine / other:.2f}")
    mine, other = ours.mean(axis=1), theirs.mean(axis=1)
    ratios = mine / other
    print(
        f"whole tick {statistics.median(mine) * 1e3:.3f} ms, placo's {statistics.median(other) * 1e3:.3f} ms: "
        f"{statistics.median(ratios):.2f} x placo's (rounds {ratios.min():.2f} to {ratios.max():.2f})"
    )


def main() -> None:
    try:
        python = environment_of("placo", "placo", REQUIREMENTS)
    except PeerMissingError as error:
        print(f"comparison with placo skipped, it is not available: {error}")
        return
    print(__doc__[__doc__.index("Equal on both sides") :])
    placo = Placo(python)
    try:
        compare(placo)
    finally:
        placo.close()


if __name__ == "__main__":
    main()

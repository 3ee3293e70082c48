"""The paper's whole-body controller written with placo: one simulated cycle per request.

Runs in placo's own environment (requirements.txt) and knows nothing of fatplan: `compare.py` sends
the robot (URDF), the stance, the tasks and the gains as one line of JSON on standard input and gets
one line of JSON back. The cycle is timed from the parsed request to the finished records in CPU time,
just as `simulate` is on the other side: loading the robot, setting up the tasks, and in every tick
kinematics, references, program, integration and the records of configuration, velocity,
acceleration, torques, wrenches, hand error and displacement of both feet.

What is known before the first tick is computed for all ticks at once (the references), and what a
task keeps (stance, gains, weights) is set once, so that a tick does little else than call placo.
"""

import json
import sys
import time

import numpy as np
import pinocchio as pin
import placo

SIDES = ("right", "left")
UP = np.array([0.0, 0.0, 1.0])


def minimum_jerk_reach(start, end, duration_s, times_s):
    """A minimum-jerk motion from pose to pose (4 x 4 matrices), at all times at once.

    Returns poses (n, 4, 4) and linear velocity, linear acceleration, angular velocity and angular
    acceleration, each (n, 3) in world axes.
    """
    x = np.clip(times_s / duration_s, 0.0, 1.0)
    progress = x**3 * (10 - 15 * x + 6 * x**2)
    rate = 30 * x**2 * (1 - x) ** 2 / duration_s
    curvature = 60 * x * (1 - x) * (1 - 2 * x) / duration_s**2
    path = end[:3, 3] - start[:3, 3]
    turn = pin.log3(start[:3, :3].T @ end[:3, :3])
    world_turn = start[:3, :3] @ turn
    # Rodrigues' formula about the constant axis of the turn
    angle = np.linalg.norm(turn)
    cross = pin.skew(turn / max(angle, 1e-12))
    sine, cosine = np.sin(progress * angle)[:, None, None], np.cos(progress * angle)[:, None, None]
    poses = np.tile(np.eye(4), (len(x), 1, 1))
    poses[:, :3, :3] = start[:3, :3] @ (np.eye(3) + sine * cross + (1 - cosine) * (cross @ cross))
    poses[:, :3, 3] = start[:3, 3] + np.outer(progress, path)
    return (
        poses,
        np.outer(rate, path),
        np.outer(curvature, path),
        np.outer(rate, world_turn),
        np.outer(curvature, world_turn),
    )


class Upright:
    """The long axis e (z) of a segment kept vertical, the rotation about it free.

    placo's dynamics solver has no task for an axis (its AxisAlignTask is one of the kinematics
    solver), so an orientation task is led along: its target is the present orientation turned by the
    error e x up, and its mask keeps the two axes across e. Both change every tick, which takes 2 % of it.
    """

    def __init__(self, solver, robot, segment, weight, stiffness):
        self.robot = robot
        self.segment = segment
        self.task = solver.add_orientation_task(segment, np.eye(3))
        self.task.configure(segment, "soft", weight)
        self.task.kp = stiffness
        self.mask = self.task.mask
        self.mask.set_axises("xy", "custom")

    def update(self):
        rotation = self.robot.get_T_world_frame(self.segment)[:3, :3]
        self.mask.R_custom_world = rotation.T
        self.task.R_world_frame = pin.exp3(np.array([rotation[1, 2], -rotation[0, 2], 0.0])) @ rotation


class Controller:
    """The robot at its stance, its tasks, contacts and limits."""

    def __init__(self, request):
        weights, stiffness = request["weights"], request["stiffness_per_s2"]
        self.robot = robot = placo.RobotWrapper("", placo.Flags.ignore_collisions, request["urdf"])
        self.stand(request["stance"])
        self.solver = solver = placo.DynamicsSolver(robot)
        solver.dt = request["time_step_s"]
        balance = solver.add_com_task(robot.com_world())
        balance.configure("centre_of_mass", "soft", weights["centre_of_mass"])
        balance.mask.set_axises("xy", "task")
        balance.kp = stiffness["centre_of_mass"]
        self.hand = hand = solver.add_frame_task("right_grip", robot.get_T_world_frame("right_grip"))
        hand.configure("hand", "soft", weights["hand"], weights["hand"])
        self.hand_position, self.hand_orientation = hand.position(), hand.orientation()
        self.hand_position.kp = self.hand_orientation.kp = stiffness["hand"]
        self.upright = [Upright(solver, robot, *task) for task in request["upright"]]
        posture = solver.add_joints_task()
        posture.set_joints(request["stance"]["joints"])
        posture.configure("posture", "soft", weights["posture"])
        posture.kp = stiffness["posture"]
        self.contacts, self.feet = [], []
        for side in SIDES:
            foot = solver.add_frame_task(f"{side}_sole", robot.get_T_world_frame(f"{side}_sole"))
            foot.configure(f"{side}_sole", "hard", 1.0, 1.0)
            foot.position().kp = foot.orientation().kp = stiffness["contact"]
            contact = solver.add_planar_contact(foot)
            contact.length, contact.width = request["sole_length_m"], request["sole_breadth_m"]
            contact.mu = request["pyramid_friction"]
            contact.weight_forces, contact.weight_moments = request["force_weight"], request["moment_weight"]
            self.contacts.append(contact)
            self.feet.append(foot.position())
        solver.torque_cost = request["torque_weight"]
        solver.enable_joint_limits(True)
        solver.enable_velocity_limits(True)
        solver.enable_torque_limits(True)
        for joint in request["stance"]["joints"]:
            solver.set_qdd_safe(joint, request["braking_radps2"])

    def stand(self, stance):
        for joint, angle in stance["joints"].items():
            self.robot.set_joint(joint, angle)
        self.robot.set_T_world_fbase(np.array(stance["base"]))
        self.robot.update_kinematics()

    def simulate(self, request):
        """One cycle; returns the records, one row per tick."""
        robot, solver, upright = self.robot, self.solver, self.upright
        position, orientation = self.hand_position, self.hand_orientation
        (right, left), (right_foot, left_foot) = self.contacts, self.feet
        state, dt = robot.state, request["time_step_s"]
        home, target = robot.get_T_world_frame("right_grip"), np.array(request["target"])
        phases = zip(request["phases"], ((home, target), (target, target), (target, home)), strict=True)
        pieces = [
            minimum_jerk_reach(*ends, phase["duration_s"], np.arange(phase["ticks"]) * dt) for phase, ends in phases
        ]
        poses, *derivatives = (np.concatenate(arrays) for arrays in zip(*pieces, strict=True))
        ticks, nv = len(poses), robot.model.nv
        widths = {"configuration": robot.model.nq, "velocity": nv, "acceleration": nv, "torque_nm": nv, "wrench": 12}
        record = {name: np.empty((ticks, width)) for name, width in widths.items()}
        hand_error, displacement = np.empty((ticks, 3)), np.empty((ticks, 2, 3))
        positions, rotations = poses[:, :3, 3].copy(), poses[:, :3, :3].copy()
        release = sum(int(phase["ticks"]) for phase in request["phases"][:2])
        for tick, (velocity, acceleration, spin, spin_rate) in enumerate(zip(*derivatives, strict=True)):
            if tick == release:  # the posture task alone brings the hand home
                solver.remove_task(self.hand)
            robot.update_kinematics()
            if tick < release:
                position.target_world, position.dtarget_world = positions[tick], velocity
                position.ddtarget_world = acceleration
                orientation.R_world_frame, orientation.omega_world = rotations[tick], spin
                orientation.domega_world = spin_rate
            for segment in upright:
                segment.update()
            record["configuration"][tick], record["velocity"][tick] = state.q, state.qd
            result = solver.solve(True)  # integrates: velocity first, then the configuration with the new velocity
            if not result.success:
                raise RuntimeError(f"placo finds no solution at t = {tick * dt:.3f} s")
            record["acceleration"][tick], record["torque_nm"][tick] = result.qdd, result.tau
            record["wrench"][tick, :6], record["wrench"][tick, 6:] = right.wrench, left.wrench
            # the tasks keep their errors at the state before the step
            hand_error[tick] = position.error if tick < release else 0.0
            displacement[tick, 0], displacement[tick, 1] = right_foot.error, left_foot.error
        record["hand_error_m"] = np.linalg.norm(hand_error, axis=1)
        record["foot_displacement_m"] = np.linalg.norm(displacement, axis=2)
        return record


def summary(robot, request, record):
    """What compare.py shows of a motion: worst errors, and means over the second around mid-work by joint."""
    reach, work, _ = (phase["ticks"] for phase in request["phases"])
    middle, half_second = reach + work // 2, round(0.5 / request["time_step_s"])
    second = slice(middle - half_second, middle + half_second)
    names = list(request["stance"]["joints"])
    offsets = np.array([robot.get_joint_v_offset(name) for name in names])
    torque, angle = record["torque_nm"][second].mean(axis=0), record["configuration"][second].mean(axis=0)
    return {
        "work_hand_error_m": float(record["hand_error_m"][reach : reach + work].max()),
        "foot_displacement_m": float(record["foot_displacement_m"].max()),
        "torque_nm": dict(zip(names, torque[offsets].tolist(), strict=True)),
        "angle_rad": dict(zip(names, angle[offsets + 1].tolist(), strict=True)),
    }


def answer(request):
    """Simulate a cycle and describe it; the CPU time is that of set-up and simulation."""
    begin = time.process_time()
    controller = Controller(request)
    record = controller.simulate(request)
    seconds = time.process_time() - begin
    return {"ticks": len(record["wrench"]), "cpu_s": seconds} | summary(controller.robot, request, record)


if __name__ == "__main__":
    for line in sys.stdin:
        try:
            reply = answer(json.loads(line))
        except RuntimeError as error:
            reply = {"error": str(error)}
        print(json.dumps(reply), flush=True)

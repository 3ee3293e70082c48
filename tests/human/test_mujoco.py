"""An independent engine: MuJoCo loads the exported URDF and must agree on every torque that is stored."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from conftest import ROOT

from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.human.urdf import urdf_text
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.reactions.reaction import Reaction

BAR_NM = 1e-8


class Oracle:
    """Inverse dynamics of the exported human by MuJoCo, in this project's conventions."""

    def __init__(self, human: Human) -> None:
        text = urdf_text(human, maximum_torque("average_man").vectors(), 10.0)
        specification = mujoco.MjSpec.from_string(text)
        specification.body("pelvis").add_freejoint(name="root")
        self.model = specification.compile()
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.model.opt.gravity = [0, 0, -9.81]
        self.data = mujoco.MjData(self.model)
        self.dofs = [self.model.joint(name).dofadr[0] for name in DEGREES_OF_FREEDOM]
        self.places = [self.model.joint(name).qposadr[0] for name in DEGREES_OF_FREEDOM]
        self.feet = [self.model.body(f"{side}_foot").id for side in ("right", "left")]
        heel, toe, _, height = human.anthropometry.sole_rectangle()
        self.sole = np.array([(heel + toe) / 2, 0, height])

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Base force and moment (world axes, 3 + 3) and joint torques (39,) without contacts."""
        d, rotation = self.data, pin.Quaternion(q[3:7]).toRotationMatrix()
        d.qpos[:3], d.qpos[3:7] = q[:3], q[[6, 3, 4, 5]]
        d.qvel[:3], d.qvel[3:6] = rotation @ v[:3], v[3:6]
        # MuJoCo's linear acceleration is the classical one in world axes
        d.qacc[:3], d.qacc[3:6] = rotation @ (a[:3] + np.cross(v[3:6], v[:3])), a[3:6]
        d.qpos[self.places], d.qvel[self.dofs], d.qacc[self.dofs] = q[7:], v[6:], a[6:]
        mujoco.mj_inverse(self.model, d)
        force = d.qfrc_inverse
        return np.concatenate([rotation.T @ force[:3], force[3:6], force[self.dofs]])

    def of_force(self, point: np.ndarray, body: int, force: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Generalised forces of a force (3,) in world axes at a point of a body, at the last state."""
        linear = np.zeros((3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, linear, None, point, body)
        total, rotation = linear.T @ force, pin.Quaternion(q[3:7]).toRotationMatrix()
        return np.concatenate([rotation.T @ total[:3], total[3:6], total[self.dofs]])

    def of_contacts(self, wrench: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Generalised forces of the two sole wrenches (each in its sole's axes), at the last state."""
        total, rotation = np.zeros(self.model.nv), pin.Quaternion(q[3:7]).toRotationMatrix()
        for body, force in zip(self.feet, wrench.reshape(2, 6), strict=True):
            axes = self.data.xmat[body].reshape(3, 3)
            point = self.data.xpos[body] + axes @ self.sole
            linear, angular = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
            mujoco.mj_jac(self.model, self.data, linear, angular, point, body)
            total += linear.T @ (axes @ force[:3]) + angular.T @ (axes @ force[3:])
        return np.concatenate([rotation.T @ total[:3], total[3:6], total[self.dofs]])


@pytest.fixture(scope="module")
def loaded(paper: Experiment) -> Human:
    return build_human(paper.workers["average_man"], paper.tool.mass_kg)


def worst_difference(human: Human, count: int, seed: int) -> float:
    """The largest difference of inverse dynamics in random states (velocities about 2, accelerations about 20)."""
    oracle, rng, data = Oracle(human), np.random.default_rng(seed), human.model.createData()
    worst = 0.0
    for _ in range(count):
        q = pin.integrate(human.model, human.stance, rng.normal(0, 0.5, 45))
        v, a = rng.normal(0, 2, 45), rng.normal(0, 20, 45)
        worst = max(worst, np.abs(pin.rnea(human.model, data, q, v, a) - oracle.inverse_dynamics(q, v, a)).max())
    return worst


def test_random_states(loaded: Human) -> None:
    """2,000 random states: inverse dynamics agrees to 1e-8 N.m."""
    assert worst_difference(loaded, 2000, 0) <= BAR_NM


def test_masses_away_from_the_fists(paper: Experiment) -> None:
    """A drill whose weight hangs before the thumb, and a pail below the other hand: 500 random states."""
    human = build_human(paper.workers["average_man"], 2.0, 6.0, (0.12, 0.03, -0.02), (0.0, -0.05, -0.4))
    assert worst_difference(human, 500, 1) <= BAR_NM


def test_every_tick_of_every_stored_motion(loaded: Human, reactions: tuple[Reaction, ...]) -> None:
    """Stored torques and contact forces balance the stored motion in MuJoCo alone, to 1e-8 N.m."""
    oracle = Oracle(loaded)
    for reaction in reactions:
        motion, worst = reaction.motion, 0.0
        for q, v, a, torque, wrench in zip(
            motion.configuration, motion.velocity, motion.acceleration, motion.torque_nm, motion.wrench, strict=True
        ):
            residual = oracle.inverse_dynamics(q, v, a) - oracle.of_contacts(wrench, q)
            residual[BASE_DOF:] -= torque
            worst = max(worst, np.abs(residual).max())
        assert worst <= BAR_NM, reaction.name


def test_forces_on_the_hands_are_balanced_in_mujoco_too() -> None:
    """A co-transport: torques, contact forces and forces on both hands balance the motion at every tick."""
    experiment = load_experiment(ROOT / "experiments" / "co_transport.yaml")
    request = reaction_requests(experiment)[-1].motion
    assert request.worker.human == "natural"  # muscles and tissue together
    motion, oracle = simulate(request), Oracle(build_human(request.worker))
    grips = [oracle.model.body(f"{side}_hand").id for side in ("right", "left")]
    offset = build_human(request.worker).anthropometry.grip_m()
    worst = 0.0
    for tick, (q, v, a) in enumerate(zip(motion.configuration, motion.velocity, motion.acceleration, strict=True)):
        residual = oracle.inverse_dynamics(q, v, a) - oracle.of_contacts(motion.wrench[tick], q)
        residual[BASE_DOF:] -= motion.torque_nm[tick] + motion.tissue_nm[tick]
        for body, force in zip(grips, motion.hand_force_n[tick].reshape(2, 3), strict=True):
            point = oracle.data.xpos[body] + oracle.data.xmat[body].reshape(3, 3) @ offset
            residual -= oracle.of_force(point, body, force, q)
        worst = max(worst, np.abs(residual).max())
    assert worst <= BAR_NM and np.abs(motion.hand_force_n).max() == 60

"""The arms that ship and the inverse of their kinematics, against Pinocchio, published numbers and a second solver."""

import itertools
from collections.abc import Iterator
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from second_inverse import ALPHA, PUBLISHED, solutions

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.robot.arm import Arm, arm_from_urdf, load_arm, shipped_arms
from fatigue_planner.robot.inverse import NOTHING, Freedom, Surroundings, contact
from fatigue_planner.robot.kinematics import axes_apart, capsule_ends, frames_of, jacobian_of
from fatigue_planner.robot.reach import NOBODY, Cell
from fatigue_planner.robot.settings import Direction, RobotBase, RobotHold, RobotSettings

Vector = NDArray[np.float64]


def frames(arm: Arm, base: Vector, angles: Vector) -> Vector:
    found = np.empty((angles.size + 2, 4, 4))
    frames_of(arm.chain, base, angles, found)
    return found


def pinocchio_of(arm: Arm, base: Vector) -> pin.Model:
    """The same arm as a model of Pinocchio, made from its placements one by one."""
    model, parent, before = pin.Model(), 0, pin.SE3(base[:3, :3], base[:3, 3])
    for name, placement in zip(arm.joints, arm.chain.placement, strict=True):
        parent = model.addJoint(parent, pin.JointModelRZ(), before * pin.SE3(placement[:3, :3], placement[:3, 3]), name)
        before = pin.SE3.Identity()
    tip = pin.SE3(arm.chain.tip[:3, :3], arm.chain.tip[:3, 3])
    model.addFrame(pin.Frame("flange", parent, 0, tip, pin.FrameType.OP_FRAME))
    return model


@pytest.mark.parametrize("name", shipped_arms())
def test_the_flange_is_where_published_parameters_put_it(name: str) -> None:
    arm, (a, d) = load_arm(name), PUBLISHED[name]
    rng = np.random.default_rng(1)
    for angles in rng.uniform(-np.pi, np.pi, (50, 6)):
        frame = np.diag([-1.0, -1.0, 1.0, 1.0])  # the description turns the base by 180 degrees
        for joint in range(6):
            c, s, ca, sa = np.cos(angles[joint]), np.sin(angles[joint]), np.cos(ALPHA[joint]), np.sin(ALPHA[joint])
            frame = frame @ np.array(
                [
                    [c, -s * ca, s * sa, a[joint] * c],
                    [s, c * ca, -c * sa, a[joint] * s],
                    [0, sa, ca, d[joint]],
                    [0, 0, 0, 1],
                ]
            )
        base = np.diag([-1.0, -1.0, 1.0, 1.0])
        np.testing.assert_allclose(frames(arm, base, angles)[-1], frame, atol=1e-12)


@pytest.mark.parametrize("name", shipped_arms())
def test_frames_and_jacobian_are_pinocchios(name: str) -> None:
    arm = load_arm(name)
    base = RobotBase(x=0.3, y=-0.2, z=0.4, yaw_deg=37).placement()
    model = pinocchio_of(arm, base)
    data = model.createData()
    for angles in np.random.default_rng(2).uniform(-np.pi, np.pi, (20, 6)):
        mine, jacobian = frames(arm, base, angles), np.empty((6, 6))
        jacobian_of(mine, jacobian)
        theirs = pin.computeFrameJacobian(
            model, data, angles, model.getFrameId("flange"), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        pin.framesForwardKinematics(model, data, angles)
        np.testing.assert_allclose(mine[-1], data.oMf[model.getFrameId("flange")].homogeneous, atol=1e-12)
        np.testing.assert_allclose(jacobian, theirs, atol=1e-12)


def test_capsules_are_as_far_apart_as_coal_says() -> None:
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(300):
        ends = rng.uniform(-1, 1, (2, 2, 3))
        radii = rng.uniform(0.02, 0.2, 2)
        found = axes_apart(ends[0], ends[1]) - radii.sum()
        if found <= 0:
            continue  # coal's distance of bodies in each other is another quantity
        shapes, places = [], []
        for (begin, end), radius in zip(ends, radii, strict=True):
            length = float(np.linalg.norm(end - begin))
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0, 1]), (end - begin) / length)
            shapes.append(coal.Capsule(float(radius), length))
            places.append(coal.Transform3s(turn.normalized().toRotationMatrix(), (begin + end) / 2))
        result = coal.DistanceResult()
        coal.distance(shapes[0], places[0], shapes[1], places[1], coal.DistanceRequest(), result)
        assert found == pytest.approx(result.min_distance, abs=1e-12)
        compared += 1
    assert compared > 100


def cell_of(name: str, x: float, z: float, y: float = -0.2, **hold: float) -> Cell:
    settings = RobotSettings(arm=name, base_m=RobotBase(x=x, y=y, z=z), hold=RobotHold(**hold))  # type: ignore[arg-type]
    return Cell(load_arm(name), settings)


def rack() -> Iterator[Vector]:
    """Flange 10 cm beyond each point of the rack of pose_grid.yaml, pointing at the worker."""
    for x, z in itertools.product(np.linspace(0.3, 0.5, 5), np.linspace(0.5, 1.3, 5)):
        target = np.eye(4)
        target[:3, :3] = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]], dtype=float)
        target[:3, 3] = x + 0.1, -0.2, z
        yield target


# A prototype's counts, made before this program: base 1.1 m before the worker, on the ground, 0.5 and 0.8 m high.
@pytest.mark.parametrize(("name", "counts"), [("ur3e", (0, 5, 5)), ("ur5e", (13, 25, 25)), ("ur10e", (25, 25, 25))])
def test_the_rack_is_reached_as_by_the_prototype_and_every_solution_holds(name: str, counts: tuple[int, ...]) -> None:
    for height, count in zip((0, 0.5, 0.8), counts, strict=True):
        cell = cell_of(name, 1.1, height)
        model = pinocchio_of(cell.arm, cell.settings.base_m.placement())
        data = model.createData()
        reached = 0
        for target in rack():
            found = cell.reach(target)
            if not found.reached:
                assert found.reason.startswith("out of reach by ")
                continue
            reached += 1
            pin.framesForwardKinematics(model, data, found.angles_rad)
            flange = data.oMf[model.getFrameId("flange")]
            assert np.linalg.norm(flange.translation - target[:3, 3]) < 1e-3
            assert flange.rotation[:, 2] @ target[:3, 2] > np.cos(np.radians(0.1))
            assert ((found.angles_rad >= cell.arm.chain.lower) & (found.angles_rad <= cell.arm.chain.upper)).all()
        assert reached == count


def random_targets(name: str, count: int, seed: int) -> Iterator[Vector]:
    """Poses about an arm on the ground, some too far away."""
    rng, length = np.random.default_rng(seed), sum(map(abs, PUBLISHED[name][0])) + 0.25
    for _ in range(count):
        away = rng.normal(size=3)
        target = np.eye(4)
        quaternion = rng.normal(size=4)
        target[:3, :3] = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).toRotationMatrix()
        target[:3, 3] = away / np.linalg.norm(away) * length * rng.uniform(0.2, 1.3)
        target[2, 3] = abs(target[2, 3])
        yield target


def missed_by(cell: Cell, name: str, target: Vector, starts: int, rng: np.random.Generator) -> bool:
    """Whether a second solver finds a posture of the arm, on the ground, in which it touches nothing."""
    base, chain = cell.settings.base_m.placement(), cell.arm.chain
    for angles in solutions(name, base, target, rng.uniform(-np.pi, np.pi, (starts, len(cell.arm.joints)))):
        assert ((angles >= chain.lower) & (angles <= chain.upper)).all()
        found = frames(cell.arm, base, angles)
        assert np.linalg.norm(found[-1, :3, 3] - target[:3, 3]) < 1e-5
        if contact(chain, capsule_ends(chain, found), Surroundings(*NOBODY, *NOBODY)) == NOTHING:
            return True
    return False


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_arms())
def test_what_is_not_reached_is_not_reached_by_another_solver(name: str) -> None:
    """Of 50 poses with 100 starts each; `python perf/robot.py` asks for 1,000 with 500 starts each."""
    cell, rng, checked = cell_of(name, 0, 0, y=0), np.random.default_rng(5), 0
    for target in random_targets(name, 50, seed=4):
        if cell.reach(target).reached:
            assert missed_by(cell, name, target, 100, rng), "the second solver finds what there is"
        else:
            checked += 1
            assert not missed_by(cell, name, target, 100, rng)
    assert checked >= 10


def test_equal_questions_have_equal_answers() -> None:
    cell, target = cell_of("ur5e", 1.1, 0.5), next(rack())
    np.testing.assert_array_equal(cell.reach(target).angles_rad, cell.reach(target).angles_rad)


def test_what_stops_the_arm_is_named() -> None:
    target = next(rack())
    assert cell_of("ur3e", 2, 0).reach(target).reason == "out of reach by 104 cm"
    assert cell_of("ur3e", 0.8, 0.5, mass_kg=3.5).reach(target).reason == "3.5 kg to hold; it carries 3 kg"
    down = target.copy()
    down[:3, 3] = 1.1, -0.2, 0.01
    assert cell_of("ur5e", 0.6, 0).reach(down).reason == "the arm would touch itself or the ground"
    stiff = cell_of("ur5e", 1.1, 0.5)
    chain = stiff.arm.chain
    upper = np.where(np.arange(6) == 2, 0.2, chain.upper)
    lower = np.where(np.arange(6) == 2, -0.2, chain.lower)
    arm = Arm(stiff.arm.name, stiff.arm.joints, chain._replace(lower=lower, upper=upper), 5, "")
    assert Cell(arm, stiff.settings).reach(target).reason == "the limits of elbow are in the way"


def test_a_roll_that_is_said_is_held() -> None:
    cell = cell_of("ur5e", 1.1, 0.5, roll_deg=90)
    target = next(rack())
    found = cell.reach(target)
    assert found.reached
    flange = frames(cell.arm, cell.settings.base_m.placement(), found.angles_rad)[-1]
    np.testing.assert_allclose(flange, target, atol=1e-4)


def test_the_worker_decides_which_of_the_solutions_is_taken() -> None:
    cell, target = cell_of("ur5e", 1.1, 0.5), next(rack())
    worker = (np.array([[[0.0, -0.2, 0.5], [0.0, -0.2, 1.5]]]), np.array([0.15]))
    alone, beside = cell.reach(target), cell.reach(target, worker)

    def nearest(ends: Vector) -> float:
        radii = cell.arm.chain.radius
        return min(axes_apart(own, worker[0][0]) - radius for own, radius in zip(ends, radii, strict=True))

    assert nearest(beside.ends_m) >= nearest(alone.ends_m)


JOINT = """
<joint name="{name}" type="{kind}"><parent link="l{index}"/><child link="l{next}"/><origin xyz="{xyz}" rpy="{rpy}"/>
<axis xyz="{axis}"/>{limit}</joint><link name="l{next}"/>"""


def urdf(path: Path, kinds: tuple[str, ...] = ("revolute",) * 6, axis: str = "0 0 1") -> Path:
    """The UR5e as a URDF file."""
    parts = []
    for index, (placement, kind) in enumerate(zip(load_arm("ur5e").chain.placement, kinds, strict=True)):
        limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/>' if kind != "continuous" else ""
        rpy = pin.rpy.matrixToRpy(placement[:3, :3])
        parts.append(
            JOINT.format(
                name=f"j{index}", kind=kind, index=index, next=index + 1, axis=axis, limit=limit,
                xyz=" ".join(map(repr, placement[:3, 3].tolist())), rpy=" ".join(map(repr, rpy.tolist())),
            )
        )  # fmt: skip
    path.write_text(f'<robot name="mine"><link name="l0"/>{"".join(parts)}</robot>')
    return path


@pytest.mark.parametrize("axis", ["0 0 1", "0 1 0", "-1 0 0", "0.6 0 0.8"])
def test_an_arm_of_ones_own_moves_as_pinocchio_says(tmp_path: Path, axis: str) -> None:
    kinds = ("revolute", "revolute", "continuous", "revolute", "revolute", "revolute")
    file = urdf(tmp_path / "mine.urdf", kinds, axis)
    arm, model = arm_from_urdf(file, 0.05), pin.buildModelFromUrdf(str(file))
    data = model.createData()
    for angles in np.random.default_rng(6).uniform(-2, 2, (10, 6)):
        configuration = pin.integrate(model, pin.neutral(model), angles)
        pin.framesForwardKinematics(model, data, configuration)
        wanted = data.oMf[model.getFrameId("l6")].homogeneous
        np.testing.assert_allclose(frames(arm, np.eye(4), angles)[-1], wanted, atol=1e-12)
    assert arm.chain.lower[0] == -3 and arm.chain.lower[2] == pytest.approx(-2 * np.pi) and arm.payload_kg is None


def test_what_is_no_arm_is_refused_with_its_reason(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="there is no such file"):
        arm_from_urdf(tmp_path / "none.urdf", 0.05)
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot")
    with pytest.raises(ExperimentError, match="is no URDF file of a robot"):
        arm_from_urdf(broken, 0.05)
    with pytest.raises(ExperimentError, match="j3 does not turn"):
        arm_from_urdf(urdf(tmp_path / "slides.urdf", (*("revolute",) * 3, "prismatic", *("revolute",) * 2)), 0.05)
    with pytest.raises(ExperimentError, match=r"ur6.*should be one of ur10e, ur3e, ur5e"):
        load_arm("ur6")


def test_a_direction_needs_a_length() -> None:
    with pytest.raises(ValueError, match="x, y and z are all 0"):
        Direction()
    assert Freedom.ROLL == 1

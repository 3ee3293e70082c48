"""The digital human: structure, body data, directions of its joints, and static torques by hand."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.anthropometry import Anthropometry, segment_table
from fatigue_planner.human.joint_data import maximum_torque, position_limits, posture, ranges_of_motion
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Human, Worker, build_human, joint_index
from fatigue_planner.human.multibody import GRAVITY_MPS2, stand
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, JOINTS, without_side
from fatigue_planner.human.urdf import urdf_text
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.controller import WholeBodyController
from fatigue_planner.motion.physiology.piece import Scene
from fatigue_planner.motion.physiology.registry import Physiology
from fatigue_planner.motion.tasks.centre_of_mass import CentreOfMassTask
from fatigue_planner.motion.tasks.joint_posture import WholePosture
from fatigue_planner.motion.tasks.task import Coordinates


def worker(height_m: float = 1.75, mass_kg: float = 75, sex: str = "male") -> Worker:
    strength = "average_man" if sex == "male" else "average_woman"
    return Worker.model_validate(
        {
            "human": "paper",
            "height_m": height_m,
            "mass_kg": mass_kg,
            "sex": sex,
            "strength": strength,
            "natural_posture_deg": {},
        }
    )


@pytest.fixture(scope="module")
def human() -> Human:
    return build_human(worker())


def place(human: Human, frame: str, **angles_deg: float) -> np.ndarray:
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, stand(human.model, posture(angles_deg, "natural_posture_deg")))
    return data.oMf[human.model.getFrameId(frame)].translation.copy()


def static_torque(human: Human, **angles_deg: float) -> dict[str, float]:
    """Gravity torques with the pelvis held (N.m), by degree of freedom."""
    q = stand(human.model, posture(angles_deg, "natural_posture_deg"))
    gravity = pin.computeGeneralizedGravity(human.model, human.model.createData(), q)
    return dict(zip(DEGREES_OF_FREEDOM, gravity[6:], strict=True))


def test_structure_is_the_papers(human: Human) -> None:
    assert len(BODIES) == 17 and len(JOINTS) == 16 and len(DEGREES_OF_FREEDOM) == 39
    assert human.model.nv == 45 and human.model.nq == 46
    for side in ("right", "left"):
        arm = [
            n
            for n in DEGREES_OF_FREEDOM
            if n.startswith(side) and any(p in n for p in ("should", "elb", "fore", "wri"))
        ]
        leg = [n for n in DEGREES_OF_FREEDOM if n.startswith(side) and any(p in n for p in ("hip", "knee", "ankle"))]
        assert len(arm) == len(leg) == 7
    assert sum(not name.startswith(("right", "left")) for name in DEGREES_OF_FREEDOM) == 11


@pytest.mark.parametrize(("sex", "total"), [("male", 100.00), ("female", 99.99)])
def test_segment_masses_sum_to_the_body(sex: str, total: float) -> None:
    rows = {name: row[sex].mass_percent for name, row in segment_table().segments.items()}
    twice = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
    assert sum(mass * (2 if name in twice else 1) for name, mass in rows.items()) == pytest.approx(total, abs=1e-9)
    built = build_human(worker(sex=sex)).mass_kg
    assert built == pytest.approx(75 * total / 100)


def test_upper_body_centre_of_mass_matches_the_hand_calculation() -> None:
    """Head, thorax, neck and abdomen: 29.4 kg, .335 m above L5/S1 for 75 kg and 1.75 m."""
    body = Anthropometry(1.75, 75, "male", "paper")
    human = build_human(worker())
    bodies = ("abdomen", "thorax", "neck", "head")
    masses = [body.segment(name).mass_kg for name in bodies]
    heights = [place(human, name)[2] + body.segment(name).com_m[2] for name in bodies]
    assert sum(masses) == pytest.approx(29.4, abs=0.05)
    assert np.average(heights, weights=masses) - place(human, "abdomen")[2] == pytest.approx(0.335, abs=0.002)


def test_moments_of_inertia_by_hand() -> None:
    """De Leva's radii of gyration about x (sagittal), y (transverse) and z (longitudinal), 75 kg and 1.75 m.

    The foot's long axis is x. About the axis of a straight hanging arm only the longitudinal moments count.
    """
    body = Anthropometry(1.75, 75, "male", "paper")
    sizes = {  # length in m, mass in % of the body's, radii in % of the length
        "forearm": (body.length("forearm_length"), 1.62, [27.6, 26.5, 12.1]),
        "thigh": (body.length("thigh_length"), 14.16, [32.9, 32.9, 14.9]),
        "foot": (body.length("foot_length"), 1.37, [12.4, 24.5, 25.7]),
        "thorax": (0.2421 * 1.75 / 1.741, 15.96 - 0.74, [50.5, 32.0, 46.5]),
    }
    for name, (length, mass, radii) in sizes.items():
        expected = 75 * mass / 100 * (length * np.array(radii) / 100) ** 2
        np.testing.assert_allclose(body.segment(name).inertia_kgm2, expected, rtol=1e-9, err_msg=name)
    model = build_human(worker()).model
    turning = pin.crba(model, model.createData(), pin.neutral(model)).diagonal()[
        6 + joint_index("left_shoulder_rotation")
    ]
    arm = [body.segment(f"left_{name}").inertia_kgm2[2] for name in ("upper_arm", "forearm", "hand")]
    assert turning == pytest.approx(sum(arm))


def test_joint_centres_are_not_as_wide_as_the_body(human: Human) -> None:
    """Winter's breadths (.191 H, .259 H) are outer ones; joint centres are .105 H and .21 H apart."""
    hips = place(human, "left_thigh") - place(human, "right_thigh")
    shoulders = place(human, "left_upper_arm") - place(human, "right_upper_arm")
    np.testing.assert_allclose(hips, [0, 0.105 * 1.75, 0], atol=1e-12)
    np.testing.assert_allclose(shoulders, [0, 0.21 * 1.75, 0], atol=1e-12)


def test_landmarks_stand_at_their_heights(human: Human) -> None:
    for frame, share in {
        "right_thigh": 0.530,
        "right_shank": 0.285,
        "right_foot": 0.039,
        "right_upper_arm": 0.818,
    }.items():
        assert place(human, frame)[2] == pytest.approx(share * 1.75)
    soles = place(human, "right_sole") + place(human, "left_sole")
    np.testing.assert_allclose(soles, 0, atol=1e-12)


@pytest.mark.parametrize(
    ("freedom", "frame", "direction"),
    [
        ("lumbar_flexion", "head", [1, 0, 0]), ("lumbar_lateral", "head", [0, -1, 0]),
        ("lumbar_rotation", "right_upper_arm", [1, 0, 0]), ("thoracic_flexion", "head", [1, 0, 0]),
        ("right_shoulder_flexion", "right_grip", [1, 0, 0]), ("right_shoulder_abduction", "right_grip", [0, -1, 0]),
        ("left_shoulder_abduction", "left_grip", [0, 1, 0]), ("right_elbow_flexion", "right_grip", [1, 0, 0]),
        ("right_wrist_flexion", "right_grip", [0, 1, 0]), ("left_wrist_flexion", "left_grip", [0, -1, 0]),
        ("right_wrist_deviation", "right_grip", [1, 0, 0]), ("left_wrist_deviation", "left_grip", [1, 0, 0]),
    ],
)  # fmt: skip
def test_positive_rotation_is_the_anatomical_direction(
    human: Human, freedom: str, frame: str, direction: list[int]
) -> None:
    moved = place(human, frame, **{freedom: 5}) - place(human, frame)
    assert moved @ np.array(direction) > 0.9 * np.linalg.norm(moved) > 0


@pytest.mark.parametrize(
    ("freedom", "frame", "direction"),
    [
        ("hip_flexion", "shank", [1, 0, 0]), ("hip_abduction", "shank", [0, -1, 0]),
        ("knee_flexion", "foot", [-1, 0, 0]), ("ankle_flexion", "sole", [0, 0, 1]),
        ("hip_rotation", "sole", [0, 1, 0]), ("ankle_rotation", "sole", [0, 1, 0]),
    ],
)  # fmt: skip
def test_leg_directions_seen_from_the_pelvis(human: Human, freedom: str, frame: str, direction: list[int]) -> None:
    for side, mirror in (("right", 1), ("left", -1)):

        def seen(angle: float, side: str = side) -> np.ndarray:
            data = human.model.createData()
            q = stand(human.model, posture({f"{side}_{freedom}": angle}, "angles"))
            pin.framesForwardKinematics(human.model, data, q)
            pelvis = data.oMf[human.model.getFrameId("pelvis")]
            return pelvis.actInv(data.oMf[human.model.getFrameId(f"{side}_{frame}")]).translation

        moved = seen(5) - seen(0)
        assert moved @ (np.array(direction) * [1, mirror, 1]) > 0.5 * np.linalg.norm(moved) > 0


def test_inversion_lifts_the_inner_edge(human: Human) -> None:
    for side, inner in (("right", 1), ("left", -1)):
        data = human.model.createData()
        q = pin.neutral(human.model)
        q[7 + joint_index(f"{side}_ankle_inversion")] = np.radians(10)
        pin.framesForwardKinematics(human.model, data, q)
        foot = data.oMf[human.model.getFrameId(f"{side}_foot")]
        assert (foot.rotation @ [0, inner, 0])[2] > 0


def test_left_and_right_are_mirror_images(human: Human) -> None:
    angles = {"shoulder_flexion": 40, "shoulder_abduction": 25, "shoulder_rotation": 15, "elbow_flexion": 60,
              "forearm_pronation": 20, "wrist_flexion": 10, "wrist_deviation": 5}  # fmt: skip
    right, left = place(human, "right_grip", **angles), place(human, "left_grip", **angles)
    np.testing.assert_allclose(right * [1, -1, 1], left, atol=1e-12)


def test_a_taller_heavier_worker_is_scaled() -> None:
    tall = build_human(worker(1.95, 100))
    assert tall.mass_kg == pytest.approx(100)
    assert place(tall, "right_upper_arm")[2] == pytest.approx(0.818 * 1.95)


def test_static_shoulder_torque_by_hand() -> None:
    """Arm held out horizontally with a 5 kg tool: sum of weight times distance along the arm."""
    body = Anthropometry(1.75, 75, "male", "paper")
    upper, fore, hand = (body.segment(f"right_{name}") for name in ("upper_arm", "forearm", "hand"))
    elbow = body.length("upper_arm_length")
    wrist = elbow + body.length("forearm_length")
    moments = (
        upper.mass_kg * -upper.com_m[2] + fore.mass_kg * (elbow - fore.com_m[2])
        + hand.mass_kg * (wrist - hand.com_m[2]) + 5 * (wrist - body.grip_m()[2])
    )  # fmt: skip
    torque = static_torque(build_human(worker(), 5), right_shoulder_flexion=90)
    assert torque["right_shoulder_flexion"] == pytest.approx(GRAVITY_MPS2 * moments)
    assert 25 < torque["right_shoulder_flexion"] < 50  # literature: 33 N.m with bent elbow


def test_stooping_loads_the_back_within_the_literature_band() -> None:
    """Trunk bent by 85 degrees with 5 kg in the hanging right hand: about 150 N.m at L5/S1."""
    human = build_human(worker(), 5)
    q = stand(human.model, posture({"hip_flexion": 85, "shoulder_flexion": 85}, "natural_posture_deg"))
    gravity = pin.computeGeneralizedGravity(human.model, human.model.createData(), q)
    assert 100 < -gravity[6 + joint_index("lumbar_flexion")] < 200


def test_neutral_stance_with_empty_hands_rests_every_joint(paper: Experiment) -> None:
    """Every one of the 78 entries is below alpha, so all of them recover."""
    human = build_human(paper.workers["average_man"])
    state = BodyState(human)
    state.update(human.stance, np.zeros(45))
    weights, stiffness = paper.controller.weights, paper.controller.stiffness_per_s2
    x, y, _ = state.centre_of_mass().position_m
    balance = CentreOfMassTask(weights.centre_of_mass, stiffness.centre_of_mass, Coordinates(x=x, y=y))
    stay = WholePosture(weights.posture, stiffness.posture, human.stance[7:])
    strength = maximum_torque(paper.workers["average_man"].strength).vectors()
    none = Physiology("paper", Scene(human, state, (), 0.01, {}))
    result = WholeBodyController(human, state, paper.controller, strength, stay, none, [balance]).step()
    assert result is not None
    acceleration, _, torque, *_ = result
    np.testing.assert_allclose(acceleration, 0, atol=1e-3)
    share = np.maximum(torque / strength[0], -torque / strength[1])
    assert share.max() < paper.fatigue.threshold


def test_every_degree_of_freedom_has_a_range_of_motion() -> None:
    assert set(ranges_of_motion()) == {without_side(name) for name in DEGREES_OF_FREEDOM}


def test_zero_lies_in_every_range_of_motion() -> None:
    lower, upper = position_limits()
    assert (lower <= 0).all() and (upper > 0).all()


def test_posture_refuses_unknown_joints_and_impossible_angles() -> None:
    with pytest.raises(DataFileError, match="unknown degree of freedom 'knee'"):
        posture({"knee": 5}, "natural_posture_deg")
    with pytest.raises(DataFileError, match=r"right_knee_flexion = -5 deg is outside .* \[0, 135\]"):
        posture({"right_knee_flexion": -5}, "natural_posture_deg")


def test_the_exported_body_can_be_seen_and_its_joints_are_listed_as_motions_count_them() -> None:
    """Every body has shapes for eye and collision: as heavy as the body if they were of water, feet on the ground."""
    human = build_human(worker())
    text = urdf_text(human, maximum_torque("average_man").vectors(), 10.0)
    robot = ElementTree.fromstring(text)
    assert [joint.get("name") for joint in robot.iter("joint")] == list(DEGREES_OF_FREEDOM)
    comment = text.split("<!--")[1].split("-->")[0]
    assert comment.split(": ")[1].split() == list(DEGREES_OF_FREEDOM)
    volume = 0.0
    for name in BODIES:
        link = next(link for link in robot.iter("link") if link.get("name") == name)
        visuals, collisions = (
            [ElementTree.tostring(shape).strip() for shape in link.findall(use)] for use in ("visual", "collision")
        )
        assert visuals and collisions == [visual.replace(b"visual", b"collision") for visual in visuals], name
        for shape in link.findall("visual"):
            (solid,) = shape.find("geometry")
            size = [float(number) for value in solid.attrib.values() for number in value.split()]
            assert min(size) > 0.02 and max(size) < 0.5, name
            volume += {"box": np.prod(size), "cylinder": np.pi * size[0] ** 2 * size[-1], "sphere": 0.0}[solid.tag]
    assert 0.8 < 1000 * volume / 75 < 1.3
    foot = next(link for link in robot.iter("link") if link.get("name") == "right_foot")
    height = float(foot.find("visual/geometry/box").get("size").split()[2])
    centre = float(foot.find("visual/origin").get("xyz").split()[2])
    assert centre - height / 2 == pytest.approx(human.anthropometry.sole_rectangle()[3])


def test_compiled_kinematics_are_pinocchios(human: Human) -> None:
    random = np.random.default_rng(3)
    lower, upper = position_limits()
    configurations = np.array([pin.randomConfiguration(human.model) for _ in range(20)])
    configurations[:, :3] = random.normal(size=(20, 3))
    configurations[:, 7:] = random.uniform(lower, upper, size=(20, 39))
    poses, data = poses_of(tree_of(human.anthropometry), configurations), human.model.createData()
    for row, configuration in enumerate(configurations):
        pin.framesForwardKinematics(human.model, data, configuration)
        for index, body in enumerate(BODIES):
            at = data.oMf[human.model.getFrameId(body)]
            assert poses.rotation[row, index] == pytest.approx(at.rotation, abs=1e-12)
            assert poses.origin_m[row, index] == pytest.approx(at.translation, abs=1e-12)
    grip = data.oMf[human.model.getFrameId("right_grip")].translation
    assert poses.points("right_hand", human.anthropometry.grip_m())[-1] == pytest.approx(grip, abs=1e-12)


@pytest.mark.parametrize(("sex", "height_m"), [("male", 1.756), ("female", 1.628)])
def test_the_natural_geometry_is_that_of_measured_people(sex: str, height_m: float) -> None:
    """Against numbers that the geometry was not made of: spans, and heights of people standing (ANSUR II, cm)."""
    measured = {
        "male": {"span": 181.4, "elbow": 0.630 * 175.6, "wrist": 84.8, "trochanterion": 90.1, "acromion": 144.1},
        "female": {"span": 166.0, "elbow": 0.630 * 162.8, "wrist": 79.4, "trochanterion": 84.5, "acromion": 133.5},
    }[sex]
    body = Anthropometry(height_m, 70, sex, "natural")
    paper = Anthropometry(height_m, 70, sex, "paper")
    arm = sum(body.length(name) for name in ("upper_arm_length", "forearm_length", "hand_length"))
    span = 200 * (body.length("shoulder_half_width") + arm)
    # no collar bone draws the shoulders in when the arms are held out
    assert 1 < span / measured["span"] < 1.045 < 109 * height_m / measured["span"]
    shoulder = 100 * body.length("shoulder_height")
    assert shoulder - 100 * body.length("upper_arm_length") == pytest.approx(measured["elbow"], rel=0.02)
    assert shoulder - 100 * (body.length("upper_arm_length") + body.length("forearm_length")) == pytest.approx(
        measured["wrist"], abs=0.1
    )
    assert 2 < measured["acromion"] - shoulder < 5  # the joint is below the acromion
    hip = 100 * sum(body.length(name) for name in ("ankle_height", "shank_length", "thigh_length"))
    assert measured["trochanterion"] < hip < 100 * 0.558 * height_m  # ANSUR II; the eight subjects
    assert body.length("thigh_length") == paper.length("thigh_length")


def test_the_papers_geometry_is_winters(human: Human) -> None:
    assert human.anthropometry.human == "paper"
    arm = [human.anthropometry.length(f"{name}_length") / 1.75 for name in ("upper_arm", "forearm", "hand")]
    assert arm == pytest.approx([0.186, 0.146, 0.108], rel=1e-12)


@pytest.mark.parametrize("end", ["min", "max"])
def test_a_posture_may_be_at_the_end_of_a_range(end: str) -> None:
    for name, motion in ranges_of_motion().items():
        angle = getattr(motion, end)
        assert posture({name: angle}, "posture").any() == (angle != 0)

"""The parts of the body as capsules: sizes, pairs, and distances against known answers and a slow optimiser."""

import itertools

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import lsq_linear

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsule_table, capsules_of, checked_pairs, exclusion
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Worker, build_human
from fatigue_planner.human.skeleton import BODIES, without_side

PAIR = np.array([[0, 1]])
MAN = Anthropometry(1.75, 75, "male")


def between(one: list[list[float]], two: list[list[float]], radii: tuple[float, float] = (0.0, 0.0)) -> tuple:
    distance, normal, first, second = capsule_distances(np.array([one, two], dtype=float), np.array(radii), PAIR)
    return distance[0], normal[0], first[0], second[0]


@pytest.mark.parametrize(
    ("one", "two", "radii", "distance", "normal"),
    [
        ([[0, 0, 0], [1, 0, 0]], [[0.5, 1, -1], [0.5, 1, 1]], (0.2, 0.3), 0.5, [0, -1, 0]),  # crossing at a distance
        ([[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [3, 0, 0]], (0.1, 0.1), 0.8, [-1, 0, 0]),  # one behind the other
        ([[0, 0, 0], [1, 0, 0]], [[0.2, 0, 0.1], [0.6, 0, 0.1]], (0.1, 0.1), -0.1, [0, 0, -1]),  # side by side, overlap
        ([[0, 0, 3], [0, 0, 3]], [[0, 0, 0], [0, 0, 0]], (1, 1), 1.0, [0, 0, 1]),  # two spheres
        ([[0, 0, 0], [4, 0, 0]], [[7, 4, 0], [7, 4, 0]], (0, 0), 5.0, [-0.6, -0.8, 0]),  # a sphere beyond the end
        ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], (0.1, 0.2), -0.3, [0, 0, 1]),  # the axes cross
    ],
)
def test_distances_that_are_known(one, two, radii, distance, normal) -> None:
    found = between(one, two, radii)
    assert found[0] == pytest.approx(distance, abs=1e-12)
    assert found[1] == pytest.approx(normal, abs=1e-12)


def test_side_by_side_the_middle_is_nearest() -> None:
    """So that the point does not jump from end to end while two limbs swing past each other."""
    _, _, first, second = between([[0, 0, 0], [1, 0, 0]], [[0.8, 0, 1], [-3, 0, 1]])
    assert first == pytest.approx([0.4, 0, 0]) and second == pytest.approx([0.4, 0, 1])


def test_distances_against_a_slow_optimiser() -> None:
    """Bounded least squares finds the nearest points, too: over s and t in [0, 1], |p1 + s d1 - p2 - t d2|."""
    random = np.random.default_rng(14)
    for number in range(300):
        one, two = random.normal(size=(2, 3)), random.normal(size=(2, 3))
        if number % 3 == 1:  # nearly or quite parallel
            two[1] = two[0] + random.choice([-2, 0.5]) * (one[1] - one[0]) + 10.0 ** -random.integers(3, 20)
        if number % 10 == 2:  # a point
            two[1] = two[0]
        found = between(one.tolist(), two.tolist())
        matrix = np.stack([one[1] - one[0], two[0] - two[1]], axis=1)
        best = lsq_linear(matrix, two[0] - one[0], bounds=(0, 1), tol=1e-14)
        assert found[0] == pytest.approx(np.sqrt(2 * best.cost), abs=1e-6)
        assert found[0] <= np.sqrt(2 * best.cost) + (1e-6 if number % 3 == 1 else 1e-12)
        assert found[2] - found[3] == pytest.approx(found[0] * found[1], abs=1e-9)


def test_the_normal_tells_how_a_distance_changes() -> None:
    random = np.random.default_rng(15)
    human = build_human(Worker.model_validate({"height_m": 1.75, "mass_kg": 75, "sex": "male"}))
    capsules, tree, data = capsules_of(human.anthropometry), tree_of(human.anthropometry), human.model.createData()
    lower, upper = human.model.lowerPositionLimit[7:], human.model.upperPositionLimit[7:]

    def measured(configuration: np.ndarray) -> tuple:
        ends = capsules.world_ends(poses_of(tree, configuration[None]))[0]
        return capsule_distances(ends, capsules.radius_m, capsules.pairs)

    for _ in range(5):
        configuration = human.stance.copy()
        configuration[7:] = random.uniform(lower, upper)
        velocity = random.normal(size=human.model.nv)
        pin.forwardKinematics(human.model, data, configuration, velocity)
        pin.updateFramePlacements(human.model, data)
        _, normal, first, second = measured(configuration)
        rate = np.empty(len(normal))
        for row, pair in enumerate(capsules.pairs):
            moving = []
            for body, point in zip(pair, (first[row], second[row]), strict=True):
                frame = human.model.getFrameId(BODIES[body])
                twist = pin.getFrameVelocity(human.model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
                moving.append(twist.linear + np.cross(twist.angular, point - data.oMf[frame].translation))
            rate[row] = normal[row] @ (moving[0] - moving[1])
        step = 1e-6
        ahead = measured(pin.integrate(human.model, configuration, step * velocity))[0]
        behind = measured(pin.integrate(human.model, configuration, -step * velocity))[0]
        assert rate == pytest.approx((ahead - behind) / (2 * step), abs=1e-5)


def test_every_pair_is_checked_or_excluded_for_a_reason() -> None:
    pairs = set(checked_pairs())
    assert all((pair in pairs) != bool(exclusion(*pair)) for pair in itertools.combinations(BODIES, 2))
    # what people see at once: hands and forearms in the trunk, the head or a leg, an arm in the other
    for part in ("head", "neck", "thorax", "abdomen", "pelvis", "right_thigh", "left_thigh", "right_shank"):
        for limb in ("right_hand", "left_hand", "right_forearm", "left_forearm"):
            assert (part, limb) in pairs or (limb, part) in pairs
    assert ("right_hand", "left_hand") in pairs and ("right_thigh", "left_thigh") in pairs
    assert ("right_forearm", "right_hand") not in pairs and ("right_foot", "left_foot") not in pairs


def test_pairs_are_alike_on_both_sides() -> None:
    def mirrored(body: str) -> str:
        return body.replace("right", "LEFT").replace("left", "right").replace("LEFT", "left")

    pairs = {frozenset(pair) for pair in checked_pairs()}
    assert {frozenset(map(mirrored, pair)) for pair in pairs} == pairs


@pytest.mark.parametrize("sex", ["male", "female"])
def test_sizes_follow_the_build(sex: str) -> None:
    build = capsule_table().reference[sex]
    usual = capsules_of(Anthropometry(build.stature_m, build.mass_kg, sex))
    heavier = capsules_of(Anthropometry(build.stature_m, 1.21 * build.mass_kg, sex))
    for body, radius, grown in zip(BODIES, usual.radius_m, heavier.radius_m, strict=True):
        part = capsule_table().parts[without_side(body)]
        assert radius == pytest.approx(part.radius_m[sex])
        assert grown == pytest.approx(radius * (1.1 if part.follows == "girth" else 1))


def test_volumes_are_about_those_of_the_masses() -> None:
    """An independent look at the radii: the limbs' volumes times water's density are about de Leva's masses."""
    capsules = capsules_of(MAN)
    for body in ("right_upper_arm", "right_forearm", "right_thigh", "right_shank"):
        index = BODIES.index(body)
        length = float(np.linalg.norm(np.subtract(*capsules.ends_m[index])))
        mass = 1000 * np.pi * capsules.radius_m[index] ** 2 * length
        assert 0.7 < mass / MAN.segment(body).mass_kg < 1.3, body


@pytest.mark.parametrize(("height", "mass", "sex"), [(1.75, 75, "male"), (1.88, 100, "male"), (1.65, 62, "female")])
def test_standing_with_the_arms_a_little_away_nothing_meets(height: float, mass: float, sex: str) -> None:
    posture = {
        "shoulder_abduction": 12,
        "elbow_flexion": 5,
        "knee_flexion": 5,
        "hip_flexion": 2.5,
        "ankle_flexion": 2.5,
    }
    worker = {"height_m": height, "mass_kg": mass, "sex": sex, "natural_posture_deg": posture}
    human = build_human(Worker.model_validate(worker))
    capsules = capsules_of(human.anthropometry)
    ends = capsules.world_ends(poses_of(tree_of(human.anthropometry), human.stance[None]))[0]
    assert capsule_distances(ends, capsules.radius_m, capsules.pairs)[0].min() > 0
    lowest, highest = (ends[:, :, 2].min(axis=1) - capsules.radius_m).min(), ends[:, :, 2].max() + capsules.radius_m[4]
    assert lowest == pytest.approx(0, abs=1e-6) and highest == pytest.approx(height, rel=0.01)

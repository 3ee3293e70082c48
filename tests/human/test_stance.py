"""Passive joint moments by their published formulas, and the stance in which they balance the body's weight."""

import math

import numpy as np
import pytest

from fatigue_planner.human.anthropometry import Anthropometry, Sex
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.joint_data import maximum_torque, position_limits, posture
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import joint_index
from fatigue_planner.human.multibody import multibody, stand
from fatigue_planner.human.passive_moments import add_passive_slopes, passive_moments_of, passive_table
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.human.stance import muscles_in_stance_nm, stance_deg

MAN = Anthropometry(1.75, 75, "male", "natural")


def moments(**degrees: float) -> np.ndarray:
    angles = np.zeros(39)
    for name, angle in degrees.items():
        angles[joint_index(name)] = np.radians(angle)
    return passive_moments_of(MAN, angles)


@pytest.mark.parametrize(("h", "k", "a"), [(0, 0, 0), (30, 60, 10), (-15, 5, -30), (100, 120, 20)])
def test_legs_have_the_moments_of_riener_and_edrich(h: float, k: float, a: float) -> None:
    """Their equations, as printed, with flexion and dorsiflexion positive, in degrees."""
    e = math.exp
    hip = e(1.4655 - 0.0034 * k - 0.0750 * h) - e(1.3403 - 0.0226 * k + 0.0305 * h) + 8.072
    knee = e(1.800 + 0.0460 * a - 0.0352 * k + 0.0217 * h) - e(-3.971 + 0.0004 * a + 0.0495 * k - 0.0128 * h)
    knee += -4.820 + e(2.220 - 1.50 * k)
    ankle = e(-7.9763 - 0.1949 * a + 0.0008 * k) - e(2.1016 + 0.0843 * a - 0.0176 * k) + 1.792
    found = moments(right_hip_flexion=h, right_knee_flexion=k, right_ankle_flexion=a)
    of_leg = [found[joint_index(f"right_{name}_flexion")] for name in ("hip", "knee", "ankle")]
    assert of_leg == pytest.approx([hip, knee, ankle], rel=1e-12)


def test_other_joints_are_pushed_back_at_the_ends_of_their_range() -> None:
    """The amplitudes of data/passive_moments.yaml at the ends, next to nothing in the middle."""
    assert moments(lumbar_flexion=60)[joint_index("lumbar_flexion")] == pytest.approx(-80, rel=0.01)
    assert moments(lumbar_flexion=30)[joint_index("lumbar_flexion")] == pytest.approx(-4, rel=0.02)
    assert moments(lumbar_lateral=-25)[joint_index("lumbar_lateral")] == pytest.approx(10, rel=1e-3)
    assert moments(right_wrist_deviation=-30)[joint_index("right_wrist_deviation")] == pytest.approx(0.9, rel=1e-6)
    assert moments(right_wrist_deviation=20)[joint_index("right_wrist_deviation")] == pytest.approx(0, abs=1e-6)
    others = [i for i, name in enumerate(DEGREES_OF_FREEDOM) if not name.endswith(("hip_flexion", "knee_flexion"))]
    others = [i for i in others if not DEGREES_OF_FREEDOM[i].endswith(("ankle_flexion", "elbow_flexion"))]
    assert np.abs(moments()[others]).max() < 0.7  # the lumbar spine's


def test_slopes_are_the_derivatives_of_the_moments() -> None:
    lower, upper = position_limits()
    angles = lower + np.random.default_rng(7).uniform(0.1, 0.9, 39) * (upper - lower)
    slopes, h = np.zeros((39, 39)), 1e-6
    add_passive_slopes(passive_table(MAN), angles, slopes)
    for column in range(39):
        step = h * np.eye(39)[column]
        change = (passive_moments_of(MAN, angles + step) - passive_moments_of(MAN, angles - step)) / (2 * h)
        np.testing.assert_allclose(slopes[:, column], change, atol=1e-6 * (1 + np.abs(slopes).max()))


def test_moments_grow_with_mass_and_stature() -> None:
    heavier = Anthropometry(1.75, 150, "male", "natural")
    np.testing.assert_allclose(passive_moments_of(heavier, np.zeros(39)), 2 * passive_moments_of(MAN, np.zeros(39)))


@pytest.mark.parametrize(
    ("height_m", "mass_kg", "sex"),
    [(1.52, 50, "female"), (1.627, 72.1, "female"), (1.75, 75, "male"), (1.88, 100, "male"), (1.4, 40, "female")],
)
def test_the_natural_stance_tires_nobody(height_m: float, mass_kg: float, sex: Sex) -> None:
    """No joint carries more than alpha - 2 % of the strength, and the arms are not in the body."""
    person = Anthropometry(height_m, mass_kg, sex, "natural")
    model, angles = multibody(person), posture(stance_deg(person), "stance")
    configuration = stand(model, angles)
    muscles = muscles_in_stance_nm(person, model, configuration)
    positive, negative = maximum_torque("average_woman" if sex == "female" else "average_man").vectors()
    assert np.maximum(muscles / positive, -muscles / negative).max() < 0.08
    pelvis = angles[[joint_index(f"right_{name}_flexion") for name in ("hip", "knee", "ankle")]] @ [1, -1, 1]
    assert abs(np.degrees(pelvis)) < 1
    capsules = capsules_of(person)
    ends = capsules.world_ends(poses_of(tree_of(person), configuration[None]))[0]
    assert capsule_distances(ends, capsules.radius_m, capsules.pairs[~capsules.joined])[0].min() >= 0
    assert capsules.joined.sum() == 2


def test_without_balance_the_ankle_would_tire() -> None:
    """The paper's stance, with its centre of mass over the ankles: the passive ankle is held by its dorsiflexor."""
    model = multibody(MAN)
    angles = posture({"knee_flexion": 5, "hip_flexion": 2.5, "ankle_flexion": 2.5}, "stance")
    ankle = muscles_in_stance_nm(MAN, model, stand(model, angles))[joint_index("right_ankle_flexion")]
    assert ankle / maximum_torque("average_man").vectors()[0][joint_index("right_ankle_flexion")] > 0.1

"""Strength by angle: known answers of the sources, load shares, other workers, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.fatigue.load import load_share, strength_nm
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.fatigue.strength_by_angle import shipped_curves, strength_by_angle
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.skeleton import without_side
from fatigue_planner.reactions.reaction import Reaction

# The sources' own numbers: N.m of the average man, 75 kg and 1.75 m, at an angle in degrees.
KNOWN = {
    "lumbar_flexion:negative": {0: 169, 18: 246.5, 72: 355, 90: 355, -10: 169},
    "elbow_flexion:positive": {0: 52, 45: 52, 90: 85, 112.5: 72.5, 140: 60},
    "shoulder_flexion:positive": {0: 89.9, 67.5: 68, 90: 68, 135: 47, 170: 47},
    # c1 m g h cos(c2 (angle - c3)), m g h = 75 x 9.81 x 1.75
    "hip_flexion:negative": {53.4: 207.3, 90: 169.8},
    "knee_flexion:negative": {64.9: 209.9, 10: 74.9},
    "ankle_flexion:negative": {23.4: 122.3, 0: 103.1, -50: 24.5},
    "ankle_flexion:positive": {-10.7: 42.5},
}


def parameters_of(strength: str, *sources: str) -> FatigueParameters:
    return fatigue_parameters(FatigueSettings(strength_by_angle=sources), maximum_torque(strength))


@pytest.mark.parametrize("entry", list(KNOWN))
def test_the_average_man_has_the_torques_of_the_sources(entry: str) -> None:
    by_angle = strength_by_angle(shipped_curves())
    assert by_angle is not None
    index = entry_indices(entry, "")[-1]
    constant = parameters_of("average_man").maximum_torque_nm[index]
    for degrees, torque in KNOWN[entry].items():
        angles = np.zeros((1, 39))
        angles[0, index % 39] = np.radians(degrees)
        assert constant * by_angle.factors(angles)[0, index] == pytest.approx(torque, rel=2e-3), degrees


def test_a_woman_keeps_her_ratio_to_the_average_man() -> None:
    man, woman = parameters_of("average_man", "kamon_arm"), parameters_of("average_woman", "kamon_arm")
    elbow = ENTRIES.index("right_elbow_flexion:positive")
    assert (
        man.by_angle == woman.by_angle and woman.maximum_torque_nm[elbow] == 41 and man.maximum_torque_nm[elbow] == 77
    )


def test_what_no_source_has_is_constant(reactions: tuple[Reaction, ...]) -> None:
    constant, varying = parameters_of("average_man"), parameters_of("average_man", *shipped_curves())
    motion = reactions[0].motion
    assert strength_nm(motion, constant).shape == (1, 78)
    changed = (strength_nm(motion, varying) != strength_nm(motion, constant)).any(axis=0)
    names = {without_side(ENTRIES[index]) for index in np.flatnonzero(changed)}
    assert names == {
        "lumbar_flexion:negative", "shoulder_flexion:positive", "elbow_flexion:positive",
        *(f"{joint}_flexion:{way}" for joint in ("hip", "knee", "ankle") for way in ("positive", "negative")),
    }  # fmt: skip


def test_the_load_is_a_share_of_the_strength_at_that_angle(reactions: tuple[Reaction, ...]) -> None:
    """Tick by tick, by hand: the lumbar extensors, whose strength doubles from upright to bent."""
    varying = parameters_of("average_man", "medx_lumbar")
    lumbar = ENTRIES.index("lumbar_flexion:negative")
    for reaction in reactions:
        motion = reaction.motion
        flexion = np.degrees(motion.configuration[:, 7])
        strength = np.interp(flexion, [0, 12, 24, 36, 48, 60, 72], [169, 222, 271, 300, 327, 348, 355])
        by_hand = np.maximum(-motion.torque_nm[:, 0], 0) / strength
        np.testing.assert_allclose(load_share(motion, varying)[:, lumbar], by_hand, rtol=1e-12)
        turned = replace(motion, configuration=np.zeros_like(motion.configuration))
        upright = load_share(turned, varying)[:, lumbar]
        np.testing.assert_allclose(upright, np.maximum(-motion.torque_nm[:, 0], 0) / 169, rtol=1e-12)


OWN = """
population: one man
curves:
  right_elbow_flexion:positive: {kind: points, angles_deg: [0, 100], torques_nm: [40, 80], source: measured}
"""


def test_a_source_of_ones_own_goes_before_an_earlier_one(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(OWN)
    found = strength_by_angle(("kamon_arm", str(path)))
    assert found is not None
    angles = np.zeros((1, 39))
    factors = 77 * found.factors(angles)[0]
    assert factors[ENTRIES.index("right_elbow_flexion:positive")] == pytest.approx(40)
    assert factors[ENTRIES.index("left_elbow_flexion:positive")] == pytest.approx(52)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[0, 100]", "[100, 0]"), "needs rising angles, and a torque for each"),
        (("[40, 80]", "[40, -80]"), "torques_nm"),
        (("right_elbow_flexion:positive", "right_elbow_flexion"), "needs a direction, :positive or :negative"),
        (
            ("right_elbow_flexion:positive", "right_elbo_flexion:positive"),
            "unknown joint 'right_elbo_flexion",
        ),
        (("kind: points", "kind: line"), "line"),
    ],
)
def test_a_wrong_source_is_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(OWN.replace(*change))
    with pytest.raises(DataFileError) as caught:
        strength_by_angle((str(path),))
    assert message in str(caught.value)


def test_an_unknown_source_is_refused() -> None:
    with pytest.raises(DataFileError, match="'schanne' is neither one of anderson_leg, kamon_arm, medx_lumbar nor"):
        strength_by_angle(("schanne",))

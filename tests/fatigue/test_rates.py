"""Rates per joint: the shipped sets against their sources, own sets, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.fatigue.entries import entry_indices
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.laws.three_compartment import ThreeCompartmentLaw
from fatigue_planner.fatigue.parameters import FatigueSettings, fatigue_parameters
from fatigue_planner.fatigue.rates import rate_file, shipped_rates
from fatigue_planner.human.joint_data import maximum_torque

STRENGTH = maximum_torque("average_man")
# Frey Law & Avin 2010: endurance b0 s^b1 in seconds.
CURVES = {
    "hip": (21.92, -1.98), "ankle": (34.71, -2.06), "back": (22.69, -2.27), "elbow": (17.98, -2.21),
    "wrist": (33.55, -1.61), "knee": (19.38, -1.88), "shoulder": (14.86, -1.83), "neck": (21.92, -1.98),
}  # fmt: skip


@pytest.mark.parametrize("joint", list(CURVES))
def test_rates_of_ma_are_fitted_to_the_endurance_curves(joint: str) -> None:
    """-ln s / (k s) has the geometric mean of the curve over s = .15 ... .75.

    What remains is a difference of shape: at most 47 % (grip), as wide as the curves' own 95 % prediction intervals.
    """
    factor, exponent = CURVES[joint]
    s = np.linspace(0.15, 0.75, 61)
    unit, measured = -np.log(s) / s, factor * s**exponent
    k = np.exp(np.log(unit / measured).mean())
    fitted = fatigue_parameters(FatigueSettings(rates="frey_law_avin_2010"), STRENGTH)
    rates = fitted.fatigue_rate[entry_indices(joint, "")]
    assert np.unique(rates).size == 1 and rates[0] == pytest.approx(k, abs=5e-6)
    assert np.abs(unit / k / measured - 1).max() < 0.47
    assert set(fitted.recovery_rate) == {0.04}


def test_the_laws_endurance_is_near_the_curves_it_was_fitted_to() -> None:
    """3CC-r within 40 % of each joint's own curve from 20 to 60 % of strength: the prediction intervals are as wide."""
    three = fatigue_parameters(FatigueSettings(law=ThreeCompartmentLaw(kind="3cc_r")), STRENGTH)
    for joint, (factor, exponent) in CURVES.items():
        for s in (0.2, 0.3, 0.5, 0.6):
            time = three.law.endurance_s(s, three)[entry_indices(joint, "")[0]]
            assert time == pytest.approx(factor * s**exponent, rel=0.40), (joint, s)


def test_the_law_decides_which_rates_it_gets() -> None:
    assert set(shipped_rates()) == {"frey_law_2012", "frey_law_avin_2010"}
    ma, three = FatigueSettings(), FatigueSettings(law=ThreeCompartmentLaw(kind="3cc_r"))
    assert (ma.rates, ma.fatigue_rate_per_s, ma.recovery_rate_per_s) == (None, 0.01667, 0.04)
    assert (three.rates, three.fatigue_rate_per_s) == ("frey_law_2012", None)
    assert FatigueSettings.model_validate(three.plain()) == three and FatigueSettings.model_validate(ma.plain()) == ma
    for name in shipped_rates():
        assert all(row.source for row in rate_file(name).joints.values())


def test_what_is_given_for_all_joints_replaces_the_set_and_a_joint_replaces_both() -> None:
    settings = FatigueSettings.model_validate(
        {
            "law": {"kind": "3cc_r"}, "recovery_rate_per_s": 0.002, "rest_multiplier": 10,
            "joints": {"shoulder": {"rest_multiplier": 20}, "left_wrist": {"fatigue_rate_per_s": 0.05}},
        }
    )  # fmt: skip
    found = fatigue_parameters(settings, STRENGTH)
    assert set(found.recovery_rate) == {0.002}
    right_wrist, left_wrist = entry_indices("right_wrist", ""), entry_indices("left_wrist", "")
    assert set(found.fatigue_rate[left_wrist]) == {0.05} and set(found.fatigue_rate[right_wrist]) == {0.0098}
    assert set(found.rest_multiplier[entry_indices("shoulder", "")]) == {20} and found.rest_multiplier[0] == 10


OWN = """
law: ma
population: one man
joints:
  all: {fatigue_rate_per_s: 0.01, recovery_rate_per_s: 0.02, source: measured}
  right_elbow: {fatigue_rate_per_s: 0.03, recovery_rate_per_s: 0.02, source: measured}
"""


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(OWN)
    found = fatigue_parameters(FatigueSettings(rates=str(tmp_path / "mine.yaml")), STRENGTH)
    assert set(found.fatigue_rate[entry_indices("right_elbow", "")]) == {0.03} and found.fatigue_rate[0] == 0.01


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("law: ma", "law: 3cc_r"), "are rates of the law 3cc_r; the law is ma"),
        (("  all:", "  back:"), "no rates for neck_flexion:positive"),
        (("right_elbow", "right_elbo"), "joints.right_elbo: unknown joint 'right_elbo'; did you mean 'right_elbow'"),
        (("0.03", "-1"), "joints.right_elbow.fatigue_rate_per_s = -1"),
        ((", source: measured}\n  right", "}\n  right"), "joints.all.source"),
    ],
)
def test_a_wrong_set_of_rates_is_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(OWN.replace(*change))
    with pytest.raises(DataFileError, match=r"fatigue\.rates = ") as caught:
        fatigue_parameters(FatigueSettings(law=MaLaw(kind="ma"), rates=str(path)), STRENGTH)
    assert message in str(caught.value)


def test_an_unknown_set_of_rates_is_refused() -> None:
    with pytest.raises(DataFileError, match="neither one of frey_law_2012, frey_law_avin_2010 nor a file"):
        fatigue_parameters(FatigueSettings(rates="frey"), STRENGTH)
    with pytest.raises(ValidationError, match="the law ma has none"):
        FatigueSettings(rest_multiplier=15)

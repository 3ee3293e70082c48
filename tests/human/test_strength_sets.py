"""Strength sets: complete, with a source for every number, built on each other, per side."""

from pathlib import Path

import numpy as np
import pytest

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import joint_index
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.strength_sets import STRENGTHS, load_strengths, shipped_sets
from fatigue_planner.output.reports.human.references import references

AT_PERCENTILES = ("average_woman:p5", "average_woman:p99")


def write(path: Path, rows: str, based_on: str | None = "average_man") -> str:
    """A strength file with these rows; its name."""
    base = "" if based_on is None else f"based_on: {based_on}\n"
    path.write_text(f"population: test\n{base}degrees_of_freedom: {{{rows}}}\n")
    return str(path)


@pytest.mark.parametrize("name", shipped_sets())
def test_shipped_sets_are_complete_and_every_number_has_a_source(name: str) -> None:
    positive, negative = maximum_torque(name).vectors()
    assert positive.shape == negative.shape == (39,)
    assert (positive > 0).all() and (negative > 0).all()
    strengths = load_strengths(name)
    marks = ("read", "recalled", "computed", "assumed", "ratio")
    assert all(entry.source.startswith(marks) for entry in strengths.entries.values())


def test_women_are_not_stronger_than_men() -> None:
    for pair in (("average_man", "average_woman"), ("stobbe_man_5", "stobbe_woman_5")):
        for man, woman in zip(*(maximum_torque(name).vectors() for name in pair), strict=True):
            assert (woman <= man).all()


def test_percentiles_are_in_order() -> None:
    for weak, middle, strong in (
        ("stobbe_man_5", "average_man", "stobbe_man_95"),
        ("stobbe_woman_5", "stobbe_woman", "stobbe_woman_95"),
    ):
        for low, median, high in zip(*(maximum_torque(name).vectors() for name in (weak, middle, strong)), strict=True):
            assert (low <= median).all() and (median <= high).all()


def test_the_thoracic_joint_is_as_strong_as_the_lumbar_one() -> None:
    """Assumed in every set: the same long muscles cross both."""
    for name in shipped_sets():
        for torques in maximum_torque(name).vectors():
            for axis in ("flexion", "lateral", "rotation"):
                assert torques[joint_index(f"thoracic_{axis}")] == torques[joint_index(f"lumbar_{axis}")]


@pytest.mark.parametrize("sex", ["man", "woman"])
def test_the_sets_hold_the_numbers_of_their_sources(sex: str) -> None:
    """Kamon 1981 as printed; Anderson 2007 scaled by hand to 75 kg and 1.75 m, or 72.08 kg and 1.6272 m."""
    gender = {"man": "male", "woman": "female"}[sex]
    mass, stature = {"man": (75, 1.75), "woman": (72.08, 1.6272)}[sex]
    for name, source, scale in (
        (f"kamon_{sex}", "kamon", 1),
        (f"young_{sex}", "anderson_young", mass * GRAVITY_MPS2 * stature),
        (f"older_{sex}", "anderson_older", mass * GRAVITY_MPS2 * stature),
    ):
        entries = {f"{freedom}:{way}": entry for (freedom, way), entry in load_strengths(name).entries.items()}
        for entry, value in references().strengths[source].values.items():
            ours = entries.get(entry) or entries[f"left_{entry}"]
            assert ours.torque_nm == pytest.approx(scale * value[gender], abs=0.051)
            assert ours.source.startswith("read")


def test_what_is_not_listed_comes_from_the_base(tmp_path: Path) -> None:
    name = write(tmp_path / "mine.yaml", "elbow_flexion: {positive: 60, source: measured}")
    for ours, base, changed in zip(
        maximum_torque(name).vectors(), maximum_torque("average_man").vectors(), (60, 46), strict=True
    ):
        elbows = [joint_index("right_elbow_flexion"), joint_index("left_elbow_flexion")]
        assert (ours[elbows] == changed).all()
        np.testing.assert_array_equal(np.delete(ours, elbows), np.delete(base, elbows))


def test_a_side_goes_before_both_sides_and_a_file_before_its_base(tmp_path: Path) -> None:
    both, side = (
        "elbow_flexion: {positive: 60, negative: 40, source: m}",
        "right_elbow_flexion: {positive: 50, source: m}",
    )
    first = write(tmp_path / "first.yaml", f"{side}, {both}")
    positive, negative = maximum_torque(first).vectors()
    right, left = joint_index("right_elbow_flexion"), joint_index("left_elbow_flexion")
    assert (positive[right], positive[left], negative[right], negative[left]) == (50, 60, 40, 40)
    second = write(tmp_path / "second.yaml", "elbow_flexion: {positive: 70, source: later}", "first.yaml")
    positive, negative = maximum_torque(second).vectors()
    assert (positive[right], positive[left], negative[right]) == (70, 70, 40)
    assert load_strengths(second).entries["right_elbow_flexion", "positive"].source == "later"


def test_a_base_is_found_beside_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "people").mkdir()
    write(tmp_path / "people" / "base.yaml", "knee_flexion: {negative: 99, source: m}")
    name = write(tmp_path / "people" / "mine.yaml", "elbow_flexion: {positive: 60, source: m}", "./base.yaml")
    monkeypatch.chdir(tmp_path)
    assert maximum_torque(name).vectors()[1][joint_index("right_knee_flexion")] == 99
    assert maximum_torque("people/mine.yaml").vectors()[1][joint_index("right_knee_flexion")] == 99


def test_a_circle_is_named(tmp_path: Path) -> None:
    write(tmp_path / "a.yaml", "", "b.yaml")
    name = write(tmp_path / "b.yaml", "", "a.yaml")
    with pytest.raises(DataFileError, match=r"a\.yaml: based_on goes round in a circle|b\.yaml -> a\.yaml -> b\.yaml"):
        maximum_torque(name).vectors()
    with pytest.raises(DataFileError, match=r"circle: own\.yaml -> own\.yaml"):
        maximum_torque(write(tmp_path / "own.yaml", "", "own.yaml"))


def test_unknown_sets_name_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(DataFileError, match="strength set 'strong_man': neither one of average_man, average_woman"):
        maximum_torque("strong_man").vectors()
    with pytest.raises(DataFileError, match=r"mine\.yaml: based_on 'strong_man': neither one of average_man"):
        maximum_torque(write(tmp_path / "mine.yaml", "", "strong_man"))


def test_without_a_base_a_file_must_be_complete(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    text = (STRENGTHS / "average_man.yaml").read_text()
    path.write_text(text.replace("  knee_flexion:", "  kneeflexion:"))
    with pytest.raises(DataFileError, match=r"missing: \['knee_flexion'\], unknown: \['kneeflexion'\]"):
        maximum_torque(str(path))
    path.write_text(text.replace("positive: 77,", ""))
    with pytest.raises(DataFileError, match=r"missing: \['elbow_flexion:positive'\], unknown: none.*based_on"):
        maximum_torque(str(path))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("elbow: {positive: 5, source: m}", r"unknown: \['elbow'\]"),
        ("left_lumbar_flexion: {positive: 5, source: m}", r"unknown: \['left_lumbar_flexion'\]"),
        ("elbow_flexion: {source: m}", "neither positive nor negative"),
        ("elbow_flexion: {positive: 0, source: m}", "greater than 0"),
        ("elbow_flexion: {positive: 5}", "source: Field required"),
    ],
)
def test_a_wrong_row_is_named(tmp_path: Path, rows: str, message: str) -> None:
    with pytest.raises(DataFileError, match=message):
        maximum_torque(write(tmp_path / "mine.yaml", rows))


def test_a_set_at_a_percentile_is_its_normal_distribution() -> None:
    """Spread of the shoulder: 0.277 (hand force); of the neck: 0.28, assumed."""
    mean, weak, strong = (maximum_torque(name).vectors() for name in ("average_woman", *AT_PERCENTILES))
    shoulder, neck = joint_index("right_shoulder_flexion"), joint_index("neck_flexion")
    assert weak[0][shoulder] == pytest.approx(30 * (1 - 1.64485 * 0.277), rel=1e-5)
    assert strong[1][neck] == pytest.approx(27 * (1 + 2.32635 * 0.28), rel=1e-5)
    for low, middle, high in zip(weak, mean, strong, strict=True):
        assert (low > 0).all() and (low < middle).all() and (middle < high).all()
    assert load_strengths("average_woman:p50").entries["neck_flexion", "positive"].torque_nm == 17


@pytest.mark.parametrize("name", ["average_woman:p0", "average_woman:p99.5", "nobody:p5", "average_woman:p"])
def test_a_percentile_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(DataFileError):
        load_strengths(name)

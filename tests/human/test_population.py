"""Percentiles of stature and the mass that goes with them, against what ANSUR II's own tables say."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.population import People, Spread, median_mass_kg, percentile_of, stature_m, survey

# A second transcription, of persons' tables, in cm: 1, 5, 10, 25, 50, 75, 90, 95, 99 %.
NUMBERS = (1, 5, 10, 25, 50, 75, 90, 95, 99)
STATURES = {
    "male": (160.2, 164.8, 166.9, 171.0, 175.5, 180.2, 184.4, 187.0, 192.7),
    "female": (148.3, 152.5, 154.7, 158.6, 162.6, 167.2, 171.3, 174.0, 177.8),
}
MEANS = {"male": (175.62, 6.86), "female": (162.85, 6.42)}
# Median masses of people of a stature: sex, percentile, kg.
MASSES = [("female", 5, 58), ("female", 95, 77), ("male", 5, 74), ("male", 95, 96)]
OWN = People(stature_m=Spread(mean=1.66, sd=0.065), mass_kg=Spread(mean=68.7, sd=12.0))


@pytest.mark.parametrize("sex", ["male", "female"])
def test_statures_are_those_of_the_survey(sex: Sex) -> None:
    for number, printed in zip(NUMBERS, STATURES[sex], strict=True):
        assert stature_m(number, sex) * 100 == pytest.approx(printed, abs=1e-9)
    own = survey().people(sex).stature_cm
    assert (own.mean, own.sd) == MEANS[sex]
    # the normal distribution of the same mean and SD is no farther away than the bar, but for the first percentile
    mean, sd = MEANS[sex]
    normal = People(stature_m=Spread(mean=mean / 100, sd=sd / 100))
    for number in (5, 25, 50, 75, 90):
        assert stature_m(number, sex, normal) == pytest.approx(stature_m(number, sex), abs=0.005)


@pytest.mark.parametrize(("sex", "percentile", "mass_kg"), MASSES)
def test_masses_are_the_medians_of_people_as_tall(sex: Sex, percentile: float, mass_kg: float) -> None:
    assert median_mass_kg(stature_m(percentile, sex), sex) == pytest.approx(mass_kg, abs=0.5)


@given(st.floats(0.5, 99.5), st.sampled_from(["male", "female"]), st.sampled_from([None, OWN]))
def test_a_percentile_is_found_again(percentile: float, sex: Sex, own: People | None) -> None:
    assert percentile_of(stature_m(percentile, sex, own), sex, own) == pytest.approx(percentile, abs=1e-9)


def test_a_population_of_ones_own_has_its_means() -> None:
    assert stature_m(50, "female", OWN) == pytest.approx(1.66)
    assert stature_m(95, "female", OWN) == pytest.approx(1.66 + 1.6449 * 0.065, abs=1e-4)
    assert median_mass_kg(1.66, "female", OWN) == pytest.approx(68.7)
    assert median_mass_kg(1.66 + 0.065, "female", OWN) == pytest.approx(68.7 + 0.533 * 12)
    lean = OWN.model_copy(update={"mass_kg": None})
    assert median_mass_kg(1.66, "female", lean) == median_mass_kg(1.66, "female")

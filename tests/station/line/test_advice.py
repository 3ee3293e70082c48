"""What a rotation gains, and where it cannot: small lines whose answers are known by hand."""

from dataclasses import replace

import numpy as np
import pytest

from fatigue_planner.fatigue.entries import ENTRIES, JOINT_GROUPS
from fatigue_planner.station.line.advice import LineLoad, advise, burden_of, pause_worth, too_much, usual_places
from fatigue_planner.station.line.demands import PERCENTS, Demand
from fatigue_planner.station.line.slots import FREE

NOTHING = Demand(
    60.0,
    np.zeros((len(ENTRIES), len(PERCENTS))),
    {"right": (), "left": ()},
    dict.fromkeys((*JOINT_GROUPS, "right_hand"), 0.0),
)
HOUR_S = 3600.0


def dosed(**dose: float) -> Demand:
    """A dose of so many cut points for an hour, by region."""
    per_cycle = {region: 0.03 * cut_points / 60 for region, cut_points in dose.items()}
    return replace(NOTHING, dose={**NOTHING.dose, **per_cycle})


def line(*stations: Demand, workers: int | None = None, measure: str = "dose", slots: int = 4) -> LineLoad:
    return LineLoad([list(stations)] * (workers or len(stations)), slots, HOUR_S, measure)


def test_loads_on_other_regions_share_themselves_out() -> None:
    """Each for half the shift: 2 of 4 hours at .4 of a cut point in either region."""
    found = advise(line(dosed(back=0.4), dosed(right_hand=0.4)))
    assert found is not None and found.helps
    assert found.best.largest == pytest.approx(0.8)
    assert found.staying == pytest.approx(1.6) and found.usual == pytest.approx(0.8)
    assert found.best.changes == 2 and found.too_much == () and found.redesign is None


def test_loads_on_one_region_are_only_shared_between_workers() -> None:
    found = advise(line(dosed(back=0.4), dosed(back=0.4)))
    assert found is not None and not found.helps
    assert found.best.largest == pytest.approx(1.6) == found.staying
    assert found.best.changes == 0


def test_a_station_that_is_too_much_in_any_share_is_to_be_redesigned() -> None:
    found = advise(line(dosed(back=0.1), dosed(back=1.5), dosed(right_hand=0.1), slots=3))
    assert found is not None and not found.helps
    assert found.too_much == (1,)
    assert found.redesign is not None and found.redesign[0] == 1
    assert found.redesign[1] <= 0.3 < found.best.largest


def test_going_on_is_at_the_end_of_a_slot_and_one_station_at_a_time() -> None:
    assert usual_places(2, 2, 3, 2 * HOUR_S).tolist() == [[0, 1, 0], [1, 0, 1]]
    assert usual_places(2, 2, 4, 0.9 * HOUR_S)[0].tolist() == [0, 1, 0, 1]


def test_who_may_not_work_somewhere_does_not() -> None:
    back, hand = dosed(back=0.4), dosed(right_hand=0.4)
    found = advise(LineLoad([[back, None], [None, hand]], 4, HOUR_S, "dose"))
    assert found is not None and found.usual is None
    assert (found.best.places == [[0] * 4, [1] * 4]).all()
    assert advise(LineLoad([[back, None], [back, None]], 4, HOUR_S, "dose")) is None
    nobody = advise(LineLoad([[back, hand], [back, hand], [None, None]], 4, HOUR_S, "dose"))
    assert nobody is not None and (nobody.best.places[2] == FREE).all()


def test_the_usual_rotation_goes_on_every_hour() -> None:
    assert usual_places(2, 2, 4, HOUR_S).tolist() == [[0, 1, 0, 1], [1, 0, 1, 0]]
    assert usual_places(2, 2, 4, HOUR_S / 2).tolist() == [[0, 0, 1, 1], [1, 1, 0, 0]]
    assert usual_places(3, 2, 3, HOUR_S)[0].tolist() == [0, 1, FREE]


def test_a_pause_is_worth_what_its_time_would_load() -> None:
    """A quarter of an hour in four: of a dose one sixteenth, of an acceptable effort less."""
    dose = line(dosed(back=0.4), dosed(right_hand=0.4))
    places = usual_places(2, 2, 4, HOUR_S)
    assert pause_worth(dose, places, HOUR_S / 4) == pytest.approx(1 / 16)
    duty = NOTHING.duty.copy()
    duty[0, percent_up_to(30)] = 0.2
    effort = line(replace(NOTHING, duty=duty), NOTHING, measure="acceptable_effort")
    assert 0 < pause_worth(effort, places, HOUR_S / 4) < 1 / 16
    assert too_much(effort) == () and burden_of(effort, places) == burden_of(effort, 1 - places)
    assert pause_worth(line(NOTHING, NOTHING), places, 900) == 0


def percent_up_to(percent: int) -> np.ndarray:
    return np.asarray(percent >= PERCENTS)


@pytest.mark.parametrize("measure", ["acceptable_effort", "dose", "cumulative_strain_index"])
def test_every_measure_of_no_load_is_none(measure: str) -> None:
    found = advise(line(NOTHING, NOTHING, measure=measure, slots=2))
    assert found is not None and found.best.largest == 0 and found.best.changes == 0 and not found.helps

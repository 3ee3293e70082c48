"""The measures that remember hours: published examples, the indicators, and second computations."""

from dataclasses import replace

import numpy as np
import pytest

from fatigue_planner.ergonomics.indicators.acceptable_effort import AcceptableEffort
from fatigue_planner.ergonomics.indicators.duet import DAMAGE
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.ergonomics.strain_equation import Effort, Task, composite_index, cumulative_index
from fatigue_planner.fatigue.entries import ENTRIES, JOINT_GROUPS
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.station.line.demands import PERCENTS, Demand
from fatigue_planner.station.line.measures import dose_ratios, effort_ratios, largest, lifting_class, strain_ratios

NOTHING = Demand(60.0, np.zeros((len(ENTRIES), len(PERCENTS))), {"right": (), "left": ()}, {"right_hand": 0.0})
HOUR_S = 3600.0


def steady(percent: int, share: float) -> Demand:
    """The first entry bears so many percents for a share of the cycle."""
    duty = NOTHING.duty.copy()
    duty[0, percent >= PERCENTS] = share
    return replace(NOTHING, duty=duty)


@pytest.mark.parametrize(("share", "printed"), [(0.01, 0.67), (0.05, 0.51), (0.1, 0.42), (0.2, 0.32), (0.3, 0.25)])
def test_the_acceptable_effort_is_potvins(share: float, printed: float) -> None:
    """All of 8 h at one station, 20 % of the strength: 0.2 over the printed effort."""
    ratio = largest(effort_ratios(np.array([[8]]), [steady(20, share)], HOUR_S))[0]
    assert round(0.2 / ratio, 2) == printed


def test_half_a_shift_is_half_the_duty_and_not_half_the_ratio() -> None:
    demands = [steady(30, 0.2), NOTHING]
    whole, half = largest(effort_ratios(np.array([[8, 0], [4, 4]]), demands, HOUR_S))
    assert half == pytest.approx(largest(effort_ratios(np.array([[8, 0]]), [steady(30, 0.1), NOTHING], HOUR_S))[0])
    assert 0.5 * whole < half < whole


def test_loads_of_two_stations_on_one_joint_add_up_by_the_second_way() -> None:
    """30 % for 0.1 and 50 % for 0.05 of the time, half a shift each: the larger of both rules, by hand."""
    ratio = largest(effort_ratios(np.array([[4, 4]]), [steady(30, 0.1), steady(50, 0.05)], HOUR_S))[0]
    at_30 = 0.3 / (1 - ((0.1 * 4 + 0.05 * 4) / 8 - 1 / 28800) ** 0.24)
    at_50 = 0.5 / (1 - (0.05 * 4 / 8 - 1 / 28800) ** 0.24)
    assert ratio == pytest.approx(max(at_30, at_50), rel=1e-12)


@pytest.mark.slow
def test_one_station_all_day_is_what_the_indicator_says(reactions: tuple[Reaction, ...]) -> None:
    """Up to the rounding of loads to whole percents, upward."""
    for reaction in reactions:
        job = Job((Operation.of(reaction),), Shift(cycle_s=60))
        value = AcceptableEffort().assess(job)
        assert value.value is not None
        ratio = largest(effort_ratios(np.array([[8]]), [Demand.of(job)], HOUR_S))[0]
        assert value.value.low - 1e-12 <= ratio <= value.value.low + 0.01 / value.parts["acceptable effort"] + 1e-9


def test_the_dose_is_duets() -> None:
    """Rating 2: 5400 efforts a day are .0074; jobs of 10 and 4 efforts a minute for 9 h together .0103572."""
    rated = [replace(NOTHING, cycle_s=60 / rate, dose={"right_hand": DAMAGE[2]}) for rate in (11.25, 10, 4)]
    first = dose_ratios(np.array([[8, 0, 0]]), rated, HOUR_S)["right_hand"][0]
    assert round(0.03 * first, 4) == 0.0074
    both = [0.03 * dose_ratios(np.array([[0, 9, 0], [0, 0, 9]]), rated, HOUR_S)["right_hand"][k] for k in (0, 1)]
    assert round(sum(both), 7) == 0.0103572


@pytest.mark.slow
def test_a_stated_rating_is_the_hands_dose(reactions: tuple[Reaction, ...]) -> None:
    job = Job((Operation.of(reactions[0], Circumstances(omni_effort=2, times_per_cycle=3)),), Shift(cycle_s=60))
    dose = Demand.of(job).dose
    assert max(dose["right_hand"], dose["left_hand"]) == pytest.approx(3 * DAMAGE[2], rel=1e-12)
    assert set(JOINT_GROUPS) < set(dose)
    assert any(dose[group] > 0 for group in JOINT_GROUPS)


def test_the_strain_of_a_day_is_the_cumulative_index() -> None:
    """Two stations, 4 h each; a hand that does nothing has none."""
    first, second = Effort(0.2, 5, 3, -5), Effort(0.4, 2.6, 1.2, 0)
    demands = [replace(NOTHING, efforts={"right": (one,), "left": ()}) for one in (first, second)]
    found = strain_ratios(np.array([[4, 4], [8, 0]]), demands, HOUR_S)
    tasks = [Task(composite_index((one,), 4), 4) for one in (first, second)]
    assert found["right_hand"][0] == pytest.approx(cumulative_index(tasks) / 10, rel=1e-12)
    assert found["right_hand"][1] == pytest.approx(composite_index((first,), 8) / 10, rel=1e-12)
    assert (found["left_hand"] == 0).all()


def test_many_stations_are_as_the_cumulative_index_one_by_one() -> None:
    """Two kinds of efforts at most stations, at some nothing to do; slots of 40 min, some of them free."""
    random = np.random.default_rng(5)
    stations, slot_h = 6, 2 / 3
    efforts = [
        tuple(Effort(*random.uniform((0.05, 1, 0.5, -40), (0.6, 12, 5, 40))) for _ in range(number))
        for number in (2, 1, 0, 2, 0, 1)
    ]
    demands = [replace(NOTHING, efforts={"right": own, "left": ()}) for own in efforts]
    counts = random.multinomial(9, np.full(stations + 1, 1 / (stations + 1)), size=50)[:, :stations]
    found = strain_ratios(counts, demands, slot_h * HOUR_S)["right_hand"]
    for row, ratio in zip(counts, found, strict=True):
        hours = [(own, slot_h * n) for own, n in zip(efforts, row, strict=True) if n and own]
        tasks = [Task(composite_index(own, time_h), time_h) for own, time_h in hours]
        assert ratio == pytest.approx(cumulative_index(tasks) / 10, rel=1e-12)


def test_a_hand_works_as_the_example_of_the_strain_index() -> None:
    """NTP 1125: .2, 5 a minute, 3 s, 5 degrees of flexion, 4 h is 3.959 by multipliers that are rounded."""
    demand = replace(NOTHING, efforts={"right": (Effort(0.2, 5, 3, -5),), "left": ()})
    assert 10 * strain_ratios(np.array([[4]]), [demand], HOUR_S)["right_hand"][0] == pytest.approx(3.959, abs=5e-4)


def test_the_class_of_lifting_is_nioshs() -> None:
    """30 min of lifting, 10 of light work, 45 of lifting: moderate; with 30 of light work: short."""
    lifts, light = 0, 1

    def of(*minutes: float) -> str | None:
        return lifting_class([lifts, light, lifts], [True, False], [(each / 60, 0.0) for each in minutes])

    assert of(30, 10, 45) == "moderate"
    assert of(30, 30, 45) == "short"
    assert lifting_class([lifts] * 8, [True], [(1.0, 0.0)] * 8) == "long"
    assert lifting_class([lifts] * 9, [True], [(1.0, 0.0)] * 9) is None
    assert lifting_class([-1, light], [True, False], [(1.0, 0.0)] * 2) == "short"

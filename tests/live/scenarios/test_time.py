"""Clocks that are set, days that end, pauses and cycles of any length, a machine that sleeps."""

import time
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from planting import fails_with
from shifts import CYCLE_S, FakeClock, World, cycles, standing

from fatigue_planner.live.clock import SystemClock
from fatigue_planner.live.events import ClockSet, Decided, Observed, Slept
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.shift import Adviser

SESSION = "fatigue_planner.live.session:Session"
SEEN = ["arm", "back", None, "arm"]


@fails_with(
    "fatigue_planner.live.session:Session._after_rest", "self._clock.seconds()", "self._clock.utc().timestamp()"
)
def test_03_the_time_of_day_is_set(world: World) -> None:
    """An hour back and on: nothing lasts longer or shorter; the journal says by how much it was set."""
    with world.open("undisturbed", clock := FakeClock()) as session:
        cycles(session, clock, SEEN)
        digest = standing(session).belief.states.tobytes()
    with world.open() as session:
        for hours, one in zip((-1, 1, 0, -1), SEEN, strict=True):
            world.clock.wall += timedelta(hours=hours)
            cycles(session, world.clock, [one])
        assert standing(session).belief.states.tobytes() == digest
    assert [one.difference_s for one in world.events(ClockSet)] == [-3600, 3600, -3600]
    assert not any(one.idle_s for one in world.events(Observed))
    world.clock.wall += timedelta(seconds=30)  # while nothing ran
    with world.open() as session:
        session.decide()
    assert world.events(ClockSet)[-1].difference_s == 30


@fails_with(f"{SESSION}._record", "self._clock.utc()", "self._clock.utc().astimezone()")
def test_04_midnight_summer_time_and_a_leap_second(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """UTC in the journal, one file, and durations that no calendar changes."""
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    try:
        world.clock.wall = datetime(2026, 10, 24, 23, 59, 30, tzinfo=UTC)  # an hour before summer time ends
        with world.open() as session:
            cycles(session, world.clock, SEEN)
            world.clock.pass_(3600)
            session.rest(3600)
            cycles(session, world.clock, SEEN)
            world.clock.wall -= timedelta(seconds=1)  # 23:59:59 once more
            cycles(session, world.clock, SEEN)
    finally:
        monkeypatch.undo()
        time.tzset()
    utc = [one.utc for one in read_journal(world.path)]
    assert all(one.endswith("+00:00") for one in utc)
    assert {one[:10] for one in utc} == {"2026-10-24", "2026-10-25"}
    assert not any(one.idle_s for one in world.events(Observed))
    assert [one.difference_s for one in world.events(ClockSet)] == [-1]


@fails_with(f"{SESSION}.rest", 'said.seconds("seconds", seconds)', 'min(said.seconds("seconds", seconds), 40.0)')
def test_11_lunch_a_pause_and_cycles_of_any_length(world: World) -> None:
    """A pause in two parts is a pause; a longer cycle is the cycle and rest; all of it is in the history."""
    with world.open() as session, world.open("other", clock := FakeClock()) as other:
        for one, its in ((session, world.clock), (other, clock)):
            cycles(one, its, SEEN)
        for seconds in (37.2, 45 * 60 - 37.2):
            world.clock.pass_(seconds)
            session.rest(seconds)
        clock.pass_(45 * 60)
        other.rest(45 * 60)
        np.testing.assert_allclose(standing(session).belief.states, standing(other).belief.states, rtol=1e-13)
        before = standing(session).belief
        session.observe(5, observation="arm", executed="high", duration_s=17.2)
        rng = np.random.default_rng(0)
        expected = before.weigh(0, [1.0, 0.0], rng).rest(1.2)
        np.testing.assert_allclose(standing(session).belief.states, expected.states, rtol=1e-13)
        digest = session.digest()
    with world.open() as resumed:
        assert resumed.digest() == digest
        world.clock.pass_(CYCLE_S)
        resumed.observe(6, executed="low")
        resumed.rest(60)
        resumed.observe(6, executed="low", observation="arm")  # told late: the pause after it stays
        late = standing(resumed).belief.states
    with world.open("in time", FakeClock()) as other:
        cycles(other, other._clock, SEEN)
        for seconds in (37.2, 45 * 60 - 37.2):
            other.rest(seconds)
        other.observe(5, observation="arm", executed="high", duration_s=17.2)
        other.observe(6, executed="low", observation="arm")
        other.rest(60)
        np.testing.assert_allclose(late, standing(other).belief.states, rtol=1e-13)


@fails_with(f"{SESSION}._decided", "time.perf_counter() - began", "self._clock.seconds() - 1000")
def test_26_the_machine_sleeps_for_20_minutes(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """The worker has rested, and a decision during which it slept is not late: no time passed for it."""

    def sleep() -> None:
        world.clock.pass_(1200)
        world.clock.slept += 1200

    with world.open(deadline_s=10) as session:
        cycles(session, world.clock, ["arm"])
        session.decide()
        sleep()
        world.clock.pass_(CYCLE_S)
        session.observe(2, observation="back")
        choose = Adviser.choose

        def asleep(*given: object) -> object:
            sleep()
            return choose(*given)  # type: ignore[arg-type]

        world.clock.pass_(CYCLE_S)
        with monkeypatch.context() as patch:
            patch.setattr(Adviser, "choose", asleep)
            session.rest(5)
        session.decide()
    assert [one.idle_s for one in world.events(Observed)] == [0, 1200]
    assert sum(one.seconds for one in world.events(Slept)) >= 2400
    assert not any(one.late for one in world.events(Decided))


def test_the_machines_clock_counts_its_sleep() -> None:
    clock = SystemClock()
    assert clock.seconds() == pytest.approx(time.clock_gettime(time.CLOCK_BOOTTIME), abs=5)
    assert clock.slept_s() >= -1e-3

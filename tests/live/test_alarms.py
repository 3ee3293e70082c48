"""Alarms and pauses: closed forms against the maps themselves and against enumeration; one alarm for one reason."""

import threading
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER
from planting import fails_with, planted
from shifts import CYCLE_S, FakeClock
from small_problems import SEVERAL, belief_in, small_model

import fatigue_planner as fp
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.model import Rest
from fatigue_planner.live.events import Alarmed, Cleared
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.pauses import AHEAD, ENOUGH, fading_s, levels, passings, pauses_s
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers
from fatigue_planner.pomdp.timing import Timing

PAUSES, WATCH = "fatigue_planner.live.pauses:", "fatigue_planner.live.watch:"
RATES = np.array([0.04, 0.02, 0.0])
REST = Rest(np.array([0.0, 0.002, 0.0]), np.zeros(3), RATES)


def timed(model: FatiguePomdp) -> FatiguePomdp:
    """An entry that fades to 0, one that fades to 0.1, and one that never fades."""
    return replace(model, timing=Timing(CYCLE_S, REST))


@fails_with(PAUSES + "fading_s", "(level - floor[falls])", "level")
def test_a_pause_is_as_long_as_the_law_says() -> None:
    """After it, the fatigue is at the level, by the map of rest; where it never is, no time is told."""
    fatigue = np.array([[0.9, 0.9, 0.9], [0.5, 0.5, 0.5], [0.1, 0.3, 0.4]])
    fade, grow = (np.broadcast_to(row, (3, 3)) for row in REST.rates(1.0, 1.0))
    times = fading_s(fatigue, 0.4, fade, grow)
    assert np.isinf(times[:2, 2]).all()
    assert (times[2] == 0).all()
    for row, column in product(range(2), range(2)):
        gain, offset = REST.maps(1.0, 1.0, times[row, column])
        assert gain[column] * fatigue[row, column] + offset[column] == pytest.approx(0.4, rel=1e-12)
    assert np.isinf(fading_s(fatigue, 0.1, fade, grow)[0, 1])


@fails_with(PAUSES + "pauses_s", "[worker]", "[worker * 0]")
def test_a_pause_is_long_enough_for_nine_tenths_of_the_workers() -> None:
    """Each by his own rates; a second less is not."""
    rates = np.random.default_rng(1).uniform(0.5, 2.0, 200)
    model = timed(small_model(0)).for_workers(Workers(np.ones(200), rates, np.zeros(200)))
    states = np.array([model.state(np.full(3, 0.6), worker) for worker in range(200)])
    belief = ExactBelief(model, states, np.full(200, 1 / 200))
    (pause,) = pauses_s(belief, np.array([0]), 0.4)
    assert pause is not None
    for seconds, enough in ((pause * (1 + 1e-9), True), (pause - 1, False)):
        after = belief.rest(seconds)
        assert (after.weights @ (after.states[:, 0] <= 0.4) >= ENOUGH - 1e-12) == enough
    assert pauses_s(belief, np.array([2]), 0.4) == [None]


@fails_with(PAUSES + "_work_design", ".min(axis=1)", ".max(axis=1)")
def test_what_no_action_keeps_below_the_limit() -> None:
    """It stays above whatever is done and chosen; what is not told apart comes below under the best of it."""
    model = timed(small_model(0))
    rng = np.random.default_rng(5)
    maps = [[profile.cycle_map() for profile in row] for row in model.profiles]
    found = 0
    for limit in (0.3, 0.5, 0.6, 0.7, 0.8, 0.9):
        told = {one.entry for one in levels(belief_in(model, np.ones((1, 3)), [1.0]), limit).work_design}
        fatigue = np.ones(3)
        for _ in range(500):
            fatigue = maps[rng.integers(2)][rng.integers(2)].apply(fatigue)
            assert all(fatigue[entry] > limit for entry in range(3) if ENTRIES[entry] in told)
        for entry in {0, 1, 2} - {ENTRIES.index(name) for name in told}:
            best = min((one for row in maps for one in row), key=lambda one: one.offset[entry] / (1 - one.gain[entry]))
            fatigue = np.ones(3)
            for _ in range(500):
                fatigue = best.apply(fatigue)
            assert fatigue[entry] <= limit + 1e-9
        found += len(told)
    assert 0 < found < 18


@fails_with(PAUSES + "passings", "predict(plan(belief, n)", "predict(plan(belief, 0)")
def test_what_is_coming_is_what_an_enumeration_finds() -> None:
    """The probabilities over all reactions of the next cycles, of a belief in three states."""
    model, weights, limit = timed(small_model(0)), [0.2, 0.5, 0.3], 0.62
    belief = belief_in(model, SEVERAL, weights)
    plan = [0, 0, 1, 1] * 3
    found = passings(belief, limit, lambda _, n: plan[n], np.random.default_rng(0))
    expected: dict[str, tuple[int, float]] = {}
    unaided = {one.entry for one in levels(belief, limit).work_design}
    states = [(weight, fatigue) for weight, fatigue in zip(weights, SEVERAL, strict=True)]
    for n in range(8):
        states = [
            (weight / 2, model.profiles[plan[n]][u].cycle_map().apply(fatigue))
            for weight, fatigue in states
            for u in range(2)
        ]
        for entry in range(3):
            above = sum(weight for weight, fatigue in states if fatigue[entry] > limit)
            if above >= 0.5 and ENTRIES[entry] not in unaided:
                expected.setdefault(ENTRIES[entry], (n + 1, above))
    assert max(first for first, _ in expected.values()) > 2
    for one in found:
        if one.in_cycles <= 8:
            assert (one.in_cycles, one.probability) == (expected[one.entry][0], pytest.approx(expected[one.entry][1]))
    assert {one.entry for one in found if one.in_cycles <= 8} == set(expected)
    assert AHEAD >= 8


# --- a shift ------------------------------------------------------------------------------------------------------

LIMIT = fp.AlarmSettings(limit=0.25, limit_source="a test", repeat_s=300)
ABOVE = "lumbar_flexion:negative"


@pytest.fixture(scope="module")
def scenario(cache_folder: Path) -> fp.Scenario:
    experiment = fp.load(PAPER)
    return fp.scenario(experiment, fp.simulate(experiment, cache_folder), "single_novice")


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


def work(session: fp.Session, clock: FakeClock, cycles: int, executed: str = "low") -> None:
    """Cycles of one action, in which the worker bends his back; each is looked at."""
    for _ in range(cycles):
        decision = session.decide()
        clock.pass_(CYCLE_S)
        session.observe(decision.cycle, executed=executed, observation="back")
        session.state()


@fails_with(WATCH + "Alarms.due", "level.probability > CLEARED", "level.probability >= RAISED")
def test_around_the_limit_there_is_one_alarm(scenario: fp.Scenario, tmp_path: Path, clock: FakeClock) -> None:
    """Where nothing is seen, the belief spreads around the limit; that is no new alarm, and no end of this one."""
    path = tmp_path / "shift.fatplan"
    with fp.Session.open(path, scenario, clock=clock, alarms=LIMIT) as session:
        work(session, clock, 20)
        for _ in range(20):  # nothing is seen: the belief widens around the limit
            decision = session.decide()
            clock.pass_(CYCLE_S)
            session.observe(decision.cycle, executed="low")
            session.state()
        alarms = {one.entry: one.probability for one in session.state().pauses.alarms}
        assert 0.1 < alarms.get(ABOVE, 0) < 0.5
    told = [one.event for one in read_journal(path) if isinstance(one.event, Alarmed | Cleared)]
    assert [one.kind for one in told if one.entry == ABOVE] == ["alarmed"]


@fails_with(WATCH + "Alarms.account", "case WorkerChanged() | Advice(on=False):", "case Advice(on=False):")
def test_alarms_and_doses_are_the_worker_s_own(scenario: fp.Scenario, tmp_path: Path, clock: FakeClock) -> None:
    """Who comes has none; who wants no belief about him has none."""
    path = tmp_path / "shift.fatplan"
    with fp.Session.open(path, scenario, clock=clock, alarms=LIMIT) as session:
        session.worker("w-1")
        work(session, clock, 20)
        before = session.state().pauses
        assert before.alarms and before.doses
        session.worker("w-2")
        assert (session.state().pauses.alarms, session.state().pauses.doses) == ((), ())
        session.worker("w-1")
        again = session.state().pauses
        assert {one.entry for one in again.alarms} == {one.entry for one in before.alarms}
        assert again.doses == before.doses
        session._journal.wait(session.state().recorded, 30)
        assert not any(isinstance(one.event, Cleared) for one in read_journal(path))
        session.advise(False)
        work(session, clock, 2)
        off = session.state().pauses
        assert (off.alarms, off.doses, off.work_design, off.coming) == ((), (), (), ())


@fails_with(WATCH + "Watch.coming", "if one.in_cycles > 0", "if one.in_cycles < 0")
def test_what_is_coming_is_told_beforehand(scenario: fp.Scenario, tmp_path: Path, clock: FakeClock) -> None:
    """Under a plan that always bends the back; found while the worker works."""
    fixed = {"kind": "fixed", "action": "low"}
    with fp.Session.open(tmp_path / "shift.fatplan", scenario, fixed, clock=clock, alarms=LIMIT) as session:
        work(session, clock, 3)
        session.decide()
        assert session._table.wait(30)
        for _ in range(200):
            coming = session.state().pauses.coming
            if coming:
                break
            threading.Event().wait(0.05)
        assert coming and coming[0].probability >= 0.5 and coming[0].in_cycles >= 1


@fails_with("fatigue_planner.live.doses:RecentDoses.last_hour", "now_s - HOUR_S", "now_s - 2 * HOUR_S")
def test_a_dose_is_that_of_the_last_hour(scenario: fp.Scenario, tmp_path: Path, clock: FakeClock) -> None:
    load_s = scenario.model.profiles[1][1].load_s
    assert scenario.model.actions[1] == "low" and scenario.model.outcomes[1] == "back"
    with fp.Session.open(tmp_path / "shift.fatplan", scenario, clock=clock) as session:
        work(session, clock, 10)
        found = {one.entry: one.mean_s for one in session.state().pauses.doses}
        largest = np.sort(load_s)[::-1][:8]
        np.testing.assert_allclose(list(found.values()), 10 * largest)
        session.observe(session.decide().cycle, executed="low")
        unsure = session.state().pauses.doses[0]
        assert unsure.low_s < unsure.mean_s < unsure.high_s
        session.observe(11, executed="low", observation="back")  # told late: the same cycle
        found = {one.entry: one.mean_s for one in session.state().pauses.doses}
        np.testing.assert_allclose(list(found.values()), 11 * largest)
        clock.pass_(3700)
        assert session.state().pauses.doses == ()


@fails_with(WATCH + "Watch._meter", "if event.idle_s:", "if event.idle_s and not event.late:")
def test_what_is_told_late_is_metered_after_the_rest_before_it(cache_folder: Path, tmp_path: Path) -> None:
    """The rest changes how likely a worker chooses, and with it the dose of a cycle that was not seen for sure."""
    mine = tmp_path / "mine.yaml"
    mine.write_text(PAPER.read_text().replace("expertise: .inf", "expertise: 30"))
    experiment = fp.load(mine)
    reactions = fp.simulate(experiment, cache_folder)
    found = []
    for is_late in (False, True):
        worker = fp.scenario(experiment, reactions, "single_expert")
        with fp.Session.open(tmp_path / f"{is_late}", worker, clock=(clock := FakeClock())) as session:
            work(session, clock, 10)
            clock.pass_(60 + CYCLE_S)
            if is_late:
                session.decide()
                session.observe(11, executed="low")
            session.observe(11, executed="low", likelihood={"arm": 0.5, "back": 0.6})
            found.append({one.entry: one.mean_s for one in session.state().pauses.doses})
    assert found[0] == pytest.approx(found[1], rel=1e-12)


TESTS: list[Callable[..., None]] = [one for name, one in globals().items() if name.startswith("test_")]


@pytest.mark.slow
@pytest.mark.parametrize("test", TESTS, ids=lambda test: test.__name__)
def test_a_planted_fault_is_seen(test: Callable[..., None], request: pytest.FixtureRequest) -> None:
    names = test.__code__.co_varnames[: test.__code__.co_argcount]
    given = {name: request.getfixturevalue(name) for name in names}
    with planted(test.fault), pytest.raises(AssertionError):  # type: ignore[attr-defined]
        test(**given)

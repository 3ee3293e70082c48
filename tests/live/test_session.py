"""A session: the same belief and answers whatever happens to the program; what was said wrongly changes nothing."""

import gc
import itertools
import math
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER
from shifts import CYCLE_S, FakeClock, cycles, standing

import fatigue_planner as fp
from fatigue_planner.core.errors import (
    ContradictionError,
    CycleError,
    EvidenceError,
    OtherSituationError,
    SelectionError,
)
from fatigue_planner.live import session as session_module
from fatigue_planner.live.clock import RehearsalClock
from fatigue_planner.live.events import Contradicted, Decided, Observed, Opened, Rested, Skipped, WorkerChanged
from fatigue_planner.live.journal_file import last_seconds, read_journal
from fatigue_planner.live.limits import LATE_CYCLES
from fatigue_planner.live.shift import Adviser, Shift


@pytest.fixture(scope="module")
def scenario(cache_folder: Path) -> fp.Scenario:
    experiment = fp.load(PAPER)
    return fp.scenario(experiment, fp.simulate(experiment, cache_folder), "multiple_novice")


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "shift.fatplan"


def test_what_the_robot_says_it_does_counts(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Its own word goes before what it was told, also after a restart; what is said late or twice changes nothing."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        asked = session.decide().action
        other = next(name for name in scenario.model.actions if name != asked)
        assert session.state().robot == "unknown"
        assert session.executed(1, other).action == asked
        recorded = session.executed(1, other).recorded
        with pytest.raises(ContradictionError, match=f"cycle 1: the robot did {other}"):
            session.executed(1, asked)
        with pytest.raises(ContradictionError, match="as it said itself"):
            session.observe(1, executed=asked)
    assert [one.event.kind for one in read_journal(path)].count("executed") == 1
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert session.state().robot == "answers"
        second = session.decide(cycle=2)
        assert session.executed(1, other).recorded == second.recorded
        with pytest.raises(ContradictionError):
            session.executed(1, asked)
        assert session.observe(1, observation="arm").cycle == 2
        with pytest.raises(CycleError):
            session.executed(3, other)
        with pytest.raises(EvidenceError):
            session.executed(2, "nowhere")
    observed = [one.event for one in read_journal(path) if isinstance(one.event, Observed)]
    assert recorded == 2
    assert [(one.executed, one.observation) for one in observed] == [(other, None), (other, "arm")]


def test_a_robot_that_says_nothing_is_unreachable(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        action = session.decide().action
        session.executed(1, action)
        cycles(session, clock, ["arm"])
        assert session.state().robot == "answers"
        cycles(session, clock, ["arm"])
        assert session.state().robot == "unreachable"
        session.executed(3, action)
        assert session.state().robot == "answers"
        assert session.skip(16.0, cycle=3).cycle == session.skip(16.0, cycle=3).cycle == 4
        with pytest.raises(CycleError, match="was observed"):
            session.skip(cycle=2)
        session.executed(3)
        session.executed(3)
        assert session.state().robot == "unreachable"
        digest = session.digest()
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert (session.state().robot, session.digest()) == ("unreachable", digest)
    assert [one.event.kind for one in read_journal(path)].count("executed") == 3


def test_a_rehearsals_journal_is_no_shifts(scenario: fp.Scenario, path: Path) -> None:
    """The chain's first event says that the clock was none; a shift is not gone on with as a rehearsal, nor back."""
    clock = RehearsalClock()
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert session.state().rehearsal
        clock.move(3600)
        session.skip()
        for wrong in (3599.0, math.nan, 1e12):
            with pytest.raises(EvidenceError, match="never set back"):
                clock.move(wrong)
    first = read_journal(path)[0]
    assert isinstance(first.event, Opened)
    assert (first.event.rehearsal, first.utc) == (True, "2000-01-01T06:00:00+00:00")
    assert last_seconds(path) == 3600
    with pytest.raises(OtherSituationError, match="the clock"):
        fp.Session.open(path, scenario)


SEEN = ["arm", "back", None, "arm", "arm", "back", None, None, "back", "arm"]


def test_it_is_the_planner_cycle_by_cycle(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """A session without pauses does what the same policy does in a benchmark's belief."""
    seen = ["arm", "back", "back", "arm"] * 3
    with fp.Session.open(path, scenario, clock=clock) as session:
        actions = cycles(session, clock, list(seen))
    rng = np.random.default_rng(0)
    policy = fp.policy(session_module.DEFAULT_POLICY).build()
    belief = scenario.initial_belief("prior", scenario.model, rng)
    for action, one in zip(actions, seen, strict=True):
        assert scenario.model.actions[policy.act(belief, rng).action] == action
        belief = belief.update(scenario.model.actions.index(action), scenario.model.observations.index(one), rng)


def test_asked_twice_it_answers_the_same(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        first = session.decide()
        again = session.decide(cycle=1)
        assert (again.cycle, again.action) == (first.cycle, first.action) == (1, first.action)
        clock.pass_(CYCLE_S)
        second = session.observe(1, observation="arm")
        digest = session.digest()
        assert session.observe(1, observation="arm").action == second.action
        assert session.digest() == digest
    assert sum(isinstance(one.event, Observed) for one in read_journal(path)) == 1


def test_something_else_said_of_a_cycle_is_refused(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        session.decide()
        session.observe(1, observation="arm")
        digest = session.digest()
        with pytest.raises(ContradictionError, match="cycle 1: was observed otherwise before; the first stands"):
            session.observe(1, observation="back")
        assert session.digest() == digest
        assert session.counts.contradicted == 1
    assert sum(isinstance(one.event, Contradicted) for one in read_journal(path)) == 1


def test_what_comes_late_is_taken_in_its_place(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        actions = cycles(session, clock, ["arm", "back"])
        third = session.decide()
        clock.pass_(CYCLE_S)
        fourth = session.decide(cycle=4)  # nothing was seen of the third
        assert session.counts.unseen == 1
        late = session.observe(3, observation="back")
        assert (late.cycle, late.action) == (4, fourth.action)  # what was decided stands
        assert session.counts.unseen == 0
        digest = session.digest()
    with fp.Session.open(path.with_name("other"), scenario, clock=FakeClock()) as other:
        assert cycles(other, other._clock, ["arm", "back"]) == actions
        assert other.decide().action == third.action
        other._clock.pass_(CYCLE_S)
        other.observe(3, observation="back")
        assert np.array_equal(standing(other).belief.states, standing(session).belief.states)
        assert standing(other).belief.weights.tolist() == standing(session).belief.weights.tolist()
    with fp.Session.open(path, scenario, clock=clock) as resumed:
        assert resumed.digest() == digest
        assert resumed.counts == session.counts


@pytest.mark.parametrize("cycle", [3, 7, -1, 0, True, 1.0, "1", None])
def test_another_cycle_is_refused(scenario: fp.Scenario, path: Path, clock: FakeClock, cycle: object) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, ["arm"])
        session.decide()
        digest = session.digest()
        with pytest.raises(CycleError):
            session.observe(cycle, observation="arm")  # type: ignore[arg-type]
        assert session.digest() == digest


def test_too_late_is_refused(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, [None] * (LATE_CYCLES + 1))
        with pytest.raises(CycleError, match=f"cycle 1: cannot be observed; the cycle going on is {LATE_CYCLES + 2}"):
            session.observe(1, observation="arm")
        session.observe(2, observation="arm")
        with pytest.raises(CycleError, match="the cycle to decide is 7"):
            session.decide(cycle=9)


NAN, INF = float("nan"), float("inf")
WRONG = [
    {"executed": "middle"},
    {"executed": 1},
    {"observation": "leg"},
    {"observation": "arm", "likelihood": {"arm": 1.0}},
    {"likelihood": {}},
    {"likelihood": {"leg": 1.0}},
    {"likelihood": {"arm": NAN}},
    {"likelihood": {"arm": INF}},
    {"likelihood": {"arm": -0.1, "back": 1.0}},
    {"likelihood": {"arm": 0.0, "back": 0}},
    {"likelihood": {"arm": 1e308}},
    {"likelihood": {"arm": True}},
    {"likelihood": {"arm": "1"}},
    {"likelihood": [0.5, 0.5]},
    {"duration_s": NAN},
    {"duration_s": -1},
    {"duration_s": 1e9},
    {"duration_s": "16"},
]


def test_what_is_no_observation_is_refused(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        session.decide()
        digest = session.digest()
        for wrong in WRONG:
            with pytest.raises(EvidenceError):
                session.observe(1, **wrong)  # type: ignore[arg-type]
        for seconds in (NAN, -1.0, INF, "1", 1e9, True):
            with pytest.raises(EvidenceError):
                session.rest(seconds)  # type: ignore[arg-type]
            with pytest.raises(EvidenceError):
                session.skip(seconds)  # type: ignore[arg-type]
        for pseudonym in ("", "  ", "x" * 65, 3):
            with pytest.raises(SelectionError):
                session.worker(pseudonym)  # type: ignore[arg-type]
        assert session.digest() == digest
    assert len(read_journal(path)) == 3  # opened, decided, closed


def test_what_the_robot_did_counts(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        asked = session.decide().action
        other = next(name for name in scenario.model.actions if name != asked)
        session.observe(1, executed=other, observation="arm")
        assert session.counts.other_actions == 1
        expected = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0)).weigh(
            scenario.model.actions.index(other), [1.0, 0.0], np.random.default_rng(0)
        )
        assert np.array_equal(standing(session).belief.states, expected.states)


def test_time_that_passed_is_rest(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Also while the machine slept. A pause that was said is not counted twice, and the wall clock is not believed."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, ["arm"])
        clock.pass_(20 * 60 + CYCLE_S)
        clock.wall -= timedelta(hours=1)
        session.observe(2, observation="back")
        clock.pass_(2700)
        session.rest(2700)
        clock.pass_(CYCLE_S + 0.2)
        session.observe(3, observation="arm")
        session.rest(300)  # said when it begins
        clock.pass_(300 + CYCLE_S)
        session.observe(4, observation="arm")
        clock.pass_(60 + CYCLE_S)
        session.observe(5, observation="arm")
    observed = [one.event for one in read_journal(path) if isinstance(one.event, Observed)]
    assert [one.idle_s for one in observed] == [0, 1200, 0, 0, 60]
    rested = [one.event.seconds for one in read_journal(path) if isinstance(one.event, Rested)]
    assert rested == [2700, 300]


def test_it_goes_on_where_it_stopped(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """After every single cycle another program goes on, and all ends as if one had worked throughout."""
    with fp.Session.open(path.with_name("whole"), scenario, clock=FakeClock()) as whole:
        actions = cycles(whole, whole._clock, SEEN)
        whole_belief = standing(whole).belief
    found = []
    for one in SEEN:
        session = fp.Session.open(path, scenario, clock=clock)
        with session:
            found += cycles(session, clock, [one])
    assert found == actions
    assert np.array_equal(standing(session).belief.weights, whole_belief.weights)
    assert np.array_equal(standing(session).belief.states, whole_belief.states)
    assert session.counts == whole.counts


def test_after_a_restart_of_the_machine_the_time_of_day_counts(
    scenario: fp.Scenario, path: Path, clock: FakeClock
) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, ["arm"])
        session.decide()
    after = FakeClock("boot 2")
    after.now_s, after.wall = 5.0, clock.wall + timedelta(minutes=30)
    with fp.Session.open(path, scenario, clock=after) as session:
        after.pass_(CYCLE_S)
        session.observe(2, observation="arm")
    observed = [one.event for one in read_journal(path) if isinstance(one.event, Observed)]
    assert observed[-1].idle_s == 30 * 60


def test_another_situation_is_refused(scenario: fp.Scenario, path: Path, clock: FakeClock, cache_folder: Path) -> None:
    fp.Session.open(path, scenario, safe_action="low", clock=clock).close()
    experiment = fp.load(PAPER)
    other = fp.scenario(experiment, fp.simulate(experiment, cache_folder), "single_novice")
    with pytest.raises(OtherSituationError, match=r"what a cycle does .* changed"):
        fp.Session.open(path, other, safe_action="low", clock=clock)
    with pytest.raises(OtherSituationError, match="the policy changed"):
        fp.Session.open(path, scenario, "greedy", safe_action="low", clock=clock)
    with pytest.raises(OtherSituationError, match="the safe action changed"):
        fp.Session.open(path, scenario, safe_action="high", clock=clock)
    fp.Session.open(path, scenario, safe_action="low", clock=clock).close()


@pytest.mark.parametrize("kind", ["random", {"kind": "threshold", "fatigue_threshold": 0.1}], ids=str)
def test_a_policy_that_remembers_is_refused(scenario: fp.Scenario, path: Path, kind: object) -> None:
    with pytest.raises(SelectionError, match="a decision must follow from the belief alone"):
        fp.Session.open(path, scenario, kind)  # type: ignore[arg-type]
    assert not path.exists()


def test_a_policy_slower_than_the_deadline_is_refused(scenario: fp.Scenario, path: Path) -> None:
    with pytest.raises(SelectionError, match="ms for a decision, more than deadline_s = 1e-06"):
        fp.Session.open(path, scenario, deadline_s=1e-6)
    assert not path.exists()


def test_a_schedule_needs_no_belief(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    schedule = {"kind": "periodic", "sequence": ("high", "low", "low")}
    with fp.Session.open(path, scenario, schedule, clock=clock) as session:
        assert cycles(session, clock, [None, "arm", "back", None]) == ["high", "low", "low", "high"]


def test_without_news_the_schedule_decides(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, [None] * session_module.UNSEEN_LIMIT)
        assert session.decide().fallback == "schedule"
        clock.pass_(CYCLE_S)
        assert session.observe(session.cycle, observation="arm").fallback == "none"


def test_switched_off_nothing_is_kept_of_a_worker(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Neither a belief nor what was seen, however it is said; the schedule decides from the next cycle on."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        session.worker("w-7f3a")
        cycles(session, clock, ["arm", None, "back"])
        newcomer = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))
        decided = session.decide()
        assert session.advise(False).action == decided.action and decided.fallback == "none"
        clock.pass_(CYCLE_S)
        assert session.observe(4, observation="arm", duration_s=15.0).fallback == "schedule"
        session.observe(4, likelihood={"back": 1.0})  # it is not known what was said: no contradiction
        session.observe(2, observation="arm")  # told late
        with pytest.raises(ContradictionError):
            session.observe(4, executed="high" if decided.action == "low" else "low")
        clock.pass_(CYCLE_S)
        session.decide(cycle=6)
        session.rest(60)
        state = session.state()
        assert not state.advised and state.joints == () and state.counts.unseen == 1
        assert np.array_equal(standing(session).belief.states, newcomer.states)
        assert all(np.array_equal(past.belief.states, newcomer.states) for past in standing(session)._past)
        digest = session.digest()
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert session.digest() == digest and session.decide().fallback == "schedule"
        session.advise(True)
        session.observe(5, observation="arm")  # of a cycle in which he was off
        assert np.array_equal(standing(session).belief.states, newcomer.states)
        clock.pass_(CYCLE_S)
        assert session.observe(6, observation="arm").fallback == "none"
        assert not np.array_equal(standing(session).belief.states, newcomer.states)
    ended = {one.event.cycle: one.event for one in read_journal(path) if isinstance(one.event, Observed)}
    assert [ended[cycle].off for cycle in range(1, 7)] == [False, False, False, True, True, False]
    for cycle in (4, 5):
        assert ended[cycle] == Observed(cycle=cycle, executed=ended[cycle].executed, off=True)


def test_workers_are_never_mixed(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Two workers in turn: each has the belief of a shift alone in which the other's time was a pause."""
    turns = [("w-a", ["arm", "back"]), ("w-b", ["back"]), ("w-a", ["back", "arm"]), ("w-b", ["arm", "arm"])]
    with fp.Session.open(path, scenario, clock=clock) as session:
        for name, seen in turns:
            session.worker(name)
            cycles(session, clock, list(seen))
            clock.pass_(60)
        shift = standing(session)
        beliefs = {name: belief for name, (belief, _) in shift._others.items()} | {shift.worker: shift.belief}
        workers = dict(session._journal.workers)
    events = [one.event for one in read_journal(path)]
    for name in ("w-a", "w-b"):
        alone, own = Shift(scenario, fp.policy(session_module.DEFAULT_POLICY), shift.session), False
        for event in events:
            if isinstance(event, WorkerChanged):
                own = event.worker == workers[name]
                if own and event.away_s is None:
                    alone.take(event)
                elif own:
                    alone.belief = alone.belief.rest(event.away_s)
            elif own and isinstance(event, Observed):
                alone.cycle = event.cycle
                alone.take(event)
        assert np.array_equal(alone.belief.states, beliefs[workers[name]].states)
        assert np.array_equal(alone.belief.weights, beliefs[workers[name]].weights)
    assert b"w-a" in path.read_bytes()
    assert not any("w-a" in str(event) for event in events)


def test_what_was_prepared_is_what_would_be_decided(
    scenario: fp.Scenario, path: Path, clock: FakeClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared = path.with_name("prepared")
    with fp.Session.open(prepared, scenario, clock=clock) as session:
        for one in SEEN:
            decision = session.decide()
            assert session._table.wait(30)
            clock.pass_(CYCLE_S)
            assert session.observe(decision.cycle, observation=one).prepared
        digest = session.digest()
    monkeypatch.setattr(session_module.Table, "take", lambda *_: None)
    with fp.Session.open(path, scenario, clock=FakeClock()) as other:
        for one in SEEN:
            decision = other.decide()
            other._clock.pass_(CYCLE_S)
            assert not other.observe(decision.cycle, observation=one).prepared
    told = [
        [
            one.event.model_dump(exclude={"prepared", "duration_s"})
            for one in read_journal(file)
            if one.event.kind == "decided"
        ]
        for file in (prepared, path)
    ]
    assert told[0] == told[1]
    with fp.Session.open(prepared, scenario, clock=clock) as resumed:  # nothing is prepared when a journal is replayed
        assert resumed.digest() == digest


def test_several_clients_get_one_answer(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    with fp.Session.open(path, scenario, clock=clock) as session:
        answers: list[set[str]] = []
        for cycle in range(1, 30):
            with ThreadPoolExecutor(8) as pool:
                asked = [pool.submit(session.decide) for _ in range(8)]
            answers.append({one.result().action for one in asked})
            session.observe(cycle, observation=("arm", "back")[cycle % 2])
        assert all(len(found) == 1 for found in answers)


def test_a_failing_policy_falls_back(scenario: fp.Scenario, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = fp.policy(session_module.DEFAULT_POLICY)
    adviser = Adviser(scenario, settings, 1)
    belief = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))

    def fail(*_: object) -> None:
        raise fp.FatplanError("no idea")

    monkeypatch.setattr(adviser._policy, "act", fail)
    chosen = adviser.choose(belief, 1)
    assert (chosen.fallback, chosen.reason) == ("schedule", "the policy failed: no idea")
    adviser._schedule = None
    assert adviser.choose(belief, 1).fallback == "safe_action"


KILLED = """
import sys
import itertools
from pathlib import Path
import fatigue_planner as fp
experiment = fp.load("paper")
scenario = fp.scenario(experiment, fp.simulate(experiment, sys.argv[2]), "multiple_novice")
session = fp.Session.open(sys.argv[1], scenario)
print("open", session.decide().cycle, flush=True)
for number in itertools.count():
    decision = session.decide()
    print("decided", decision.cycle, decision.action, flush=True)
    decision = session.observe(decision.cycle, observation=["arm", "back", None][decision.cycle % 3])
    session._journal.wait(decision.recorded, 30)
    print("durable", decision.cycle, session.digest(), flush=True)
"""


@pytest.mark.slow
def test_a_kill_loses_nothing_that_was_durable(scenario: fp.Scenario, path: Path, cache_folder: Path) -> None:
    """The session after a kill stands where the last durable one stood, or later, and answers the same."""
    rng = np.random.default_rng(5)
    digests: dict[int, str] = {}
    actions: dict[int, str] = {}
    for _ in range(8):
        with subprocess.Popen(
            [sys.executable, "-c", KILLED, path, cache_folder], stdout=subprocess.PIPE, text=True
        ) as running:
            assert running.stdout is not None
            lines = [running.stdout.readline() for _ in range(3)]  # open, decided, durable: it works
            time.sleep(rng.uniform(0, 0.3))
            os.kill(running.pid, signal.SIGKILL)
            lines += running.stdout.readlines()
        last = 0
        for words in (line.split() for line in lines if line.endswith("\n")):
            if words[0] == "durable":
                last = int(words[1])
                assert digests.setdefault(last, words[2]) == words[2]
            elif words[0] == "decided":
                assert actions.setdefault(int(words[1]), words[2]) == words[2]
        with fp.Session.open(path, scenario) as session:
            assert session.cycle >= last
            assert digests.get(session.cycle, session.digest()) == session.digest()
            decision = session.decide()
            assert actions.get(decision.cycle, decision.action) == decision.action
    assert len(digests) > 20


@pytest.mark.slow
def test_a_shift_leaves_memory_and_times_flat(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """12 hours of the paper's cycles; then the journal is resumed in two seconds."""
    seen = itertools.cycle(["arm", "back", "arm", None, "back"])
    sizes = []
    with fp.Session.open(path, scenario, clock=clock) as session:
        for number in range(2700):
            cycles(session, clock, [next(seen)])
            if number % 300 == 299:
                sizes.append(len(standing(session).belief.states))
        digest = session.digest()
    assert max(sizes) <= 1000
    begin = time.process_time()
    with fp.Session.open(path, scenario, clock=clock) as resumed:
        assert resumed.digest() == digest
    assert time.process_time() - begin < 20


@pytest.mark.slow
def test_a_hidden_worker_goes_on_where_he_stopped(path: Path, clock: FakeClock, cache_folder: Path) -> None:
    """Beyond the first rejuvenations, and past the cycles that the history keeps whole."""
    unknown = "{kind: choice, values: [0.454, 1, 2.203], probabilities: [0.166, 0.668, 0.166]}"
    text = (PAPER.parent / "hidden_worker.yaml").read_text(encoding="utf-8")
    mine = path.with_name("mine.yaml")
    mine.write_text(text.replace(unknown, "{kind: lognormal, median: 1, sigma: 0.456}"), encoding="utf-8")
    experiment = fp.load(mine)
    scenario = fp.scenario(experiment, fp.simulate(experiment, cache_folder))
    assert scenario.prior is not None and scenario.prior.size == np.inf
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, SEEN * 30)
        digest = session.digest()
    with fp.Session.open(path, scenario, clock=clock) as resumed:
        assert resumed.digest() == digest


def test_a_tracker_that_is_always_late_does_not_switch_the_belief_off(
    scenario: fp.Scenario, path: Path, clock: FakeClock
) -> None:
    with fp.Session.open(path, scenario, clock=clock, unseen_limit=5) as session:
        for number in range(1, 12):
            session.decide(number)
            clock.pass_(CYCLE_S)
            decision = session.decide(number + 1)
            session.observe(number, observation="arm")
        assert decision.fallback == "none" and not session.state().degraded
        assert (session.counts.unseen, session.counts.unseen_in_a_row) == (0, 0)


def test_who_is_off_stays_off_when_another_situation_is_accepted(scenario: fp.Scenario, path: Path) -> None:
    with fp.Session.open(path, scenario, clock=FakeClock()) as session:
        session.worker("w")
        session.advise(False)
        session.worker("v")
    with fp.Session.open(path, scenario, {"kind": "greedy"}, clock=FakeClock(), accept=True) as session:
        session.worker("v")
        assert standing(session).advised
        session.worker("w")
        assert not standing(session).advised
    with fp.Session.open(path, scenario, {"kind": "greedy"}, clock=FakeClock()) as session:
        assert not standing(session).advised


def test_to_close_twice_is_to_close(scenario: fp.Scenario, path: Path) -> None:
    with fp.Session.open(path, scenario, clock=FakeClock()) as session:
        session.close()


def test_a_pause_that_has_a_name_counts_once(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Said again, also later and after a restart, it changes nothing; of another length it is refused."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        cycles(session, clock, ["arm"])
        clock.pass_(300)
        session.rest(300, key="lunch-1")
        digest = session.digest()
        assert session.rest(300, key="lunch-1").cycle == 2 and session.digest() == digest
        session.rest(60, key="after-it")
        cycles(session, clock, ["arm"])
        digest = session.digest()
    with fp.Session.open(path, scenario, clock=clock) as session:
        session.rest(300, key="lunch-1")
        assert session.digest() == digest
        with pytest.raises(ContradictionError, match="the pause lunch-1 was said to be of 300 s before"):
            session.rest(299, key="lunch-1")
        for wrong in ("", "x" * 41, "Jane Doe\n", 3):
            with pytest.raises(EvidenceError, match="that names a pause"):
                session.rest(1, key=wrong)  # type: ignore[arg-type]
        assert session.digest() == digest
        session.rest(300)
        assert session.digest() != digest
    assert [one.event.seconds for one in read_journal(path) if isinstance(one.event, Rested)] == [300, 60, 300]


def test_of_who_is_off_no_time_is_kept(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Neither pauses, nor how long he did nothing, nor how long he was away; a restart changes nothing."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        session.worker("w-1")
        session.advise(False)
        cycles(session, clock, ["arm"])
        clock.pass_(100)
        session.rest(100, key="p")
        session.rest(7)
        clock.pass_(33)
        session.skip()
        assert session.skip(cycle=2).cycle == 3
        session.worker("w-2")
        cycles(session, clock, ["arm"])
        session.worker("w-1")
        session.advise(True)
        clock.pass_(20 + CYCLE_S)
        session.observe(4, observation="arm")
        digest = session.digest()
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert session.digest() == digest
        session.rest(100, key="p")  # nothing was kept of it
        assert session.digest() != digest
    events = [one.event for one in read_journal(path)]
    assert [(one.duration_s, one.off) for one in events if isinstance(one, Skipped)] == [(0, True)]
    assert [one.away_s for one in events if isinstance(one, WorkerChanged)] == [None, None, None]
    assert [one.seconds for one in events if isinstance(one, Rested)] == [100]
    assert [one.idle_s for one in events if isinstance(one, Observed)] == [0, 0, 20]


def test_an_answer_that_was_prepared_is_given_to_nothing_else(
    scenario: fp.Scenario, path: Path, clock: FakeClock
) -> None:
    """What is equal to what may be said, or cannot be compared with it, is refused as ever."""
    with fp.Session.open(path, scenario, clock=clock) as session:
        first = session.decide()
        assert session._table.wait(30)
        digest = session.digest()
        clock.pass_(CYCLE_S)
        for cycle in (True, 1.0, np.int64(1), "1"):
            with pytest.raises(CycleError):
                session.observe(cycle, observation="arm")  # type: ignore[arg-type]
        other = next(name for name in scenario.model.actions if name != first.action)
        session.executed(1, first.action)
        assert session._table.wait(30)
        with pytest.raises(ContradictionError):
            session.observe(1, executed=other, observation="arm")
        for wrong in (["arm"], "elbow", np.array(["arm", "arm"]), 1):
            with pytest.raises(EvidenceError):
                session.observe(1, observation=wrong)  # type: ignore[arg-type]
            with pytest.raises(EvidenceError):
                session.observe(1, executed=wrong, observation="arm")  # type: ignore[arg-type]
        assert session.digest() == digest
        assert session.observe(1, observation="arm").prepared


def test_whoever_looks_after_an_answer_sees_where_it_leads(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """Also before the thread that does so has brought the shift there; and the journal has both in order."""
    gate = threading.Event()
    answers = []
    with fp.Session.open(path, scenario, clock=clock) as session:
        session._table.catch_up = lambda: gate.wait(30) and session._stand()
        answers.append(session.decide())

        def answered(seen: str | None) -> fp.CycleDecision:
            assert session._table.wait(30)
            clock.pass_(CYCLE_S)
            gate.clear()
            answers.append(session.observe(answers[-1].cycle, observation=seen))
            assert answers[-1].prepared
            return answers[-1]

        looks = [
            lambda: session.cycle,
            lambda: session.state().cycle,
            lambda: session.decide().cycle,
            lambda: session.observe(answers[-2].cycle, observation="arm").cycle,
            lambda: session.executed(answers[-1].cycle, answers[-1].action).cycle,
        ]
        for look in looks:
            answer = answered("arm")
            assert look() == answer.cycle
            gate.set()
        answered(None)
        assert session.counts.unseen == 1
        gate.set()
        answered("back")
        session.note("said after the answer")
        gate.set()
        digest = session.digest()
    events = {one.number: one.event for one in read_journal(path)}
    for answer in answers:
        decided, before = events[answer.recorded], events[answer.recorded - 1]
        assert isinstance(decided, Decided)
        assert (decided.cycle, decided.action) == (answer.cycle, answer.action)
        assert answer.cycle == 1 or (isinstance(before, Observed) and before.cycle == answer.cycle - 1)
    with fp.Session.open(path, scenario, clock=clock) as resumed:
        assert resumed.digest() == digest


def test_who_answers_goes_first(scenario: fp.Scenario, path: Path, clock: FakeClock) -> None:
    """No garbage is looked for within an answer, nor among what was there before; threads beside it give way."""
    found: list[int] = []
    answering = False

    def looked(phase: str, _: object) -> None:
        if answering and phase == "start":
            found.append(gc.get_freeze_count())

    before = gc.get_freeze_count()
    with fp.Session.open(path, scenario, clock=clock) as session:
        assert gc.get_freeze_count() > before + 10_000
        for thread in (session._table._thread, session._journal._thread):
            assert thread.native_id is not None
            policy = os.sched_getscheduler(thread.native_id) & ~os.SCHED_RESET_ON_FORK
            assert policy == os.SCHED_BATCH
        gc.callbacks.append(looked)
        try:
            for number in range(150):
                decision = session.decide()
                assert session._table.wait(30)
                clock.pass_(CYCLE_S)
                answering = True
                session.observe(decision.cycle, observation=("arm", "back")[number % 2])
                answering = False
        finally:
            gc.callbacks.remove(looked)
    assert found == []
    assert gc.get_freeze_count() == before


def test_a_learnt_worker_with_habits_is_believed_by_bayes_rule(cache_folder: Path, tmp_path: Path) -> None:
    """As `record learn` writes him: two betas, an offset, inertia. Fatigue and habit of every cycle, by hand."""
    text = PAPER.read_text(encoding="utf-8").replace(
        "  conditions:\n",
        "  conditions:\n    learnt: {initial_belief: single, hidden_worker: learnt, choice_model: learnt}\n",
        1,
    )
    file = tmp_path / "mine.yaml"
    file.write_text(
        text + "\nhidden_workers:\n  learnt:\n"
        "    expertise: {kind: choice, values: [1.0e+4, 1.0e+5], probabilities: [0.3, 0.7]}\n"
        "choice_models:\n  learnt: {kind: inertia, inertia: 1.5, offsets: {back: -0.5}}\n",
        encoding="utf-8",
    )
    experiment = fp.load(file)
    scenario = fp.scenario(experiment, fp.simulate(experiment, cache_folder), "learnt")
    model, clock = scenario.model, FakeClock()
    with fp.Session.open(tmp_path / "shift.fatplan", scenario, clock=clock) as session:
        seen = ["back", "back", "arm", "back"]
        done = cycles(session, clock, seen)
        belief = standing(session).belief
        betas = belief.model.workers.expertise[belief.states[:, -1].astype(int)]
        found = [belief.weights[betas == beta].sum() for beta in (1e4, 1e5)]
    state, last, weights = model.state(np.zeros(78)), -1, np.array([0.3, 0.7])
    for action, name in zip((model.actions.index(one) for one in done), seen, strict=True):
        costs = np.array([-model.transition(state, action, u)[1] for u in range(2)])
        odds = np.array([0.0, -0.5]) + 1.5 * (np.arange(2) == last) - np.outer([1e4, 1e5], costs - costs.min())
        last = model.outcomes.index(name)
        weights *= np.exp(odds[:, last]) / np.exp(odds).sum(axis=1)
        state, _ = model.transition(state, action, last)
    np.testing.assert_allclose(found, weights / weights.sum(), rtol=1e-9)
    assert abs(found[0] - 0.3) > 0.01

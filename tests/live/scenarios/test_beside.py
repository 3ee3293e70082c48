"""What works beside the answers: a search that fails, clients who come at the same time, and twelve hours."""

import itertools
import os
import signal
import threading
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from linearizable import Call, is_linearizable
from planting import fails_with
from shifts import CYCLE_S, World, cycles

import fatigue_planner as fp
from fatigue_planner.core.errors import FatplanError
from fatigue_planner.live import searcher
from fatigue_planner.live.events import SearchFailed

SEARCH = {"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 300, "leaf_value": "bound"}


# A search that begins anew may take so long on a busy machine; so may one that gives way to all others.
PATIENCE_S = searcher.START_WAIT_S


def until(condition: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def searched(session: fp.Session) -> bool:
    """Whether a search has found something for every reaction that may come."""
    ready = session._table._ready
    return len(ready) == 3 and all(entry.choice.searched for entry in ready.values())


@pytest.mark.slow
@fails_with("fatigue_planner.live.table:Table.improve", "task.number != self._round or ", "")
def test_23_the_search_dies_hangs_and_answers_late(  # noqa: PLR0915
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without it the policy decides, and that is counted; it comes back; what it says of an old cycle is dropped."""
    monkeypatch.setattr(searcher, "FIRST_PAUSE_S", 0.05)
    monkeypatch.setattr(searcher, "ANSWER_WAIT_S", PATIENCE_S)  # nothing hangs but what is stopped
    with world.open(search=SEARCH) as session:
        assert session._searcher is not None
        assert session.decide().fallback == "policy"  # of the first cycle nothing was prepared

        def next_cycle() -> fp.CycleDecision:
            world.clock.pass_(CYCLE_S)
            return session.observe(session.cycle, observation="arm")

        until(lambda: searched(session))
        decision = next_cycle()
        assert (decision.fallback, decision.prepared) == ("none", True)
        assert "descents" in decision.reason
        # it dies
        until(lambda: searched(session))
        process = session._searcher._process
        assert process is not None
        os.kill(process.pid, signal.SIGKILL)
        decision = next_cycle()  # was found before
        assert session._table.wait(30)
        decision = next_cycle()
        assert decision.fallback == "policy"
        until(lambda: searched(session))
        assert session._searcher.restarts == 1
        assert next_cycle().fallback == "none"
        # it hangs
        until(lambda: searched(session))
        process = session._searcher._process
        os.kill(process.pid, signal.SIGSTOP)
        monkeypatch.setattr(searcher, "ANSWER_WAIT_S", 0.5)
        next_cycle()
        assert session._table.wait(30)
        until(lambda: session._searcher.restarts == 2)
        monkeypatch.setattr(searcher, "ANSWER_WAIT_S", PATIENCE_S)
        assert next_cycle().fallback == "policy"
        # it answers late
        until(lambda: searched(session))
        process = session._searcher._process
        os.kill(process.pid, signal.SIGSTOP)
        next_cycle()
        assert session._table.wait(30)
        until(lambda: not session._searcher._waiting or len(session._searcher._waiting) < 3)  # a question was asked
        session.rest(3600)  # changes every belief
        assert session._table.wait(30)
        before = {seen: entry.choice for seen, entry in session._table._ready.items()}
        stale = session._searcher.stale
        answered, taken = threading.Event(), list[bool]()
        improve = session._table.improve

        def noted(task: searcher.Task, choice: Any) -> bool:
            taken.append(improve(task, choice))
            answered.set()
            return taken[-1]

        monkeypatch.setattr(session._table, "improve", noted)
        os.kill(process.pid, signal.SIGCONT)
        assert answered.wait(PATIENCE_S)
        assert not taken[0]
        until(lambda: session._searcher.stale == stale + 1)
        assert not any(choice.searched for choice in before.values())
        fallbacks = session.counts.fallback
    failures = world.events(SearchFailed)
    assert ["hung" in one.why for one in failures] == [False, True]
    assert fallbacks >= 4


@pytest.mark.slow
def test_what_was_asked_of_a_search_that_died_is_asked_again(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the same cycle, once for each reaction that may come."""
    monkeypatch.setattr(searcher, "FIRST_PAUSE_S", 0.05)
    with world.open(search=SEARCH) as session:
        assert session._searcher is not None
        session.decide()
        until(lambda: searched(session))
        process = session._searcher._process
        assert process is not None
        os.kill(process.pid, signal.SIGKILL)
        world.clock.pass_(CYCLE_S)
        session.observe(1, observation="arm")
        until(lambda: searched(session))
        assert session._searcher.restarts == 1


@fails_with("fatigue_planner.live.session:Session.observe", "if before is None:", "if before is None and "
            "(time.sleep(0.001) or self._shift.cycle == cycle or True) and self._turn._lock.release() is None and "
            "(time.sleep(0.001) or self._turn._lock.acquire()):")  # fmt: skip
def test_24_clients_come_at_the_same_time(world: World) -> None:
    """Whatever they do, there is an order of one call after the other that explains all answers."""
    rng = np.random.default_rng(24)
    with world.open() as session, ThreadPoolExecutor(3) as pool:
        for number in range(40):
            history: list[Call] = []
            first = session.decide()
            assert number % 2 or session._table.wait(30)  # with answers that were prepared, and without
            barrier = threading.Barrier(3)

            def client(calls: list[tuple[str, int, str | None]], wait: threading.Barrier, log: list[Call]) -> None:
                wait.wait(10)
                for kind, cycle, seen in calls:
                    began = time.perf_counter()
                    try:
                        answer = session.decide() if kind == "decide" else session.observe(cycle, observation=seen)
                        result: object = answer.cycle, answer.action
                    except FatplanError as error:
                        result = type(error).__name__
                    log.append(Call(kind, cycle, seen, result, began, time.perf_counter()))

            plans = [
                [
                    (str(rng.choice(["decide", "observe"])), first.cycle + int(rng.integers(2)),
                     [None, "arm", "back"][rng.integers(3)])
                    for _ in range(3)
                ]
                for _ in range(3)
            ]  # fmt: skip
            for one in [pool.submit(client, plan, barrier, history) for plan in plans]:
                one.result(30)
            assert is_linearizable(history, first.cycle), history
            actions = {call.result for call in history if isinstance(call.result, tuple)}
            assert len({cycle for cycle, _ in actions}) == len(actions)  # one action for a cycle


@pytest.mark.slow
@fails_with("fatigue_planner.live.shift:Shift.take", "self._past.append(", "self.__dict__.setdefault('all', [])"
            ".append([self.belief.states.copy() for _ in range(40)]) or self._past.append(")  # fmt: skip
def test_25_twelve_hours(world: World) -> None:
    """Memory stays flat; the journal is small; resumed, it believes the same. Ten times that: perf/live.py."""
    seen = itertools.cycle(["arm", "back", "arm", "back", "arm", "back", None])
    tracemalloc.start()
    try:
        with world.open() as session:
            cycles(session, world.clock, [next(seen) for _ in range(990)])
            assert session._journal.wait(session._recorded, 60)
            before, _ = tracemalloc.get_traced_memory()
            cycles(session, world.clock, [next(seen) for _ in range(900)])
            assert session._journal.wait(session._recorded, 60)
            after, _ = tracemalloc.get_traced_memory()
            assert after - before < 5e6
            cycles(session, world.clock, [next(seen) for _ in range(810)])
            digest = session.digest()
    finally:
        tracemalloc.stop()  # with no thread of the session left: beside one it can crash Python (cpython #128679)
    assert world.path.stat().st_size < 6e6
    with world.open() as resumed:
        assert (resumed.cycle, resumed.digest()) == (2701, digest)

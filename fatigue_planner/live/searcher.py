"""A search that improves prepared decisions in a process of its own, which may die, hang or answer late.

Nothing waits for it. What it does not answer in time is decided without it; what it answers for a cycle that has ended
is dropped; a process that died or hangs is replaced, after a pause that grows from one failure to the next.
"""

import json
import os
import pickle
import select
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.live.realtime import work_beside
from fatigue_planner.live.search_process import plain, sized
from fatigue_planner.live.shift import Choice
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Scenario

# A process that begins compiles what it needs.
START_WAIT_S = 120.0
# A search that takes longer hangs: the cycle that it was for is over.
ANSWER_WAIT_S = 20.0
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.5, 60.0
CHUNK_BYTES = 1 << 16


@dataclass(frozen=True)
class Task:
    """A belief to search from. number: of the preparation it is part of; observation: what would have been seen.

    is_again: it was asked before, of a process that died or hung.
    """

    number: int
    cycle: int
    observation: str | None
    belief: Belief
    is_again: bool = False


class Searcher:
    """Has one belief after the other searched, the newest ones only, and hands on what is found.

    restarts: processes that died or hung; stale: answers for cycles that had ended.
    """

    def __init__(
        self, scenario: Scenario, settings: PolicySettings, session: str, found: Callable[[Task, Choice], bool]
    ) -> None:
        """`found` is told what was found, in another thread, and says whether that was of use.

        Raises SelectionError if the search gives no answer for the beginning of a shift.
        """
        self._first = pickle.dumps((scenario, settings, session))
        self._model, self._found = scenario.model, found
        self.restarts = self.stale = 0
        self._faults: list[str] = []
        self._pause_s, self._not_before = FIRST_PAUSE_S, 0.0
        self._waiting: list[Task] = []
        self._newest = -1  # preparation
        self._is_open = True
        self._changed = threading.Condition()
        self._process: subprocess.Popen[bytes] | None = None
        start = scenario.initial_belief(settings.knows, scenario.model, random_stream(0, "live", session))
        if self._asked(Task(0, 1, None, start)) is None:
            self._end()
            raise SelectionError(f"the search {settings.kind!r} gave no answer: {self._faults[-1]}.")
        self._thread = threading.Thread(target=self._work, name="fatplan search", daemon=True)
        self._thread.start()

    def search(self, tasks: Sequence[Task]) -> None:
        """Search these, and forget what else was waiting."""
        with self._changed:
            self._waiting = list(tasks)
            self._newest = tasks[0].number if tasks else -1
            self._changed.notify_all()

    def faults(self) -> list[str]:
        """What went wrong since this was asked last."""
        with self._changed:
            told, self._faults = self._faults, []
        return told

    def close(self) -> None:
        """End thread and process."""
        with self._changed:
            self._is_open = False
            self._changed.notify_all()
            process = self._process
        if process is not None:
            process.kill()
        self._thread.join()
        self._end()

    def _work(self) -> None:
        work_beside()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or not self._is_open)
                while self._is_open and (pause_s := self._not_before - time.monotonic()) > 0:
                    self._changed.wait(pause_s)
                if not self._is_open:
                    return
                if not self._waiting:
                    continue
                task = self._waiting.pop(0)
            choice = self._asked(task)
            if choice is not None and not self._found(task, choice):
                self.stale += 1

    def _asked(self, task: Task) -> Choice | None:
        """What the process answers; one that fails is ended, and the next one begins after a pause."""
        try:
            wait_s = ANSWER_WAIT_S
            if self._process is None:
                self._begin()
                wait_s = START_WAIT_S
            what = task.number, task.cycle, task.observation
            choice = self._checked(self._exchange(sized(plain(task.belief, what, self._model)), wait_s), task)
        except (OSError, ValueError) as error:
            with self._changed:
                if self._is_open:
                    self.restarts += 1
                    self._faults.append(str(error) or type(error).__name__)
                self._not_before = time.monotonic() + self._pause_s
                if task.number == self._newest and not task.is_again:
                    self._waiting.append(replace(task, is_again=True))
            self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)
            self._end()
            return None
        self._pause_s = FIRST_PAUSE_S
        return choice

    def _checked(self, reply: bytes, task: Task) -> Choice | None:
        """A reply as a choice. Raises ValueError for what is no reply to this."""
        said = json.loads(reply)
        if said["number"] != task.number:
            raise ValueError(f"the search answered preparation {said['number']}, was asked for {task.number}")
        if "failed" in said:
            with self._changed:
                self._faults.append(str(said["failed"]))
            return None
        action = said["action"]
        if not isinstance(action, int) or not 0 <= action < len(self._model.actions):
            raise ValueError(f"the search answered {action!r}, which is no action")
        return Choice(action, str(said["reason"]), searched=True)

    def _begin(self) -> None:
        command = [sys.executable, "-m", "fatigue_planner.live.search_process"]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True, bufsize=0
        )
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)
        self._exchange(sized(self._first), START_WAIT_S, answered=False)

    def _exchange(self, message: bytes, wait_s: float, answered: bool = True) -> bytes:
        """Send a message and wait for its reply. Raises TimeoutError; BrokenPipeError if the process has ended."""
        process = self._process
        assert process is not None and process.stdin is not None and process.stdout is not None
        until, left, reply = time.monotonic() + wait_s, memoryview(message), b""
        while left or (answered and not reply.endswith(b"\n")):
            readable, writable, _ = select.select(
                [process.stdout], [process.stdin] if left else [], [], max(until - time.monotonic(), 0)
            )
            if not readable and not writable:
                raise TimeoutError(f"the search hung for {wait_s:g} s and was ended")
            if writable:
                left = left[os.write(process.stdin.fileno(), left[:CHUNK_BYTES]) :]
            if readable:
                part = os.read(process.stdout.fileno(), CHUNK_BYTES)
                if not part:
                    raise BrokenPipeError("the search ended by itself")
                reply += part
        return reply

    def _end(self) -> None:
        """End the process, whatever it does."""
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            with suppress(OSError):
                pipe.close()


def unsearched(choice: Choice) -> Choice:
    """A policy's choice where a search should have improved it."""
    return choice if choice.searched or choice.fallback != "none" else replace(choice, fallback="policy")

"""What will be answered: the belief and the decision after every reaction that may be recognised, and after none."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from fatigue_planner.live.events import Observed
from fatigue_planner.live.realtime import collect_young, work_beside
from fatigue_planner.live.searcher import Task
from fatigue_planner.live.shift import Adviser, Choice, Shift
from fatigue_planner.pomdp.beliefs.belief import Belief

# A cycle that has gone on for so long after all was prepared leaves time for more.
IDLE_S = 0.05


@dataclass(frozen=True)
class Prepared:
    """How a cycle may end, the belief after that, and what to do in the next."""

    event: Observed
    belief: Belief
    choice: Choice


class Table:
    """Prepares, in a thread of its own, what follows a cycle of planned duration that goes as it was decided.

    Its answers are those that would be computed afterwards: both come from the same functions of the same inputs. Its
    adviser is its own, for policies have working memory. `search` is told all that was prepared, and may improve it.
    When what was prepared has been answered, the thread calls `catch_up`; when all is prepared, `look`; and when the
    cycle then goes on for a while, `foresee`, with a function that tells when it has ended.
    """

    def __init__(
        self, shift: Shift, adviser: Adviser, search: Callable[[Sequence[Task]], None] = lambda _: None
    ) -> None:
        self._shift, self.adviser, self._search = shift, adviser, search
        self.catch_up: Callable[[], None] = lambda: None
        self.look: Callable[[], object] = lambda: None
        self.foresee: Callable[[Callable[[], bool]], None] = lambda _: None
        self._is_answered = self._is_looking = False
        self._ready: dict[str | None, Prepared] = {}
        # what is prepared for, None for nothing, and how much of it was begun with
        self._cycle: tuple[Belief, int, str] | None = None
        self._begun = 0
        self._round = 0
        self._seen = (None, *shift.scenario.model.observations)
        self._is_open = True
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="fatplan table", daemon=True)
        self._thread.start()

    def prepare(self, belief: Belief, cycle: int, action: str) -> None:
        """Begin with what may follow this cycle, and forget what was prepared before."""
        with self._changed:
            self._ready = {}
            self._cycle, self._begun = (belief, cycle, action), 0
            self._round += 1
            self._changed.notify_all()

    def answered(self) -> None:
        """What was taken has been answered: `catch_up` is to prepare what may follow."""
        with self._changed:
            self._ready, self._cycle = {}, None
            self._round += 1
            self._is_answered = True
            self._changed.notify_all()

    def take(self, cycle: int, executed: str, observation: str | None) -> Prepared | None:
        """What was prepared for this end of a cycle, if it is ready."""
        with self._changed:
            if self._cycle is None or self._cycle[1:] != (cycle, executed):
                return None
            return self._ready.get(observation)

    def improve(self, task: Task, choice: Choice) -> bool:
        """Take what a search has found; whether that was of use: it is not if the cycle has ended."""
        with self._changed:
            if task.number != self._round or task.observation not in self._ready:
                return False
            self._ready[task.observation] = replace(self._ready[task.observation], choice=choice)
            return True

    def wait(self, timeout_s: float) -> bool:
        """Wait until everything is prepared and looked at; whether it is."""
        with self._changed:
            return self._changed.wait_for(self._is_done, timeout_s)

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._is_open, self._cycle, self._is_answered = False, None, False
            self._changed.notify_all()
        self._thread.join()

    def _work(self) -> None:
        work_beside()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_answered or self._is_todo() or not self._is_open)
                if not self._is_open:
                    return
                is_answered = self._is_answered
                if not is_answered:
                    assert self._cycle is not None
                    (belief, cycle, action), number, adviser = self._cycle, self._round, self.adviser
                    seen = self._seen[self._begun]
                    self._begun += 1
            if is_answered:
                self.catch_up()
                with self._changed:
                    self._is_answered = False
                    self._changed.notify_all()
                continue
            if seen is None:
                self._search(())
            event = Observed(cycle=cycle, executed=action, observation=seen)
            after = self._shift.after(belief, event)
            prepared = Prepared(event, after, adviser.choose(after, cycle + 1))
            with self._changed:
                if self._has_ended(number):
                    continue
                self._ready[seen] = prepared
                self._is_looking = not self._is_todo()
                self._changed.notify_all()
                found = [Task(number, cycle + 1, one, entry.belief) for one, entry in self._ready.items()]
            if self._is_looking:
                self._search(found)
                self.look()
                collect_young()
                with self._changed:
                    self._is_looking = False
                    self._changed.notify_all()
                    has_ended = partial(self._has_ended, number)
                    is_idle = not self._changed.wait_for(has_ended, IDLE_S)
                if is_idle:
                    self.foresee(has_ended)

    def _has_ended(self, number: int) -> bool:
        return number != self._round or not self._is_open

    def _is_done(self) -> bool:
        is_ready = len(self._ready) == len(self._seen) and not self._is_looking
        return not self._is_answered and (self._cycle is None or is_ready)

    def _is_todo(self) -> bool:
        return self._cycle is not None and self._begun < len(self._seen)

"""What will be answered: the belief and the decision after every reaction that may be recognised, and after none."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from fatigue_planner.live.events import Observed
from fatigue_planner.live.shift import Adviser, Choice, Shift
from fatigue_planner.pomdp.beliefs.belief import Belief

# A cycle that has gone on for so long after all was prepared leaves time for more.
IDLE_S = 0.05


@dataclass(frozen=True)
class Prepared:
    """The belief after a cycle, and what to do in the next."""

    belief: Belief
    choice: Choice


class Table:
    """Prepares, in a thread of its own, what follows a cycle of planned duration that goes as it was decided.

    Its answers are those that would be computed afterwards: both come from the same functions of the same inputs. Its
    adviser is its own, for policies have working memory. When all is prepared, the thread calls `look`; and when the
    cycle then goes on for a while, `foresee`, with a function that tells when it has ended.
    """

    def __init__(self, shift: Shift, adviser: Adviser) -> None:
        self._shift, self.adviser = shift, adviser
        self.look: Callable[[], object] = lambda: None
        self.foresee: Callable[[Callable[[], bool]], None] = lambda _: None
        self._is_looking = False
        self._ready: dict[Observed, Prepared] = {}
        self._todo: list[Observed] = []
        self._belief: Belief = shift.belief
        self._round = 0
        self._is_open = True
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="fatplan table", daemon=True)
        self._thread.start()

    def prepare(self, belief: Belief, cycle: int, action: str) -> None:
        """Begin with what may follow this cycle, and forget what was prepared before."""
        seen = [None, *belief.model.observations]
        with self._changed:
            self._ready = {}
            self._belief = belief
            self._todo = [Observed(cycle=cycle, executed=action, observation=one) for one in reversed(seen)]
            self._round += 1
            self._changed.notify_all()

    def take(self, event: Observed) -> Prepared | None:
        """What was prepared for this event, if it is ready."""
        if event.likelihood is not None:
            return None
        with self._changed:
            return self._ready.get(event)

    def wait(self, timeout_s: float) -> bool:
        """Wait until everything is prepared and looked at; whether it is."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._todo and not self._is_looking, timeout_s)

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._is_open, self._todo = False, []
            self._changed.notify_all()
        self._thread.join()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._todo or not self._is_open)
                if not self._is_open:
                    return
                event, belief, number = self._todo[-1], self._belief, self._round
            after = self._shift.after(belief, event)
            prepared = Prepared(after, self.adviser.choose(after, event.cycle + 1))
            with self._changed:
                if not self._has_ended(number):
                    self._ready[event] = prepared
                    self._todo.pop()
                    self._is_looking = not self._todo
                    self._changed.notify_all()
            if self._is_looking:
                self.look()
                with self._changed:
                    self._is_looking = False
                    self._changed.notify_all()
                    has_ended = partial(self._has_ended, number)
                    is_idle = not self._changed.wait_for(has_ended, IDLE_S)
                if is_idle:
                    self.foresee(has_ended)

    def _has_ended(self, number: int) -> bool:
        return number != self._round or not self._is_open

"""Whether the model fits a worker: how often he did what it holds impossible, or none of what it knows."""

from collections import deque

from fatigue_planner.live.events import Observed

# Of so many cycles, at most so many may be surprises before the model is said not to fit. Both are assumptions: the
# model holds a surprise impossible, so that with a recogniser that errs in one cycle of twenty, more than 10 surprises
# in 50 cycles have a probability of 3e-5.
WINDOW, MOST = 50, 10


class Fit:
    """The surprises in every worker's last WINDOW cycles of which something was seen."""

    def __init__(self) -> None:
        self._worker = ""
        self._recent: dict[str, deque[bool]] = {}

    def add(self, event: Observed, surprised: bool) -> None:
        """A cycle of this worker has ended."""
        if not (event.is_blind or event.off):
            self._recent.setdefault(self._worker, deque(maxlen=WINDOW)).append(surprised)

    def change(self, worker: str) -> None:
        """From now on another worker, by his random number."""
        self._worker = worker

    def forget(self) -> None:
        """Forget what is known of this worker."""
        self._recent.pop(self._worker, None)

    @property
    def surprises(self) -> int:
        """Of the cycles that are judged, the number of surprises."""
        return sum(self._recent.get(self._worker, ()))

    @property
    def judged(self) -> int:
        """How many cycles are judged: this worker's last ones of which something was seen, WINDOW at most."""
        return len(self._recent.get(self._worker, ()))

    @property
    def holds(self) -> bool:
        """Whether the model fits this worker, as far as is known."""
        return self.surprises <= MOST

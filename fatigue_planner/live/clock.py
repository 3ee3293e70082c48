"""Clocks: time that passed, also while the machine slept, and the time of day for people to read."""

import time
from abc import ABC, abstractmethod
from datetime import UTC, datetime, timedelta
from pathlib import Path

from fatigue_planner.core.errors import EvidenceError, shortened
from fatigue_planner.live.events import ClockSet, Slept

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
MAX_REHEARSAL_S = 366 * 86_400.0
# A clock that is slewed, as NTP does it, has been set when that adds up to so much.
CLOCK_STEP_S = 0.5


class Clock(ABC):
    """Where a session takes its times from; a test or a rehearsal has one of its own.

    >>> class Standing(fp.Clock):
    ...     def seconds(self):
    ...         return 0.0
    ...     def utc(self):
    ...         return datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC)
    ...     def origin(self):
    ...         return "nowhere"
    >>> isinstance(Standing(), fp.Clock)
    True
    """

    @abstractmethod
    def seconds(self) -> float:
        """Seconds since some moment, never set back; they go on while the machine sleeps."""

    @abstractmethod
    def utc(self) -> datetime:
        """The time of day, in UTC, which may be set at any time."""

    @abstractmethod
    def origin(self) -> str:
        """What `seconds` counts from: `seconds` of the same origin can be compared."""

    def slept_s(self) -> float:
        """How many of its seconds the machine has been suspended."""
        return 0.0

    def is_rehearsal(self) -> bool:
        """Whether what it shows is not the time: a journal written by such a clock is marked as a rehearsal's."""
        return True


class SystemClock(Clock):
    """The machine's: CLOCK_BOOTTIME, which also counts the time in suspend (Linux), and the wall clock in UTC."""

    def __init__(self) -> None:
        self._origin = BOOT_ID.read_text(encoding="ascii").strip() if BOOT_ID.is_file() else "unknown"

    def seconds(self) -> float:
        """See Clock.seconds."""
        return time.clock_gettime(time.CLOCK_BOOTTIME)

    def utc(self) -> datetime:
        """See Clock.utc."""
        return datetime.now(UTC)

    def origin(self) -> str:
        """See Clock.origin."""
        return self._origin

    def slept_s(self) -> float:
        """See Clock.slept_s."""
        return time.clock_gettime(time.CLOCK_BOOTTIME) - time.clock_gettime(time.CLOCK_MONOTONIC)

    def is_rehearsal(self) -> bool:
        """See Clock.is_rehearsal."""
        return False


class ClockWatch:
    """Notices that the time of day was set, and that the machine was suspended."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._ahead_s, self._slept_s = clock.utc().timestamp() - clock.seconds(), clock.slept_s()

    def stood(self, seconds: float, utc: str) -> None:
        """What the clock and the time of day showed when it was last looked at."""
        self._ahead_s = datetime.fromisoformat(utc).timestamp() - seconds

    def look(self, seconds: float, utc: datetime) -> list[ClockSet | Slept]:
        """What has happened since it was last asked, or since `stood`, by what the clock and the time of day show."""
        ahead_s, slept_s = utc.timestamp() - seconds, self._clock.slept_s()
        found: list[ClockSet | Slept] = []
        if slept_s - self._slept_s >= CLOCK_STEP_S:
            found.append(Slept(seconds=slept_s - self._slept_s))
            self._slept_s = slept_s
        if abs(ahead_s - self._ahead_s) >= CLOCK_STEP_S:
            found.append(ClockSet(difference_s=ahead_s - self._ahead_s))
            self._ahead_s = ahead_s
        return found


class RehearsalClock(Clock):
    """A clock that stands until it is moved on; it begins on a day on which nobody worked with this program."""

    BEGIN = datetime(2000, 1, 1, 6, tzinfo=UTC)

    def __init__(self, seconds: float = 0.0) -> None:
        self._show(seconds)

    def move(self, seconds: float) -> None:
        """Show so many seconds from now on. Raises EvidenceError for fewer than before, or more than a year."""
        if not self._seconds <= seconds <= MAX_REHEARSAL_S:
            raise EvidenceError(
                f"seconds {shortened(seconds)}: the rehearsal's clock shows {self._seconds:g} and is never set back, "
                f"nor beyond {MAX_REHEARSAL_S:g}."
            )
        self._show(seconds)

    def seconds(self) -> float:
        """See Clock.seconds."""
        return self._seconds

    def utc(self) -> datetime:
        """See Clock.utc."""
        return self._utc

    def origin(self) -> str:
        """See Clock.origin."""
        return "rehearsal"

    def _show(self, seconds: float) -> None:
        self._seconds, self._utc = seconds, self.BEGIN + timedelta(seconds=seconds)

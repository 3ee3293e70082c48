"""Clocks: time that passed, also while the machine slept, and the time of day for people to read."""

import time
from abc import ABC, abstractmethod
from datetime import UTC, datetime
from pathlib import Path

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


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

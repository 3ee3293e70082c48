"""A robot's client: pose number and cycle number go out, and only what the robot echoes counts as delivered."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fatigue_planner.core.errors import SelectionError, listed
from fatigue_planner.live.clients.client import Client
from fatigue_planner.live.clients.connection import Address
from fatigue_planner.live.limits import LATE_CYCLES

# How long a tracker may take after the robot has asked for the next cycle, and how long a robot may say nothing.
GRACE_S = 0.5
SILENCE_S = 60.0
RECONNECT_EVERY_S = 1.0
NO_POSE = 0  # echoed of a cycle in which the robot does nothing


@dataclass(frozen=True)
class Echo:
    """What a robot says: the number of the pose that it executes, of which cycle, and the cycle that it asks for."""

    pose: int
    cycle: int
    asked: int


class RobotLink(ABC):
    """A kind of robot. Nothing it returns or raises is taken for delivery."""

    @abstractmethod
    def connect(self) -> bool:
        """Whether there is a connection now; tried again and again where there is none."""

    @abstractmethod
    def write(self, pose: int, cycle: int) -> None:
        """Send a pose number, then the cycle's."""

    @abstractmethod
    def read(self) -> Echo | None:
        """What the robot says now; None if it says nothing new any more."""

    @abstractmethod
    def close(self) -> None:
        """Let go of it."""


class RobotClient(Client):
    """Tells a robot the poses, and the face what the robot does.

    poses: the actions by number, from 1: those taught in the robot. grace_s: how long the tracker is waited for when
    the robot asks for the next cycle. silence_s: after how long without an echo it counts as unreachable.
    """

    def __init__(
        self,
        address: Address,
        link: RobotLink,
        poses: Sequence[str],
        say: Callable[[str], None] = lambda _: None,
        grace_s: float = GRACE_S,
        silence_s: float = SILENCE_S,
    ) -> None:
        super().__init__(address, say)
        self._link, self._poses = link, tuple(poses)
        self._grace_s, self._silence_s = grace_s, silence_s
        self._is_connected, self._tried_s = False, -RECONNECT_EVERY_S
        self._written: tuple[int, int] | None = None
        self._heard, self._cycle = 0, 0  # the last cycle echoed, and the one going on
        self._since_s = self._asked_s = 0.0
        self._is_silent = False
        self._odd: Echo | None = None

    def check(self, actions: tuple[str, ...], reactions: tuple[str, ...]) -> None:
        """See Client.check: every action must have been taught."""
        del reactions
        missing = [name for name in actions if name not in self._poses]
        if missing or len(set(self._poses)) < len(self._poses):
            raise SelectionError(
                f"poses {listed(self._poses)}: should name every action of the experiment once, each at the number "
                f"that it has in the robot's program; the experiment has {listed(actions)}."
            )

    def look(self, cycle: int, action: str) -> None:
        """See Client.look."""
        now_s = time.monotonic()
        if cycle != self._cycle:
            if self._cycle > 0 and self._heard < self._cycle == cycle - 1:
                self._unreachable(cycle)
            if cycle < self._cycle:  # another shift
                self._heard, self._written, self._odd, self._is_silent = 0, None, None, False
            self._cycle, self._since_s, self._asked_s = cycle, now_s, 0.0
        if not self._connected(now_s):
            self._unreachable(cycle)
            return
        wanted = self._poses.index(action) + 1, cycle
        if wanted != self._written:
            self._link.write(*wanted)
            self._written = wanted
        echo = self._link.read()
        if echo is None:
            self._is_connected, self._written = False, None
            self._unreachable(cycle)
            return
        self._hear(echo, cycle)
        if self._heard < cycle and now_s - self._since_s > self._silence_s:
            self._unreachable(cycle)
        if echo.asked == cycle + 1 and self._heard == cycle:
            self._asked_s = self._asked_s or now_s
            if now_s - self._asked_s >= self._grace_s:
                if echo.pose == NO_POSE:
                    self.tell("skip", cycle=cycle)
                else:
                    self.tell("decide", cycle=cycle + 1)

    def close_device(self) -> None:
        """See Client.close_device."""
        self._link.close()

    def _connected(self, now_s: float) -> bool:
        if not self._is_connected and now_s - self._tried_s >= RECONNECT_EVERY_S:
            self._tried_s = now_s
            self._is_connected, self._written = self._link.connect(), None
        return self._is_connected

    def _hear(self, echo: Echo, cycle: int) -> None:
        """Believe what can be: a known pose, of this cycle or of one that has just ended."""
        if echo.cycle == self._heard and not self._is_silent:
            return
        if (echo.pose, echo.cycle) == (0, 0):
            return  # a program that has not begun
        known = NO_POSE <= echo.pose <= len(self._poses)
        if not known or not max(cycle - LATE_CYCLES, 1) <= echo.cycle <= cycle:
            if echo != self._odd:
                self._odd = echo
                self.ignore(f"the robot says pose {echo.pose} of cycle {echo.cycle}, which cannot be")
            return
        if echo.cycle < self._heard or (self._is_silent and echo.cycle == self._heard < cycle):
            return
        self._heard = echo.cycle
        if self._is_silent:
            self._is_silent = False
            self.say("the robot answers again")
        if echo.pose != NO_POSE:
            self.tell("executed", cycle=echo.cycle, action=self._poses[echo.pose - 1])

    def _unreachable(self, cycle: int) -> None:
        if not self._is_silent:
            self._is_silent = True
            self.say("robot unreachable: it does not say what it does")
            self.tell("executed", cycle=cycle)

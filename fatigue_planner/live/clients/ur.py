"""Universal Robots: poses by RTDE, through general-purpose integer registers that the robot's program reads and writes.

Out: 42 the pose's number, then 43 the cycle's. Back: 36 the number of the pose that is executed, 37 its cycle's, 38 the
cycle that the program asks for. ur_rtde itself uses 47. Nothing else is written: no motion, no speed, no stop cleared.
"""

import json
import os
import select
import subprocess
import sys
import time
from contextlib import suppress

from fatigue_planner.live.clients.robot import Echo, RobotLink

# How long a controller may take to answer, and how long its own clock may stand.
CONNECT_WAIT_S = 5.0
STALE_S = 1.0
CHUNK_BYTES = 1 << 16


class UrLink(RobotLink):
    """A controller at an address, by a process that is killed and started anew when it says nothing."""

    def __init__(self, host: str) -> None:
        self._host = host
        self._process: subprocess.Popen[bytes] | None = None
        self._rest = b""
        self._echo: Echo | None = None
        self._timestamp_s, self._moved_s = -1.0, 0.0

    def connect(self) -> bool:
        """See RobotLink.connect. The recipes are set up anew each time."""
        self.close()
        command = [sys.executable, "-m", "fatigue_planner.live.clients.ur_process", self._host]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
        )
        self._rest, self._echo, self._timestamp_s = b"", None, -1.0
        until_s = time.monotonic() + CONNECT_WAIT_S
        while self._echo is None and self._process.poll() is None and time.monotonic() < until_s:
            self._receive(until_s - time.monotonic())
        return self._echo is not None

    def write(self, pose: int, cycle: int) -> None:
        """See RobotLink.write."""
        assert self._process is not None
        assert self._process.stdin is not None
        with suppress(OSError):
            os.write(self._process.stdin.fileno(), json.dumps([pose, cycle]).encode() + b"\n")

    def read(self) -> Echo | None:
        """See RobotLink.read."""
        self._receive(0.0)
        return self._echo if time.monotonic() - self._moved_s < STALE_S else None

    def close(self) -> None:
        """See RobotLink.close."""
        if self._process is not None:
            self._process.kill()
            with self._process:
                self._process = None

    def _receive(self, wait_s: float) -> None:
        """Take what the process has said; an echo is new if the controller's clock has moved."""
        assert self._process is not None
        assert self._process.stdout is not None
        while select.select([self._process.stdout], [], [], wait_s)[0]:
            said = os.read(self._process.stdout.fileno(), CHUNK_BYTES)
            if not said:
                self._moved_s = 0.0
                return
            *lines, self._rest = (self._rest + said).split(b"\n")
            for line in lines:
                try:
                    timestamp_s, pose, cycle, asked = json.loads(line)
                except ValueError:
                    continue
                if timestamp_s != self._timestamp_s:
                    self._timestamp_s, self._moved_s = timestamp_s, time.monotonic()
                self._echo = Echo(pose, cycle, asked)
            wait_s = 0.0

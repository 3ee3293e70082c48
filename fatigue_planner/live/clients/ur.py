"""Universal Robots: poses by RTDE, through general-purpose integer registers that the robot's program reads and writes.

Out: 42 the pose's number, then 43 the cycle's. Back: 36 the number of the pose that is executed, 37 its cycle's, 38 the
cycle that the program asks for. ur_rtde itself uses 47. Nothing else is written: no motion, no speed, no stop cleared.
"""

import ctypes
import time
from contextlib import suppress
from typing import Any

from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

from fatigue_planner.live.clients.robot import Echo, RobotLink

POSE, CYCLE = 42, 43
# ur_rtde 1.6.5 reads 36 to 43, whatever its documentation says.
ECHOED = (36, 37, 38)
READ = ["timestamp", *(f"output_int_register_{number}" for number in ECHOED)]
FREQUENCY_HZ = 50.0
# A controller whose own clock stands for so long is off, whatever the library says of the connection.
STALE_S = 1.0


class UrLink(RobotLink):
    """A controller at an address, by ur_rtde."""

    def __init__(self, host: str) -> None:
        self._host = host
        self._receive: Any = None
        self._send: Any = None
        self._timestamp_s, self._moved_s = -1.0, 0.0

    def connect(self) -> bool:
        """See RobotLink.connect. The recipes are set up anew each time."""
        try:
            if self._receive is None:
                self._receive = _kept(RTDEReceiveInterface(self._host, FREQUENCY_HZ, READ, False, True))
            else:
                self._receive.reconnect()
            if self._send is None:
                self._send = _kept(RTDEIOInterface(self._host, False, True))
            else:
                self._send.reconnect()
        except RuntimeError:
            return False
        self._timestamp_s, self._moved_s = -1.0, time.monotonic()
        return True

    def write(self, pose: int, cycle: int) -> None:
        """See RobotLink.write."""
        with suppress(RuntimeError):
            self._send.setInputIntRegister(POSE, pose)
            self._send.setInputIntRegister(CYCLE, cycle)

    def read(self) -> Echo | None:
        """See RobotLink.read."""
        try:
            timestamp_s = self._receive.getTimestamp()
            values = [self._receive.getOutputIntRegister(number) for number in ECHOED]
            alive = self._receive.isConnected()
        except RuntimeError:
            return None
        now_s = time.monotonic()
        if timestamp_s != self._timestamp_s:
            self._timestamp_s, self._moved_s = timestamp_s, now_s
        return Echo(*values) if alive and now_s - self._moved_s < STALE_S else None

    def close(self) -> None:
        """See RobotLink.close."""
        for one in (self._receive, self._send):
            with suppress(RuntimeError):
                if one is not None:
                    one.disconnect()


def _kept(interface: Any) -> Any:
    """An interface that is never destroyed: ur_rtde 1.6.5 aborts the process if its connection is broken then."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(interface))
    return interface

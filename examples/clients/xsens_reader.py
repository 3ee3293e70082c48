"""A reader of Xsens MVN datagrams (UDP, type 02: positions and quaternions of 23 segments) that says what it saw.

Which posture means which reaction is yours to measure: the angles here are an example, no finding.
"""

import socket
import time

import numpy as np
from face import tried

HEADER_BYTES, SEGMENT = 24, np.dtype([("id", ">i4"), ("position_m", ">f4", 3), ("quaternion", ">f4", 4)])
PELVIS, T8 = 1, 5
STRAIGHT_DEG, BENT_DEG = 20.0, 45.0  # below, surely from the arm; above, surely from the back


def trunk_deg(datagram: bytes) -> float | None:
    """How far the trunk leans in a datagram; None for another kind of datagram, or half a one."""
    if datagram[:6] != b"MXTP02" or len(datagram) < HEADER_BYTES + T8 * SEGMENT.itemsize:
        return None
    segments = {int(one["id"]): one["position_m"] for one in np.frombuffer(datagram, SEGMENT, T8, HEADER_BYTES)}
    trunk = segments[T8] - segments[PELVIS] if {PELVIS, T8} <= segments.keys() else np.zeros(3)
    length = float(np.linalg.norm(trunk))
    return float(np.degrees(np.arccos(trunk[2] / length))) if 0.1 < length < 1 else None


def follow(datagrams: socket.socket) -> None:
    """Watch cycle after cycle; the robot asks for the next one, and what was seen of the last is told late."""
    cycle, most_deg, asked_s = 0, None, 0.0  # it is within no cycle yet
    while True:
        lean_deg = trunk_deg(datagrams.recv(2048))
        if lean_deg is not None:
            most_deg = max(lean_deg, most_deg or 0.0)
        if time.monotonic() - asked_s > 0.5:
            decision, asked_s = tried("decide"), time.monotonic()
            now = decision["cycle"] if decision else cycle
            if now == cycle + 1 > 1 and most_deg is not None:
                back = float(np.clip((most_deg - STRAIGHT_DEG) / (BENT_DEG - STRAIGHT_DEG), 0.05, 0.95))
                tried("observe", cycle=cycle, likelihood={"back": back, "arm": 1 - back})
            if now != cycle:
                cycle, most_deg = now, None


if __name__ == "__main__":
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
        listening.bind(("", 9763))
        follow(listening)

"""The process that searches: beliefs come on standard input, decisions go out as lines of JSON.

It is nobody's last resort: it may be ended at any moment, and gives way to whoever answers the robot.
"""

import io
import json
import os
import pickle
import signal
import sys
from collections.abc import Iterator
from typing import Any, BinaryIO

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.problem import Pomdp

NICENESS = 10
LENGTH_BYTES = 8
# In the place of the problem, which the process knows.
PROBLEM = "problem"


def sized(message: bytes) -> bytes:
    """A message with its length before it."""
    return len(message).to_bytes(LENGTH_BYTES) + message


def plain(belief: Belief, what: tuple[int, int, str | None], problem: Pomdp) -> bytes:
    """A belief without the problem, which the process knows, and what it is for: number, cycle and observation."""

    class Writer(pickle.Pickler):
        def persistent_id(self, value: object) -> str | None:
            return PROBLEM if value is problem else None

    out = io.BytesIO()
    Writer(out, pickle.HIGHEST_PROTOCOL).dump((what, belief))
    return out.getvalue()


def restored(message: bytes, problem: Pomdp) -> tuple[tuple[int, int, str | None], Belief]:
    """What `plain` was given."""

    class Reader(pickle.Unpickler):
        def persistent_load(self, name: object) -> Any:
            assert name == PROBLEM
            return problem

    return Reader(io.BytesIO(message)).load()  # type: ignore[no-any-return]


def messages(stream: BinaryIO) -> Iterator[bytes]:
    """The messages of a stream, until it ends."""
    while length := stream.read(LENGTH_BYTES):
        yield stream.read(int.from_bytes(length))


def main() -> None:
    """Search from one belief after the other until there are no more."""
    for stop in (signal.SIGINT, signal.SIGTERM):
        signal.signal(stop, signal.SIG_IGN)  # it ends when its session does
    os.nice(NICENESS)
    coming = messages(sys.stdin.buffer)
    scenario, settings, session = pickle.loads(next(coming))
    policy = settings.build()
    for message in coming:
        (number, cycle, observation), belief = restored(message, scenario.model)
        said: dict[str, object] = {"number": number}
        try:
            rng = random_stream(0, "live search", session, cycle, observation or "")
            decision = policy.act(belief, rng)
            said |= {"action": int(decision.action), "reason": decision.reason}
        except (FatplanError, ArithmeticError, ValueError) as error:
            said["failed"] = f"the search failed: {error}"
        os.write(sys.stdout.fileno(), json.dumps(said).encode() + b"\n")


if __name__ == "__main__":
    main()

"""A shift beside a robot: times of answers in a session and over HTTP, of a resumed journal, and what grows.

Wall-clock times here are what a robot sees; they depend on what else the machine does, so its load is printed.
"""

import http.client
import itertools
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

import fatigue_planner as fp

CYCLES, LONG = 10_000, 27_000
# One cycle of 25 is not seen.
SEEN = (*("arm", "back", "arm", "back") * 6, None)
CYCLE_S = 16.0
DEADLINE_S = 0.05


class SimulatedClock(fp.Clock):
    """A clock that a rehearsal moves."""

    now_s = 0.0

    def seconds(self) -> float:
        return self.now_s

    def utc(self) -> datetime:
        return datetime(2026, 1, 1, tzinfo=UTC)

    def origin(self) -> str:
        return "simulated"


def told(what: str, times_s: list[float]) -> None:
    """Quantiles of times."""
    ms = 1e3 * np.array(times_s)
    p50, p99, p999 = np.quantile(ms, (0.5, 0.99, 0.999))
    late = int((ms > 1e3 * DEADLINE_S).sum())
    print(f"{what}: p50 {p50:.3f}, p99 {p99:.3f}, p99.9 {p999:.3f}, max {ms.max():.3f} ms; {late} of {ms.size} late")


def in_a_session(folder: Path, scenario: fp.Scenario) -> None:
    """Answers that were prepared, and the first and the last tenth of a long shift."""
    clock, seen = SimulatedClock(), itertools.cycle(SEEN)
    times: list[float] = []
    with fp.Session.open(folder / "session", scenario, clock=clock) as session:
        decision = session.decide()
        for _ in range(CYCLES):
            session._table.wait(10)
            clock.now_s += CYCLE_S
            begin = time.perf_counter()
            decision = session.observe(decision.cycle, observation=next(seen))
            times.append(time.perf_counter() - begin)
    told(f"prepared, {CYCLES} cycles", times)
    begin = time.perf_counter()
    with fp.Session.open(folder / "long", scenario, clock=clock) as session:
        print(f"session opened, warm: {time.perf_counter() - begin:.2f} s")
        decision = session.decide()
        tenths = []
        for number in range(LONG):
            if number % (LONG // 10) == 0:
                tenths.append((time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
            clock.now_s += CYCLE_S
            decision = session.observe(decision.cycle, observation=next(seen))
        tenths.append((time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
    per_tenth = np.diff([spent for spent, _ in tenths])
    print(
        f"{LONG} cycles: last tenth against first {per_tenth[-1] / per_tenth[0]:.2f} x CPU; "
        f"memory {tenths[1][1]:.0f} to {tenths[-1][1]:.0f} MB"
    )


def resumed(folder: Path, scenario: fp.Scenario) -> None:
    """A journal of 12 hours is opened again."""
    clock, seen = SimulatedClock(), itertools.cycle(SEEN)
    with fp.Session.open(folder / "resumed", scenario, clock=clock) as session:
        decision = session.decide()
        for _ in range(2700):
            clock.now_s += CYCLE_S
            decision = session.observe(decision.cycle, observation=next(seen))
        digest = session.digest()
    begin = time.perf_counter()
    with fp.Session.open(folder / "resumed", scenario, clock=clock) as session:
        took = time.perf_counter() - begin
        assert session.digest() == digest
    print(f"resumed after 2,700 cycles: {took:.2f} s, the same belief")


def over_http(folder: Path) -> None:
    """Observation sent, decision received, on one connection."""
    command = [sys.executable, "-m", "fatigue_planner", "live", "serve", "paper", "--condition", "multiple_novice"]
    command += ["--journal", str(folder / "http"), "--port", "0", "--cache", str(folder / "cache")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        found = re.match(r"http://127\.0\.0\.1:(\d+)/", server.stdout.readline())
        assert found
        token = (folder / "http.act-token").read_text().strip()
        connection = http.client.HTTPConnection("127.0.0.1", int(found[1]), timeout=30)
        headers = {"Authorization": f"Bearer {token}"}

        def ask(path: str, body: dict[str, object]) -> dict[str, int]:
            connection.request("POST", path, json.dumps(body), headers)
            return dict(json.loads(connection.getresponse().read()))

        for _ in range(50):
            try:
                decision = ask("/v1/decide", {})
                break
            except ConnectionRefusedError:
                time.sleep(0.1)
        times, seen = [], itertools.cycle(SEEN)
        for _ in range(CYCLES):
            begin = time.perf_counter()
            decision = ask("/v1/observe", {"cycle": decision["cycle"], "observation": next(seen)})
            times.append(time.perf_counter() - begin)
        server.terminate()
    told(f"over HTTP, {CYCLES} cycles", times)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(f"load {os.getloadavg()[0]:.1f}")
        experiment = fp.load("paper")
        scenario = fp.scenario(experiment, fp.simulate(experiment, folder / "cache"), "multiple_novice")
        in_a_session(folder, scenario)
        resumed(folder, scenario)
        over_http(folder)
        print(f"load {os.getloadavg()[0]:.1f}")

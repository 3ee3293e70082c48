"""A shift beside a robot: times of answers in a session and over HTTP, under load and with real-time priority; what
grows in a long shift; how long it takes to start and to resume.

Wall-clock times here are what a robot sees; they depend on what else the machine does, so its load is printed.

    python perf/live.py                 all of it
    python perf/live.py http --load 12  one part, beside so many processes that compute
"""

import argparse
import gc
import http.client
import itertools
import json
import multiprocessing
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

import fatigue_planner as fp
from fatigue_planner.live.clock import RehearsalClock
from fatigue_planner.live.realtime import answer_first

CYCLES, LONG, LOOP = 10_000, 27_000, 600
# One cycle of 25 is not seen.
SEEN = (*("arm", "back", "arm", "back") * 6, None)
CYCLE_S = 16.0
DEADLINE_S = 0.05


def told(what: str, times_s: list[float]) -> None:
    """Quantiles of times."""
    ms = 1e3 * np.array(times_s)
    p50, p99, p999 = np.quantile(ms, (0.5, 0.99, 0.999))
    late = int((ms > 1e3 * DEADLINE_S).sum())
    print(f"{what}: p50 {p50:.3f}, p99 {p99:.3f}, p99.9 {p999:.3f}, max {ms.max():.3f} ms; {late} of {ms.size} late")


def worked(
    session: fp.Session,
    clock: RehearsalClock,
    count: int,
    seen: Iterator[str | None],
    first: Callable[[], object] | None = None,
) -> list[float]:
    """Work cycles as a robot does; the times of the answers, or of what is done `first` at the end of each cycle.

    A cycle takes seconds: when the robot asks, everything has been prepared, and what was said before is on the disk.
    """
    times, decision = [], session.decide()
    for _ in range(count):
        assert session._table.wait(60) and session._journal.wait(session._recorded, 60)
        clock.move(clock.seconds() + CYCLE_S)
        one = next(seen)
        begin = time.perf_counter()
        if first is not None:
            first()
            times.append(time.perf_counter() - begin)
        decision = session.observe(decision.cycle, observation=one)
        if first is None:
            times.append(time.perf_counter() - begin)
    return times


def bare_loop() -> int:
    """As much work as a prepared answer, in a single loop: what is the machine's."""
    return sum(number * number for number in range(LOOP))


def prepared(folder: Path, scenario: fp.Scenario) -> None:
    """Answers that were prepared, with real-time priority for them where that is permitted."""
    clock = RehearsalClock()
    with fp.Session.open(folder / "prepared", scenario, clock=clock) as session:
        told(f"prepared, {CYCLES} cycles", worked(session, clock, CYCLES, itertools.cycle(SEEN)))
        told("  a bare loop instead", worked(session, clock, CYCLES, itertools.cycle(SEEN), bare_loop))


def long_shift(folder: Path, scenario: fp.Scenario) -> None:
    """The first and the last tenth of a long shift."""
    clock, seen = RehearsalClock(), itertools.cycle(SEEN)
    begin = time.perf_counter()
    with fp.Session.open(folder / "long", scenario, clock=clock) as session:
        print(f"session opened, warm: {time.perf_counter() - begin:.2f} s")
        tenths, memory, spent = [], [], [time.process_time()]
        for _ in range(10):
            tenths.append(worked(session, clock, LONG // 10, seen))
            memory.append(resident_mb())
            spent.append(time.process_time())
    cpu = np.diff(spent)
    print(
        f"{LONG} cycles, last tenth against first: {cpu[-1] / cpu[0]:.2f} x CPU; of all {np.round(cpu, 1).tolist()} s"
    )
    print(f"  memory {memory[0]:.1f} to {memory[-1]:.1f} MB")
    told("  first tenth", tenths[0])
    told("  last tenth", tenths[-1])


def resident_mb() -> float:
    """Memory that this process has."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


def resumed(folder: Path, scenario: fp.Scenario) -> None:
    """A journal of 12 hours is opened again."""
    clock = RehearsalClock()
    with fp.Session.open(folder / "resumed", scenario, clock=clock) as session:
        worked(session, clock, 2700, itertools.cycle(SEEN))
        digest = session.digest()
    begin = time.perf_counter()
    with fp.Session.open(folder / "resumed", scenario, clock=clock) as session:
        took = time.perf_counter() - begin
        assert session.digest() == digest
    print(f"resumed after 2,700 cycles: {took:.2f} s, the same belief")


class Served:
    """A server, and a client that keeps its connection."""

    def __init__(self, folder: Path, name: str, *options: str, **environment: str) -> None:
        self.begin = time.perf_counter()
        command = [sys.executable, "-m", "fatigue_planner", "live", "serve", "paper", "--condition", "multiple_novice"]
        command += ["--journal", str(folder / name), "--port", "0", "--cache", str(folder / "cache"), *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | environment)
        assert self.process.stdout is not None
        found = re.match(r"http://127\.0\.0\.1:(\d+)/", self.process.stdout.readline())
        assert found
        self._headers = {"Authorization": f"Bearer {(folder / f'{name}.act-token').read_text().strip()}"}
        self._connection = http.client.HTTPConnection("127.0.0.1", int(found[1]), timeout=60)
        self.waited: dict[str, float] = {}
        while True:
            try:
                self.first = self.ask("/v1/decide", {})
                break
            except ConnectionRefusedError:
                self._connection.close()
                time.sleep(0.01)
        self.started_s = time.perf_counter() - self.begin

    def ask(self, path: str, body: dict[str, object]) -> dict[str, int]:
        begin = time.perf_counter()
        self._connection.request("POST", path, json.dumps(body | self.waited), self._headers)
        answer = dict(json.loads(self._connection.getresponse().read()))
        self.waited["waited_s"] = time.perf_counter() - begin
        return answer

    def state(self) -> dict[str, dict[str, int]]:
        self._connection.request("GET", "/v1/state", headers=self._headers)
        return dict(json.loads(self._connection.getresponse().read()))

    def __enter__(self) -> "Served":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(60)


def start(folder: Path, _: fp.Scenario) -> None:
    """From the command to the first decision, with nothing compiled before and with everything."""
    with tempfile.TemporaryDirectory() as empty:
        for what in ("cold", "warm"):
            with Served(folder, what, XDG_CACHE_HOME=empty) as server:
                print(f"command to first decision, {what}: {server.started_s:.1f} s")


def over_http(folder: Path, _: fp.Scenario) -> None:
    """Observation sent, decision received, on one connection; without and with real-time priority."""
    for options in ((), ("--realtime",)):
        with Served(folder, f"http{len(options)}", *options) as server:
            if options and (refused := answer_first()):  # the client, too, stands for a robot's program
                print(f"over HTTP, real time: {refused}")
                return
            gc.freeze()  # a robot's program does not look for garbage in what is loaded here
            times, seen, decision = [], itertools.cycle(SEEN), server.first
            for _number in range(CYCLES):
                decision = server.ask("/v1/observe", {"cycle": decision["cycle"], "observation": next(seen)})
                times.append(server.waited["waited_s"])
            server.ask("/v1/decide", {})  # says how long the last one took
            told(f"over HTTP, {CYCLES} cycles{', real time' if options else ''}", times)
            counts = server.state()["counts"]
            print(f"  counted and shown: {counts['came_late']} came late; {counts['late']} were decided late")


def compute() -> None:
    """Do nothing useful, for ever."""
    while True:
        sum(range(10_000))


@contextmanager
def load(processes: int) -> Iterator[None]:
    """Beside so many processes that compute."""
    busy = [multiprocessing.get_context("spawn").Process(target=compute, daemon=True) for _ in range(processes)]
    for one in busy:
        one.start()
    time.sleep(3 if processes else 0)
    try:
        yield
    finally:
        for one in busy:
            one.kill()


PARTS = {"start": start, "prepared": prepared, "long": long_shift, "resumed": resumed, "http": over_http}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", default=list(PARTS), help=f"of {', '.join(PARTS)}; default: all")
    parser.add_argument("--load", type=int, default=0, help="processes that compute beside it")
    given = parser.parse_args()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        experiment = fp.load("paper")
        task = fp.scenario(experiment, fp.simulate(experiment, folder / "cache"), "multiple_novice")
        stack.enter_context(load(given.load))
        for part in given.parts:
            print(f"load {os.getloadavg()[0]:.1f}, {given.load} processes beside it", flush=True)
            PARTS[part](folder, task)

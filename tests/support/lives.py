"""A shift that is killed again and again: every life is a fork of one process that has compiled everything."""

import json
import os
import pickle
import select
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from planting import program
from shifts import World

# A journal that has become long is slow to resume; so many lives go on with one.
LIVES_PER_JOURNAL = 50
# Of a life; the first waits until everything is compiled.
LONGEST_S = 240.0
PROGRAM = """
import json, os, pickle, sys, traceback
from pathlib import Path
import fatigue_planner as fp

def live(path, scenario):
    session = fp.Session.open(path, scenario, deadline_s=10)
    say = lambda *words: os.write(1, (json.dumps(words) + "\\n").encode())
    say("journal", session._journal._process.pid)
    while True:
        decision = session.decide()
        say("decided", decision.cycle, decision.action)
        seen = ["arm", "back", None][decision.cycle % 3]
        decision = session.observe(decision.cycle, observation=seen)
        if session._journal.wait(decision.recorded, 30):
            say("durable", decision.cycle, session.digest())

scenario = pickle.load(open(sys.argv[1], "rb"))
with fp.Session.open(sys.argv[2], scenario, deadline_s=10) as session:
    session.decide()
for line in sys.stdin:
    child = os.fork()
    if not child:
        try:
            live(line.rstrip("\\n"), scenario)
        finally:
            traceback.print_exc()
            os._exit(1)
    os.write(1, (json.dumps(["born", child]) + "\\n").encode())
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    os.write(1, (json.dumps(["died", status]) + "\\n").encode())
"""


@dataclass
class Found:
    """How many lives were killed, and how often one had said that a cycle was durable."""

    kills: int = 0
    durable: int = 0


def lived(world: World, kills: int) -> Found:
    """Kill a shift at random moments, some together with the process that writes; check what the next life finds."""
    task = world.folder / "task"
    task.write_bytes(pickle.dumps(world.scenario))
    text = (program(world.fault) if world.fault else "") + PROGRAM
    command = [sys.executable, "-c", text, str(task), str(world.folder / "first")]
    helper = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0)
    try:
        return _killed(helper, world.folder, kills)
    finally:
        helper.kill()
        helper.communicate()


def _killed(helper: "subprocess.Popen[bytes]", folder: Path, kills: int) -> Found:
    rng, found = np.random.default_rng(14), Found()
    digests: dict[int, str] = {}
    actions: dict[int, str] = {}
    last = 0
    while found.kills < kills:
        if found.kills % LIVES_PER_JOURNAL == 0:
            digests, actions, last = {}, {}, 0
        path = folder / f"shift {found.kills // LIVES_PER_JOURNAL}"
        said = _life(helper, path, bool(rng.integers(2)), float(rng.uniform(0, 0.3)), bool(rng.integers(3) == 0))
        found.kills += 1
        first = next((words for words in said if words[0] == "decided"), None)
        if first is not None:  # a life that came so far goes on where what was durable ended, or later
            assert first[1] >= last, (first, last)
        for kind, *words in said:
            if kind == "durable":
                last = int(words[0])
                found.durable += 1
                assert digests.setdefault(last, words[1]) == words[1], last
            elif kind == "decided":
                assert actions.setdefault(words[0], words[1]) == words[1], words
    return found


def _life(
    helper: "subprocess.Popen[bytes]", path: Path, waits: bool, after_s: float, writer_too: bool
) -> list[list[object]]:
    """One life, killed after a time from its birth, or from when something was durable; what it said."""
    assert helper.stdin is not None and helper.stdout is not None
    helper.stdin.write(f"{path}\n".encode())
    said: list[list[object]] = []
    rest = b""

    def read(until: float) -> None:
        nonlocal rest
        while (left := until - time.monotonic()) > 0:
            ready, _, _ = select.select([helper.stdout], [], [], left)
            if not ready:
                return
            part = os.read(helper.stdout.fileno(), 1 << 16)
            assert part, "the program that is forked has ended"
            *lines, rest = (rest + part).split(b"\n")
            said.extend(json.loads(line) for line in lines)
            if any(words[0] in kinds for words in said):
                return

    end = time.monotonic() + LONGEST_S
    kinds = {"born", "died"}
    read(end)
    kinds = {"durable", "died"} if waits else set()
    read(end if waits else time.monotonic() + after_s)
    kinds = {"died"}
    if waits:
        read(time.monotonic() + after_s / 6)
    pids = {str(words[0]): int(str(words[1])) for words in said if words[0] in {"born", "journal"}}
    assert "died" not in {words[0] for words in said}, said
    if writer_too and "journal" in pids:
        os.kill(pids["journal"], signal.SIGKILL)
    os.kill(pids["born"], signal.SIGKILL)
    read(end)
    assert said[-1] == ["died", -signal.SIGKILL], said[-1]
    return said

"""Ctrl-C and termination: once in good order, with what is kept and the command that goes on; twice at once."""

import json
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import FATPLAN, finished, listens, process
from conftest import PAPER, ROOT

from fatigue_planner import __version__

SIGNALS = [(signal.SIGINT, 130), (signal.SIGTERM, 143)]
ADVICE = re.compile(r"Stopped\. (?P<kept>.+) Continue with: (?P<command>fatplan .+)\n$")
STOPPING = "Stopping after the work in progress (once more to stop at once) ...\n"
TABLES = ("trials.csv", "actions.csv", "comparison.csv", "contrasts.csv", "summary.txt", "manifest.json", "regret.csv")


def stopped(running: subprocess.Popen[str], number: int, code: int) -> str:
    """Send one signal; what the process says that is kept. It says nothing else, and how to go on."""
    running.send_signal(number)
    out, err = running.communicate(timeout=120)
    assert running.returncode == code, err
    found = ADVICE.fullmatch(err.removeprefix(STOPPING))
    assert found and out == "", err
    assert shlex.split(found["command"]) == ["fatplan", *running.args[len(FATPLAN) :]]
    return found["kept"]


def wait_for(running: subprocess.Popen[str], folder: Path, pattern: str, count: int = 1) -> None:
    while len(list(folder.glob(pattern))) < count:
        assert running.poll() is None
        time.sleep(0.01)


def contents(results: Path) -> dict[str, bytes]:
    return {name: next(results.glob(f"paper_*/{name}")).read_bytes() for name in TABLES}


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_a_benchmark_stops_in_every_stage_and_ends_in_the_same_bytes(
    cache_folder: Path, tmp_path: Path, number: int, code: int
) -> None:
    """While it loads, while it runs, while it judges, while it publishes; each time the same command goes on."""
    grid = ["--cycles", "20", "--conditions", "single_novice", "--policies", "pomcp_0.1", "--policies", "pomcp_0.001"]
    few = [*grid, "--descents", "500", "--trials", "40", "--jobs", "1", "--regret"]
    results = tmp_path / "my results"
    command = ["benchmark", PAPER, "--cache", cache_folder, *few, "--results", results]
    parts = results / "paper" / "parts"

    running = process(*command)
    assert listens(running)
    assert stopped(running, number, code) == "What is finished is kept."
    assert not results.exists()

    running = process(*command)
    wait_for(running, parts, "*/[0-9]*.json")
    assert re.fullmatch(rf"[1-9]\d* of 80 runs are kept in {re.escape(str(parts))}\.", stopped(running, number, code))
    kept = {path: path.read_bytes() for path in parts.glob("*/*.json")}
    assert kept

    running = process(*command)
    wait_for(running, parts, "*/[0-9]*.json", 17)  # 16 of runs, then those of judgements
    assert re.fullmatch(r"[1-9]\d* of 80 judged runs are kept in .+", stopped(running, number, code))
    assert all(path.read_bytes() == content for path, content in kept.items())

    running = process(*command)
    wait_for(running, results, "paper_*/regret.csv")
    if running.poll() is None:
        running.send_signal(number)
        out, err = running.communicate(timeout=120)
        # if the signal comes when everything is written, all is well
        assert (running.returncode == code and ADVICE.fullmatch(err)) or (running.returncode == 0 and out)
    assert not [path for path in results.rglob(".*") if path.is_file()]

    assert finished(*command).returncode == 0
    ended = contents(results)
    shutil.rmtree(results)
    assert finished(*command).returncode == 0
    assert contents(results) == ended


AT_EVERY_LINE = """
import atexit, json, os, signal, sys, tempfile
from fatigue_planner.cli import entry, main
from fatigue_planner.core import interrupts

lines, handled = 0, False

def trace(frame, event, _):
    global lines, handled
    if frame.f_code.co_filename not in (entry.__file__, interrupts.__file__):
        return None
    if event == "line":
        handled = handled or signal.SIG_DFL not in map(signal.getsignal, interrupts.STOPPING)
        lines += handled
        if lines == number > 0:
            signal.raise_signal(signal.SIGTERM)
    return trace

number, last = 0, 1
while number <= last:  # 0: none at a line, only at the end
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        child = os.fork()
        if not child:
            os.dup2(out.fileno(), 1), os.dup2(err.fileno(), 2)
            sys.argv = ["fatplan", "--version"]
            atexit.register(lambda: number or print(lines, file=sys.stderr) or signal.raise_signal(signal.SIGTERM))
            sys.settrace(trace)
            entry.run()
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        end = [code, *(file.seek(0) or file.read() for file in (out, err))]
        if number == 0:
            last = int(end.pop())
        print(json.dumps(end))
        number += 1
"""


def test_from_the_first_handler_to_the_last_line_a_signal_is_never_lost_and_never_kills() -> None:
    """It comes at one line after another, and at last when Python leaves."""
    done = subprocess.run([sys.executable, "-c", AT_EVERY_LINE], capture_output=True, text=True, check=True)
    at_the_end, *ends = [json.loads(line) for line in done.stdout.splitlines()]
    version = f"fatplan {__version__}\n"
    assert at_the_end == [0, version]
    stopped = [143, "Stopped. What is finished is kept. Continue with: fatplan --version\n"]
    for number, (code, out, err) in enumerate(ends, start=1):
        assert [code, err] == stopped or (code, out, err) == (0, version, ""), (number, code, out, err)
    assert sum(code == 143 for code, *_ in ends) > 10


@pytest.mark.slow
def test_a_simulation_is_stopped_and_goes_on(tmp_path: Path) -> None:
    coarse = tmp_path / "coarse.yaml"
    coarse.write_text(PAPER.read_text().replace("time_step_s: 0.01", "time_step_s: 0.02"))
    command = ["simulate", coarse, "--cache", tmp_path / "cache", "--jobs", "1"]
    running = process(*command)
    wait_for(running, tmp_path, "cache/*.h5")
    kept = stopped(running, signal.SIGTERM, 143)
    there = len(list((tmp_path / "cache").glob("*.h5")))
    assert kept == f"{there} of 4 reactions are kept in {tmp_path / 'cache'}."
    done = finished(*command)
    assert done.returncode == 0 and f"{there} found in the cache" in done.stdout


@pytest.mark.slow
def test_a_study_is_stopped_and_goes_on(tmp_path: Path) -> None:
    command = ["sensitivity", ROOT / "experiments" / "sensitivity.yaml", "--cache", tmp_path, "--results", tmp_path]
    running = process(*command)
    wait_for(running, tmp_path, "*.h5")
    assert re.fullmatch(r"[1-9]\d* of \d+ reactions are kept in .+", stopped(running, signal.SIGINT, 130))
    running = process(*command)
    assert listens(running)  # before, while Python starts, no program can
    wait_for(running, tmp_path, "*.h5", 4)
    assert stopped(running, signal.SIGTERM, 143)


def test_a_check_of_the_cache_is_stopped(cache_folder: Path) -> None:
    running = process("cache", "verify", "--cache", cache_folder, "--jobs", "1")
    assert listens(running)
    assert stopped(running, signal.SIGINT, 130)


def test_twice_is_at_once(cache_folder: Path, tmp_path: Path) -> None:
    """The second signal ends even what is in progress; long runs, so that there is some."""
    grid = ["--conditions", "single_novice", "--cycles", "100", "--policies", "pomcp_0.1", "--descents", "200000"]
    running = process("benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path, *grid, "--jobs", "1")
    assert listens(running)
    wait_for(running, tmp_path, "paper/parts")
    time.sleep(1)
    running.send_signal(signal.SIGINT)
    assert running.stderr is not None and running.stderr.readline() == STOPPING
    begin = time.monotonic()
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == -signal.SIGINT and time.monotonic() - begin < 10 and "Traceback" not in err


LOST = """
import os, signal, sys, time
from fatigue_planner.cli.entry import run
import fatigue_planner.core.yaml_reader as yaml_reader
class Destructor:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
def work(*_):
    Destructor()
    time.sleep(30)
yaml_reader.read_yaml = work
run()
"""


def test_a_signal_in_a_destructor_is_not_lost() -> None:
    """Python only prints what is raised there."""
    command = [sys.executable, "-c", LOST, "validate", "x.yaml"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=25)
    assert done.returncode == 143 and ADVICE.fullmatch(done.stderr)


STOPPED_ON_IMPORT = """
import os, signal, sys
class Stopper:
    def find_spec(self, name, *_):
        if name == "fatigue_planner.experiment.schema":
            os.kill(os.getpid(), signal.SIGTERM)
sys.meta_path.insert(0, Stopper())
from fatigue_planner.cli.entry import run
run()
"""


def test_stopped_while_it_loads() -> None:
    command = [sys.executable, "-c", STOPPED_ON_IMPORT, "simulate", "my file.yaml", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 143 and done.stderr.endswith("Continue with: fatplan simulate 'my file.yaml' --json\n")
    assert '"exit_code": 143' in done.stdout and len(done.stderr.splitlines()) == 1

"""The process that reads HDF5: what happens to it does not happen to the process that asks."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from foreign import crafted, packed, small_entry, small_reaction

from fatigue_planner.core import reading_process
from fatigue_planner.core.errors import ReaderError
from fatigue_planner.core.reading_process import UnreadableError
from fatigue_planner.reactions import sandbox
from fatigue_planner.reactions.hdf5_layout import ARRAYS, LAYOUT, read_entry
from fatigue_planner.reactions.sandbox import read_hdf5

ROWS = 50_000
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def slow_content() -> bytes:
    """A file that takes HDF5 a fraction of a second, and 90 MB."""
    return crafted(lambda file: [packed(file, array, ROWS) for array in ARRAYS])


def reader() -> int:
    """The id of the process, which is started if necessary."""
    assert read_entry(small_entry(), "own").digest == small_reaction().digest
    assert sandbox._READER._process is not None
    return sandbox._READER._process.pid


def descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def children() -> list[str]:
    """The state of every child of this process."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = path.read_text().rsplit(")")[1].split()[:2]
        except OSError:
            continue
        found += [state] if int(parent) == os.getpid() else []
    return found


@contextmanager
def while_it_reads(act: Callable[[], object], every_s: float) -> Iterator[None]:
    """Do something again and again meanwhile."""
    done = threading.Event()

    def run() -> None:
        while not done.wait(every_s):
            act()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def kill_in_the_middle(how: int) -> None:
    """End the process if it holds so much that it must be reading."""
    process = sandbox._READER._process
    try:
        pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1]) if process is not None else 0
        if process is not None and pages * os.sysconf("SC_PAGE_SIZE") > 100 * 2**20:
            process.send_signal(how)
    except OSError:  # it has just ended
        pass


def test_a_reader_that_was_killed_is_started_again() -> None:
    for how in (signal.SIGKILL, signal.SIGSEGV):
        old = reader()
        os.kill(old, how)
        assert reader() != old


def test_a_reader_that_dies_of_a_file_twice_is_the_files_fault(slow_content: bytes) -> None:
    sandbox._READER.stop()
    with (
        while_it_reads(lambda: kill_in_the_middle(signal.SIGSEGV), 0.01),
        pytest.raises(UnreadableError, match=r"ends the process that reads it \(-11\)"),
    ):
        read_hdf5(slow_content, LAYOUT)
    reader()


def test_a_reader_that_dies_once_while_it_reads_is_asked_again(slow_content: bytes) -> None:
    old = reader()
    timer = threading.Timer(0.05, os.kill, (old, signal.SIGKILL))
    timer.start()
    assert len(read_hdf5(slow_content, LAYOUT)["torque_nm"]) == ROWS
    timer.join()
    assert reader() != old


def test_a_file_that_takes_too_long_is_refused(slow_content: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    reader()
    monkeypatch.setattr(sandbox, "MAX_SECONDS", 0.05)
    with pytest.raises(UnreadableError, match="takes too long to read"):
        read_hdf5(slow_content, LAYOUT)
    reader()
    monkeypatch.setattr(reading_process, "PATIENCE_S", 0.05)
    with pytest.raises(ReaderError, match="does not start"):
        sandbox._READER.stop()
        reader()
    monkeypatch.undo()
    reader()


def test_a_stopped_reader_is_not_waited_for_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    os.kill(reader(), signal.SIGSTOP)
    monkeypatch.setattr(sandbox, "MAX_SECONDS", 0.1)
    monkeypatch.setattr(reading_process, "PATIENCE_S", 0.1)
    with pytest.raises(UnreadableError, match="takes too long to read"):
        read_hdf5(small_entry(), LAYOUT)
    monkeypatch.undo()
    reader()


def test_after_an_interrupt_nobody_gets_the_answer_to_another_question(slow_content: bytes) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for wait_s in (0.02, 0.1):
            reader()
            signal.setitimer(signal.ITIMER_REAL, wait_s)
            with pytest.raises(KeyboardInterrupt):
                read_hdf5(slow_content, LAYOUT)
            reader()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_a_machine_on_which_it_cannot_start_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sandbox._READER.stop()
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no-python"))
    with pytest.raises(ReaderError, match=r"does not start \(No such file or directory\)"):
        read_hdf5(small_entry(), LAYOUT)
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(ReaderError, match=r"does not start \(exit code 1\)"):
        read_hdf5(small_entry(), LAYOUT)
    monkeypatch.undo()
    reader()


def test_threads_get_their_own_answers() -> None:
    wrong: list[object] = []

    def read(seed: int) -> None:
        rows = np.random.default_rng(seed).normal(size=(6, 39))
        content = crafted(lambda file: file["torque_nm"].__setitem__(..., rows))
        for _ in range(10):
            if not np.array_equal(read_hdf5(content, LAYOUT)["torque_nm"], rows):
                wrong.append(seed)

    threads = [threading.Thread(target=read, args=(seed,)) for seed in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_nothing_is_left_behind(slow_content: bytes) -> None:
    reader()
    before, processes = descriptors(), len(children())
    for _ in range(2):
        os.kill(reader(), signal.SIGKILL)
        with pytest.raises(UnreadableError):
            read_hdf5(b"nothing", LAYOUT)
    read_hdf5(slow_content, LAYOUT)
    reader()
    assert descriptors() == before and len(children()) == processes and "Z" not in children()


READING = """
import io, os
import h5py, numpy as np
from fatigue_planner.reactions import sandbox

def right(rows):
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file["x"] = np.arange(rows) + 0.5
    layout = sandbox.Layout({"x": ("f8", (None,))}, 1000, 10)
    found = [sandbox.read_hdf5(content.getvalue(), layout)["x"] for _ in range(30)]
    return all(np.array_equal(values, np.arange(rows) + 0.5) for values in found)

assert right(10)
first = sandbox._READER._process.pid
print(first, flush=True)
"""
FORKING = f"""{READING}
sandbox._READER._lock.acquire()  # as if a thread were reading
child = os.fork()
if child == 0:
    assert right(20) and sandbox._READER._process.pid != first
    sandbox._READER.stop()
    os._exit(7)
sandbox._READER._lock.release()
assert right(30) and sandbox._READER._process.pid == first
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    one_thread = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, timeout=60, cwd=ROOT, check=False,
        env={**os.environ, **one_thread},
    )  # fmt: skip


def test_a_fork_has_a_reader_of_its_own_and_the_end_is_silent() -> None:
    done = run("-X", "dev", "-W", "error", "-c", FORKING)
    assert (done.returncode, done.stderr) == (0, "")
    assert not Path(f"/proc/{done.stdout.strip()}").exists()


def test_the_reader_ends_with_a_killed_parent() -> None:
    done = run("-c", f"{READING}\nos.kill(os.getpid(), 9)")
    assert done.returncode == -9, done.stderr
    gone = Path(f"/proc/{done.stdout.strip()}")
    end = time.monotonic() + 20
    while gone.exists() and gone.joinpath("stat").read_text().rsplit(")")[1].split()[0] != "Z":
        assert time.monotonic() < end
        time.sleep(0.05)

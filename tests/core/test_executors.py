"""Work survives the workers that do it."""

import gc
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from multiprocessing import spawn
from pathlib import Path

import pytest
from conftest import ROOT
from pieces import Interrupt, complain, die, fail, interrupt_after, interruptible, process_id, slow_square, square

from fatigue_planner.core.errors import FailedMotionError, WorkerError
from fatigue_planner.core.executors.executor import Lost
from fatigue_planner.core.executors.processes import LocalProcesses


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_every_item_is_done_once(jobs: int) -> None:
    found = list(LocalProcesses(jobs).run(square, range(20)))
    assert sorted(found) == [(index, index * index) for index in range(20)]
    assert list(LocalProcesses(jobs).run(square, [])) == []


def test_work_whose_process_dies_is_done_again_and_given_up_in_the_end(tmp_path: Path) -> None:
    """Two items lose their process once or twice and are done; one always does, and nothing else is lost."""
    deaths = [0, 1, 0, 2, 0, 99, 0, 0]
    items = [(tmp_path, number, count) for number, count in enumerate(deaths)]
    found = dict(LocalProcesses(2).run(die, items))
    assert isinstance(found.pop(5), Lost)
    assert found == {number: number for number in range(8) if number != 5}
    assert len(list(tmp_path.glob("5-*"))) in (3, 4)  # three times alone, and perhaps once in company


def test_an_error_of_the_work_is_raised() -> None:
    with pytest.raises(FailedMotionError, match=r"^the third$"):
        list(LocalProcesses(2).run(fail, range(10)))


@pytest.mark.parametrize("delay_s", [0.0, 0.15], ids=["while a result is stored", "while waiting"])
def test_after_an_interrupt_what_is_in_progress_is_still_delivered(
    capfd: pytest.CaptureFixture[str], delay_s: float
) -> None:
    def until_interrupted() -> Iterator[int]:
        for index, _ in LocalProcesses(2).run(slow_square, range(50)):
            yield index
            if index == 1:
                interrupt_after(delay_s)

    found = []
    with interruptible(), pytest.raises(Interrupt):
        found.extend(until_interrupted())
    assert 3 <= len(found) <= 8
    assert capfd.readouterr().err == "Stopping after the work in progress (once more to stop at once) ...\n"


def test_an_interrupt_at_the_very_end_is_heard() -> None:
    with interruptible(), pytest.raises(Interrupt):
        for index, _ in LocalProcesses(1).run(square, range(3)):
            if index == 2:
                interrupt_after(0)


SCRIPT = """
from fatigue_planner.core.executors.processes import LocalProcesses

class Own:
    def __init__(self, number):
        self.number = number

def work(own):
    return Own(own.number + 1)

found = dict(LocalProcesses(2).run(work, [Own(0), Own(1)]))
assert all(type(result) is Own for result in found.values())
print([found[index].number for index in range(2)])
"""


def test_workers_import_neither_the_script_nor_the_working_folder(tmp_path: Path) -> None:
    """A script that works as it is imported, with classes of its own, beside files with the names of libraries."""
    for name in ("signal", "socket"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('imported')\n")
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts" / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "scripts/script.py"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "[1, 2]\n", "")


def test_a_worker_that_dies_before_its_first_piece_of_work_shows_what_it_said(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\necho libpython is missing >&2\nexit 1\n")
    broken.chmod(0o700)
    spawn.set_executable(str(broken))
    try:
        with pytest.raises(WorkerError, match=r"before its first piece of work; it said:\nlibpython is missing$"):
            list(LocalProcesses(1).run(square, [1, 2]))
    finally:
        spawn.set_executable(sys.executable)
    assert capfd.readouterr().err == ""


def test_what_workers_say_is_shown_in_the_end(capfd: pytest.CaptureFixture[str]) -> None:
    assert list(LocalProcesses(1).run(complain, ["too hot"])) == [(0, None)]
    assert capfd.readouterr().err == "too hot\n"


def test_processes_stay_for_further_work_until_nobody_uses_them(capfd: pytest.CaptureFixture[str]) -> None:
    """What they say is shown after each work; if one dies meanwhile, others do the next."""
    executor = LocalProcesses(1)
    ((_, first),) = executor.run(process_id, [0])
    for text in ("too hot", "too cold"):
        list(executor.run(complain, [text]))
        assert capfd.readouterr().err == f"{text}\n"
    assert list(executor.run(process_id, [0])) == [(0, first)]
    os.kill(first, signal.SIGKILL)
    ((_, second),) = executor.run(process_id, [0])
    assert second != first
    del executor
    gc.collect()
    with pytest.raises(ProcessLookupError):
        os.kill(second, 0)


@pytest.mark.skipif(
    subprocess.run(["unshare", "--mount", "--map-root-user", "true"], check=False, capture_output=True).returncode != 0
    if shutil.which("unshare") else True,
    reason="needs a file system of its own",
)  # fmt: skip
def test_a_read_only_shared_memory_is_named_with_the_remedy() -> None:
    script = (
        "from fatigue_planner.core.executors.processes import LocalProcesses; list(LocalProcesses(1).run(abs, [1]))"
    )
    inside = f'mount -t tmpfs -o ro tmpfs /dev/shm && exec {sys.executable} -c "{script}"'
    done = subprocess.run(
        ["unshare", "--mount", "--map-root-user", "sh", "-c", inside], capture_output=True, text=True, check=False
    )
    told = done.stderr.splitlines()[-1]
    assert "WorkerError: /dev/shm: cannot be written (Read-only file system)" in told and "Mount it writable" in told

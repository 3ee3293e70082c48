"""The slow tests' second chance: a test that fails is run once more, alone, and is told of all the same."""

import subprocess
import sys
from pathlib import Path

from conftest import ROOT

TESTS = """
import os, pathlib, pytest
pytestmark = pytest.mark.slow
first = pathlib.Path(__file__).with_name("first")

def test_good():
    pass

def test_disturbed():
    if not first.exists():
        first.touch()
        assert "a busy machine" == ""

@pytest.mark.parametrize("number", range(int(os.environ["BROKEN"])))
def test_broken(number):
    assert number < 0
"""
OPTIONS = ["--confcutdir", ".", "--rootdir", ".", "-c", "pytest.ini"]


def run(folder: Path, broken: int, processes: int) -> tuple[int, list[str]]:
    (folder / "test_some.py").write_text(TESTS)
    (folder / "pytest.ini").write_text("[pytest]\naddopts = -q\nmarkers = slow\n")
    command = [sys.executable, str(ROOT / "tests" / "run_slow_tests.py"), *OPTIONS, f"-n{processes}"]
    done = subprocess.run(
        command, cwd=folder, env={"PATH": "", "BROKEN": str(broken)}, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout.splitlines()


def test_a_failure_that_does_not_come_again_is_the_last_thing_said_and_fails_nothing(tmp_path: Path) -> None:
    code, said = run(tmp_path, 0, processes=2)
    assert code == 0 and said[-1] == "slow tests: 1 failed at first, 0 of them again"
    assert said[-2] == "FAULT: test_some.py::test_disturbed failed at first, and passed alone"
    assert any("a busy machine" in line for line in said[-8:-2])
    assert sum(" passed" in line and " in " in line for line in said) == 2  # pytest's own summaries


def test_a_second_failure_fails_the_run_and_many_are_not_repeated(tmp_path: Path) -> None:
    code, said = run(tmp_path, 1, processes=0)
    assert code == 1 and said[-1] == "slow tests: 2 failed at first, 1 of them again"
    code, said = run(tmp_path, 6, processes=0)
    assert code == 1 and not any("once more" in line for line in said)

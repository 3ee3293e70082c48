"""Files damaged by chance: each is read, or refused with one message that names a file; none takes long or grows."""

import subprocess
import sys
from pathlib import Path

import mutations
import pytest

FAST, ALL = 200, 10_000
PROCESSES = 2
# Of a whole process that reads thousands of files, with its libraries, which are half of it.
MAX_MIB = 300


def test_some_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    """The fuzzer must reach both ends, or it says nothing about one of them."""
    folder = mutations.folder_of_experiments(tmp_path)
    ends = {number: mutations.read(number, folder) for number in range(FAST)}
    faults = [mutations.told(number, end) for number, end in ends.items() if end not in mutations.GOOD_ENDS]
    assert not faults, "\n".join(faults)
    assert all(list(ends.values()).count(end) >= FAST / 20 for end in mutations.GOOD_ENDS)


def test_damaged_files_are_the_same_for_ever() -> None:
    """Otherwise a fault could not be found again."""
    inputs = [mutations.mutated(number) for number in range(40)]
    assert inputs == [mutations.mutated(number) for number in range(40)]
    assert len({content for _, content in inputs}) > 35 and {kind for kind, _ in inputs} == set(mutations.LOADERS)


@pytest.mark.slow
def test_ten_thousand_damaged_files_are_read_or_refused() -> None:
    each = ALL // PROCESSES
    script = str(Path(mutations.__file__))
    commands = [[sys.executable, script, str(first), str(first + each)] for first in range(0, ALL, each)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    children = [subprocess.Popen(command, text=True, **pipes) for command in commands]
    for child in children:
        said, wrong = child.communicate()
        assert child.returncode == 0, said + wrong
        count, peak_mib = map(float, said.split())
        assert count == each and peak_mib < MAX_MIB

"""SIGKILL at random moments of `simulate` and `benchmark`: nothing unreadable, and the same bytes in the end."""

import copy
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from conftest import PAPER
from stored_files import assert_whole, visible

from fatigue_planner.core.files import LEFT_BEHIND_AFTER_S, left_behind, remove_left_behind

FATPLAN = [sys.executable, "-c", "from fatigue_planner.cli.entry import run; run()"]
# How often each command is killed, in as many tests, at most so often in a row before it may end.
KILLS, TESTS, IN_A_ROW = 102, 6, 6


class Command:
    """A command that writes below a folder, and how long it takes undisturbed."""

    def __init__(self, arguments: list[str], option: str, folder: Path) -> None:
        self.arguments, self.option = arguments, option
        begin = time.perf_counter()
        self.expected = self.run(folder / "first")
        self.seconds = time.perf_counter() - begin
        assert len(self.expected) > 2

    def start(self, folder: Path) -> subprocess.Popen[bytes]:
        command = [*FATPLAN, *self.arguments, self.option, str(folder), "--jobs", "1"]
        return subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def run(self, folder: Path) -> dict[str, bytes]:
        """Run to the end; what it leaves."""
        process = self.start(folder)
        _, stderr = process.communicate()
        assert process.returncode == 0, stderr.decode()
        return visible(folder)

    def kill(self, folder: Path, fraction: float) -> bool:
        """Run and kill with all its processes after a fraction of its time; whether it had not ended before.

        A run that had was quicker than those before: it finds more, or the machine is less busy now.
        """
        process, begin = self.start(folder), time.perf_counter()
        try:
            process.communicate(timeout=fraction * self.seconds)
            self.seconds = time.perf_counter() - begin
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return True
        return False


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Command]:
    """Both commands on a quick experiment, so that there can be many kills."""
    folder = tmp_path_factory.mktemp("commands")
    experiment = yaml.safe_load(PAPER.read_text())
    high = experiment["actions"]["high"]["right_hand"]
    experiment |= {"name": "quick", "cycle": {"reach_s": 1.0, "work_s": 0.2, "return_s": 1.0}, "actions": {}}
    for number in range(3):
        position = high["position_m"] | {"z": 1.2 + number / 100}
        # a copy, as YAML would otherwise use an alias
        experiment["actions"][f"high{number}"] = copy.deepcopy({"right_hand": high | {"position_m": position}})
    experiment["preferences"].pop("back")
    experiment["accuracy"] = {key: float(value) for key, value in experiment["accuracy"].items()}
    experiment["accuracy"]["hand_error_m"] = 0.05
    experiment["benchmark"]["reference"] = {"kind": "lookahead", "depth": 2}
    file = folder / "quick.yaml"
    file.write_text(yaml.safe_dump(experiment, sort_keys=False))
    simulate = Command(["simulate", str(file)], "--cache", folder / "simulate")
    grid = ["--cycles", "5", "--trials", "20", "--descents", "20", "--conditions", "single_novice"]
    grid += ["--policies", "greedy", "--policies", "random", "--policies", "pomcp_0.1", "--regret", "--bound"]
    benchmark = ["benchmark", str(file), *grid, "--cache", str(folder / "simulate" / "first")]
    return {"simulate": simulate, "benchmark": Command(benchmark, "--results", folder / "benchmark")}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["simulate", "benchmark"])
@pytest.mark.parametrize("part", range(TESTS))
def test_a_run_killed_at_any_moment_goes_on_to_the_same_bytes(
    name: str, part: int, commands: dict[str, Command], tmp_path: Path
) -> None:
    """Killed several times in a row, then left alone; what a kill leaves is whole and is kept by the next run."""
    command = commands[name]
    moment = random.Random(1000 * (KILLS + part) + len(name))
    done, kills = 0, KILLS // TESTS
    while done < kills:
        folder = tmp_path / str(done)
        for _ in range(min(IN_A_ROW, kills - done)):
            before = visible(folder)
            if not command.kill(folder, moment.random()):
                break
            done += 1
            assert_whole(folder)
            after = visible(folder)
            stored = {path for path in before if "parts" in path or path.endswith(".h5")}
            assert all(after.get(path) == before[path] for path in stored)
        abandoned = leave_behind(folder, command)
        ended = command.run(folder)
        assert not any(path.exists() for path in abandoned)
        assert_whole(folder)
        assert tables(ended) == tables(command.expected)
        assert stored_rows(ended) == stored_rows(command.expected)
        assert_nothing_is_left(folder)


def tables(found: dict[str, bytes]) -> dict[str, bytes]:
    """All but the parts, which may be divided differently when a run goes on."""
    return {path: content for path, content in found.items() if "/parts/" not in path}


def stored_rows(found: dict[str, bytes]) -> list[str]:
    """The rows of all parts, with the folder they are in: each is there once."""
    return sorted(
        f"{Path(path).parent.name} {json.dumps(row)}"
        for path, content in found.items()
        if "/parts/" in path
        for row in json.loads(content)
    )


def leave_behind(folder: Path, command: Command) -> list[Path]:
    """Old temporary files as killed runs leave them, where a run removes them: in all folders but the cache."""
    if command.option == "--cache":  # which `fatplan cache gc` cleans
        return []
    results = [(folder / path).parent for path in command.expected if path.endswith("trials.csv")]
    left = [parent / f".x.fatplan-unfinished-{0:016x}.csv" for parent in results]
    left += [folder / "quick" / below / f".0-4.fatplan-unfinished-{0:016x}.json" for below in ("parts/0", "bounds")]
    for path in left:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{")
    age(left)
    return left


def age(paths: list[Path]) -> None:
    old = time.time() - LEFT_BEHIND_AFTER_S - 60
    for path in paths:
        os.utime(path, (old, old))


def assert_nothing_is_left(folder: Path) -> None:
    """Temporary files of killed runs are hidden, and go when they are old enough to be nobody's; others stay."""
    left = [path for path in folder.rglob(".*") if path.is_file()]
    foreign = folder / ".mine.json"
    foreign.write_text("{")
    assert not left_behind(folder)  # they are young
    age([*left, foreign])
    assert set(left_behind(folder)) == set(left)
    remove_left_behind(folder)
    assert [path for path in folder.rglob(".*") if path.is_file()] == [foreign]
    foreign.unlink()

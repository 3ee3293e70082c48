"""The same bytes wherever the work is done, in whatever order, killed and resumed or not."""

import hashlib
import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from conftest import PAPER
from dask_clusters import Cluster, cluster

SUPPORT = Path(__file__).parents[1] / "support"
# kind, workers, order of work, hash seed, how many kills
LOCAL = [
    ("processes", 1, 1, "0", 0), ("processes", 1, 2, "1", 0), ("processes", 2, 3, "2", 0),
    ("processes", 2, 4, "random", 0),
    ("processes", 3, 5, "3", 0), ("processes", 1, 6, "4", 2), ("processes", 2, 7, "5", 3), ("processes", 2, 8, "6", 3),
    ("threads", 1, 9, "0", 0), ("threads", 2, 10, "1", 0), ("threads", 2, 11, "2", 0), ("threads", 3, 12, "random", 0),
    ("threads", 4, 13, "3", 0), ("threads", 8, 14, "4", 0), ("threads", 2, 15, "5", 2), ("threads", 4, 16, "6", 3),
]  # fmt: skip
# workers: of one thread each, or one of two
THERE = [
    ("dask", 1, 17, "0", 0), ("dask", 2, 18, "1", 0), ("dask", 2, 19, "random", 0), ("dask", 2, 20, "2", 2),
    ("threads of dask", 2, 21, "0", 0), ("threads of dask", 2, 22, "1", 0), ("threads of dask", 2, 23, "2", 0),
    ("threads of dask", 2, 24, "3", 2),
]  # fmt: skip


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The paper's experiment with few trials of few cycles."""
    settings = yaml.safe_load(PAPER.read_text(encoding="utf-8"))
    settings["name"] = "small"
    settings["benchmark"] |= {"n_cycles": [3, 8], "trials": 6}
    for policy in settings["benchmark"]["policies"].values():
        if "descents" in policy:
            policy["descents"] = 40
    path = tmp_path_factory.mktemp("experiment") / "small.yaml"
    path.write_text(yaml.safe_dump(settings), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def expected(small: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """What one process makes, undisturbed and in the usual order."""
    folder = tmp_path_factory.mktemp("expected")
    for command in ("simulate", "benchmark"):
        to_the_end(fatplan(command, small, folder, "--jobs", "1"))
    return hash_of(folder)


def fatplan(command: str, experiment: Path, folder: Path, *options: str) -> subprocess.Popen[str]:
    """The program as a user calls it."""
    more = ["--regret", "--bound", "--results", str(folder / "results")] if command == "benchmark" else []
    code = "from fatigue_planner.cli.entry import run; run()"
    call = [sys.executable, "-c", code, command, str(experiment), "--cache", str(folder / "cache"), *more, *options]
    return subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def to_the_end(process: subprocess.Popen[str]) -> None:
    _, stderr = process.communicate()
    assert process.returncode == 0, stderr


def hash_of(folder: Path) -> str:
    """Of all reactions and all tables but the times; what a killed run had not finished has a hidden name."""
    files = sorted([*folder.glob("cache/*.h5"), *folder.glob("results/small/*.*")])
    named = [path for path in files if path.name != "planning_times.csv" and not path.name.startswith(".")]
    assert len([path for path in named if path.suffix == ".h5"]) == 4
    tables = {"trials.csv", "actions.csv", "contrasts.csv", "regret.csv", "bounds.csv", "summary.txt", "manifest.json"}
    assert tables <= {path.name for path in named}
    return hashlib.sha256(b"".join(path.name.encode() + path.read_bytes() for path in named)).hexdigest()


def run(way: tuple[str, int, int, str, int], kind: str, small: Path, folder: Path) -> None:
    """Run both commands, killed at random moments as often as asked, until they are through."""
    _, count, order, hash_seed, kills = way
    rng = random.Random(order)
    paths = os.pathsep.join(
        [str(SUPPORT), str(SUPPORT.parent), str(SUPPORT.parents[1]), os.environ.get("PYTHONPATH", "")]
    )
    environment = os.environ | {"PYTHONHASHSEED": hash_seed, "PYTHONPATH": paths}
    for name in ("OMP", "OPENBLAS", "MKL"):  # threads of this process do linear algebra themselves
        environment[f"{name}_NUM_THREADS"] = "1"
    call = [sys.executable, str(SUPPORT / "run_elsewhere.py"), kind, str(count), str(order), str(small), str(folder)]
    for attempt in range(kills + 1):
        with (folder / f"log-{attempt}").open("wb") as log:
            process = subprocess.Popen(call, env=environment, stdout=log, stderr=log)
            if attempt < kills:
                time.sleep(rng.uniform(2.5, 8.0))
                process.send_signal(signal.SIGKILL)
                process.wait()
            else:
                assert process.wait() == 0, (folder / f"log-{attempt}").read_text()
    said = (folder / f"log-{kills}").read_text().splitlines()[-1]
    done = re.fullmatch(rf"{re.escape(kind)} did (\d+) pieces of work in the order of seed {order}", said)
    assert done is not None and int(done[1]) > (0 if kills else 200), said


def test_there_are_ways_enough() -> None:
    assert len({*LOCAL, *THERE}) >= 24


@pytest.mark.slow
@pytest.mark.parametrize("way", LOCAL, ids=str)
def test_here(way: tuple[str, int, int, str, int], small: Path, expected: str, tmp_path: Path) -> None:
    run(way, way[0], small, tmp_path)
    assert hash_of(tmp_path) == expected


@pytest.fixture(scope="module")
def clusters(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[tuple[str, int], Cluster]]:
    folder = tmp_path_factory.mktemp("clusters")
    with (
        cluster(folder / "one", workers=1) as one,
        cluster(folder / "two", workers=2) as two,
        cluster(folder / "threads", workers=0) as threads,
    ):
        threads.add("--nthreads", "2", PYTHONHASHSEED="7")
        yield {("dask", 1): one, ("dask", 2): two, ("threads of dask", 2): threads}


@pytest.mark.slow
@pytest.mark.parametrize("way", THERE, ids=str)
def test_there(
    way: tuple[str, int, int, str, int],
    clusters: dict[tuple[str, int], Cluster],
    small: Path,
    expected: str,
    tmp_path: Path,
) -> None:
    run(way, clusters[way[0], way[1]].address, small, tmp_path)
    assert hash_of(tmp_path) == expected


@pytest.mark.slow
def test_without_its_scheduler_it_ends_in_one_message_and_goes_on_here(
    small: Path, expected: str, tmp_path: Path
) -> None:
    with cluster(tmp_path / "dask", workers=2) as one:
        to_the_end(fatplan("simulate", small, tmp_path, "--dask", one.address))
        broken = fatplan("benchmark", small, tmp_path, "--dask", one.address)
        while len(list(tmp_path.glob("results/small/parts/*/*.json"))) < 5:
            assert broken.poll() is None
            time.sleep(0.05)
        one.scheduler.kill()
        _, stderr = broken.communicate(timeout=60)
    assert broken.returncode == 3
    assert stderr.count("Error: ") == 1 and "Traceback" not in stderr
    assert "the connection to the Dask scheduler is lost. What is finished is kept" in stderr
    assert not (tmp_path / "results" / "small" / "trials.csv").exists()
    to_the_end(fatplan("benchmark", small, tmp_path, "--jobs", "2"))
    assert hash_of(tmp_path) == expected

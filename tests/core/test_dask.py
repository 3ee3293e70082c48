"""Many machines: a Dask cluster gives the same bytes, whatever becomes of its workers."""

import gc
import random
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import pytest
from conftest import PAPER
from dask_clusters import Cluster, cluster
from pieces import Deadly, Interrupt, fail, interrupt_after, interruptible, slow_square, square

from fatigue_planner.cli.options import executor_of
from fatigue_planner.core.errors import (
    ClusterError,
    ExitCode,
    FailedMotionError,
    LostClusterError,
    LostWorkError,
    MissingExtraError,
)
from fatigue_planner.core.executors import dask
from fatigue_planner.core.executors.dask import DaskCluster
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import GreedySettings, RandomSettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.runner import TrialStore, run_grid
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, TRIALS_FILE, publish_table, trial_table


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """Two workers, each with a nanny that starts it again."""
    with cluster(tmp_path_factory.mktemp("dask")) as it:
        yield it


@pytest.fixture(scope="module")
def cells(paper: Experiment, reactions: tuple[Reaction, ...]) -> list[Cell]:
    policies = {
        "random": RandomSettings(kind="random"),
        "greedy": GreedySettings(kind="greedy"),
        "search": PomcpSettings(kind="pomcp", backup="mean", exploration_constant=0.01, descents=300),
    }
    profiles = cycle_profiles(paper, reactions)
    return [
        Cell(condition, 10, policy, settings, scenario(paper, profiles, chosen), seed=7, trials=40)
        for condition, chosen in paper.benchmark.conditions.items()
        for policy, settings in policies.items()
    ]


def tables(
    cells: Sequence[Cell], folder: Path, executor: Executor, progress: Callable[[object, int], None] = lambda *_: None
) -> bytes:
    results, warnings = run_grid(cells, folder / "parts", executor, progress)
    assert warnings == []
    publish_table(folder, trial_table(cells, results), [TRIALS_FILE, ACTIONS_FILE])
    return b"".join((folder / name).read_bytes() for name in (TRIALS_FILE, ACTIONS_FILE))


@pytest.mark.slow
def test_every_item_is_done_once_and_an_error_of_the_work_is_raised(two: Cluster) -> None:
    executor = DaskCluster(two.address)
    assert sorted(executor.run(square, range(50))) == [(index, index * index) for index in range(50)]
    assert list(executor.run(square, [])) == []
    with pytest.raises(FailedMotionError, match=r"^the third$"):
        list(executor.run(fail, range(10)))
    assert executor.workers == 2


def test_after_an_interrupt_what_is_in_progress_is_still_delivered(two: Cluster) -> None:
    def until_interrupted() -> Iterator[int]:
        for index, _ in DaskCluster(two.address).run(slow_square, range(50)):
            yield index
            if index == 1:
                interrupt_after(0.05)

    found = []
    with interruptible(), pytest.raises(Interrupt):
        found.extend(until_interrupted())
    assert 2 <= len(found) <= 6


def test_a_scheduler_of_another_version_is_refused(two: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask, "version", lambda name: "1.2.3")
    with pytest.raises(ClusterError, match=r"the scheduler has dask \d{4}\S+ instead of 1\.2\.3"):
        list(DaskCluster(two.address).run(square, [1]))


@pytest.mark.parametrize("address", ["localhost:8786", "http://a:1", "tcp://", "tcp://a", "tls://a b:1", "tcp://a:1/x"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(ClusterError, match=r"must be the address of a Dask scheduler, tcp://HOST:PORT or tls://") as no:
        executor_of(1, address)
    assert no.value.exit_code == ExitCode.BAD_INPUT


def test_without_the_extra_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'fatigue-planner\[dask\]'"):
        executor_of(1, "tcp://127.0.0.1:8786")
    assert isinstance(executor_of(1, None), LocalProcesses)


def test_where_no_scheduler_is_there_is_one_message() -> None:
    import dask as dask_library

    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        with (
            dask_library.config.set({"distributed.comm.timeouts.connect": "1s"}),
            pytest.raises(ClusterError, match=r"cannot be reached .* Check that `dask scheduler` runs there\.$"),
        ):
            list(DaskCluster(address).run(square, [1]))


@pytest.mark.slow
def test_workers_that_could_give_other_results_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """No worker; then one without fatplan, one with another, one with several threads, and one that is right."""
    monkeypatch.setattr(dask, "LOOK_S", 0.2)
    with cluster(tmp_path, workers=0) as it:
        executor = DaskCluster(it.address)
        monkeypatch.setattr(dask, "PATIENCE_S", 0.5)
        with pytest.raises(ClusterError, match=r"no worker for .* minutes"):
            list(executor.run(square, [1]))
        assert "Waiting for a worker of tcp://" in capfd.readouterr().err
        monkeypatch.setattr(dask, "PATIENCE_S", 60.0)
        for name in ("none", "other"):
            (tmp_path / name).mkdir()
        (tmp_path / "none" / "fatigue_planner").mkdir()
        (tmp_path / "none" / "fatigue_planner" / "__init__.py").touch()
        import shutil

        copy = tmp_path / "other" / "fatigue_planner"
        shutil.copytree(PAPER.parents[1] / "fatigue_planner", copy, ignore=shutil.ignore_patterns("__pycache__"))
        (copy / "core/random_streams.py").write_text((copy / "core/random_streams.py").read_text() + "# changed\n")
        for environment, message in (
            ({"PYTHONPATH": str(tmp_path / "none")}, "has no fatplan like this one"),
            ({"PYTHONPATH": str(tmp_path / "other")}, r"has fatplan's files \w{16} instead of \w{16}: its results"),
            ({"OMP_NUM_THREADS": "2"}, "was not started with OMP_NUM_THREADS=1"),
        ):
            it.add(nanny=False, **environment)
            with pytest.raises(ClusterError, match=message):
                list(executor.run(square, [1]))
            it.workers[-1].kill()
            it.workers[-1].wait()
        it.add(nanny=False)
        assert list(executor.run(square, [3])) == [(0, 9)]


def certificate(folder: Path) -> dict[str, str]:
    """Dask's settings for a new key whose certificate is its own authority, as docs/cluster.md makes it."""
    folder.mkdir()
    call = "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2"
    files = ["-keyout", "key.pem", "-out", "cert.pem"]
    extra = ["-subj", "/CN=fatplan", "-addext", "keyUsage=critical,digitalSignature,keyCertSign"]
    subprocess.run([*call.split(), *files, *extra], cwd=folder, check=True, capture_output=True)
    settings = {"distributed.comm.tls.ca-file": str(folder / "cert.pem"), "distributed.comm.require-encryption": "true"}
    for role in ("scheduler", "worker", "client"):
        settings[f"distributed.comm.tls.{role}.cert"] = str(folder / "cert.pem")
        settings[f"distributed.comm.tls.{role}.key"] = str(folder / "key.pem")
    return settings


@pytest.mark.slow
def test_with_tls_only_who_has_the_key_gets_in(tmp_path: Path) -> None:
    import dask as dask_library

    ours, others = certificate(tmp_path / "ours"), certificate(tmp_path / "others")
    environment = {f"DASK_{name.upper().replace('.', '__').replace('-', '_')}": value for name, value in ours.items()}
    brief = {"distributed.comm.timeouts.connect": "1s"}
    with cluster(tmp_path / "dask", workers=1, scheme="tls", environment=environment) as it:
        assert it.address.startswith("tls://")
        with dask_library.config.set(ours):
            assert dict(DaskCluster(it.address).run(square, [1, 2])) == {0: 1, 1: 4}
        for wrong in ({}, others):
            with (
                dask_library.config.set(wrong | brief),
                pytest.raises(ClusterError, match=r"cannot be reached .* the certificates are right"),
            ):
                list(DaskCluster(it.address).run(square, [1]))
        with dask_library.config.set(brief), pytest.raises(ClusterError, match="cannot be reached"):
            list(DaskCluster(it.address.replace("tls", "tcp")).run(square, [1]))


def test_a_client_that_could_not_connect_is_no_obstacle_to_the_next(
    two: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is garbage, and Python may collect it at the worst moment: while the next one holds Dask's lock."""
    import dask as dask_library
    from distributed.utils import LoopRunner

    start = LoopRunner._start_unlocked

    def collect_and_start(self: LoopRunner) -> None:
        gc.collect()
        start(self)

    gc.disable()
    try:
        with dask_library.config.set({"distributed.comm.timeouts.connect": "1s"}), suppress(ClusterError):
            list(DaskCluster("tls://127.0.0.1:9").run(square, [1]))
        monkeypatch.setattr(LoopRunner, "_start_unlocked", collect_and_start)
        done: list[object] = []
        work = threading.Thread(target=lambda: done.extend(DaskCluster(two.address).run(square, [3])), daemon=True)
        work.start()
        work.join(30)
        assert done == [(0, 9)]
    finally:
        gc.enable()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["is killed", "does not answer"])
def test_a_scheduler_that_is_lost_is_one_error(
    tmp_path: Path, number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask, "SILENCE_S", 2.0)
    found = []
    message = r"is lost\. What is finished is kept; the same command goes on"
    with cluster(tmp_path, workers=1) as it, pytest.raises(LostClusterError, match=message) as lost:
        for index, _ in DaskCluster(it.address).run(slow_square, range(100)):
            found.append(index)
            if len(found) == 2:
                it.scheduler.send_signal(number)
    assert lost.value.exit_code == ExitCode.FAILED_PARTS
    assert 2 <= len(found) < 10


@pytest.mark.slow
@pytest.mark.parametrize(("nanny", "threads"), [(True, 1), (False, 1), (True, 2)])
def test_a_benchmark_whose_workers_are_killed_ends_in_the_same_bytes(
    cells: list[Cell], tmp_path: Path, nanny: bool, threads: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """At least 10 kills of each kind of cluster, at most one in three parts."""
    rng, kills = random.Random(0), 0
    expected = tables(cells, tmp_path / "here", LocalProcesses(2))
    with cluster(tmp_path / "dask", workers=0) as it:
        for _ in range(2):
            it.add("--nthreads", str(threads), nanny=nanny)

        def kill(_job: object, _trials: int) -> None:
            nonlocal kills
            if len(list(folder.glob("parts/*/[0-9]*.json"))) % 3 == 2:
                kills += 1
                it.kill_one(rng)
                if not nanny:
                    it.add("--nthreads", str(threads), nanny=False)

        run = 0
        while kills < 10:
            folder = tmp_path / str(run := run + 1)
            assert tables(cells, folder, DaskCluster(it.address), kill) == expected
    told = capfd.readouterr().err.splitlines()
    assert all(line.startswith(("The worker tcp://", "Waiting for")) for line in told)
    assert any(line.endswith("is gone; Dask begins its work again.") for line in told)


@pytest.mark.slow
def test_only_the_culprit_is_given_up_and_the_rest_is_kept(tmp_path: Path) -> None:
    """On two threads of a worker Dask also gives up what was in the culprit's company; that is then done alone."""
    job = Deadly(tmp_path, 7)
    environment = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
    with cluster(tmp_path / "dask", workers=0, environment=environment) as it:
        it.add("--nthreads", "2")
        with pytest.raises(LostWorkError, match="deadly, trials 5 to 9: Dask gave it up twice") as lost:
            run_grid([job], tmp_path / "parts", DaskCluster(it.address), lambda *_: None)
    assert lost.value.exit_code == ExitCode.FAILED_PARTS
    assert len(list(tmp_path.glob("7-*"))) == 4
    assert sorted(TrialStore(tmp_path / "parts").load(job)) == [*range(5), *range(10, 20)]


@pytest.mark.slow
def test_workers_told_to_go_give_their_work_back(tmp_path: Path) -> None:
    """As a queue does that wants its machines back: SIGTERM to the nanny, again and again."""
    with cluster(tmp_path, workers=2) as it:
        results = {}
        for index, result in DaskCluster(it.address).run(slow_square, range(40)):
            results[index] = result
            if len(results) % 8 == 0:
                it.add()
                it.workers[-3].terminate()
    assert results == {number: number * number for number in range(40)}

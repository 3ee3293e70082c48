"""Many machines: a Dask cluster gives the same bytes, whatever becomes of its workers."""

import asyncio
import random
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import pytest
from conftest import PAPER
from dask_clusters import Cluster, Killer, cluster
from distributed import Client
from distributed.comm import CommClosedError
from pieces import Deadly, Interrupt, die, fail, interrupt_after, interruptible, slow_square, square

from fatigue_planner.cli.options import executor_of
from fatigue_planner.core.errors import (
    ClusterError,
    ExitCode,
    FailedMotionError,
    LostClusterError,
    LostWorkError,
    MissingExtraError,
)
from fatigue_planner.core.executors import crew
from fatigue_planner.core.executors.dask import DaskCluster
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.planners.baselines import GreedySettings, RandomSettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.store import TrialStore
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, TRIALS_FILE, publish_table, trial_table


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """Two workers, each with a nanny that starts it again."""
    with cluster(tmp_path_factory.mktemp("dask")) as one:
        yield one


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


def parts_in(folder: Path) -> int:
    """How many parts of a benchmark are kept in a folder."""
    return sum(1 for _ in (folder / "parts").glob("*/[0-9]*.json"))


def tables(cells: Sequence[Cell], folder: Path, executor: Executor) -> bytes:
    results, warnings = run_grid(cells, folder / "parts", executor, lambda cell, n: None)
    assert warnings == []
    publish_table(folder, trial_table(cells, results), [TRIALS_FILE, ACTIONS_FILE])
    return b"".join((folder / name).read_bytes() for name in (TRIALS_FILE, ACTIONS_FILE))


def test_every_item_is_done_once(two: Cluster) -> None:
    executor = DaskCluster(two.address)
    assert sorted(executor.run(square, range(50))) == [(place, place * place) for place in range(50)]
    assert list(executor.run(square, [])) == []
    assert executor.workers == 2


def test_an_error_of_the_work_is_raised_as_it_is(two: Cluster) -> None:
    with pytest.raises(FailedMotionError, match=r"^the third$"):
        list(DaskCluster(two.address).run(fail, range(10)))


def test_a_benchmark_whose_workers_are_killed_ends_in_the_same_bytes(
    cells: list[Cell], two: Cluster, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    here = tables(cells, tmp_path / "here", LocalProcesses(2))
    with Killer(two, seed=1, progress=lambda: parts_in(tmp_path / "there"), most=2) as killer:
        there = tables(cells, tmp_path / "there", DaskCluster(two.address))
    assert killer.kills == 2
    assert there == here
    told = capfd.readouterr()
    assert told.out == "" and all(
        line.startswith(("The worker tcp://", "Waiting for")) for line in told.err.splitlines()
    )


def test_reactions_simulated_there_are_the_same(paper: Experiment, two: Cluster) -> None:
    """The bytes of every array of every motion; at a coarse time step."""
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.motion.simulator import simulate

    coarse = paper.model_copy(
        update={
            "cycle": Cycle(reach_s=1.0, work_s=0.2, return_s=1.0),
            "controller": paper.controller.model_copy(update={"time_step_s": 0.01}),
        }
    )
    motions = [request.motion for request in reaction_requests(coarse)]
    here, there = (dict(executor.run(simulate, motions)) for executor in (LocalProcesses(2), DaskCluster(two.address)))
    assert len(here) == 4
    for place, motion in here.items():
        for name, value in vars(motion).items():
            other = getattr(there[place], name)
            assert value.tobytes() == other.tobytes() if hasattr(value, "tobytes") else value == other, name


def test_what_kills_its_worker_three_times_is_reported_and_the_rest_is_kept(two: Cluster, tmp_path: Path) -> None:
    job = Deadly(tmp_path, 7)
    with pytest.raises(LostWorkError, match=r"deadly, trials 5 to 9: its worker died 3 times") as lost:
        run_grid([job], tmp_path / "parts", DaskCluster(two.address), lambda *_: None)
    assert lost.value.exit_code == ExitCode.FAILED_PARTS
    assert len(list(tmp_path.glob("7-*"))) == 3
    assert sorted(TrialStore(tmp_path / "parts").load(job)) == [*range(5), *range(10, 20)]


def test_work_whose_worker_dies_is_done_again(two: Cluster, tmp_path: Path) -> None:
    items = [(tmp_path, number, count) for number, count in enumerate([0, 1, 0, 2])]
    assert dict(DaskCluster(two.address).run(die, items)) == dict(enumerate(range(4)))


def test_after_an_interrupt_what_is_in_progress_is_still_delivered(two: Cluster) -> None:
    def until_interrupted() -> Iterator[int]:
        for place, _ in DaskCluster(two.address).run(slow_square, range(50)):
            yield place
            if place == 1:
                interrupt_after(0.05)

    found = []
    with interruptible(), pytest.raises(Interrupt):
        found.extend(until_interrupted())
    assert 2 <= len(found) <= 6


def test_a_connection_lost_while_a_result_comes_is_a_lost_scheduler(two: Cluster) -> None:
    """The moment cannot be chosen: the error is put in the result's place."""

    async def listen() -> bool:
        async with Client(two.address, asynchronous=True) as client:
            reports: list[object] = []
            one = crew.Crew(client, lambda *what: reports.append(what), lambda: None, reports.append)
            lost = asyncio.get_running_loop().create_future()
            lost.set_exception(CommClosedError("Stream is closed"))
            await one._listen("tcp://127.0.0.1:1", "key", lost)
            return one._lost.is_set() and not reports

    assert asyncio.run(listen())


def test_a_scheduler_of_another_version_is_refused(two: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "version", lambda name: "1.2.3")
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
    import dask

    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        with (
            dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
            pytest.raises(ClusterError, match=r"cannot be reached .* Check that `dask scheduler` runs there\.$"),
        ):
            list(DaskCluster(address).run(square, [1]))


def test_workers_that_could_give_other_results_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nobody; then one without fatplan, one with another, one with threads, and at last one that is right."""
    monkeypatch.setattr(crew, "LOOK_S", 0.2)
    with cluster(tmp_path, workers=0) as one:
        executor = DaskCluster(one.address)
        monkeypatch.setattr(crew, "PATIENCE_S", 0.5)
        with pytest.raises(ClusterError, match=r"no worker for .* minutes"):
            list(executor.run(square, [1]))
        assert "Waiting for a worker of tcp://" in capfd.readouterr().err
        monkeypatch.setattr(crew, "PATIENCE_S", 60.0)
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
            one.add(nanny=False, **environment)
            with pytest.raises(ClusterError, match=message):
                list(executor.run(square, [1]))
            one.workers[-1].kill()
            one.workers[-1].wait()
        one.add(nanny=False)
        assert list(executor.run(square, [3])) == [(0, 9)]


@pytest.mark.slow
def test_a_scheduler_that_is_lost_is_one_error(tmp_path: Path) -> None:
    with cluster(tmp_path, workers=1) as one:
        found = []
        with pytest.raises(
            LostClusterError, match=r"is lost\. What is finished is kept; the same command goes on"
        ) as lost:
            for place, _ in DaskCluster(one.address).run(slow_square, range(100)):
                found.append(place)
                if len(found) == 2:
                    one.scheduler.kill()
        assert lost.value.exit_code == ExitCode.FAILED_PARTS
        assert 2 <= len(found) < 10


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


def test_with_tls_only_who_has_the_key_gets_in(tmp_path: Path) -> None:
    import dask

    ours, others = certificate(tmp_path / "ours"), certificate(tmp_path / "others")
    environment = {f"DASK_{name.upper().replace('.', '__').replace('-', '_')}": value for name, value in ours.items()}
    brief = {"distributed.comm.timeouts.connect": "1s"}
    with cluster(tmp_path / "dask", workers=1, scheme="tls", environment=environment) as one:
        assert one.address.startswith("tls://")
        with dask.config.set(ours):
            assert dict(DaskCluster(one.address).run(square, [1, 2])) == {0: 1, 1: 4}
        for wrong in ({}, others):
            with (
                dask.config.set(wrong | brief),
                pytest.raises(ClusterError, match=r"cannot be reached .* the certificates are right"),
            ):
                list(DaskCluster(one.address).run(square, [1]))
        with dask.config.set(brief), pytest.raises(ClusterError, match="cannot be reached"):
            list(DaskCluster(one.address.replace("tls", "tcp")).run(square, [1]))


@pytest.mark.slow
def test_a_scheduler_that_says_nothing_more_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "LOOK_S", 0.5)
    monkeypatch.setattr(crew, "SILENCE_S", 2.0)
    with cluster(tmp_path, workers=1) as one, pytest.raises(LostClusterError):
        for place, _ in DaskCluster(one.address).run(slow_square, range(100)):
            if place == 2:
                one.scheduler.send_signal(signal.SIGSTOP)


@pytest.mark.slow
@pytest.mark.parametrize(("nanny", "threads"), [(True, 1), (False, 1), (True, 2)])
def test_many_kills_change_nothing(cells: list[Cell], tmp_path: Path, nanny: bool, threads: int) -> None:
    """At least 10 kills of each kind of cluster; every part is kept once."""
    here = tables(cells, tmp_path / "here", LocalProcesses(2))
    with cluster(tmp_path / "dask", workers=0) as one:
        for _ in range(2):
            one.add("--nthreads", str(threads), nanny=nanny)
        kills, run = 0, 0
        while kills < 10:
            run += 1
            there = tmp_path / f"there-{run}"
            with Killer(one, run, partial(parts_in, there), replace=not nanny) as killer:
                assert tables(cells, there, DaskCluster(one.address)) == here
            kills += killer.kills
            assert parts_in(there) == parts_in(tmp_path / "here")
            assert run < 40


@pytest.mark.slow
def test_several_at_a_time_die_and_only_the_culprit_is_given_up(tmp_path: Path) -> None:
    """Two threads per worker: who was in company is done again alone."""
    deaths = [0, 1, 0, 2, 0, 99, 0, 0, 0, 0]
    with cluster(tmp_path / "dask", workers=0) as one:
        one.add("--nthreads", "2")
        one.add("--nthreads", "2")
        found = dict(DaskCluster(one.address).run(die, [(tmp_path, n, count) for n, count in enumerate(deaths)]))
    assert isinstance(found.pop(5), Lost)
    assert found == {number: number for number in range(10) if number != 5}


@pytest.mark.slow
def test_a_scheduler_of_little_patience_changes_nothing(tmp_path: Path) -> None:
    """It gives a task up at its first death, with an error of its own."""
    deaths = [0, 1, 2, 99, 0]
    environment = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
    with cluster(tmp_path / "dask", environment=environment) as one:
        found = dict(DaskCluster(one.address).run(die, [(tmp_path, n, count) for n, count in enumerate(deaths)]))
    assert isinstance(found.pop(3), Lost) and found == {0: 0, 1: 1, 2: 2, 4: 4}
    assert len(list(tmp_path.glob("3-*"))) == 3


@pytest.mark.slow
def test_workers_told_to_go_have_not_died_of_their_work(tmp_path: Path) -> None:
    """As a queue does that wants its machines back: SIGTERM to the nanny, again and again."""
    rng = random.Random(0)
    with cluster(tmp_path, workers=2) as one:
        results = {}
        for place, result in DaskCluster(one.address).run(slow_square, range(40)):
            results[place] = result
            if len(results) % 8 == 0:
                one.add()
                rng.choice(one.workers[-3:-1]).terminate()
    assert results == {number: number * number for number in range(40)}

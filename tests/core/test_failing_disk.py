"""Every write, fsync, rename, open, mkdir and unlink of a run fails once: one message, and the store stays whole."""

import errno
import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest
from failing_disk import FailingDisk, failing
from stored_files import assert_whole, visible

from fatigue_planner.core.errors import ExitCode, OutputFolderError
from fatigue_planner.core.executors.executor import Executor, Pool
from fatigue_planner.core.files import publish_csv, publish_text, remove, writable_folder
from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.bounds import bound_jobs, bound_rows, publish_bounds
from fatigue_planner.study.benchmark.regret import RegretJob
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.selection import Selection, cells, references, selected
from fatigue_planner.study.benchmark.tables import (
    ACTIONS_FILE,
    REGRET_FILE,
    TRIALS_FILE,
    publish_table,
    regret_rows,
    trial_table,
)
from fatigue_planner.study.statistics.comparison import comparison_table, summary_text
from fatigue_planner.study.statistics.regret import gap_table


class Remembering(Executor):
    """Works in this process and does the same work once only, so that many runs are quick, down to the same times."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], Any] = {}

    @property
    def workers(self) -> int:
        return 1

    def pool(self, most: int) -> AbstractContextManager[Pool]:
        raise NotImplementedError("there is no pool: see run")

    def run(self, work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        for index, item in enumerate(items):
            key = work.__qualname__, _name_of(item)
            if key not in self._known:
                self._known[key] = work(item)
            yield index, self._known[key]


def _name_of(item: Any) -> str:
    """What tells items apart: a reaction's or job's digest, with the trials."""
    if isinstance(item, tuple):
        job, rest = item
        return f"{job.digest()} {rest}"
    return str(item.digest)


@pytest.fixture(scope="module")
def small(paper: Experiment) -> Experiment:
    """Two quick reactions and two policies in a condition."""
    grid = selected(paper, Selection([5], ["single_expert"], ["random", "greedy"], 2, None, None))
    return grid.model_copy(
        update={
            "cycle": Cycle(reach_s=1.0, work_s=0.2, return_s=1.0),
            "actions": {"high": paper.actions["high"]},
            "accuracy": paper.accuracy.model_copy(update={"hand_error_m": 0.05}),
        }
    )


def one_run(experiment: Experiment, folder: Path, executor: Executor) -> None:
    """All that `simulate` and `benchmark --regret --bound` write."""
    requests = reaction_requests(experiment)
    cache = ReactionCache(folder / "cache")
    cache.complete(requests, executor, lambda _: None)
    grid = cells(experiment, cycle_profiles(experiment, cache.stream(requests, "fatplan simulate")))
    results = writable_folder(folder / "results" / experiment.name)
    parts = writable_folder(results / "parts")
    done, _ = run_grid(grid, parts, executor, lambda job, n: None)
    table = trial_table(grid, done)
    publish_table(results, table, [TRIALS_FILE, ACTIONS_FILE])
    comparison = comparison_table(table, experiment.statistics.significance_level)
    publish_csv(results / "comparison.csv", comparison)
    judges = references(experiment, grid)
    judgements = [
        RegretJob(cell, judges[cell.condition], {trial: result.actions for trial, result in runs.items()})
        for cell, runs in zip(grid, done, strict=True)
    ]
    regrets, _ = run_grid(judgements, parts, executor, lambda job, n: None)
    publish_table(results, regret_rows(grid, regrets), [REGRET_FILE])
    bounds = bound_jobs(grid)
    found, _ = run_grid(bounds, writable_folder(results / "bounds"), executor, lambda job, n: None)
    publish_bounds(results, gap_table(comparison, bound_rows(bounds, found)))
    remove(results / "of an earlier run.csv")
    publish_text(results / "summary.txt", summary_text(comparison, experiment.statistics.significance_level))
    files = [results / name for name in (TRIALS_FILE, ACTIONS_FILE, REGRET_FILE, "bounds.csv", "summary.txt")]
    publish_manifest(results, "benchmark", {"reactions": digests(requests)}, files)


def hashes(folder: Path) -> dict[str, str]:
    return {path: hashlib.sha256(content).hexdigest() for path, content in visible(folder).items()}


@pytest.fixture(scope="module")
def undisturbed(small: Experiment, tmp_path_factory: pytest.TempPathFactory) -> tuple[Remembering, list[str], Any]:
    """An executor that knows everything, the calls of a run, and what is there in the end."""
    executor, folder = Remembering(), tmp_path_factory.mktemp("undisturbed")
    one_run(small, folder / "first", executor)
    (folder / "second").mkdir()
    with failing(FailingDisk(folder / "second", None)) as disk:
        one_run(small, folder / "second", executor)
    assert hashes(folder / "first") == hashes(folder / "second")
    assert min(disk.calls.count(name) for name in ("open", "write", "fsync", "replace")) > 10
    return executor, disk.calls, hashes(folder / "first")


def check(
    small: Experiment,
    undisturbed: tuple[Remembering, list[str], Any],
    folder: Path,
    number: int,
    for_good: bool,
    step: int = 1,
) -> None:
    """For every call of a run, or every so many: let it fail, look at what is there, and run once more."""
    executor, calls, expected = undisturbed
    for index, name in list(enumerate(calls))[::step]:
        own = folder / str(index)
        own.mkdir()
        try:
            with failing(FailingDisk(own, index, number, for_good)) as disk:
                one_run(small, own, executor)
        except OutputFolderError as error:
            message = str(error)
            assert error.exit_code == ExitCode.BAD_INPUT and "\n" not in message and str(own) in message
            assert any(reason in message for reason in ("No space left", "Input/output error")), message
        else:
            assert name == "unlink", f"call {index}, {name}, failed without a message"
        assert disk.failed == name
        assert_whole(own)
        there = hashes(own)
        assert all(expected[path] == found for path, found in there.items() if "manifest" not in path)
        one_run(small, own, executor)
        assert hashes(own) == expected
        assert_whole(own)


@pytest.mark.slow
def test_a_full_disk_at_some_calls_damages_nothing(
    small: Experiment, undisturbed: tuple[Remembering, list[str], Any], tmp_path: Path
) -> None:
    check(small, undisturbed, tmp_path, errno.ENOSPC, for_good=False, step=5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "for_good"), [(errno.ENOSPC, False), (errno.EIO, False), (errno.ENOSPC, True), (errno.EIO, True)]
)
def test_a_broken_disk_at_any_call_damages_nothing(
    small: Experiment,
    undisturbed: tuple[Remembering, list[str], Any],
    tmp_path: Path,
    number: int,
    for_good: bool,
) -> None:
    check(small, undisturbed, tmp_path, number, for_good)

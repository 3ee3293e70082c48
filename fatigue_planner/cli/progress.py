"""What is said while a command works, all of it on stderr: progress, warnings, and what is kept if it ends early."""

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

    from fatigue_planner.core.executors.executor import Executor
    from fatigue_planner.study.benchmark.job import Job

T = TypeVar("T")

SECONDS_BETWEEN_LINES = 60.0


def talk() -> "Console":
    """Where progress and messages go: the terminal's error stream, apart from results."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def warn(warnings: Iterable[str]) -> None:
    """Print warnings."""
    console = talk()
    for warning in warnings:
        console.print(f"Warning: {warning}", markup=False)


class Counter:
    """Counts pieces of work that are done; their efforts make the bar, which is for terminals only.

    Where nobody watches, in a file or a pipe, there is a line now and then.
    """

    def __init__(self, title: str, console: "Console", effort: float) -> None:
        self.pieces = 0
        self._title, self._console = title, console
        self._effort, self._done = effort, 0.0
        self._said = time.monotonic()
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        if console.is_interactive:
            from rich import progress as bar

            percentage = bar.TextColumn("{task.percentage:.0f} %")
            times = (bar.TimeElapsedColumn(), bar.TimeRemainingColumn())
            columns = (bar.TextColumn("{task.description}"), bar.BarColumn(), percentage, *times)
            self._bar = bar.Progress(*columns, console=console)
            self._task = self._bar.add_task(title, total=effort)
            self._bar.start()

    def advance(self, pieces: int = 1, effort: float = 1) -> None:
        """So many pieces more are done and kept, which took so much of the effort."""
        self.pieces += pieces
        self._done += effort
        if self._bar is not None and self._task is not None:
            self._bar.advance(self._task, effort)
        elif time.monotonic() - self._said > SECONDS_BETWEEN_LINES:
            self._said = time.monotonic()
            self._console.print(f"{self._title}: {self._done / self._effort:.0%}", markup=False)

    def close(self) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.stop()


@contextmanager
def progress(
    title: str, total: int, effort: float | None = None, kept: tuple[str, Path] | None = None
) -> Iterator[Counter]:
    """Show how much is done of `total` pieces of work, which make up an `effort`, by default of one each.

    kept: what the pieces are called and where they are kept. What ends the work early carries that as a note.
    """
    counter = Counter(title, talk(), total if effort is None else effort)
    try:
        yield counter
    except BaseException as error:
        if kept is not None:
            error.add_note(f"{counter.pieces} of {total} {kept[0]} are kept in {kept[1]}.")
        raise
    finally:
        counter.close()


def run_jobs(grid: "Sequence[Job[T]]", store: Path, executor: "Executor", title: str, what: str) -> list[dict[int, T]]:
    """As `benchmark.runner.run_grid`, with its progress shown and its warnings printed; `what`: what the trials are."""
    from fatigue_planner.study.benchmark.runner import run_grid

    runs = sum(len(job.trial_numbers()) for job in grid)
    effort = sum(len(job.trial_numbers()) * job.effort for job in grid)
    with progress(title, runs, effort, kept=(what, store)) as counter:
        done, warnings = run_grid(grid, store, executor, lambda job, n: counter.advance(n, n * job.effort))
    warn(warnings)
    return done

"""`fatplan simulate` and `benchmark` as one process, with the work done wherever and in whatever order.

Called as: run_elsewhere.py KIND COUNT ORDER EXPERIMENT FOLDER; KIND is processes, threads or a scheduler's address,
ORDER the seed of the order in which work is begun.
"""

import random
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from threads import Threads

from fatigue_planner.cli import options
from fatigue_planner.cli.benchmark import benchmark
from fatigue_planner.cli.simulate import simulate
from fatigue_planner.core.executors.executor import Executor, Pool


class Shuffled(Executor):
    """Another executor that begins work in another order."""

    def __init__(self, inner: Executor, seed: int) -> None:
        self._inner, self._rng = inner, random.Random(seed)
        self.done = 0

    @property
    def workers(self) -> int:
        return self._inner.workers

    def pool(self, most: int) -> AbstractContextManager[Pool]:
        return self._inner.pool(most)

    def run(self, work: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        order = list(range(len(items)))
        self._rng.shuffle(order)
        for index, result in self._inner.run(work, [items[i] for i in order]):
            self.done += 1
            yield order[index], result


def executor(kind: str, count: int) -> Executor:
    return Threads(count) if kind == "threads" else options.executor_of(count, None if kind == "processes" else kind)


if __name__ == "__main__":
    kind, count, order, experiment, folder = sys.argv[1:]
    where = Shuffled(executor(kind, int(count)), int(order))
    options.executor_of = lambda jobs, dask: where
    cache, results = Path(folder, "cache"), Path(folder, "results")
    simulate(Path(experiment), cache)
    benchmark(Path(experiment), regret=True, bound=True, cache=cache, results=results)
    # told last, to whoever must know that nothing else has done the work
    print(f"{kind} did {where.done} pieces of work in the order of seed {order}")

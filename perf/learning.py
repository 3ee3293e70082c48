"""How well learning finds what a worker is like.

    python perf/learning.py beta [--runs 1000] [--cycles 200]
    python perf/learning.py regret [--workers 100] [--cycles 100]

`beta`: workers of 200 cycles, utilities that differ by 0.5 to 2.5 either way, 10 and 15 % of reactions confused, known
from 140 labelled repetitions of each, an unknown offset of 0.4, the model `offset`: how often the 95 % interval of beta
holds it, and the bias of the estimate, with and without what `recordings/learning/bias.py` takes off.
"""

import argparse
import math
import sys
from multiprocessing import Pool
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
from simulated_choices import simulated


def one(arguments: tuple[int, int]) -> tuple[float, float, float, float]:
    """The most likely beta, that without bias, and the interval of one worker."""
    estimator = simulated(*arguments)
    fit = estimator.fit("offset")
    interval = estimator.interval(fit, "offset", 0)
    return fit.beta, interval.estimate, interval.low, interval.high


def beta(runs: int, cycles: int) -> None:
    """Print coverage and bias; the true beta is 1."""
    with Pool() as pool:  # a process per core
        found = np.array(pool.map(one, [(seed, cycles) for seed in range(runs)], chunksize=5))
    likely, estimate, low, high = found.T
    covered = ((low <= 1) & (high >= 1)).mean()
    print(f"{runs} workers of {cycles} cycles; beta is 1")
    print(f"95 % intervals that hold it: {100 * covered:.1f} %; above it {100 * (low > 1).mean():.1f} %, below "
          f"{100 * (high < 1).mean():.1f} %")  # fmt: skip
    for name, values in (("without bias", estimate), ("most likely", likely)):
        finite = values[np.isfinite(values)]
        print(f"{name}: mean {finite.mean():.4f} (standard error {finite.std() / math.sqrt(finite.size):.4f}), median "
              f"{np.median(values):.4f}, endless {values.size - finite.size}")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["beta"])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--cycles", type=int, default=200)
    chosen = parser.parse_args()
    beta(chosen.runs, chosen.cycles)

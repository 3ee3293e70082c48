"""Pairs the runs of two policies by common random numbers: in a trial both meet the same world."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows by name of their columns."""
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


def cells_of(table: pd.DataFrame) -> Iterator[tuple[str, int, pd.DataFrame]]:
    """The rows of every condition and number of cycles, in the order of the table."""
    for key, rows in table.groupby(["condition", "n_cycles"], sort=False):
        condition, n_cycles = cast(tuple[str, int], key)
        yield condition, int(n_cycles), rows


def groups_of(table: pd.DataFrame, column: str) -> Iterator[tuple[str, pd.DataFrame]]:
    """The rows of every value of a column of texts, in the order of the table."""
    for name, rows in table.groupby(column, sort=False):
        yield str(name), rows


Vector = NDArray[np.float64]

# Returns that differ by less than this fraction of them are the same.
ROUNDING = 1e-12
MAX_NAMED = 5


@dataclass(frozen=True)
class Runs:
    """A policy's runs in one cell: trial number -> discounted return; deterministic: every run would be the same."""

    policy: str
    returns: dict[int, float]
    deterministic: bool

    def missing(self, trials: Sequence[int]) -> list[int]:
        """The trials in which it is not known what the policy returns."""
        if self.deterministic:
            return [] if self.returns else [0]
        return [trial for trial in trials if trial not in self.returns]

    def in_worlds(self, trials: Sequence[int]) -> Vector:
        """The returns in the worlds of these trials; a deterministic policy returns the same in all of them."""
        if self.deterministic:
            return np.full(len(trials), next(iter(self.returns.values())))
        return np.array([self.returns[trial] for trial in trials])


@dataclass(frozen=True)
class PairedReturns:
    """The returns (n,) of two policies, row by row in the same world.

    drawn: whether chance had a part in the runs of the first, of the second.
    fault: why the runs cannot be paired, or empty; then there are no returns.
    """

    first: Vector
    second: Vector
    drawn: tuple[bool, bool]
    fault: str = ""

    @property
    def differences(self) -> Vector:
        """first - second (n,), 0 where only rounding tells them apart."""
        same = np.isclose(self.first, self.second, rtol=ROUNDING, atol=0)
        return np.where(same, 0.0, self.first - self.second)

    def constant(self) -> bool:
        """Whether the difference is the same in all worlds."""
        return not _vary(self.differences, self.first, self.second)

    def comparable_unpaired(self) -> bool:
        """Whether both are samples of at least two runs that are not all alike."""
        return all(self.drawn) and len(self.first) > 1 and (_vary(self.first) or _vary(self.second))


def _vary(values: Vector, *scale: Vector) -> bool:
    return bool(np.ptp(values) > ROUNDING * max(np.abs(sample).max() for sample in (scale or (values,))))


def runs_by_policy(trials: pd.DataFrame) -> dict[tuple[str, int, str], Runs]:
    """The runs of every condition, length and policy; a run without a return (NaN) is missing."""
    runs: dict[tuple[str, int, str], Runs] = {}
    columns = ("condition", "n_cycles", "policy", "trial", "deterministic", "discounted_return")
    rows = zip(*(trials[column].tolist() for column in columns), strict=True)
    for condition, n_cycles, policy, trial, deterministic, discounted_return in rows:
        policy_runs = runs.setdefault((condition, n_cycles, policy), Runs(policy, {}, deterministic))
        if not math.isnan(discounted_return):
            policy_runs.returns[trial] = discounted_return
    return runs


def pair_runs(first: Runs, second: Runs) -> PairedReturns:
    """Match runs by the number of their trial, which decides their common random numbers (`core.random_streams`)."""
    both = (first, second)
    drawn = (not first.deterministic, not second.deterministic)
    trials = sorted({trial for runs in both if not runs.deterministic for trial in runs.returns}) or [0]
    gaps = [(runs.policy, missing) for runs in both if (missing := runs.missing(trials))]
    if gaps:
        return PairedReturns(np.empty(0), np.empty(0), drawn, _fault(gaps))
    return PairedReturns(first.in_worlds(trials), second.in_worlds(trials), drawn)


def _fault(gaps: Sequence[tuple[str, Sequence[int]]]) -> str:
    named = []
    for policy, missing in gaps:
        numbers = ", ".join(map(str, missing[:MAX_NAMED])) + (", …" if len(missing) > MAX_NAMED else "")
        named.append(f"trial{'s' if len(missing) > 1 else ''} {numbers} of {policy}")
    single = sum(len(missing) for _, missing in gaps) == 1
    return f"{' and '.join(named)} {'is' if single else 'are'} missing"

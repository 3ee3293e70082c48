"""Numbered pieces of work whose results are kept on disk: the runs of a cell, or the judging of them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, Generic, Self, TypeVar

T = TypeVar("T")


class Job(ABC, Generic[T]):
    """One result of type T, a dataclass, for each of some trials."""

    @property
    @abstractmethod
    def name(self) -> str:
        """How the job is called in messages and files."""

    @property
    @abstractmethod
    def effort(self) -> int:
        """What a trial costs in comparison with other jobs of the same run, in cycles."""

    @abstractmethod
    def digest(self) -> str:
        """Key of the results: everything that decides them but the trial's number."""

    @abstractmethod
    def trial_numbers(self) -> Sequence[int]:
        """The trials to do."""

    def part(self, trials: Sequence[int]) -> Self:
        """The job with what it takes to do these trials: what is sent to a worker."""
        return self

    @abstractmethod
    def run(self, trials: Sequence[int]) -> dict[int, T]:
        """Do some trials."""

    @abstractmethod
    def result_of(self, row: Mapping[str, Any]) -> T:
        """The result that a file holds as JSON values. Raises KeyError, TypeError or ValueError if it is none."""

    def accepts(self, trial: int, result: T) -> bool:
        """Whether a result found is of what the job is about now; else it is done again."""
        return True

    @abstractmethod
    def outcome(self, result: T) -> tuple[Any, ...]:
        """What must be equal when a trial is repeated; times never are."""

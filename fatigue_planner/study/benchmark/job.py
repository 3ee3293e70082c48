"""Numbered pieces of work whose results are kept on disk: the runs of a cell, the judging of them, a bound."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar, Generic, Self, TypeVar

from fatigue_planner.core.files import digest_of

T = TypeVar("T")


class Job(ABC, Generic[T]):
    """One result of type T, the dataclass `result_type`, for each of some trials.

    What its comparison leaves out, such as times, may differ when a trial is repeated.
    """

    result_type: ClassVar[type[Any]]

    @property
    @abstractmethod
    def name(self) -> str:
        """How the job is called in messages and files."""

    @property
    @abstractmethod
    def effort(self) -> int:
        """What a trial costs in comparison with other jobs of the same run, in cycles."""

    @abstractmethod
    def key(self) -> Any:
        """Everything that decides the results but the trial's number, as JSON values."""

    @abstractmethod
    def trial_numbers(self) -> Sequence[int]:
        """The trials to do."""

    @property
    def trials_at_once(self) -> int:
        """How many trials are best done together."""
        return 1

    @abstractmethod
    def run(self, trials: Sequence[int]) -> dict[int, T]:
        """Do some trials."""

    def part(self, trials: Sequence[int]) -> Self:
        """The job with what it takes to do these trials: what is sent to a worker."""
        return self

    def accepts(self, trial: int, result: T) -> bool:
        """Whether a result found is of what the job is about now; else it is done again."""
        return True

    def digest(self) -> str:
        """SHA-256 of the key, under which results are kept."""
        return self._digest

    @cached_property
    def _digest(self) -> str:
        return digest_of(self.key())

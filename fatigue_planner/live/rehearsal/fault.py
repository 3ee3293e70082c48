"""What can go wrong in a shift: an extension point with a kind per fault."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from fatigue_planner.live.rehearsal.cell import Cell


@dataclass(frozen=True)
class Reaction:
    """What the server did about a fault, and whether that is right."""

    did: str
    right: bool


class Fault(ABC):
    """A fault; `rate`: in which share of the cycles it happens where nothing else is asked for."""

    name: ClassVar[str]
    rate: ClassVar[float]

    def is_possible(self, cell: Cell) -> bool:
        """Whether it can happen in this cell at all."""
        del cell
        return True

    @abstractmethod
    def happen(self, cell: Cell) -> Reaction:
        """Live through at least one cycle in which it happens; how the server reacted."""

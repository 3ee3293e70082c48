"""What a worker may do in a shift: how many slots at every station, and how hard that is."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int64]
Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# The burden of slots at stations, for all workers' spans at once: counts (n, stations) to ratios (n,).
Burden = Callable[[Counts], Vector]


@dataclass(frozen=True)
class Crew:
    """Everything that a rota is made from. Slots are equally long, so that only their number counts.

    slots    how many slots the shift has
    spans    every way in which a worker's slots may be shared among the stations, (n, stations); what is left of the
        slots is free of the line
    burden   by worker and span the largest ratio of load to acceptable load, (workers, n); infinite where the worker
        may not work at one of the stations
    """

    slots: int
    spans: Counts
    burden: Matrix

    @property
    def workers(self) -> int:
        """How many workers there are."""
        return len(self.burden)

    @property
    def stations(self) -> int:
        """How many stations there are; each has one worker in every slot."""
        return int(self.spans.shape[1])

    @classmethod
    def of(cls, slots: int, may: NDArray[np.bool_], burdens: Sequence[Burden]) -> "Crew":
        """A crew of which worker w may work at station s where may[w, s], with the burden of each worker.

        Raises ValueError if there are fewer workers than stations: each is manned all the time.
        """
        workers, stations = may.shape
        if workers < stations:
            raise ValueError(f"{workers} workers cannot man {stations} stations all the time")
        spans = spans_of(slots, stations, free=workers > stations)
        values = np.full((workers, len(spans)), np.inf)
        for worker, burden in enumerate(burdens):
            allowed = ~(spans[:, ~may[worker]] > 0).any(axis=1)
            values[worker, allowed] = burden(spans[allowed])
        return cls(slots, spans, values)


def spans_of(slots: int, stations: int, free: bool) -> Counts:
    """All ways to share slots among stations, (n, stations), in a fixed order; free: some may be left over."""
    places = stations + free
    chosen = np.array(list(combinations_with_replacement(range(places), slots)), dtype=np.int64).reshape(-1, slots)
    counts = np.zeros((len(chosen), places), dtype=np.int64)
    for place in range(places):
        counts[:, place] = (chosen == place).sum(axis=1)
    return counts[:, :stations]

"""From the number of slots of every worker at every station to who is where in which slot, with few changes."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, linear_sum_assignment, milp
from scipy.sparse import coo_array, csr_array

from fatigue_planner.station.line.spans import Counts

# The branch and bound stops after so many nodes, so that the answer does not depend on the speed of the machine.
NODES = 2000
FREE = -1


def changes_of(rota: Counts) -> int:
    """How often a worker goes to another place from a slot to the next, all together; rota (workers, slots)."""
    return int((rota[:, 1:] != rota[:, :-1]).sum())


def with_free(counts: Counts, slots: int) -> Counts:
    """Counts (workers, stations) with one more column: the slots in which a worker is free of the line."""
    return np.column_stack([counts, slots - counts.sum(axis=1)])


def decomposed(counts: Counts, slots: int) -> Counts:
    """Some rota with these counts, (workers, slots): one perfect matching after the other (König, Birkhoff).

    Free places are split into as many as workers are free at a time, so that the counts are those of a regular graph.
    """
    workers, stations = counts.shape
    square = np.zeros((workers, workers), dtype=np.int64)
    square[:, :stations] = counts
    place, room = stations, slots
    for worker in np.repeat(np.arange(workers), slots - counts.sum(axis=1)):
        square[worker, place] += 1
        room -= 1
        if not room:
            place, room = place + 1, slots
    rota = np.empty((workers, slots), dtype=np.int64)
    for slot in range(slots):
        rows, columns = linear_sum_assignment(np.where(square > 0, 0, 1))
        square[rows, columns] -= 1
        rota[rows, slot] = np.where(columns < stations, columns, FREE)
    return rota


class ChangeRows:
    """The rows of the integer program for who is where in which slot, and for the changes.

    Variables: x[w, p, t] of every pair of worker and place that is possible (p = stations is free); then changed[w, t].
    """

    def __init__(self, possible: NDArray[np.bool_], slots: int) -> None:
        self.slots = slots
        self.stations = possible.shape[1] - 1
        self.workers = len(possible)
        self.pairs = np.argwhere(possible)
        self.placed = len(self.pairs) * slots
        self.size = self.placed + self.workers * (slots - 1)

    def constraints(self) -> list[tuple[csr_array, float, float]]:
        """Each worker is at one place, each station has one worker, who moves is changed; (rows, low, high)."""
        slot = np.arange(self.slots)
        at_worker, at_place = [np.add.outer(self.pairs[:, axis] * self.slots, slot).ravel() for axis in (0, 1)]
        column = np.arange(self.placed)
        manned = at_place < self.stations * self.slots
        rows = [
            (coo_array((np.ones(self.placed), (at_worker, column)), (self.workers * self.slots, self.size)), 1.0, 1.0),
            (
                coo_array(
                    (np.ones(manned.sum()), (at_place[manned], column[manned])),
                    (self.stations * self.slots, self.size),
                ),
                1.0,
                1.0,
            ),
        ]
        later = column.reshape(len(self.pairs), self.slots)[:, 1:].ravel()
        row = np.arange(len(later))
        worker = np.repeat(self.pairs[:, 0], self.slots - 1)
        changed = self.placed + worker * (self.slots - 1) + np.tile(np.arange(self.slots - 1), len(self.pairs))
        values = np.concatenate([np.ones(len(row)), -np.ones(2 * len(row))])
        moves = coo_array(
            (values, (np.tile(row, 3), np.concatenate([later, later - 1, changed]))), (len(row), self.size)
        )
        if len(row):
            rows.append((moves, -np.inf, 0.0))
        return [(csr_array(matrix), low, high) for matrix, low, high in rows]

    def counting(self) -> coo_array:
        """How many slots a worker is at a place: a row for each pair."""
        row = np.repeat(np.arange(len(self.pairs)), self.slots)
        return coo_array((np.ones(self.placed), (row, np.arange(self.placed))), (len(self.pairs), self.size))

    def cost(self) -> NDArray[np.float64]:
        """The number of changes."""
        return np.concatenate([np.zeros(self.placed), np.ones(self.size - self.placed)])

    def rota(self, solution: NDArray[np.float64]) -> Counts:
        """Who is where: (workers, slots), FREE where free."""
        found = np.empty((self.workers, self.slots), dtype=np.int64)
        for (worker, place), at in zip(self.pairs, solution[: self.placed].reshape(-1, self.slots) > 0.5, strict=True):
            found[worker, at] = place if place < self.stations else FREE
        return found


def arranged(counts: Counts, slots: int) -> Counts:
    """A rota (workers, slots) with these counts (workers, stations) and as few changes as are found."""
    best = decomposed(counts, slots)
    full = with_free(counts, slots)
    least = int((full > 0).sum()) - len(full)
    if changes_of(best) > least:
        rows = ChangeRows(full > 0, slots)
        wanted = full[full > 0].astype(float)
        found = milp(
            rows.cost(),
            integrality=np.ones(rows.size, dtype=int),
            bounds=Bounds(0, 1),
            constraints=[
                *(LinearConstraint(*each) for each in rows.constraints()),
                LinearConstraint(csr_array(rows.counting()), wanted, wanted),
            ],
            options={"node_limit": NODES, "mip_rel_gap": 0.0},
        )
        if found.x is not None and changes_of(rows.rota(found.x)) < changes_of(best):
            best = rows.rota(found.x)
    return best

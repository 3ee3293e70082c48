"""The rota that burdens a crew least: least largest burden, then fairness, then fewest changes, by integer programming.

A burden depends on how many slots a worker spends at which station, not on their order. So the program first chooses a
span (these numbers) for every worker, such that each station is manned in every slot; numbers like that can always be
put into an order (a theorem of König). This takes the symmetry of the slots out, and allows any burden, also one that
is not a sum. Of large crews not all spans are looked at: those that linear programming asks for (column generation);
what is found is compared with the bound of linear programming.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import coo_array, csr_array, hstack, vstack

from fatigue_planner.station.line.slots import NODES, ChangeRows, arranged, changes_of, with_free
from fatigue_planner.station.line.spans import Counts, Crew, Matrix, Vector

# So many pairs of worker and span are looked at all together; of more, those that are asked for.
MOST_COLUMNS = 20_000
# How many spans of each worker are added at a time.
AT_A_TIME = 20
# Burdens and sums of squares that differ by less, as a share, count as equal: it is what the solver resolves.
TOLERANCE = 1e-5
# What is missing in a relaxation that cannot be kept to is more than this, which is rounding.
INFEASIBLE_ABOVE = 1e-7
# Where not all spans are looked at, burdens that differ by less, as a share, are not told apart.
STEP = 1e-3
# What `milp` calls its ends.
SOLVED, INFEASIBLE = 0, 2
# A larger joint program for the changes is not tried.
MOST_JOINT = 4000


@dataclass(frozen=True)
class Rota:
    """Who works where in which slot.

    places      (workers, slots): the number of the station, -1 where free of the line
    burdens     (workers,): of each worker, by the crew's measure
    burden_bound  what no rota's largest burden is below; fairness and its bound: the sum of the squares of the burdens,
        each as a share of the largest one; changes and their bound: how often a worker goes elsewhere
    """

    places: Counts
    burdens: Vector
    burden_bound: float
    fairness: float
    fairness_bound: float
    changes: int
    changes_bound: int

    @property
    def largest(self) -> float:
        """The largest burden of a worker."""
        return float(self.burdens.max())

    @property
    def exact(self) -> bool:
        """Whether all three numbers are proven to be the least."""
        return (
            self.largest <= self.burden_bound * (1 + TOLERANCE)
            and self.fairness <= self.fairness_bound + TOLERANCE * len(self.burdens)
            and self.changes == self.changes_bound
        )


class Columns:
    """The pairs of worker and span that are looked at, and the rows that they have to keep to."""

    def __init__(self, crew: Crew) -> None:
        self.crew = crew
        self.inside = np.isfinite(crew.burden)
        self.complete = int(self.inside.sum()) <= MOST_COLUMNS
        # whether every integer program so far was solved to its end, over all spans
        self.proven = self.complete
        if not self.complete:
            unmoving = (crew.spans > 0).sum(axis=1) <= 1
            self.inside &= unmoving[None, :]

    def allowed(self, limit: float) -> NDArray[np.int64]:
        """The pairs (n, 2) up to a burden."""
        return np.argwhere(self.inside & (self.crew.burden <= limit))

    def rows(self, pairs: NDArray[np.int64]) -> csr_array:
        """One span for each worker, then every station manned in every slot: (workers + stations, n)."""
        crew = self.crew
        one = coo_array((np.ones(len(pairs)), (pairs[:, 0], np.arange(len(pairs)))), (crew.workers, len(pairs)))
        manned = csr_array(crew.spans[pairs[:, 1]].T.astype(float))
        return csr_array(vstack([one, manned], format="csr"))

    def wanted(self) -> Vector:
        """The right-hand side of the rows."""
        return np.concatenate([np.ones(self.crew.workers), np.full(self.crew.stations, float(self.crew.slots))])

    def relaxed(self, limit: float, cost: Matrix | None) -> float:
        """The bound of linear programming with burdens up to a limit; adds the spans that it asks for.

        cost: by worker and span, (workers, n); None: 0 if it can be kept to, else above 0. Infinite if it cannot.
        """
        crew, wanted = self.crew, self.wanted()
        under = crew.burden <= limit
        while True:
            pairs = self.allowed(limit)
            own = np.zeros(len(pairs)) if cost is None else cost[pairs[:, 0], pairs[:, 1]]
            high = 1.0 if cost is None else 1e4
            rows = self.rows(pairs)
            missing = csr_array(np.eye(len(wanted)))
            found = linprog(
                np.concatenate([own, np.full(len(wanted), high)]),
                A_eq=hstack([rows, missing], format="csr"),
                b_eq=wanted,
                method="highs",
            )
            assert found.x is not None and found.fun is not None, "what is missing has a price, so there is a solution"
            absent = float(found.x[len(pairs) :].sum())
            price = np.asarray(found.eqlin.marginals)
            gain = price[: crew.workers, None] + (crew.spans @ price[crew.workers :])[None, :]
            reduced = (0.0 if cost is None else cost) - gain
            open_ = under & ~self.inside & (reduced < -1e-7)
            if self.complete or not open_.any() or (cost is None and absent <= INFEASIBLE_ABOVE):
                return float(found.fun) if cost is None or absent <= INFEASIBLE_ABOVE else np.inf
            for worker in range(crew.workers):
                asked = np.flatnonzero(open_[worker])
                best = asked[np.argsort(reduced[worker, asked], kind="stable")[:AT_A_TIME]]
                self.inside[worker, best] = True

    def solved(self, limit: float, cost: Matrix | None, more: list[LinearConstraint] | None = None) -> Counts | None:
        """Counts (workers, stations) of least cost with burdens up to a limit, of the spans that are looked at."""
        pairs = self.allowed(limit)
        own = np.zeros(len(pairs)) if cost is None else cost[pairs[:, 0], pairs[:, 1]]
        wanted = self.wanted()
        found = milp(
            own,
            integrality=np.ones(len(pairs), dtype=int),
            bounds=Bounds(0, 1),
            constraints=[LinearConstraint(self.rows(pairs), wanted, wanted), *(more or [])],
            options={"node_limit": NODES, "mip_rel_gap": 0.0},
        )
        self.proven &= found.status in (SOLVED, INFEASIBLE)
        if found.x is None:
            return None
        counts = np.zeros((self.crew.workers, self.crew.stations), dtype=np.int64)
        for worker, span in pairs[found.x > 0.5]:
            counts[worker] = self.crew.spans[span]
        return counts


def best_rota(crew: Crew) -> Rota | None:
    """The rota of least largest burden; of these the fairest, of these one with fewest changes. None if there is none.

    Fairest is the least sum of squares: it moves burden from those who bear much to those who bear little, and never
    burdens anybody more for the sake of equality alone.
    """
    columns = Columns(crew)
    lowest = _least_limit(columns)
    if lowest is None:
        return None
    bound, limit = lowest
    cost = _squares(crew, limit)
    fair_bound = columns.relaxed(limit, cost)
    counts = columns.solved(limit, cost)
    assert counts is not None, "the limit was kept to"
    fairness = _cost(crew, counts, cost)
    if columns.proven:
        fair_bound = fairness
    rota, changes_bound = _fewest_changes(columns, limit, cost, fairness, counts)
    burdens = burdens_of(crew, counts_of(rota, crew.stations))
    return Rota(rota, burdens, bound, _cost(crew, counts_of(rota, crew.stations), cost), fair_bound,
                changes_of(rota), changes_bound)  # fmt: skip


def least_burden(crew: Crew, below: float = np.inf) -> float | None:
    """The largest burden of the best rota; None if there is no rota, or none whose largest burden is below so much."""
    lowest = _least_limit(Columns(crew), below)
    return None if lowest is None else lowest[1]


def counts_of(places: Counts, stations: int) -> Counts:
    """How many slots every worker is at every station, (workers, stations)."""
    return np.stack([(places == station).sum(axis=1) for station in range(stations)], axis=1)


def burdens_of(crew: Crew, counts: Counts) -> Vector:
    """The burden of each worker with these counts, (workers,)."""
    known = {tuple(span): number for number, span in enumerate(crew.spans.tolist())}
    return np.array([crew.burden[worker, known[tuple(row)]] for worker, row in enumerate(counts.tolist())])


def _cost(crew: Crew, counts: Counts, cost: Matrix) -> float:
    return float(burdens_of(replace(crew, burden=cost), counts).sum())


def _least_limit(columns: Columns, below: float = np.inf) -> tuple[float, float] | None:
    """What no largest burden is below, and the least one that was found; None if stations cannot be manned so."""
    every = np.unique(columns.crew.burden[columns.crew.burden < below])
    values = every if columns.complete else _apart(every)
    if not len(values) or columns.relaxed(values[-1], None) > INFEASIBLE_ABOVE:
        return None
    if np.isfinite(below):
        columns.relaxed(values[-1], _squares(columns.crew, values[-1]))  # asks for more spans
        if columns.solved(values[-1], None) is None:
            return None
    low, high = 0, len(values) - 1  # the least index whose relaxation can be kept to
    while low < high:
        middle = (low + high) // 2
        if columns.relaxed(values[middle], None) <= INFEASIBLE_ABOVE:
            high = middle
        else:
            low = middle + 1
    bound = float(every[np.searchsorted(every, values[low - 1], side="right")] if low else every[0])
    step, under, above = 1, low - 1, low
    while columns.solved(values[above], None) is None:
        if above == len(values) - 1:
            return None
        under, above, step = above, min(above + step, len(values) - 1), 2 * step
        columns.relaxed(values[above], None)
    while above - under > 1:
        middle = (above + under) // 2
        if columns.solved(values[middle], None) is None:
            under = middle
        else:
            above = middle
    return (float(values[above]) if columns.proven else bound), float(values[above])


def _squares(crew: Crew, limit: float) -> Matrix:
    """The squares of the burdens up to a limit, as shares of it, (workers, n); 0 above it."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(crew.burden <= limit, (crew.burden / (limit if limit > 0 else 1.0)) ** 2, 0.0))


def _apart(values: Vector) -> Vector:
    """Of values in order so many that none is further than STEP below one of them."""
    with np.errstate(divide="ignore"):
        steps = np.floor(np.log(values) / math.log1p(STEP))
    return values[np.append(steps[1:] > steps[:-1], True)] if len(values) else values


def _fewest_changes(
    columns: Columns, limit: float, cost: Matrix, fairness: float, counts: Counts
) -> tuple[Counts, int]:
    """A rota (workers, slots) as fair as that, with few changes, and what no such rota has fewer changes than."""
    crew = columns.crew
    pairs = columns.allowed(limit)
    squares, most = csr_array(cost[pairs[:, 0], pairs[:, 1]][None, :]), fairness + TOLERANCE * crew.workers
    full = np.column_stack([crew.spans, crew.slots - crew.spans.sum(axis=1)])
    stays = np.broadcast_to(((full > 0).sum(axis=1) - 1).astype(float), crew.burden.shape)
    fewer = columns.solved(limit, stays, [LinearConstraint(squares, -np.inf, most)])
    counts = counts if fewer is None else fewer
    rota = arranged(counts, crew.slots)
    bound = int((with_free(counts, crew.slots) > 0).sum()) - crew.workers
    if changes_of(rota) > bound and columns.proven:
        rows = ChangeRows(np.ones((crew.workers, crew.stations + 1), dtype=bool), crew.slots)
        if len(pairs) + rows.size <= MOST_JOINT:
            return _joint(columns, pairs, (squares, most), rows)
    if not columns.proven:
        bound = max(math.ceil(columns.relaxed(limit, stays) - TOLERANCE), 0)
    return rota, bound


def _joint(
    columns: Columns, pairs: NDArray[np.int64], fair: tuple[csr_array, float], rows: ChangeRows
) -> tuple[Counts, int]:
    """Spans and slots chosen in one program."""
    crew, wanted = columns.crew, columns.wanted()
    full = np.column_stack([crew.spans, crew.slots - crew.spans.sum(axis=1)])[pairs[:, 1]]
    place_of = rows.pairs[:, 1]
    own = (rows.pairs[:, 0][:, None] == pairs[:, 0][None, :]) * full[:, place_of].T
    size = len(pairs)
    constraints = [
        LinearConstraint(_widened(columns.rows(pairs), 0, rows.size), wanted, wanted),
        LinearConstraint(_widened(fair[0], 0, rows.size), -np.inf, fair[1]),
        *(LinearConstraint(_widened(matrix, size, 0), low, high) for matrix, low, high in rows.constraints()),
        LinearConstraint(hstack([csr_array(-own.astype(float)), rows.counting()], format="csr"), 0.0, 0.0),
    ]
    found = milp(
        np.concatenate([np.zeros(size), rows.cost()]),
        integrality=np.ones(size + rows.size, dtype=int),
        bounds=Bounds(0, 1),
        constraints=constraints,
        options={"mip_rel_gap": 0.0},
    )
    assert found.x is not None, "the rota that is known keeps to it"
    rota = rows.rota(found.x[size:])
    return rota, changes_of(rota)


def _widened(matrix: csr_array, before: int, after: int) -> csr_array:
    rows = matrix.shape[0]
    parts = [csr_array((rows, before)), matrix, csr_array((rows, after))]
    return csr_array(hstack([part for part in parts if part.shape[1]], format="csr"))

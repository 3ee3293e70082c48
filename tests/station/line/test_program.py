"""The rota of a line: the integer program finds what looking at every rota finds."""

from functools import partial
from itertools import permutations

import numpy as np
import pytest

from fatigue_planner.station.line import program
from fatigue_planner.station.line.program import STEP, TOLERANCE, best_rota, burdens_of, counts_of, least_burden
from fatigue_planner.station.line.slots import FREE, changes_of, decomposed
from fatigue_planner.station.line.spans import Counts, Crew, Matrix, spans_of


def largest_sum(load: Matrix, counts: Counts) -> Matrix:
    """The largest sum over the slots of any region; load (stations, regions), counts (n, stations)."""
    return np.asarray((counts @ load).max(axis=1))


def random_crew(workers: int, stations: int, slots: int, seed: int) -> Crew:
    """Burdens that are sums over the slots, the largest of three regions; of every other seed, any at all."""
    random = np.random.default_rng(seed)
    load = random.uniform(0, 1, (workers, stations, 3))
    may = random.uniform(size=(workers, stations)) > 0.1
    crew = Crew.of(slots, may, [partial(largest_sum, own) for own in load])
    if seed % 2:
        crew.burden[np.isfinite(crew.burden)] = random.uniform(size=np.isfinite(crew.burden).sum())
    return crew


def every_rota(crew: Crew) -> tuple[float, float, int] | None:
    """Least largest burden, then sum of squares, then changes, of all rotas, one by one."""
    stations, slots = crew.stations, crew.slots
    ways = np.array([
        [order.index(worker) if worker in order else FREE for worker in range(crew.workers)]
        for order in permutations(range(crew.workers), stations)
    ])  # fmt: skip
    weight = np.append((slots + 1) ** np.arange(stations), 0)  # the last is that of FREE
    table = np.full((crew.workers, (slots + 1) ** stations), np.inf)
    table[:, crew.spans @ weight[:-1]] = crew.burden
    differ = (ways[:, None] != ways[None]).sum(axis=2)
    code, changes = weight[ways], np.zeros(len(ways), dtype=int)
    for _ in range(slots - 1):
        code = code[..., None, :] + weight[ways]
        changes = changes[..., None] + np.broadcast_to(differ, (*changes.shape, len(ways)))
    burden = np.stack([table[worker, code[..., worker]] for worker in range(crew.workers)])
    largest = burden.max(axis=0)
    if not np.isfinite(least := largest.min()):
        return None
    squares = ((burden / least) ** 2).sum(axis=0)
    fairness = squares[largest <= least].min()
    fair = (largest <= least) & (squares <= fairness + TOLERANCE * crew.workers)
    return float(least), float(fairness), int(changes[fair].min())


def check(seed: int) -> None:
    random = np.random.default_rng([seed, 7])
    workers = int(random.integers(1, 5))
    crew = random_crew(workers, int(random.integers(1, workers + 1)), int(random.integers(1, 5)), seed)
    found, wanted = best_rota(crew), every_rota(crew)
    if wanted is None:
        assert found is None and least_burden(crew) is None
        return
    assert found is not None and found.exact
    assert found.largest == pytest.approx(wanted[0], rel=1e-9)
    assert found.fairness == pytest.approx(wanted[1], abs=2 * TOLERANCE * workers)
    assert found.changes == wanted[2] == changes_of(found.places)
    assert least_burden(crew) == least_burden(crew, np.nextafter(found.largest, np.inf)) == found.largest
    assert least_burden(crew, found.largest) is None
    for station in range(crew.stations):
        assert ((found.places == station).sum(axis=0) == 1).all()
    assert (found.burdens == burdens_of(crew, counts_of(found.places, crew.stations))).all()


@pytest.mark.parametrize("seed", range(6))
def test_it_is_what_looking_at_every_rota_finds(seed: int) -> None:
    check(seed)


@pytest.mark.slow
def test_so_it_is_on_200_random_lines() -> None:
    for seed in range(200):
        check(seed)


@pytest.mark.slow
def test_of_a_crew_of_twelve_the_largest_burden_is_proven_least_and_the_other_gaps_are_stated() -> None:
    found = best_rota(random_crew(12, 12, 8, 2))
    assert found is not None
    assert found.burden_bound <= found.largest <= 1.02 * found.burden_bound
    assert found.fairness_bound <= found.fairness <= 1.05 * found.fairness_bound
    assert 0 <= found.changes_bound <= found.changes
    assert sorted(found.places[:, 0]) == list(range(12))


def test_asking_for_spans_finds_what_all_spans_do(monkeypatch: pytest.MonkeyPatch) -> None:
    crew = random_crew(4, 4, 4, 8)
    whole = best_rota(crew)
    monkeypatch.setattr(program, "MOST_COLUMNS", 0)
    asked = best_rota(crew)
    assert whole is not None and asked is not None
    assert asked.burden_bound <= whole.largest * (1 + 1e-9) and whole.largest <= asked.largest * (1 + 1e-9)
    assert whole.largest <= (least_burden(crew) or 0) * (1 + 1e-9) <= asked.largest * (1 + STEP)
    assert asked.fairness_bound <= asked.fairness
    assert asked.changes_bound <= asked.changes


def test_a_crew_too_small_for_its_stations_is_refused() -> None:
    with pytest.raises(ValueError, match="1 workers cannot man 2 stations"):
        Crew.of(2, np.ones((1, 2), dtype=bool), [lambda counts: counts.sum(axis=1)])


def test_all_spans_share_the_slots() -> None:
    assert len(spans_of(8, 12, free=False)) == 75_582
    assert (spans_of(3, 2, free=False).sum(axis=1) == 3).all()
    assert sorted(map(tuple, spans_of(1, 2, free=True).tolist())) == [(0, 0), (0, 1), (1, 0)]


def test_any_counts_can_be_put_into_slots() -> None:
    random = np.random.default_rng(3)
    places = np.array([random.permutation([0, 1, 2, FREE, FREE]) for _ in range(6)]).T
    counts = counts_of(places, 3)
    rota = decomposed(counts, 6)
    assert (counts_of(rota, 3) == counts).all()
    assert all(((rota == station).sum(axis=0) == 1).all() for station in range(3))

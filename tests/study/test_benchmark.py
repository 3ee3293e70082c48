"""The benchmark: paired worlds, resuming, and the same bytes whatever the workers and interruptions."""

import json
import math
import random
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import Machine
from small_problems import STARTS, belief_in, small_model

from fatigue_planner.core.errors import DamagedFileError, MissingTableError, SelectionError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.files import publish_with_checksum
from fatigue_planner.core.random_streams import RandomNumbers, draw_random_numbers, random_stream
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import GreedySettings, RandomSettings
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, plain_decision
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.fatigue_pomdp import one_worker
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import replay
from fatigue_planner.study.benchmark.runner import TrialStore, run_grid
from fatigue_planner.study.benchmark.selection import choose
from fatigue_planner.study.benchmark.tables import (
    ACTIONS_FILE,
    KEY,
    OUTCOMES,
    SAME,
    TRIALS_FILE,
    publish_table,
    read_table,
    trial_table,
)
from fatigue_planner.study.benchmark.trial import TrialResult, run_trial

SEARCH = PomcpSettings(kind="pomcp", backup="mean", exploration_constant=0.01, descents=60)


def cell_of(condition: str, one: Scenario, n_cycles: int, policy: str, settings: PolicySettings) -> Cell:
    return Cell(condition, n_cycles, policy, settings, one, seed=7, trials=12)


@pytest.fixture(scope="module")
def cells() -> list[Cell]:
    """The paper's conditions in a small task that was made up."""
    rest, several = np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0], *STARTS])
    conditions = {
        "single_novice": (0.0, rest, [1.0]),
        "single_expert": (math.inf, rest, [1.0]),
        "multiple_novice": (0.0, several, [0.2, 0.4, 0.4]),
    }
    scenarios = {}
    for name, (expertise, starts, weights) in conditions.items():
        belief = belief_in(small_model(expertise), starts, weights)
        scenarios[name] = Scenario(belief.model, belief.states, belief.weights, None, ExactSettings(kind="exact"))
    policies = {"random": RandomSettings(kind="random"), "greedy": GreedySettings(kind="greedy"), "search": SEARCH}
    return [
        cell_of(condition, one, n_cycles, policy, settings)
        for condition, one in scenarios.items()
        for n_cycles in (2, 5)
        for policy, settings in policies.items()
    ]


class Fixed(Policy):
    """Always the same action; remembers what it was asked."""

    def __init__(self, action: int) -> None:
        self.action = action
        self.beliefs: list[Belief] = []
        self.observed: list[tuple[int, int]] = []

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        self.beliefs.append(belief)
        rng.random(3)
        return plain_decision(self.action, np.zeros(2), 0, 0.0, "always the same", belief)

    def observe(self, action: int, observation: int) -> None:
        self.observed.append((action, observation))


def test_return_is_the_discounted_sum_by_hand(cells: list[Cell]) -> None:
    """The policy hears of every cycle, and its belief follows what happened."""
    cell = cells[0]
    model, policy = cell.scenario.model, Fixed(1)
    world = RandomNumbers(np.zeros(3), 0.0, np.array([0.1, 0.9]), np.zeros(2))
    result = run_trial(cell.scenario, policy, "prior", 2, world, np.random.default_rng(0))
    gain, offset = model.arrays.gain, model.arrays.offset  # rows: action * 2 + preference
    first = gain[2] * 0 + offset[2]
    second = gain[3] * first + offset[3]
    costs = [(f**2).sum() / model.entries for f in (first, second)]
    assert result.discounted_return == pytest.approx(-costs[0] - 0.95 * costs[1])
    assert result.final_cost == pytest.approx(costs[1]) and result.peak_cost == pytest.approx(max(costs))
    assert policy.observed == [(1, 0), (1, 1)]
    np.testing.assert_allclose(policy.beliefs[1].states[0, :-1], first)


def test_worlds_depend_on_condition_length_and_trial_only() -> None:
    base = draw_random_numbers(1, "novice", 5, 0)
    again = draw_random_numbers(1, "novice", 5, 0)
    for name in ("worker", "preference", "observation"):
        np.testing.assert_array_equal(getattr(base, name), getattr(again, name))
    for other in (
        draw_random_numbers(2, "novice", 5, 0),
        draw_random_numbers(1, "expert", 5, 0),
        draw_random_numbers(1, "novice", 5, 1),
    ):
        assert not np.array_equal(base.preference, other.preference) and base.start != other.start
        assert not np.array_equal(base.worker, other.worker) and not np.array_equal(base.observation, other.observation)
    assert not np.array_equal(draw_random_numbers(1, "novice", 20, 0).preference[:5], base.preference)


def test_all_policies_meet_the_same_worker_and_cannot_see_him(cells: list[Cell]) -> None:
    """Reactions follow the world's draws alone, however much a policy draws; its stream is its own."""
    cell = cells[0]
    world = draw_random_numbers(3, "c", 30, 4)
    starts = []
    for seed in (0, 1):
        policy = Fixed(0)
        run_trial(cell.scenario, policy, "prior", 30, world, np.random.default_rng(seed))
        starts.append(policy.beliefs[-1].states)
    np.testing.assert_array_equal(*starts)
    planner, chance = (
        random_stream(3, "planner", "c", 30, 4, "p").random(1000),
        random_stream(3, "preference", "c", 30, 4).random(1000),
    )
    assert abs(np.corrcoef(planner, chance)[0, 1]) < 5 / np.sqrt(1000)  # false alarm 6e-7


def test_every_run_plans_with_draws_of_its_own(cells: list[Cell], monkeypatch: pytest.MonkeyPatch) -> None:
    """No number a policy draws is drawn by another one, in another run or by the world."""
    drawn: list[float] = []

    class Drawing(Fixed):
        def observe(self, action: int, observation: int) -> None:
            drawn.extend(self.numbers)

        def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
            self.numbers = rng.random(5)
            return super().act(belief, rng)

    for kind in {type(cell.settings) for cell in cells}:
        monkeypatch.setattr(kind, "build", lambda _: Drawing(0))
    for cell in cells:
        cell.run([0, 1])
    for key in {(cell.seed, cell.condition, cell.n_cycles) for cell in cells}:
        for world in (draw_random_numbers(*key, trial) for trial in (0, 1)):
            drawn += [*world.worker, world.start, *world.preference, *world.observation]
    assert len(set(drawn)) == len(drawn) > 10 * len(cells)


def test_novices_choose_evenly_and_start_with_the_initial_probabilities(
    paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """Reactions and starts counted from what runs came to; binomial and chi-square, false alarm 1e-6 each."""
    from scipy.stats import binomtest, chisquare

    condition = "multiple_novice"
    one = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions[condition])
    costs = np.array([[-one.model.transition(state, 0, u)[1] for u in range(2)] for state in one.states])
    assert len(set(costs.ravel())) == costs.size  # the cost tells which start and preference it was
    seen = np.zeros(costs.shape, dtype=int)
    for trial in range(3000):
        world = draw_random_numbers(2023, condition, 1, trial)
        result = run_trial(one, Fixed(0), "prior", 1, world, np.random.default_rng(0))
        seen[costs == result.final_cost] += 1
    assert seen.sum() == 3000
    assert binomtest(int(seen[:, 0].sum()), 3000).pvalue > 1e-6
    assert chisquare(seen.sum(axis=1), [600, 1200, 1200]).pvalue > 1e-6


def test_what_is_deterministic_is_run_once(cells: list[Cell]) -> None:
    from dataclasses import replace

    runs = {cell.name: len(cell.trial_numbers()) for cell in cells}
    assert runs["single_expert/5/greedy"] == runs["single_expert/5/search"] == 1
    assert runs["single_expert/5/random"] == runs["single_novice/5/greedy"] == runs["multiple_novice/2/search"] == 12
    search = next(cell for cell in cells if cell.name == "single_expert/5/search")
    for settings, expected in (
        (LookaheadSettings(kind="lookahead", depth=2), 1),
        (LookaheadSettings(kind="lookahead", depth=2, leaf_value="random_rollout"), 12),
        (SEARCH.model_copy(update={"descents": None, "seconds": 0.1}), 12),
    ):
        assert len(replace(search, settings=settings).trial_numbers()) == expected
    assert len(set(search.run(range(5)).values())) == 1


def table_bytes(cells: list[Cell], store: Path, out: Path, jobs: int) -> bytes:
    results, warnings = run_grid(cells, store, LocalProcesses(jobs), lambda cell, n: None)
    assert warnings == []
    publish_table(out, trial_table(cells, results), [TRIALS_FILE, ACTIONS_FILE])
    return b"".join((out / name).read_bytes() for name in (TRIALS_FILE, ACTIONS_FILE))


@pytest.mark.slow
def test_table_is_the_same_for_any_workers_and_after_interruption(cells: list[Cell], tmp_path: Path) -> None:
    one = table_bytes(cells, tmp_path / "a", tmp_path / "a", 1)
    two = table_bytes(cells, tmp_path / "b", tmp_path / "b", 2)
    # an interrupted run: some parts are missing, a temporary file was left behind
    parts = sorted((tmp_path / "b").glob("*/*.json"))
    random.Random(0).shuffle(parts)
    for part in parts[: len(parts) // 2]:
        part.unlink()
    (parts[-1].parent / ".0-9.123.json").write_text("{")
    resumed = table_bytes(cells, tmp_path / "b", tmp_path / "c", 2)
    assert one == two == resumed
    assert table_bytes(cells, tmp_path / "b", tmp_path / "d", 2) == one  # nothing left to do


def test_more_trials_reuse_the_first_ones(cells: list[Cell], tmp_path: Path) -> None:
    from dataclasses import replace

    few = [replace(cells[0], trials=3)]
    run_grid(few, tmp_path, LocalProcesses(1), lambda cell, n: None)
    first = sorted(path.name for path in tmp_path.glob("*/*.json"))
    results, _ = run_grid([cells[0]], tmp_path, LocalProcesses(1), lambda cell, n: None)
    assert sorted(results[0]) == list(range(12))
    assert first == ["0-2.json"] and (tmp_path / cells[0].digest()[:16] / "3-11.json").exists()


def test_key_of_a_cell_knows_what_decides_its_trials(cells: list[Cell]) -> None:
    from dataclasses import replace

    cell = cells[0]
    one = cell.scenario
    model = one.model
    maps = model.arrays
    scenarios = [
        replace(one, model=replace(model, discount=0.9)),
        replace(one, model=model.for_workers(one_worker(1.0))),
        replace(one, model=replace(model, arrays=maps._replace(gain=maps.gain * 0.999))),
        replace(one, states=one.states + 0.1),
    ]
    others = [
        replace(cell, seed=8), replace(cell, n_cycles=3), replace(cell, policy="p"), replace(cell, condition="c"),
        replace(cell, settings=SEARCH), replace(cell, settings=SEARCH.model_copy(update={"descents": 61})),
        *(replace(cell, scenario=other) for other in scenarios),
    ]  # fmt: skip
    assert len({cell.digest(), *(other.digest() for other in others)}) == 1 + len(others)
    assert replace(cell, trials=99).digest() == cell.digest()


def test_key_of_a_cell_knows_sources_and_libraries(cells: list[Cell], machine: Machine) -> None:
    def key() -> str:
        return replace(cells[0]).digest()  # a new one: a cell knows its own

    same = key()
    files = (
        "fatigue/model.py",
        "pomdp/beliefs/exact.py",
        "planners/pomcp/policy.py",
        "study/benchmark/trial.py",
        "core/random_streams.py",
        "core/jit.py",
        "core/pcg64.py",
    )
    keys = [machine.with_another_file(file, key) for file in files]
    keys += [machine.with_another_version(name, key) for name in ("numpy", "numba", "scipy")]
    assert len({same, *keys}) == len(keys) + 1
    for file in ("motion/simulator.py", "study/statistics/pairing.py", "cli/benchmark.py"):
        assert machine.with_another_file(file, key) == same


def test_damaged_part_is_set_aside_and_run_again(cells: list[Cell], tmp_path: Path) -> None:
    run_grid(cells[:1], tmp_path, LocalProcesses(1), lambda cell, n: None)
    part = sorted(tmp_path.glob("*/*.json"))[0]
    intact = json.loads(part.read_text())["trials"]
    for count, damage in enumerate(("{", '{"sha256": "0"}'), start=1):
        part.write_text(damage)
        results, warnings = run_grid(cells[:1], tmp_path, LocalProcesses(1), lambda cell, n: None)
        assert len(warnings) == 1 and "set aside" in warnings[0]
        assert part.with_suffix(f".damaged-{count}").exists()
        assert results[0][0].discounted_return == intact[0]["discounted_return"]


def test_a_part_of_another_cell_is_set_aside(cells: list[Cell], tmp_path: Path) -> None:
    run_grid([cells[2]], tmp_path, LocalProcesses(1), lambda cell, n: None)
    ours, theirs = (tmp_path / cell.digest()[:16] for cell in (cells[2], cells[1]))
    ours.rename(theirs)
    store = TrialStore(tmp_path)
    assert store.load(cells[1]) == {} and len(store.warnings) == len(list(theirs.glob("*.damaged-1"))) == 3


def test_two_results_of_one_trial_are_an_error_that_shows_both(cells: list[Cell], tmp_path: Path) -> None:
    store = TrialStore(tmp_path)
    store.add(cells[0], {0: TrialResult(-1.0, 0.1, 0.1, 0, 0, (0, 1)), 1: TrialResult(-2.0, 0.1, 0.1, 0, 0, (0, 1))})
    store.add(cells[0], {0: TrialResult(-1.0, 0.1, 0.1, 5, 5, (0, 1))})
    assert store.load(cells[0])[0].discounted_return == -1.0  # equal but for its times
    store.add(cells[0], {0: TrialResult(-1.5, 0.1, 0.1, 0, 0, (0, 1)), 2: TrialResult(-3.0, 0.1, 0.1, 0, 0, (0, 1))})
    with pytest.raises(DamagedFileError, match=r"-1\.0.*-1\.5|-1\.5.*-1\.0"):
        store.load(cells[0])


def test_two_rows_of_a_trial_in_one_part_are_an_error_too(cells: list[Cell], tmp_path: Path) -> None:
    """Equal ones are ignored; so are times."""
    cell = cells[0]
    rows = [{"trial": 0, **asdict(result)} for result in cell.run([0, 0, 1]).values()]
    path = tmp_path / cell.digest()[:16] / "0-0.json"
    publish_with_checksum(path, {"cell": cell.name, "digest": cell.digest(), "trials": rows[:1] * 2})
    assert list(TrialStore(tmp_path).load(cell)) == [0]
    publish_with_checksum(path, {"cell": cell.name, "digest": cell.digest(), "trials": rows})
    with pytest.raises(DamagedFileError, match="trial 0 of single_novice/2/random has two results"):
        TrialStore(tmp_path).load(cell)


def test_table_is_tidy_and_checked_on_reading(cells: list[Cell], tmp_path: Path) -> None:
    with pytest.raises(MissingTableError, match="fatplan benchmark"):
        read_table(tmp_path, TRIALS_FILE, "fatplan benchmark")
    results, _ = run_grid(cells[:2], tmp_path / "parts", LocalProcesses(1), lambda cell, n: None)
    made = trial_table(cells[:2], results)
    publish_table(tmp_path, made, [TRIALS_FILE])
    table = read_table(tmp_path, TRIALS_FILE, "fatplan benchmark")
    assert list(table.columns) == [*KEY, SAME, *OUTCOMES] and len(table) == 24
    np.testing.assert_array_equal(table[OUTCOMES], made[OUTCOMES])  # to the last bit
    path = tmp_path / TRIALS_FILE
    lines = path.read_text().splitlines()
    for bad, message in (
        (lines[:3] + lines[2:3], "has duplicate rows: single_novice/2/random/1. Run"),
        ([*lines[:3], lines[2][:-3] + "999"], r"random/1, with different values: \(.*\) and \(.*999\)\. Run"),
        ([lines[0].replace("trial", "run"), *lines[1:]], "columns"),
        ([*lines[:2], lines[2][:-25] + ","], "gaps"),
        ([*lines[:2], lines[2].replace("-0.", "-x.")], "not one of our tables"),
    ):
        path.write_text("\n".join(bad) + "\n")
        with pytest.raises(DamagedFileError, match=message):
            read_table(tmp_path, TRIALS_FILE, "fatplan benchmark")


def test_a_run_is_lived_through_again_from_its_actions(cells: list[Cell]) -> None:
    for cell in cells:
        for trial, result in cell.run(cell.trial_numbers()[:3]).items():
            course = replay(cell, trial, result.actions)
            assert course.discounted_return == result.discounted_return  # to the last bit
            assert course.fatigue.shape == (cell.n_cycles, 3) and len(course.observations) == cell.n_cycles
            assert (course.fatigue[-1] ** 2).sum() / 3 == pytest.approx(result.final_cost, rel=1e-12)


def test_choose_names_what_is_not_there() -> None:
    assert choose("cycles", (5, 20, 100), [100, 5]) == [5, 100]
    assert choose("cycles", (5, 20), None) == [5, 20]
    with pytest.raises(SelectionError, match="--cycles 7: not in the experiment; available: 5, 20"):
        choose("cycles", (5, 20), [5, 7])

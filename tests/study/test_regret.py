"""Regret and bounds: by hand, and as a benchmark reports them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.random_streams import draw_random_numbers
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import AlternatingSettings, GreedySettings
from fatigue_planner.planners.bounds.cost_bound import bound_of
from fatigue_planner.planners.lookahead import (
    LookaheadPolicy,
    LookaheadSettings,
    ReferenceSettings,
    describe,
    reference_for,
)
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.fatigue_pomdp import one_worker
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE, bound_jobs, bound_rows, publish_bounds
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.regret import RegretJob
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.tables import REGRET_FILE, REGRETS, publish_table, read_table, regret_rows
from fatigue_planner.study.benchmark.trial import Episode
from fatigue_planner.study.statistics.comparison import comparison_table
from fatigue_planner.study.statistics.regret import gap_table, gap_text, regret_table, regret_text

REFERENCE = ReferenceSettings(kind="lookahead", depth=3)
SAME = LookaheadSettings(kind="lookahead", depth=3)


@pytest.fixture(scope="module")
def scenarios(paper: Experiment, reactions: tuple[Reaction, ...]) -> dict[str, Scenario]:
    profiles = cycle_profiles(paper, reactions)
    return {name: scenario(paper, profiles, one) for name, one in paper.benchmark.conditions.items()}


def cell(one: Scenario, name: str, settings, **changes) -> Cell:
    return Cell("c", 6, name, settings, one, 5, 3, **changes)


def judged(one: Cell, reference: ReferenceSettings = REFERENCE) -> RegretJob:
    runs = one.run(one.trial_numbers())
    return RegretJob(one, reference, {trial: run.actions for trial, run in runs.items()})


def test_regret_is_what_the_decisions_lose_by_the_references_values(scenarios: dict[str, Scenario]) -> None:
    """An expert from one state: the run can be followed by hand."""
    one = scenarios["single_expert"]
    regret = judged(cell(one, "alternating", AlternatingSettings(kind="alternating"))).run([0])[0]
    belief, losses, rng = one.initial_belief("prior", one.model, np.random.default_rng(0)), [], np.random.default_rng(0)
    for cycle in range(6):
        values = LookaheadPolicy(REFERENCE).values(belief, rng)
        losses.append(values.max() - values[cycle % 2])
        choice = int(one.model.probabilities(belief.states[0], cycle % 2).argmax())
        belief = belief.update(cycle % 2, choice, rng)
    assert max(losses) > 0
    assert regret.decision_loss == pytest.approx(np.mean(losses))
    assert regret.run_loss == pytest.approx(sum(0.95**t * loss for t, loss in enumerate(losses)))
    assert regret.agreement == np.mean(np.array(losses) == 0)


@pytest.mark.slow
def test_the_reference_loses_nothing(scenarios: dict[str, Scenario]) -> None:
    own = judged(cell(scenarios["multiple_novice"], "reference", SAME))
    assert all((r.run_loss, r.agreement) == (0, 1) for r in own.run(range(3)).values())


def test_regret_is_stored_and_published(scenarios: dict[str, Scenario], tmp_path: Path) -> None:
    own = judged(cell(scenarios["single_novice"], "greedy", GreedySettings(kind="greedy")))
    first, _ = run_grid([own], tmp_path / "parts", LocalProcesses(1), lambda _job, _n: None)
    again, _ = run_grid([own], tmp_path / "parts", LocalProcesses(1), lambda _job, _n: None)
    assert first == again == [own.run(range(3))]
    publish_table(tmp_path, regret_rows([own.cell], first), [REGRET_FILE])
    table = read_table(tmp_path, REGRET_FILE, "fatplan benchmark")
    assert list(table["run_loss"]) == [first[0][trial].run_loss for trial in range(3)]
    deeper = replace(own, reference=REFERENCE.model_copy(update={"depth": 4}))
    assert len({own.digest(), own.cell.digest(), deeper.digest()}) == 3


def test_regret_of_other_actions_is_measured_again(scenarios: dict[str, Scenario], tmp_path: Path) -> None:
    """A policy with a time budget may act otherwise when its runs are made again."""
    own = judged(cell(scenarios["single_novice"], "greedy", GreedySettings(kind="greedy")))
    other = replace(own, actions={trial: tuple(1 - action for action in own.actions[trial]) for trial in own.actions})
    (first,), _ = run_grid([own], tmp_path, LocalProcesses(1), lambda _job, _n: None)
    (second,), _ = run_grid([other], tmp_path, LocalProcesses(1), lambda _job, _n: None)
    assert second == other.run(range(3)) and all(second[trial] != first[trial] for trial in first)


def test_what_is_stored_for_other_trials_is_ignored(scenarios: dict[str, Scenario], tmp_path: Path) -> None:
    """Three trials were judged; then the grid is restricted to the first."""
    own = judged(cell(scenarios["single_novice"], "greedy", GreedySettings(kind="greedy")))
    (first,), _ = run_grid([own], tmp_path, LocalProcesses(1), lambda _job, _n: None)
    fewer = replace(own, cell=replace(own.cell, trials=1), actions={0: own.actions[0]})
    assert fewer.digest() == own.digest()
    (found,), warnings = run_grid([fewer], tmp_path, LocalProcesses(1), lambda _job, _n: None)
    assert found == {0: first[0]} and warnings == []


def test_the_judge_believes_what_the_policy_could(scenarios: dict[str, Scenario]) -> None:
    """Which of three states a run began in shows only in what was observed: the judge follows it."""
    one = scenarios["multiple_novice"]
    runs = cell(one, "greedy", GreedySettings(kind="greedy"))
    result = runs.run([1])[1]
    world, rng = draw_random_numbers(5, "c", 6, 1), np.random.default_rng(0)
    belief, episode, losses = one.initial_belief("prior", one.model, rng), Episode(one, world), []
    for action in result.actions:
        values = LookaheadPolicy(REFERENCE).values(belief, rng)
        losses.append(values.max() - values[action])
        belief = belief.update(action, episode.step(action).observation, rng)
    regret = RegretJob(runs, REFERENCE, {1: result.actions}).run([1])[1]
    assert regret.decision_loss == pytest.approx(np.mean(losses), rel=1e-9) and max(losses) > 0


def test_regret_table_by_hand() -> None:
    rows = [("c", 5, "p", -2.0, 0.1, 0.4, 0.5), ("c", 5, "p", -4.0, 0.3, 0.8, 1.0), ("c", 5, "q", -1.0, 0, 0, 1.0)]
    columns = ["condition", "n_cycles", "policy", "discounted_return", *REGRETS]
    trials = pd.DataFrame(rows, columns=columns).assign(deterministic=False)
    table = regret_table(trials)
    assert list(table["policy"]) == ["q", "p"]  # the smallest loss first
    worse = table.iloc[1]
    assert worse["run_loss"] == pytest.approx(0.6) and worse["run_loss_share"] == pytest.approx(0.2)
    assert worse["run_loss_standard_error"] == pytest.approx(0.2) and worse["agreement"] == pytest.approx(0.75)
    assert math.isnan(table.iloc[0]["run_loss_standard_error"])  # one run of chance says nothing of its spread
    certain = regret_table(trials.assign(deterministic=True)).iloc[0]
    assert certain["run_loss_standard_error"] == 0
    text = regret_text(table, {"c": "the oracle"})
    assert "reference: the oracle" in text and "20.000%" in text


def test_the_reference_is_as_deep_as_is_affordable(scenarios: dict[str, Scenario]) -> None:
    chosen = {}
    for name, one in scenarios.items():
        chosen[name] = reference_for(one.initial_belief("prior", one.model, np.random.default_rng(0)))
    assert chosen["single_novice"].leaf_value == "bound" and chosen["single_expert"].leaf_value == "greedy_rollout"
    assert chosen["single_novice"].depth > chosen["multiple_novice"].depth - 1 >= 2  # three states cost three times
    assert "cyclic plans" in describe(chosen["single_novice"]) and "greedy rollouts" in describe(
        chosen["single_expert"]
    )


def test_bounds_are_kept_and_hold(scenarios: dict[str, Scenario], tmp_path: Path) -> None:
    """Short runs, where the bound is the optimum itself: an exact lookahead over all cycles reaches it."""
    one = scenarios["single_expert"]
    cells = [Cell("single_expert", n, "p", GreedySettings(kind="greedy"), one, 1, 2) for n in (2, 4)]
    first, warnings = bounds_of(cells, tmp_path, 2)
    assert warnings == [] and list(first["exact"]) == [True, True]
    written = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*/*.json")}
    again, _ = bounds_of(cells, tmp_path)
    pd.testing.assert_frame_equal(first, again)
    assert written == {path: path.stat().st_mtime_ns for path in tmp_path.glob("*/*.json")} and len(written) == 2
    belief = one.initial_belief("prior", one.model, np.random.default_rng(0))
    for n, bound in zip((2, 4), first["cost_bound"], strict=True):
        whole = LookaheadPolicy(LookaheadSettings(kind="lookahead", depth=n))
        assert -whole.values(belief, np.random.default_rng(0)).max() == pytest.approx(bound, rel=1e-9)
    two, four = tmp_path.glob("*/*.json")
    two.write_bytes(four.read_bytes())
    again, warnings = bounds_of(cells, tmp_path)
    pd.testing.assert_frame_equal(first, again)
    assert len(warnings) == 1 and str(two) in warnings[0] and two.with_suffix(".damaged-1").exists()


def bounds_of(cells: list[Cell], folder: Path, processes: int = 1) -> tuple[pd.DataFrame, list[str]]:
    jobs = bound_jobs(cells)
    found, warnings = run_grid(jobs, folder, LocalProcesses(processes), lambda _job, _n: None)
    return bound_rows(jobs, found), warnings


def test_a_judge_is_sent_the_actions_it_needs(scenarios: dict[str, Scenario]) -> None:
    cell = Cell("single_novice", 3, "p", GreedySettings(kind="greedy"), scenarios["single_novice"], 1, 9)
    reference = ReferenceSettings(kind="lookahead", depth=1)
    judgement = RegretJob(cell, reference, {trial: (trial % 2, 0, 1) for trial in range(9)})
    part = judgement.part([3, 4])
    assert part.digest() == judgement.digest() and set(part.actions) == {3, 4}
    assert part.run([3, 4]) == judgement.run([3, 4])


def test_no_policy_beats_the_bound_of_the_papers_conditions(scenarios: dict[str, Scenario]) -> None:
    """Greedy over 12 cycles, 200 runs: its mean may lie below the bound by chance once in 1e6 at most."""
    from scipy.stats import norm

    one = scenarios["multiple_novice"]
    bound = bound_of(one, 12)
    results = Cell("c", 12, "greedy", GreedySettings(kind="greedy"), one, 3, 200).run(range(200))
    cost = -np.array([r.discounted_return for r in results.values()])
    assert cost.mean() + norm.isf(1e-6) * cost.std(ddof=1) / math.sqrt(200) > bound.cost
    assert 0 < bound.cost <= cost.mean() * 1.2


def test_gaps_in_words(tmp_path: Path) -> None:
    rows = [("c", 5, name, trial, False, value) for name, value in (("p", -1.1), ("q", -1.3)) for trial in (0, 1)]
    trials = pd.DataFrame(
        rows, columns=["condition", "n_cycles", "policy", "trial", "deterministic", "discounted_return"]
    )
    trials.loc[0, "discounted_return"] = -1.0
    bounds = pd.DataFrame({"condition": ["c"], "n_cycles": [5], "cost_bound": [1.0], "exact": [False]})
    table = gap_table(comparison_table(trials, 0.05), bounds)
    assert table["gap"].tolist() == pytest.approx([0.05, 0.3])
    assert table["standard_error"].tolist() == pytest.approx([0.05, 0])
    assert "at least 1.000000; the mean of p is 5.00 % ± 5.00 % above that" in gap_text(table, [])
    assert "No bound where the worker is hidden: h." in gap_text(table, ["h"])
    single = gap_table(comparison_table(trials[trials["trial"] == 0], 0.05), bounds)
    assert single["standard_error"].isna().all() and "above that, one run" in gap_text(single, [])
    publish_bounds(tmp_path, table)
    assert (tmp_path / BOUNDS_FILE).read_text().startswith("condition,n_cycles,policy,cost_bound,exact,gap")


@pytest.mark.parametrize("expertise", [0.0, 5000.0, math.inf])
def test_the_reference_itself_has_no_regret(scenarios: dict[str, Scenario], expertise: float) -> None:
    """Whatever is left to chance: its values must not be noisy, or the best of them is too good."""
    one = scenarios["single_novice"]
    one = replace(one, model=one.model.for_workers(one_worker(expertise)))
    chosen = reference_for(one.initial_belief("prior", one.model, np.random.default_rng(0)))
    chosen = chosen.model_copy(update={"depth": 2})
    same = LookaheadSettings.model_validate(chosen.model_dump())
    own = judged(Cell("c", 5, "p", same, one, 5, 2), chosen)
    assert all(regret.run_loss == 0 for regret in own.run(own.trial_numbers()).values())


def test_random_rollouts_are_chance_even_with_an_expert(scenarios: dict[str, Scenario]) -> None:
    one = scenarios["single_expert"]
    rollouts = {"leaf_value": "random_rollout", "exploration_constant": 0.1}
    search = PomcpSettings(kind="pomcp", backup="mean", descents=5, **rollouts)
    assert not cell(one, "p", search).is_deterministic()
    assert cell(one, "p", search.model_copy(update={"leaf_value": "none"})).is_deterministic()


def test_where_nothing_tires_the_bound_is_nothing(scenarios: dict[str, Scenario]) -> None:
    one = scenarios["single_expert"]
    nothing = replace(one, model=replace(one.model, active_entries=np.zeros(0, np.intp)))
    assert bound_of(nothing, 5).cost == 0 and bound_of(nothing, 5).exact
    rows = [("c", 5, "p", trial, True, 0.0) for trial in (0, 1)]
    columns = ["condition", "n_cycles", "policy", "trial", "deterministic", "discounted_return"]
    bounds = pd.DataFrame({"condition": ["c"], "n_cycles": [5], "cost_bound": [0.0], "exact": [True]})
    table = gap_table(comparison_table(pd.DataFrame(rows, columns=columns), 0.05), bounds)
    assert table["gap"].tolist() == [0.0] and "nan" not in gap_text(table, [])

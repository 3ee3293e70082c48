"""Sensitivity studies: what a file may contain, the points of a study, and what follows from their results."""

import json
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from conftest import PAPER, ROOT

from fatigue_planner.core.errors import ExperimentError, LostWorkError
from fatigue_planner.core.executors.executor import Lost
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.core.text import brief_percent
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.estimate import decisions_left, estimated_seconds
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.claims.evaluation import Judgements
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.claims.relations import ClaimJudgement
from fatigue_planner.study.claims.schema import Answer
from fatigue_planner.study.sensitivity.conclusions import conclusions
from fatigue_planner.study.sensitivity.design import Point, design
from fatigue_planner.study.sensitivity.factors import ChoiceSettings, RangeSettings
from fatigue_planner.study.sensitivity.gains import (
    claim_table,
    gain_table,
    judge,
    leader_table,
    paired_gain,
    reproduced_fraction,
    verdict_table,
)
from fatigue_planner.study.sensitivity.importance import explained_variance, importance_table, p_values
from fatigue_planner.study.sensitivity.reactions import react, unique_requests
from fatigue_planner.study.sensitivity.study import Study, load_study
from fatigue_planner.study.sensitivity.tables import StudyGrid

STUDY: dict[str, Any] = {
    "name": "tiny",
    "base": str(PAPER),
    "grid": {
        "conditions": ["single_novice"],
        "n_cycles": [5],
        "policies": ["alternating", "greedy", "pomcp_0.1"],
        "trials": 3,
        "further_policies": {"planning": {"kind": "lookahead", "depth": 2}},
    },
    "planners": ["planning", "pomcp_0.1"],
    "baselines": ["greedy", "alternating"],
    "headline": {"planner": "planning", "condition": "single_novice", "n_cycles": 5},
    "space_filling": {"points": 4, "seed": 1},
    "factors": {
        "rate": {
            "kind": "scale", "keys": ["fatigue.fatigue_rate_per_s"], "from": 0.5, "to": 2.0, "scale": "log",
            "reason": "test",
        },
        "descents": {
            "kind": "range", "keys": ["benchmark.policies.pomcp_0.1.descents"], "from": 5, "to": 5000, "scale": "log",
            "integer": True, "reason": "test",
        },
        "rollout": {
            "kind": "choice", "reason": "test",
            "levels": {
                "none": {"benchmark.policies.pomcp_0.1.leaf_value": "none"},
                "random": {"benchmark.policies.pomcp_0.1.leaf_value": "random_rollout"},
            },
        },
    },
}  # fmt: skip


def write(folder: Path, changes: Mapping[str, Any] = {}) -> Path:
    path = folder / "study.yaml"
    path.write_text(json.dumps({**STUDY, **changes}, indent=1))
    return path


def one_factor(**factor: Any) -> dict[str, Any]:
    return {"factors": {"own": {"reason": "test", **factor}}}


def span(kind: str, first: float, last: float, *keys: str) -> dict[str, Any]:
    return one_factor(kind=kind, keys=keys, **{"from": first, "to": last})


def choice(**levels: dict[str, Any]) -> dict[str, Any]:
    return one_factor(kind="choice", levels=levels)


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return load_study(write(tmp_path))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (span("range", 0.05, 0.2, "fatigue.treshold"),
         "factors.own: fatigue.treshold: unknown key; did you mean 'fatigue.threshold'?"),
        (span("range", 0.5, 0.9, "discount.deep"), "discount has no settings of its own"),
        (span("range", 5, 9, "benchmark.policies.pomcp_0.2.descents"),
         "did you mean 'benchmark.policies.pomcp_0.1'?"),
        (span("range", 1.6, 2.5, "workers.average_man.height_m"),
         "factors.own at 2.2: workers.average_man.height_m = 2.2: input should be less than or equal to 2.1"),
        (span("range", 0.96, 0.99, "discount"), "discount = 0.95 is outside"),
        (span("range", 4, 9, "cycle.work_s", "cycle.reach_s"), "use kind: scale"),
        (span("range", 4, 9, "tool.held"), "a range is for numbers; use kind: choice"),
        (span("range", 0.99, 0.9, "discount"), "from = 0.99 must be below to = 0.9"),
        (span("scale", 0.1, 0.9, "discount"), "1, the experiment's own, is outside"),
        (span("scale", 0.5, 2.0, "controller.centre_of_mass_shift_m"), "are the same"),
        (span("range", 2, 9, "benchmark.trials"), "must be the same at all points"),
        (choice(a={"discount": 0.9}, b={"discount": 0.8}), "none is the experiment's own"),
        (choice(a={"discount": 0.9}, b={}), "levels.b: all levels must give the same keys"),
        (choice(a={f"key_{number:04}": 1 for number in range(3000)}, b={}), "key_0049, … (3000 in all)"),
        (one_factor(kind="wheel"), "own.kind = 'wheel': should be one of 'range', 'scale', 'choice', 'readings'"),
        ({"factors": STUDY["factors"] | {"again": STUDY["factors"]["rollout"]}},
         "is already changed by factor 'rollout'"),
        ({"planners": ["planing"]}, "planners: planing; known are alternating"),
        ({"baselines": ["planning"]}, "'planning' is also among the planners"),
        ({"headline": STUDY["headline"] | {"n_cycles": 7}}, "headline.n_cycles: 7; known are 5"),
        ({"space_filling": {"points": 12, "seed": 1}}, "points = 12: should be a power of two"),
        ({"grid": STUDY["grid"] | {"policies": ["best"]}}, "grid.policies: best; known are random"),
        ({"grid": STUDY["grid"] | {"trials": 1}}, "grid.trials = 1: intervals need at least 2"),
        ({"grid": STUDY["grid"] | {"further_policies": {"greedy": {"kind": "greedy"}}}}, "has a policy of this name"),
        ({"name": "paper"}, "name = 'paper': is the base experiment's"),
        ({"hedline": 1}, "hedline: unknown key; did you mean 'headline'?"),
        ({"base": "none.yaml"}, "study.yaml: base = 'none.yaml': "),
    ],
)  # fmt: skip
def test_faulty_studies_are_refused_with_one_message(tmp_path: Path, changes: dict[str, Any], expected: str) -> None:
    path = write(tmp_path, changes)
    with pytest.raises(ExperimentError, match=re.escape(expected)) as error:
        load_study(path)
    assert str(path.parent) in str(error.value)


def test_the_base_is_a_file_or_one_that_ships(tmp_path: Path) -> None:
    assert load_study(write(tmp_path, {"base": "paper"})).base_file == PAPER
    (tmp_path / "paper").write_text(PAPER.read_text())
    assert load_study(write(tmp_path, {"base": "paper"})).base_file == tmp_path / "paper"
    with pytest.raises(ExperimentError, match=r"study\.yaml: base = papre: neither a file nor the name"):
        load_study(write(tmp_path, {"base": "papre"}))


def test_a_part_of_a_key_taken_by_another_factor_is_refused(tmp_path: Path) -> None:
    """natural_posture_deg as a whole, and one angle of it."""
    key = "workers.average_man.natural_posture_deg"
    own = yaml.safe_load(PAPER.read_text())["workers"]["average_man"]["natural_posture_deg"]
    whole = {
        "kind": "choice",
        "reason": "test",
        "levels": {"own": {key: own}, "other": {key: own | {"elbow_flexion": 9}}},
    }
    part = {"kind": "range", "keys": [f"{key}.elbow_flexion"], "from": 5, "to": 20, "reason": "test"}
    for factors in ({"whole": whole, "part": part}, {"part": part, "whole": whole}):
        with pytest.raises(ExperimentError, match="is already changed by factor"):
            load_study(write(tmp_path, {"factors": factors}))


def test_the_base_point_is_the_base_experiment(
    study: Study, paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """Same reactions, and same cells as the paper's where the grid has them, so that stored results are found again."""
    base = design(study)[0]
    assert base.design == "base" and base.experiment is not None
    assert [r.digest for r in reaction_requests(base.experiment)] == [r.digest for r in reaction_requests(paper)]
    profiles = cycle_profiles(paper, reactions)
    theirs = {cell.name: cell.digest() for cell in cells(paper, profiles)}
    ours = {cell.name: cell.digest() for cell in cells(base.experiment, profiles)}
    shared = ours.keys() & theirs.keys()
    assert shared == {f"single_novice/5/{policy}" for policy in ("alternating", "greedy", "pomcp_0.1")}
    assert all(ours[name] == theirs[name] for name in shared)


def test_every_level_occurs_alone_and_the_combinations_fill_the_space(tmp_path: Path) -> None:
    study = load_study(write(tmp_path, {"space_filling": {"points": 16, "seed": 1}}))
    points = design(study)
    for name, factor in study.settings.factors.items():
        alone = [point.levels[name] for point in points if point.factor == name]
        own = study.base_levels()[name]
        assert sorted(map(str, [*alone, own])) == sorted({str(level) for level in [*factor.all_levels(), own]})
    combined = [point for point in points if point.design == "space filling"]
    rates = np.array([point.levels["rate"] for point in combined], dtype=float)
    positions = np.log(rates / 0.5) / np.log(4)
    assert np.histogram(positions, bins=16, range=(0, 1))[0].tolist() == [1] * 16  # one in each sixteenth
    assert [sum(point.levels["rollout"] == level for point in combined) for level in ("none", "random")] == [8, 8]
    assert points == design(study)
    other = load_study(write(tmp_path, {"space_filling": {"points": 16, "seed": 2}}))
    assert design(other)[-1].levels != points[-1].levels
    longer = load_study(write(tmp_path, {"space_filling": {"points": 32, "seed": 1}}))
    assert design(longer)[: len(points)] == points


def test_levels_reach_the_experiment(study: Study) -> None:
    points = {point.name: point for point in design(study)}
    fast = points["rate=2"].experiment
    assert fast is not None and fast.fatigue.fatigue_rate_per_s == pytest.approx(0.03334)
    few = points["descents=5"].experiment
    assert few is not None and few.benchmark.policies["pomcp_0.1"].descents == 5  # type: ignore[union-attr]
    assert few.fatigue == study.base.fatigue
    rolled = points["rollout=random"].experiment
    assert rolled is not None and rolled.benchmark.policies["pomcp_0.1"].leaf_value == "random_rollout"  # type: ignore[union-attr]
    assert list(rolled.benchmark.policies) == ["alternating", "greedy", "pomcp_0.1", "planning"]


def test_the_published_study_is_sound() -> None:
    study = load_study(ROOT / "experiments" / "sensitivity.yaml")
    for wanted in ("phase_split", "return_hand", "hand_gain", "posture_gain", "natural_posture", "centre_of_mass",
                   "tool_held", "strength", "height", "mass", "sex", "fatigue_rate", "recovery_rate", "threshold",
                   "discount", "descents", "exploration", "rollout"):  # fmt: skip
        assert wanted in study.settings.factors
    for key in ("descents", "exploration_constant", "leaf_value"):  # none of the searches is forgotten
        searches = [name for name, policy in study.base.benchmark.policies.items() if policy.kind == "pomcp"]
        assert {f"benchmark.policies.{name}.{key}" for name in searches} <= set(study.paths)


@pytest.fixture
def own_cache(cache_folder: Path, tmp_path: Path) -> Path:
    """A copy of the paper's reactions, to which a study adds its own."""
    return Path(shutil.copytree(cache_folder, tmp_path / "own_cache"))


@pytest.mark.slow
def test_what_cannot_be_performed_is_kept_and_says_why(tmp_path: Path, own_cache: Path) -> None:
    """A man too short for the object on the shelf, by geometry; another by simulation."""
    short = span("range", 0.5, 3.0, "actions.high.right_hand.position_m.x")
    study = load_study(write(tmp_path, short | {"space_filling": {"points": 2, "seed": 1}}))
    points = [point for point in design(study) if point.design != "space filling"]
    assert [point.experiment is None for point in points] == [False, False, True, True]
    assert "together measure" in points[3].reason
    reacted = react(points, ReactionCache(own_cache), LocalProcesses(2), lambda _: None, "again")
    assert len(reacted) == len(points)
    assert [result.profiles is None for result in reacted] == [False, True, True, True]
    assert "average_man/high/" in reacted[1].reason and reacted[3].reason == points[3].reason
    assert set(StudyGrid(reacted).of_point) == {"base"}


def test_a_simulation_that_kills_its_workers_says_nothing_about_a_point(study: Study, tmp_path: Path) -> None:
    class Deadly(LocalProcesses):
        def run(self, work: Any, items: Any) -> Any:
            return ((index, Lost("its worker died")) for index in range(len(items)))

    with pytest.raises(LostWorkError, match=r"average_man/high/\S+: its worker died\n[\s\S]+the same command tries"):
        react(design(study), ReactionCache(tmp_path / "cache"), Deadly(1), lambda _: None, "again")


def test_reactions_and_cells_in_common_are_made_once(study: Study, own_cache: Path, tmp_path: Path) -> None:
    points = design(study)
    assert len(unique_requests(points)) == 4  # no factor of this study changes a motion
    heard: list[bool] = []
    reacted = react(
        points, ReactionCache(own_cache), LocalProcesses(1), lambda outcome: heard.append(outcome.found), "again"
    )
    assert heard == [True] * 4
    grid = StudyGrid(reacted)
    assert all(len(indices) == 4 for indices in grid.of_point.values())
    policies = [cell.policy for cell in grid.cells]
    rates = {point.experiment.fatigue.fatigue_rate_per_s for point in points if point.experiment is not None}
    assert policies.count("greedy") == len(rates) < len(points)  # only the rate matters to it
    assert policies.count("pomcp_0.1") == len(points)
    left = decisions_left(grid.cells, tmp_path / "nothing")
    assert 0 < estimated_seconds(grid.cells, left, 2) < estimated_seconds(grid.cells, left, 1) * 10


def test_gains_by_hand() -> None:
    """Savings 1, 2, 3 of 10: mean 0.2 of the cost, standard error 1 / sqrt(3), t = 4.3027 on two degrees of freedom."""
    planner, baseline = np.array([9.0, 8.0, 7.0]), np.full(3, 10.0)
    trials, cost, gain, error, low, high, verdict = paired_gain(planner, baseline, certain=False)
    assert (trials, cost, verdict) == (3, 10.0, "undecided")
    assert gain == pytest.approx(0.2) and error == pytest.approx(0.1 / np.sqrt(3))
    assert high - gain == pytest.approx(4.302653 * error, rel=1e-6) and gain - low == pytest.approx(high - gain)
    assert paired_gain(planner - 6.0, baseline, certain=False)[-1] == "better"
    assert paired_gain(baseline, planner - 6.0, certain=False)[-1] == "worse"
    assert paired_gain(np.array([9.0]), np.array([10.0]), certain=True)[2:] == (0.1, 0.0, 0.1, 0.1, "better")
    assert paired_gain(np.array([9.0]), planner, certain=False)[2] == pytest.approx(-1 / 8)
    assert paired_gain(np.zeros(2), np.zeros(2), certain=False)[2] == 0.0


def trials_of(**costs: list[float]) -> pd.DataFrame:
    rows = [("novice", 5, name, -cost) for name, own in costs.items() for cost in own]
    table = pd.DataFrame(rows, columns=["condition", "n_cycles", "policy", "discounted_return"])
    return table.assign(deterministic=False)


def test_gain_table_pairs_the_trials() -> None:
    table = gain_table({"base": trials_of(plan=[1.0, 2.0], greedy=[2.0, 3.0])}, ["plan"], ["greedy"])
    assert table.loc[0, "gain"] == pytest.approx(0.4) and table.loc[0, "standard_error"] == 0
    leaders = leader_table({"base": trials_of(plan=[1.0, 2.0], greedy=[2.0, 3.0])})
    assert leaders.loc[0, "policy"] == "plan" and leaders.loc[0, "mean_cost"] == 1.5


def test_explained_variance_of_a_known_function() -> None:
    """y = 3 a + b with independent, uniform a and b: they explain 9/10 and 1/10; c explains all of 2 c^2."""
    rng = np.random.default_rng(0)
    a, b, c = rng.uniform(-1, 1, (3, 4000))
    values = np.column_stack([3 * a + b, 2 * c**2, np.ones(4000)])
    own = [explained_variance(np.column_stack([x, x**2]), values, random_stream(0, "x")) for x in (a, b, c)]
    assert own[0][0, 0] == pytest.approx(0.9, abs=0.02) and own[1][0, 0] == pytest.approx(0.1, abs=0.02)
    assert own[2][0, 1] == pytest.approx(1.0) and own[2][0, 0] == pytest.approx(0.0, abs=0.002)
    assert np.isnan(own[0][:, 2]).all()  # nothing varies
    assert own[1][1, 0] < own[1][0, 0] < own[1][2, 0]


def test_explained_variance_of_names_is_the_adjusted_correlation_ratio() -> None:
    factor = ChoiceSettings(kind="choice", reason="test", levels={"p": {"k": 1}, "q": {"k": 2}, "unused": {"k": 3}})
    levels, values = ["p", "q", "p", "q", "p", "q"], np.array([1.0, 5, 2, 4, 3, 6])
    within = np.var([1, 2, 3]) * 3 + np.var([5, 4, 6]) * 3
    expected = 1 - within / (np.var(values) * 6) * 5 / 4
    assert explained_variance(factor.regressors(levels), values[:, None], random_stream(0, "x"))[0, 0] == pytest.approx(
        expected
    )


def test_a_factor_without_effect_explains_nothing_in_the_mean() -> None:
    """20 points are few, but the adjustment subtracts what a parabola explains by chance."""
    rng = np.random.default_rng(1)
    x = np.linspace(-1, 1, 20)
    found = explained_variance(np.column_stack([x, x**2]), rng.normal(size=(20, 400)), random_stream(0, "x"))[0]
    assert abs(found.mean()) < 4 * found.std() / 20 and (found < 0).any()


def test_naming_a_factor_by_chance_is_rare_however_many_there_are() -> None:
    """Without effects, the smallest of 12 p-values is below 10 % in about 10 % of 300 responses."""
    rng = np.random.default_rng(2)
    designs = [np.column_stack([x, x**2]) for x in rng.uniform(-1, 1, (12, 16))]
    noise = rng.normal(size=(16, 300))
    least = p_values(designs, noise, random_stream(0, "x")).min(axis=0)
    assert 0.05 < (least < 0.1).mean() < 0.16
    effect = noise * 0.1 + designs[3][:, :1]
    found = p_values(designs, effect, random_stream(0, "x"))
    assert (found[3] < 0.05).all() and found[3].max() < np.median(found[0])
    assert np.isnan(p_values(designs, np.ones((16, 1)), random_stream(0, "x"))).all()


SPAN = {"reason": "test", "from": 0.0, "to": 1.0}


@pytest.fixture
def synthetic() -> tuple[list[Point], pd.DataFrame, dict[str, RangeSettings]]:
    """Gains of 0.1 strong + 0.01 weak over 32 combinations, and one at a time."""
    factors = {
        name: RangeSettings.model_validate({"kind": "range", "keys": (name,), **SPAN}) for name in ("weak", "strong")
    }
    levels = random_stream(3, "levels").random((32, 2))
    points = [Point("base", "base", "", {"weak": 0.5, "strong": 0.5}, None)]
    points += [Point("weak=1", "one at a time", "weak", {"weak": 1.0, "strong": 0.5}, None)]
    points += [Point("strong=0", "one at a time", "strong", {"weak": 0.5, "strong": 0.0}, None)]
    points += [Point("strong=1", "one at a time", "strong", {"weak": 0.5, "strong": 1.0}, None)]
    points += [
        Point(f"c{i}", "space filling", "", {"weak": float(w), "strong": float(s)}, None)
        for i, (w, s) in enumerate(levels)
    ]
    rows = []
    for point in points:
        gain = 0.1 * float(point.levels["strong"]) + 0.01 * float(point.levels["weak"])
        rows += [
            (
                point.name,
                "single_novice",
                5,
                planner,
                baseline,
                3,
                1.0,
                gain,
                0.001,
                gain - 0.003,
                gain + 0.003,
                "better",
            )
            for planner in ("planning", "pomcp_0.1")
            for baseline in ("greedy", "alternating")
        ]
    from fatigue_planner.study.sensitivity.gains import COLUMNS

    return points, pd.DataFrame(rows, columns=COLUMNS), factors


def test_swings_and_order_of_a_known_table(synthetic: Any) -> None:
    points, gains, factors = synthetic
    table = importance_table(points, gains, factors, seed=1)
    own = table[(table["planner"] == "planning") & (table["baseline"] == "greedy")]
    assert list(own["factor"]) == ["strong", "weak"]
    strong, weak = own.to_dict("records")
    assert strong["share"] > 0.9 and weak["share"] < 0.1
    assert strong["swing"] == pytest.approx(0.1) and weak["swing"] == pytest.approx(0.005)
    assert (strong["least_at"], strong["most_at"]) == ("0", "1") and (weak["least_at"], weak["most_at"]) == ("0.5", "1")
    spread = gains[
        (gains["planner"] == "planning") & (gains["baseline"] == "greedy") & gains["point"].str.startswith("c")
    ]
    assert strong["chance"] == pytest.approx(0.001**2 / spread["gain"].var())
    assert importance_table(points, gains, factors, seed=1).equals(table)


def sentences(study: Study, synthetic: Any, gains: pd.DataFrame, claims: pd.DataFrame | None = None) -> list[str]:
    points, _, factors = synthetic
    importance = importance_table(points, gains, factors, seed=1)
    leaders = pd.DataFrame({"point": ["c1", "c2"], "policy": ["greedy", "planning"]})
    return conclusions(study.settings, points, gains, importance, leaders, claims, study.base.statistics)


def test_ranks_see_what_two_large_gains_hide(synthetic: Any) -> None:
    """A factor moves the gain everywhere; in a second table, two combinations gain a hundred times as much."""
    points, gains, factors = synthetic
    calm = importance_table(points, gains, factors, seed=1)
    combined = [point.name for point in points if point.design == "space filling"]
    ordered = gains[gains["point"].isin(combined)].sort_values("gain")["point"]
    wild = gains.copy()
    wild.loc[wild["point"].isin([ordered.iloc[0], ordered.iloc[len(ordered) // 2]]), "gain"] += 10
    found = importance_table(points, wild, factors, seed=1)
    for table, seen in ((calm, True), (found, False)):
        strong = table[table["factor"] == "strong"].iloc[0]
        assert (strong["p_value"] < 0.05) == seen and strong["rank_p_value"] < 0.05


def test_five_sentences_follow_from_the_tables(study: Study, synthetic: Any) -> None:
    gains = synthetic[1]
    text = sentences(study, synthetic, gains)
    assert len(text) == 5
    assert (
        "can perform 32 of 32 combinations of all 3 settings; planning is significantly better than greedy in 32 of 32"
        in text[0]
    )
    assert "planning is significantly better than alternating in 32" in text[1].lower()
    assert "would: over greedy strong 9" in text[2] and "strong (by 10 % of the cost, 0 to 1)" in text[2]
    assert text[4] == "The policy with the lowest mean cost is greedy in 1, planning in 1 of 2 cells."
    gone = gains[~gains["point"].isin(["c1", "c2"])].copy()
    gone.loc[gone["point"] == "c3", "verdict"] = "worse"
    changed = sentences(study, synthetic, gone)
    assert "can perform 30 of 32" in changed[0]
    assert "planning is significantly better than greedy in 29 of 30 and worse in 1" in changed[0]
    most = gains[gains["point"].str.startswith("c")].sort_values("gain").iloc[-1]
    assert f"the largest gain is {brief_percent(most['gain'])} (" in text[3] and f"at {most['point']}," in text[3]
    alone = gains[~gains["point"].str.startswith("c")]
    assert sentences(study, synthetic, alone) == [
        "The digital human can perform 0 of 32 combinations of all 3 settings, so there is nothing to compare."
    ]


def test_claims_are_counted_over_points(study: Study, synthetic: Any) -> None:
    holds, fails, open_ = (ClaimJudgement(answer, "") for answer in (Answer.HOLDS, Answer.FAILS, Answer.OPEN))
    yes, no = Judgements(fails, holds), Judgements(fails, open_)
    verdicts = {"a": {"first": yes, "second": no}, "b": {"first": yes, "second": yes}}
    tables = {name: pd.DataFrame({"name": [name]}) for name in verdicts}
    claims = claim_table(verdict_table(tables, lambda trials: verdicts[trials.loc[0, "name"]]))
    counts = {(row["claim"], row["analysis"], row["verdict"]): row["points"] for row in claims.to_dict("records")}
    assert counts == {
        ("first", "modern", "reproduced"): 2, ("second", "modern", "undetermined"): 1,
        ("second", "modern", "reproduced"): 1, ("first", "paper", "not reproduced"): 2,
        ("second", "paper", "not reproduced"): 2,
    }  # fmt: skip
    assert reproduced_fraction(claims).to_dict() == {"first": 1.0, "second": 0.5}
    last = sentences(study, synthetic, synthetic[1], claims)[-1]
    assert last == (
        "Of the paper's 2 claims, 1 are reproduced at more than half of the 2 settings tried and 0 at none; the most "
        "robust, first, is reproduced at 100 % of them."
    )


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.01, "1 %"), (0.1234, "12.3 %"), (0.00456, "0.46 %"), (-0.02, "−2 %"), (0.0, "0 %"), (-0.0, "0 %")],
)
def test_percent(share: float, text: str) -> None:
    assert brief_percent(share) == text


@pytest.mark.slow
def test_the_command_resumes_and_ends_in_the_same_bytes_also_over_dask(tmp_path: Path, own_cache: Path) -> None:
    from commands import fatplan, refused
    from dask_clusters import cluster

    few = dict(STUDY["factors"])
    few["descents"] = few["descents"] | {"to": 6000}
    base = tmp_path / "paper.yaml"
    base.write_text(PAPER.read_text().replace("descents: 5000", "descents: 20"))
    path = write(tmp_path, {"factors": few, "base": "paper.yaml"})
    runs = {}
    with cluster(tmp_path / "dask") as dask:
        executors = {"one": ["--jobs", 1], "two": ["--jobs", 2], "dask": ["--dask", dask.address]}
        results = {
            name: fatplan("sensitivity", path, "--cache", own_cache, "--results", tmp_path / name, *options)
            for name, options in executors.items()
        }
    for name, done in results.items():
        assert done.returncode == 0, done.stderr
        assert done.stdout.startswith("1. The digital human can perform ")
        assert " different cells, " in done.stderr and " decisions left: about " in done.stderr
        folder = tmp_path / name / "tiny"
        runs[name] = {
            file.relative_to(folder): file.read_bytes() for file in folder.rglob("*.*") if "parts" not in file.parts
        }
        if name == "one":  # half of the finished work is lost
            for part in sorted((folder / "parts").iterdir())[::2]:
                for file in part.iterdir():
                    file.unlink()
            again = fatplan("sensitivity", path, "--cache", own_cache, "--results", tmp_path / name)
            assert again.returncode == 0 and again.stdout == done.stdout
            assert runs[name] == {file: (folder / file).read_bytes() for file in runs[name]}
    page = Path("report.html")  # it contains the command that makes it, which names the folder
    folder_name = str(tmp_path / "one").encode()
    assert folder_name in runs["one"][page]
    for name in ("two", "dask"):
        assert runs["one"] | {page: runs["one"][page].replace(folder_name, str(tmp_path / name).encode())} == runs[name]
    files = {str(file) for file in runs["one"]}
    assert {
        "report.html",
        "lessons.txt",
        "points.csv",
        "gains.csv",
        "importance.csv",
        "figures/tornado_greedy.svg",
    } <= files
    manifest = json.loads(runs["one"][Path("manifest.json")])["sensitivity"]
    assert manifest["study"]["space_filling"] == {"points": 4, "seed": 1} and len(manifest["reactions"]) == 4
    path.write_text(path.read_text().replace('"from": 0.5', '"from": .nan'))
    assert "factors.rate.from" in refused(2, "sensitivity", path)


def test_claims_at_a_point_are_judged_as_in_their_experiment(paper: Experiment) -> None:
    """A planner that the paper does not have changes no verdict, however good."""
    claims = load_claims(ROOT / "experiments" / "paper_claims.yaml")
    rng, rows = np.random.default_rng(3), []
    for condition in paper.benchmark.conditions:
        for n_cycles in paper.benchmark.n_cycles:
            world = rng.normal(size=8)
            for index, policy in enumerate([*paper.benchmark.policies, "oracle"]):
                runs = -10 + 0.1 * world - 0.2 * index + 0.05 * rng.normal(size=8) + 5 * (policy == "oracle")
                rows += [(condition, n_cycles, policy, trial, False, value) for trial, value in enumerate(runs)]
    columns = ["condition", "n_cycles", "policy", "trial", "deterministic", "discounted_return"]
    table = pd.DataFrame(rows, columns=columns)
    verdicts_of = judge(claims)
    found = verdicts_of(table)
    assert found == verdicts_of(table[table["policy"] != "oracle"]) and len(found) == len(claims.claims)
    assert len({judgements.modern.answer for judgements in found.values()}) > 1


def test_claims_must_be_about_the_base(tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(PAPER.read_text())
    text = (ROOT / "experiments" / "paper_claims.yaml").read_text()
    (tmp_path / "claims.yaml").write_text(text.replace("experiment: paper.yaml", "experiment: other.yaml"))
    with pytest.raises(ExperimentError, match=r"claims = 'claims.yaml': are about .*other.yaml, not the base"):
        load_study(write(tmp_path, {"claims": "claims.yaml"}))

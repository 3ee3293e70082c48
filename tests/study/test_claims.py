"""Claims: known answers of every relation by both analyses, the headroom, and files that are refused."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from conftest import PAPER

from fatigue_planner.core.errors import ClaimsError, ExperimentError
from fatigue_planner.experiment.statistics_settings import Family, StatisticsSettings
from fatigue_planner.study.claims.evaluation import Evaluation, claims_text, evaluate, judge_claims
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.claims.relations import RELATIONS
from fatigue_planner.study.claims.schema import Answer, Claim, all_of, any_of
from fatigue_planner.study.statistics.contrasts import contrasts

PAPER_CLAIMS = PAPER.parent / "paper_claims.yaml"
SETTINGS = StatisticsSettings(significance_level=0.05, equivalence_margin=0.01, resamples=99)
RUNS = 40
H, F, O = Answer.HOLDS, Answer.FAILS, Answer.OPEN  # noqa: E741

# What the runs of a have in common with those of b, and what only a has: mean 0, standard deviation about 1.
SHARED = np.linspace(-1.7, 1.7, RUNS)
OWN = np.tile([1.0, -1.0], RUNS // 2)


def runs(policies: Mapping[str, object], cell: tuple[str, int] = ("novice", 5)) -> pd.DataFrame:
    """A table of trials; a number stands for a policy whose every run is the same."""
    tables = []
    for policy, returns in policies.items():
        same = isinstance(returns, float)
        values = np.atleast_1d(np.asarray(returns, dtype=float))
        columns = {"policy": policy, "trial": range(len(values)), "deterministic": same, "discounted_return": values}
        tables.append(pd.DataFrame({"condition": cell[0], "n_cycles": cell[1], **columns}))
    return pd.concat(tables, ignore_index=True)


def shifted(by: float, own: float = 0.5, shared: float = 0.5) -> np.ndarray:
    """Returns about -100, so that 1 is 1 % of the cost; `own`: how much chance is in the difference to b."""
    return -100 + by + shared * SHARED + own * OWN


B = shifted(0, own=0)
# What the difference of a to b is like, in % of the cost.
CASES = {
    "clear": {"a": shifted(3), "b": B},
    "worse": {"a": shifted(-3), "b": B},
    "same": {"a": shifted(-0.01), "b": B},
    "noisy": {"a": shifted(0.5, own=10), "b": B},
    # certain when paired, hidden in what both share when not
    "tiny": {"a": shifted(0.3, own=0.1, shared=5), "b": shifted(0, own=0, shared=5)},
    "once": {"a": shifted(3)[:1], "b": B[:1]},
    "gaps": {"a": shifted(3), "b": B[:-1]},
    "unrun": {"a": shifted(3)},
    "exactly better": {"a": -97.0, "b": -100.0},
    "exactly a little better": {"a": -99.7, "b": -100.0},
    "exactly the same": {"a": -100.0, "b": -100.0},
    "exactly a little worse": {"a": -100.3, "b": -100.0},
    "exactly worse": {"a": -103.0, "b": -100.0},
    "value against chance": {"a": -97.0, "b": B},
    "value lost in noise": {"a": -99.5, "b": shifted(0, own=10)},
    "the same in every run": {"a": B * (1 - 1e-15), "b": B},
    "the same without spread": {"a": [-100.0] * RUNS, "b": [-100.0] * RUNS},
}


def claim(relation: str, policies: str, others: str = "", n_cycles: tuple[int, ...] = (5,)) -> Claim:
    return Claim(
        place="V-a",
        quote="…",
        conditions=("novice",),
        n_cycles=n_cycles,
        relation=relation,
        policies=tuple(policies.split()),
        others=tuple(others.split()),
    )


def answers(asked: Claim, trials: pd.DataFrame) -> tuple[Answer, Answer]:
    found = judge_claims({"it": asked}, trials, contrasts(trials, SETTINGS, 0), SETTINGS)["it"]
    return found.paper.answer, found.modern.answer


def evaluated(
    claims: Mapping[str, Claim],
    trials: pd.DataFrame,
    bounds: pd.DataFrame | None = None,
    settings: StatisticsSettings = SETTINGS,
    seed: int = 0,
) -> Evaluation:
    return evaluate(claims, trials, contrasts(trials, settings, seed), settings, bounds)


@pytest.mark.parametrize(
    ("relation", "expected"),
    [
        (
            "significantly_outperforms",
            {
                "clear": (H, H), "worse": (F, F), "same": (F, F), "noisy": (F, O), "tiny": (F, H),
                "exactly better": (H, H), "exactly a little better": (H, H), "exactly the same": (F, F),
                "exactly worse": (F, F), "value against chance": (H, H), "value lost in noise": (H, O),
            },
        ),
        (
            "better_mean",
            {
                "clear": (H, H), "worse": (F, F), "same": (F, F), "noisy": (H, O), "tiny": (H, H),
                "exactly better": (H, H), "exactly the same": (F, F), "value lost in noise": (H, O),
            },
        ),
        (
            "at_least_as_good",
            {
                "clear": (H, H), "worse": (F, F), "same": (H, H), "noisy": (H, O), "tiny": (H, H),
                "exactly better": (H, H), "exactly a little worse": (H, H), "exactly worse": (F, F),
                "value lost in noise": (H, O),
            },
        ),
        (
            "equivalent",
            {
                "clear": (F, F), "worse": (F, F), "same": (H, H), "noisy": (H, O), "tiny": (H, H),
                "exactly better": (F, F), "exactly a little better": (H, H), "value against chance": (F, F),
                "value lost in noise": (H, O),
            },
        ),
    ],
)  # fmt: skip
def test_questions_of_a_pair(relation: str, expected: dict[str, tuple[Answer, Answer]]) -> None:
    unknown = dict.fromkeys(("once", "gaps", "unrun"), (O, O))
    same = dict.fromkeys(("the same in every run", "the same without spread"), expected["same"])
    for case, both in (expected | unknown | same).items():
        assert answers(claim(relation, "a", "b"), runs(CASES[case])) == both, case


@pytest.mark.parametrize(
    ("relation", "expected"),
    [
        ("not_significantly_different", {
            "clear": (F, F), "worse": (F, F), "same": (H, H), "noisy": (H, O), "tiny": (H, F),
            "exactly better": (F, F), "exactly a little better": (H, H), "once": (O, O), "unrun": (O, O),
        }),
        ("equivalent", {"clear": (F, F), "same": (H, H), "noisy": (H, O), "tiny": (H, H), "unrun": (O, O)}),
        ("same_mean", {
            "clear": (F, F), "worse": (F, F), "same": (H, H), "noisy": (H, O), "tiny": (H, H), "unrun": (O, O),
        }),
    ],
)  # fmt: skip
def test_questions_among_policies(relation: str, expected: dict[str, tuple[Answer, Answer]]) -> None:
    for case, both in expected.items():
        assert answers(claim(relation, "a b"), runs(CASES[case])) == both, case
        assert answers(claim(relation, "b a"), runs(CASES[case])) == both, case


def test_low_performance_is_the_others_being_better() -> None:
    for case, both in {"clear": (H, H), "worse": (F, F), "noisy": (H, O), "unrun": (O, O)}.items():
        assert answers(claim("low_performance", "b", "a"), runs(CASES[case])) == both, case


def test_one_failing_comparison_decides_and_else_one_open() -> None:
    """In the second length the difference is lost in noise; in the third it is the other way round."""
    twice = pd.concat([runs(CASES["clear"]), runs(CASES["noisy"], ("novice", 20))])
    assert answers(claim("significantly_outperforms", "a", "b", (5, 20)), twice) == (F, O)
    thrice = pd.concat([twice, runs(CASES["worse"], ("novice", 100))])
    assert answers(claim("better_mean", "a", "b", (5, 20, 100)), thrice) == (F, F)
    assert answers(claim("better_mean", "a", "b", (5, 20)), thrice) == (H, O)


def test_significance_is_corrected_for_the_family() -> None:
    """p = 0.02 is enough alone, not as one of three comparisons; the paper's own test does not correct."""
    cell = {"a": shifted(1.9, own=5, shared=0), "b": shifted(0, own=0, shared=0.1)}
    asked = claim("significantly_outperforms", "a", "b")
    assert answers(asked, runs(cell)) == (H, H)
    assert answers(asked, runs(cell | {"c": shifted(0.9, own=-5, shared=0.2)})) == (H, O)


def test_the_best_of_several_outperforms() -> None:
    """a beats both others or one; b neither. No version beats both: it does not help that each beats one."""
    low = shifted(-6, own=0)
    asked = claim("best_outperforms", "a b", "c d")
    assert answers(asked, runs({"a": shifted(3), "b": shifted(-9), "c": B, "d": low})) == (H, H)
    assert answers(asked, runs({"a": shifted(-3), "b": shifted(-9), "c": B, "d": low})) == (F, F)
    assert answers(asked, runs({"a": shifted(0.5, own=10), "b": shifted(-9), "c": B, "d": low})) == (H, O)
    assert answers(asked, runs({"a": shifted(3), "b": B, "c": low})) == (O, O)
    # over two lengths it may be another one each time
    swapped = runs({"a": shifted(-9), "b": shifted(3), "c": B, "d": low}, ("novice", 20))
    both = pd.concat([runs({"a": shifted(3), "b": shifted(-9), "c": B, "d": low}), swapped])
    assert answers(claim("best_outperforms", "a b", "c d", (5, 20)), both) == (H, H)
    assert answers(claim("better_mean", "a b", "c d", (5, 20)), both) == (F, F)


def test_less_sensitive_compares_the_sizes_of_two_differences() -> None:
    asked = claim("less_sensitive", "a b", "c d")

    def four(ours: float, theirs: float, own: float) -> pd.DataFrame:
        return runs({"a": shifted(ours, own), "b": B, "c": shifted(theirs, -own), "d": B})

    assert answers(asked, four(-0.2, 3, 0.1)) == (H, H)
    assert answers(asked, four(-3, 0.2, 0.1)) == (F, F)
    assert answers(asked, four(0.1, 0.6, 10)) == (H, O)
    assert answers(asked, four(0.1, 0.12, 0.2)) == (H, F)  # if less, by nothing that counts
    assert answers(asked, runs({"a": shifted(1), "b": B, "c": B})) == (O, O)
    # averaged over lengths: the difference in one outweighs that in the other
    mixed = pd.concat([four(-0.2, 1.5, 0.1), four(-2, 1.5, 0.1).assign(n_cycles=20)])
    assert answers(claim("less_sensitive", "a b", "c d", (5, 20)), mixed) == (H, H)


def test_no_single_best() -> None:
    """Better in one length: the best, unless beaten in the other one, or no better than a third."""

    def two(case: str) -> pd.DataFrame:
        return pd.concat([runs(CASES["clear"]), runs(CASES[case], ("novice", 20))])

    asked = claim("no_single_best", "a b", n_cycles=(5, 20))
    assert answers(asked, two("noisy")) == (F, F)
    assert answers(asked, two("worse")) == (H, H)
    assert answers(asked, two("unrun")) == (O, O)
    assert answers(claim("no_single_best", "a b"), runs(CASES["noisy"])) == (H, H)
    assert answers(claim("no_single_best", "a b"), runs(CASES["tiny"])) == (H, F)
    assert answers(claim("no_single_best", "a b c"), runs(CASES["clear"] | {"c": shifted(3, own=-0.5)})) == (H, H)


def test_a_pair_in_no_family_is_undetermined() -> None:
    settings = SETTINGS.model_copy(update={"families": {"some": Family(policies=("a",), against=("c",))}})
    trials = runs(CASES["clear"] | {"c": B})
    found = evaluated({"it": claim("better_mean", "a", "b")}, trials, settings=settings)
    assert found.claims["verdict"].tolist() == ["undetermined"] and "in no family" in found.claims["reason"][0]


def test_logic_of_three_values() -> None:
    for first in Answer:
        for second in Answer:
            given = {first, second}
            assert all_of([first, second]) is (F if F in given else O if O in given else H)
            assert any_of([first, second]) is (H if H in given else O if O in given else F)
    assert all_of([]) is H and any_of([]) is F


def some_claims() -> dict[str, Claim]:
    return {
        "wins": claim("significantly_outperforms", "a b", "c d", (5, 20)),
        "alike": claim("equivalent", "a b c", n_cycles=(5, 20)),
        "best": claim("best_outperforms", "a b", "c d", (5, 20)),
        "steady": claim("less_sensitive", "a b", "c d", (5, 20)),
        "none": claim("no_single_best", "a b c d", n_cycles=(5, 20)),
    }


def some_runs() -> pd.DataFrame:
    rng = np.random.default_rng(0)
    cell = {name: shifted(0.2 * index) + rng.normal(size=RUNS) for index, name in enumerate("dcba")}
    return pd.concat([runs(cell), runs(cell | {"b": shifted(0.6) + rng.normal(size=RUNS)}, ("novice", 20))])


def test_order_of_rows_and_resampling_change_nothing() -> None:
    trials, expected = some_runs(), evaluated(some_claims(), some_runs())
    mixed = evaluated(some_claims(), trials.sample(frac=1, random_state=1), seed=7)
    words = ["verdict", "paper_verdict", "reason", "paper_reason", "numbers"]
    pd.testing.assert_frame_equal(mixed.claims[words], expected.claims[words])
    columns = ["claim", "first", "second", "answer", "paper_answer"]
    pd.testing.assert_frame_equal(mixed.detail[columns], expected.detail[columns])
    assert {"fails", "undetermined", "holds"} <= set(expected.detail["answer"])


def test_the_detail_has_every_comparison_in_the_claims_order() -> None:
    detail = evaluated(some_claims(), some_runs()).detail
    assert detail.groupby("claim", sort=False).size().to_dict() == {
        "wins": 8, "alike": 6, "best": 8, "steady": 4, "none": 24
    }  # fmt: skip
    trials = some_runs()
    means = trials.groupby(["n_cycles", "policy"])["discounted_return"].mean()
    for row in detail.to_dict("records"):
        expected = means[row["n_cycles"], row["first"]] - means[row["n_cycles"], row["second"]]
        assert row["difference"] == pytest.approx(expected, abs=1e-10)
        assert row["t_low"] <= row["difference"] <= row["t_high"]


def test_room_to_win_by_hand() -> None:
    """b costs 100, the bound is 99.5: 0.5 % of 100. Student's quantile for 78 degrees of freedom is 1.990847."""
    trials = runs({"a": shifted(-1, own=2, shared=0), "b": shifted(0, own=2, shared=0)})
    bounds = pd.DataFrame({"condition": "novice", "n_cycles": [5, 5], "cost_bound": 99.5})
    spread = 2 * math.sqrt(RUNS / (RUNS - 1))
    found = evaluated({"it": claim("better_mean", "a", "b")}, trials, bounds)
    row = found.detail.iloc[0]
    assert row["largest_win"] == pytest.approx(0.005, rel=1e-9)
    assert row["needed_win"] == pytest.approx(1.990847 * spread * math.sqrt(2 / RUNS) / 100, rel=1e-5)
    text = found.claims["room_to_win"][0]
    assert "no policy could win by more than 0.50 ± 0.32 % of b's cost, less than the margin" in text
    assert text.endswith("the paper's test needs 0.90 %")  # 0.50 + 2 x 0.32 is more
    close = evaluated({"it": claim("better_mean", "a", "b")}, trials, bounds.assign(cost_bound=99.9))
    assert "needs 0.90 %, so that not even the best possible could be expected to win" in close.claims["room_to_win"][0]
    wide = evaluated({"it": claim("better_mean", "a", "b")}, trials, bounds.assign(cost_bound=90.0))
    assert "10.00 ± 0.32 % of b's cost; the paper's test needs 0.90 %" in wide.claims["room_to_win"][0]
    assert "not even" not in wide.claims["room_to_win"][0]


def test_room_to_win_is_said_of_wins_that_are_not_shown_only() -> None:
    elsewhere = pd.DataFrame({"condition": ["expert"], "n_cycles": [5], "cost_bound": [1.0]})
    trials = runs(CASES["worse"])
    won, lost = claim("better_mean", "b", "a"), claim("better_mean", "a", "b")
    different = claim("equivalent", "a b")
    claims = {"won": won, "lost": lost, "different": different}
    for bounds, expected in ((None, "not known: no bounds.csv"), (elsewhere, "not known: no bound for these")):
        rooms = evaluated(claims, trials, bounds).claims["room_to_win"]
        assert rooms[0] == "" and rooms[1].startswith(expected) and rooms[2] == ""


def test_the_text_names_every_claim_and_counts_the_verdicts() -> None:
    table = evaluated(some_claims(), some_runs()).claims
    text = claims_text(table, 100)
    assert max(map(len, text.splitlines())) <= 100
    assert all(f"{name} (section V-a): " in text for name in some_claims())
    counts = [f"{(table['verdict'] == name).sum()} {name}" for name in ("reproduced", "not reproduced", "undetermined")]
    assert f"5 claims: {', '.join(counts)}." in text


def test_the_papers_claims_are_complete_and_known() -> None:
    loaded = load_claims(PAPER_CLAIMS)
    assert len(loaded.claims) >= 22 and loaded.experiment_file == PAPER
    assert {stated.place for stated in loaded.claims.values()} == {"V-a", "V-b", "VI"}
    assert {stated.relation for stated in loaded.claims.values()} == set(RELATIONS)
    told = {(stated.conditions, stated.n_cycles) for stated in loaded.claims.values() if stated.place != "VI"}
    assert {(condition, n) for conditions, cycles in told for condition in conditions for n in cycles} == {
        (condition, n) for condition in loaded.experiment.benchmark.conditions for n in (5, 20, 100)
    }


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("place: V-a", "plaze: V-a", "claims.novice_5_not_different.plaze: unknown key; did you mean 'place'?"),
        ("    place: V-a\n", "", "claims.novice_5_not_different.place: is missing."),
        ("quote: For", "quote: ''\n    x: For", "claims.novice_5_not_different.quote = '': string should"),
        ("[single_novice]", "[novice]", "claims.novice_5_not_different.conditions: novice not in paper; known are"),
        ("n_cycles: [5]", "n_cycles: [7]", "claims.novice_5_not_different.n_cycles: 7 not in paper; known are 5, 20"),
        ("n_cycles: [5]", "n_cycles: []", "claims.novice_5_not_different.n_cycles = []: should have at least 1"),
        ("n_cycles: [5]", "n_cycles: [5, 5]", "claims.novice_5_not_different.n_cycles: 5 is given twice."),
        ("policies: [greedy,", "policies: [best,", "claims.novice_5_not_different.policies: best not in paper"),
        (
            "others: [alternating,", "others: [greedy,",
            "claims.novice_5_outperform.others: greedy already among the policies.",
        ),
        (
            "relation: not_significantly_different", "relation: wins",
            "claims.novice_5_not_different.relation = 'wins': should be one of significantly_outperforms, better_mean",
        ),
        (
            "relation: not_significantly_different", "relation: better_mean",
            "claims.novice_5_not_different: better_mean needs others.",
        ),
        (
            "relation: significantly_outperforms", "relation: same_mean",
            "claims.novice_5_outperform: same_mean takes no others.",
        ),
        (
            "relation: significantly_outperforms", "relation: less_sensitive",
            "claims.novice_5_outperform: less_sensitive needs two policies and two others.",
        ),
        ("  novice_5_outperform:", "  novice_5_not_different:", "line "),
        ("claims:\n", "- claims\n", "line "),
    ],
)  # fmt: skip
def test_wrong_files_are_refused_with_the_place(tmp_path: Path, old: str, new: str, expected: str) -> None:
    (tmp_path / "paper.yaml").write_text(PAPER.read_text())
    text = PAPER_CLAIMS.read_text()
    assert old in text
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ClaimsError) as caught:
        load_claims(path)
    assert f"{path}: {expected}" in str(caught.value)


def test_the_experiment_of_a_file_must_be_there(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER_CLAIMS.read_text())
    with pytest.raises(ExperimentError, match=r"mine\.yaml: experiment = .paper\.yaml.: there is no such file"):
        load_claims(path)
    path.write_text(PAPER_CLAIMS.read_text().replace("experiment: paper.yaml", "experiment: papre"))
    with pytest.raises(ExperimentError, match=r"mine\.yaml: experiment = papre: neither a file nor the name"):
        load_claims(path)

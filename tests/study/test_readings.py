"""A study that sets a few readings of a text side by side: its file, its points, and what holds under all of them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import PAPER, ROOT

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.fatigue.entries import JOINT_GROUPS
from fatigue_planner.output.reports.page import Table
from fatigue_planner.output.reports.study.finished import read_study
from fatigue_planner.output.reports.study.side_by_side import side_by_side
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.study.benchmark.replay import replay
from fatigue_planner.study.sensitivity.agreement import agreement, agreement_sentences
from fatigue_planner.study.sensitivity.design import design
from fatigue_planner.study.sensitivity.reactions import react
from fatigue_planner.study.sensitivity.settings import StudySettings
from fatigue_planner.study.sensitivity.shares import cost_shares
from fatigue_planner.study.sensitivity.study import load_study
from fatigue_planner.study.sensitivity.tables import StudyGrid

STRONG: dict[str, Any] = {
    "argument": "who tires at 20 %",
    "changes": {"fatigue.threshold": 0.2, "fatigue.fatigue_rate_per_s": 0.01},
}
HASTY: dict[str, Any] = {"argument": "who counts the next cycle", "changes": {"discount": 0.5}}
STUDY: dict[str, Any] = {
    "name": "few",
    "base": str(PAPER),
    "grid": {
        "conditions": ["single_novice"], "n_cycles": [5], "policies": ["alternating", "greedy", "periodic"],
        "trials": 3, "further_policies": {"planning": {"kind": "lookahead", "depth": 2}},
    },
    "planners": ["planning"],
    "baselines": ["greedy", "alternating", "periodic"],
    "headline": {"planner": "planning", "condition": "single_novice", "n_cycles": 5},
    "factors": {
        "reading": {
            "kind": "readings", "base": "own", "reason": "as it is", "others": {"strong": STRONG, "hasty": HASTY},
        },
    },
}  # fmt: skip


def write(folder: Path, **others: Any) -> Path:
    factor = STUDY["factors"]["reading"]
    path = folder / "few.yaml"
    path.write_text(json.dumps(STUDY | {"factors": {"reading": factor | {"others": factor["others"] | others}}}))
    return path


@pytest.mark.parametrize(
    ("others", "expected"),
    [
        ({"own": HASTY}, "base = 'own': is also among the others"),
        ({"same": HASTY}, "its levels 'hasty' and 'same' are the same"),
        ({"none": {"argument": "a", "changes": {"discount": 0.95}}}, "its levels 'own' and 'none' are the same"),
        ({"none": {"argument": "a", "changes": {}}}, "others.none.changes = {}: should have at least 1"),
        ({"mute": {"changes": {"discount": 0.9}}}, "others.mute.argument: is missing"),
        ({"odd": {"argument": "a", "changes": {"discont": 0.9}}}, "discont: unknown key; did you mean 'discount'?"),
        ({"odd": {"argument": "a", "changes": {"discount": 2}}}, "factors.reading at 'odd': discount = 2"),
        ({"odd": {"argument": "a", "changes": {"benchmark.seed": 2}}}, "must be the same at all points"),
    ],
)
def test_wrong_readings_are_named(others: dict[str, Any], expected: str, tmp_path: Path) -> None:
    with pytest.raises(ExperimentError) as caught:
        load_study(write(tmp_path, **others))
    assert expected in str(caught.value)


def test_a_reading_changes_what_it_says_and_nothing_else(tmp_path: Path) -> None:
    study = load_study(write(tmp_path))
    points = design(study)
    assert [point.name for point in points] == ["base", "reading=strong", "reading=hasty"]
    own, strong, hasty = (point.experiment for point in points)
    assert own == study.base and own is not None and strong is not None
    fatigue = own.fatigue.model_copy(update={"threshold": 0.2, "fatigue_rate_per_s": 0.01})
    assert strong == own.model_copy(update={"fatigue": fatigue})
    assert hasty == own.model_copy(update={"discount": 0.5})


def test_the_readings_that_ship_are_twelve_that_can_all_be_built() -> None:
    """Each changes the paper, no two alike, and each gives its argument."""
    study = load_study(ROOT / "experiments" / "readings.yaml")
    points = design(study)
    assert len(points) == 12 and all(point.experiment is not None for point in points), [p.reason for p in points]
    assert len({json.dumps(point.experiment.plain()) for point in points if point.experiment}) == 12
    factor = study.settings.factors["reading"]
    assert len({factor.argument(level) for level in factor.all_levels()}) == 12


@pytest.mark.slow
def test_shares_of_the_cost_are_those_of_the_runs(tmp_path: Path, cache_folder: Path) -> None:
    """The joints' parts of Eq. 5 add up to the cost that the runs reported, with the discount of the reading."""
    study = load_study(write(tmp_path))
    reacted = react(design(study), ReactionCache(cache_folder), LocalProcesses(1), lambda _: None, "again")
    grid = StudyGrid(reacted)
    runs = grid.runs([cell.run(cell.trial_numbers()) for cell in grid.cells], study.settings)
    assert set(runs.trials) == {"base", "reading=strong", "reading=hasty"}
    shares = runs.shares.pivot_table(index="point", columns="joint_group", values="share")
    np.testing.assert_allclose(shares.sum(axis=1), 1, rtol=1e-12)
    assert set(shares.columns) == set(JOINT_GROUPS)
    for point in runs.trials:
        (cell,) = [grid.cells[i] for i in grid.of_point[point] if grid.cells[i].policy == "greedy"]
        returns = runs.trials[point].query("policy == 'greedy'")["discounted_return"]
        results = cell.run(range(3))
        wrist, model = 0.0, cell.scenario.model
        for trial, done in results.items():
            for cycle, fatigue in enumerate(replay(cell, trial, done.actions).fatigue):
                wrist += model.discount**cycle * (fatigue[JOINT_GROUPS["right_wrist"]] ** 2).sum() / fatigue.size
        assert shares.loc[point, "right_wrist"] == pytest.approx(wrist / -returns.sum(), rel=1e-12) and wrist > 0
        assert cost_shares(cell, results) == pytest.approx(shares.loc[point].to_dict(), rel=1e-12)


def synthetic() -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Gains, verdicts and shares at two points: planning beats greedy at both, alternating at one, the plan nowhere."""
    gains = pd.DataFrame(
        [
            (point, "single_novice", 5, "planning", baseline, gain, verdict)
            for point, own in {
                "base": {"greedy": (0.02, "better"), "alternating": (0.1, "better"), "periodic": (0.0, "undecided")},
                "reading=hasty": {
                    "greedy": (0.01, "better"), "alternating": (0.0, "undecided"), "periodic": (-0.01, "worse"),
                },
            }.items()
            for baseline, (gain, verdict) in own.items()
        ],
        columns=["point", "condition", "n_cycles", "planner", "baseline", "gain", "verdict"],
    )  # fmt: skip
    answers = {"a_b": ("reproduced", "reproduced"), "c": ("reproduced", "undetermined"), "d": ("not reproduced",) * 2}
    verdicts = pd.DataFrame(
        [
            (point, claim, analysis, verdict if analysis == "modern" else "reproduced")
            for claim, own in answers.items()
            for point, verdict in zip(("base", "reading=hasty"), own, strict=True)
            for analysis in ("modern", "paper")
        ],
        columns=["point", "claim", "analysis", "verdict"],
    )
    shares = pd.DataFrame(
        [
            ("base", "right_wrist", 0.75), ("base", "back", 0.25), ("reading=hasty", "right_wrist", 0.5),
            ("reading=hasty", "back", 0.5),
        ],
        columns=["point", "joint_group", "share"],
    )  # fmt: skip
    return gains, verdicts, shares


def test_what_holds_under_all_some_and_no_readings() -> None:
    study = StudySettings.model_validate(STUDY)
    gains, verdicts, shares = synthetic()
    agreed = agreement(study, gains, verdicts)
    assert dict(zip(agreed["statement"], agreed["held"], strict=True)) == {
        "planning better than greedy": 2, "planning better than alternating": 1, "planning better than periodic": 0,
        "a_b": 2, "c": 1, "d": 0,
    }  # fmt: skip
    assert set(agreed["points"]) == {2}
    names = {"base": "own", "reading=hasty": "hasty"}
    assert agreement_sentences(study, agreed, gains, shares, names) == [
        "Under all 2 readings: planning better than greedy, a b (1 of the paper's claims).",
        "Under some: planning better than alternating (1), c (1) (1 of the paper's claims).",
        "Under none: planning better than periodic, d (1 of the paper's claims).",
        "The policy planning costs less (single novice, 5 cycles) than greedy by 1 % (hasty) to 2 % (own), 1.5 % in "
        "the median, alternating by 0 % (hasty) to 10 % (own), 5 % in the median and periodic by −1 % (hasty) to 0 % "
        "(own), −0.5 % in the median.",
        "Of greedy's cost (single novice, 5 cycles), the right wrist makes up 50 % (hasty) to 75 % (own) and the back "
        "makes up 25 % (own) to 50 % (hasty).",
    ]
    assert agreement(study, gains, None)["kind"].eq("gain").all()


@pytest.mark.slow
def test_the_command_writes_the_same_bytes_and_the_report_shows_it(tmp_path: Path, cache_folder: Path) -> None:
    """One process or two, in one go or resumed."""
    from commands import fatplan

    path = write(tmp_path)
    files: dict[str, dict[str, bytes]] = {}
    for name, jobs in (("one", 1), ("two", 2)):
        done = fatplan("sensitivity", path, "--cache", cache_folder, "--results", tmp_path / name, "--jobs", jobs)
        assert done.returncode == 0, done.stderr
        assert done.stdout.startswith("1. Under all 3 readings: ")
        folder = tmp_path / name / "few"
        files[name] = {file.name: file.read_bytes() for file in folder.glob("*.csv")}
    assert files["one"] == files["two"] and "agreement.csv" in files["one"] and "importance.csv" not in files["one"]
    study = read_study(tmp_path / "one" / "few")
    _, arguments = side_by_side(study, "")
    table = arguments.blocks[0]
    assert isinstance(table, Table)
    assert [row[1] for row in table.rows] == ["as it is", STRONG["argument"], HASTY["argument"]]
    page = (tmp_path / "one" / "few" / "report.html").read_text()
    assert "What holds where" in page and HASTY["argument"] in page and "Which settings decide" not in page

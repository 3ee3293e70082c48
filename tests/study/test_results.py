"""Published tables are checked row by row before anything is made of them."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from conftest import PAPER
from published import COMMAND, publish, seal

from fatigue_planner.core.errors import DamagedFileError, FatplanError, MissingTableError, StaleTableError
from fatigue_planner.core.files import digest_of
from fatigue_planner.experiment.build import cycle_profiles
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.benchmark.results import (
    CONTRASTS_FILE,
    BenchmarkNote,
    courses,
    keep_or_remove,
    load_folder,
    load_results,
)
from fatigue_planner.study.benchmark.selection import Selection, cells, selected
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, KEY, REGRET_FILE, TRIALS_FILE, publish_table
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.statistics.comparison import comparison_table
from fatigue_planner.study.statistics.contrasts import contrasts


@pytest.fixture(scope="module")
def small(paper: Experiment) -> Experiment:
    return selected(paper, Selection([5], None, ["random", "greedy"], 4, None, None))


@pytest.fixture(scope="module")
def published(small: Experiment, reactions: tuple[Reaction, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("published")
    publish(small, reactions, folder)
    return folder


@pytest.fixture
def folder(published: Path, tmp_path: Path) -> Path:
    """A copy that a test may spoil."""
    return Path(shutil.copytree(published, tmp_path / "results"))


def alter(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")


def test_courses_come_to_the_returns_of_the_table(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path
) -> None:
    results = load_results(small, folder, COMMAND)
    assert results.regret is None and results.bounds is None
    grid = cells(small, cycle_profiles(small, reactions))
    found = courses(grid, results, folder)
    assert {key: len(runs) for key, runs in found.items()} == {
        (cell.condition, 5, cell.policy): len(cell.trial_numbers()) for cell in grid
    }


def test_claims_about_conditions_that_could_not_be_run_are_not_judged(folder: Path) -> None:
    entry = json.loads((folder / "manifest.json").read_text())["benchmark"]
    del entry["actions"]["single_expert"]
    grid = BenchmarkNote.model_validate(entry).grid
    assert set(grid.conditions) == {"single_novice", "multiple_novice"}
    claims = load_claims(PAPER.parent / "paper_claims.yaml")
    wide = grid.model_copy(update={"n_cycles": (5, 20, 100), "policies": claims.experiment.benchmark.policies})
    assert {condition for claim in claims.about(wide).values() for condition in claim.conditions} == set(
        grid.conditions
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: [*lines, lines[3]], "has duplicate rows: single_novice/5/random/2"),
        (lambda lines: [*lines[:2], *lines[4:]], "2 rows are missing: single_novice/5/random/1, .*/2"),
        (
            lambda lines: [*lines, lines[1].replace("novice", "nobody")],
            "1 row is in no cell .*single_nobody/5/random/0",
        ),
        (lambda lines: [*lines, lines[1].replace("random,0", "random,9")], "1 row is in no cell .*random/9"),
        (lambda lines: [*lines[:1], lines[1].replace("-0.0", "-0.1"), *lines[2:]], "altered or damaged"),
    ],
    ids=["twice", "missing", "foreign", "too many", "altered"],
)
def test_wrong_rows_are_named(small: Experiment, folder: Path, change: Callable, message: str) -> None:
    alter(folder / TRIALS_FILE, change)
    with pytest.raises(DamagedFileError, match=message):
        load_results(small, folder, COMMAND)


def test_rows_of_another_configuration_are_named(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, tmp_path: Path
) -> None:
    """A row copied from a run with another seed, and the manifest made anew: only living it through shows it."""
    other = selected(small, Selection(None, None, None, None, None, 1))
    publish(other, reactions, tmp_path / "other")
    foreign = (tmp_path / "other" / TRIALS_FILE).read_text().splitlines()[3]
    alter(folder / TRIALS_FILE, lambda lines: [*lines[:3], foreign, *lines[4:]])
    seal(small, folder)
    results = load_results(small, folder, COMMAND)
    with pytest.raises(DamagedFileError, match=r"not from this configuration.*: single_novice/5/random/2\. Run"):
        courses(cells(small, cycle_profiles(small, reactions)), results, folder)


@pytest.mark.parametrize("text", ["0 1", "0 1 0 1 2", "0 1 0 1 x", "0 1 0 1 -1"])
def test_actions_that_are_none_are_named(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, text: str
) -> None:
    table = pd.read_csv(folder / ACTIONS_FILE, dtype=str)
    table.loc[0, "actions"] = text
    table.to_csv(folder / ACTIONS_FILE, index=False)
    seal(small, folder)
    with pytest.raises(DamagedFileError, match="single_novice/5/random/0"):
        courses(cells(small, cycle_profiles(small, reactions)), load_results(small, folder, COMMAND), folder)


def test_tables_of_other_settings_are_refused(small: Experiment, folder: Path) -> None:
    for change, name in (({"discount": 0.9}, "discount"), ({"tool": small.tool.model_copy(update={"mass_kg": 1})}, "")):
        with pytest.raises(StaleTableError, match=f"other settings .*{name or 'tool, reactions'}"):
            load_results(small.model_copy(update=change), folder, COMMAND)
    looser = small.model_copy(update={"statistics": small.statistics.model_copy(update={"significance_level": 0.1})})
    with pytest.raises(StaleTableError, match=r"contrasts.csv: was made with other settings \(statistics\)\. Run"):
        load_results(looser, folder, COMMAND)


def test_comparisons_are_read_back_as_they_were_computed(small: Experiment, folder: Path) -> None:
    found = load_results(small, folder, COMMAND)
    level, seed = small.statistics.significance_level, small.benchmark.seed
    for table, expected in (
        (found.comparison, comparison_table(found.trials, level)),
        (found.contrasts, contrasts(found.trials, small.statistics, seed)),
    ):
        pd.testing.assert_frame_equal(table, expected, check_exact=True)
    alter(folder / CONTRASTS_FILE, lambda lines: [lines[0], lines[1].replace("e-", "e-1"), *lines[2:]])
    with pytest.raises(DamagedFileError, match=r"contrasts\.csv: is not what was written"):
        load_results(small, folder, COMMAND)


def test_what_is_not_there_is_said(small: Experiment, folder: Path, tmp_path: Path) -> None:
    errors: list[tuple[str, type[FatplanError]]] = [
        (ACTIONS_FILE, MissingTableError), ("manifest.json", DamagedFileError), (TRIALS_FILE, MissingTableError)
    ]  # fmt: skip
    for name, error in errors:
        (folder / name).unlink()
        with pytest.raises(error, match="Run `fatplan benchmark`"):
            load_results(small, folder, COMMAND)


def test_bounds_are_checked_row_by_row(small: Experiment, reactions: tuple[Reaction, ...], folder: Path) -> None:
    grid = cells(small, cycle_profiles(small, reactions))
    rows = [(one.condition, 5, one.policy, 0.001, True, 0.1, float("nan"), 4) for one in grid]
    columns = ["condition", "n_cycles", "policy", "cost_bound", "exact", "gap", "standard_error", "trials"]
    path = folder / BOUNDS_FILE
    pd.DataFrame(rows, columns=columns).to_csv(path, index=False)
    seal(small, folder)
    with pytest.raises(DamagedFileError, match=r"bounds.csv: is not what was written.*Run `fatplan benchmark --bound`"):
        load_results(small, folder, COMMAND)  # the note does not speak of it
    seal(small, folder, BOUNDS_FILE)
    found = load_results(small, folder, COMMAND)
    assert found.bounds is not None and found.options == " --bound" and len(found.bounds) == len(grid)
    for change, message in (
        (lambda lines: [*lines, lines[1]], "has duplicate rows: single_novice/5/random"),
        (lambda lines: lines[:-1], "1 row is missing: multiple_novice/5/greedy"),
        (
            lambda lines: [*lines, lines[1].replace("random", "chance")],
            "1 row is in no cell .*: single_novice/5/chance",
        ),
        (lambda lines: [lines[0], lines[1].replace("0.001", "")], "not one of our tables"),
        (lambda lines: [""], "not one of our tables"),
    ):
        whole = path.read_text()
        alter(path, change)
        with pytest.raises(DamagedFileError, match=message):
            load_results(small, folder, COMMAND)
        path.write_text(whole)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DamagedFileError, match="not one of our tables"):
        load_results(small, folder, COMMAND)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda folder: None, None),
        (lambda folder: alter(folder / ACTIONS_FILE, lambda lines: [*lines[:-1], lines[1]]), "different: runs"),
        (lambda folder: alter(folder / REGRET_FILE, lambda lines: lines[:-1]), "it is now regret.damaged-1"),
    ],
    ids=["same runs", "other runs", "damaged"],
)
def test_tables_of_an_earlier_run_stay_only_with_its_runs(
    small: Experiment, folder: Path, change: Callable[[Path], None], said: str | None
) -> None:
    regret = pd.read_csv(folder / TRIALS_FILE)[KEY].assign(decision_loss=0.1, run_loss=0.5, agreement=0.5)
    publish_table(folder, regret, [REGRET_FILE])
    seal(small, folder, REGRET_FILE)
    change(folder)
    kept, warnings = keep_or_remove(small, folder, [REGRET_FILE, BOUNDS_FILE])
    assert (list(kept) == [REGRET_FILE]) == (folder / REGRET_FILE).exists() == (said is None)
    if said is not None:
        assert len(warnings) == 1 and said in warnings[0] and warnings[0].endswith("`--regret` makes it again.")


def write_manifest(folder: Path, entry: dict[str, object]) -> None:
    """A manifest with the seal it should have."""
    entry.pop("seal", None)
    text = json.dumps({"benchmark": {**entry, "seal": digest_of(entry)}}, indent=1, sort_keys=True, ensure_ascii=False)
    (folder / "manifest.json").write_text(text + "\n")


@pytest.mark.parametrize("missing", ["versions", "references", "experiment", "actions", "seed", "sha256", "reactions"])
def test_a_manifest_of_another_version_is_one_clear_message(small: Experiment, folder: Path, missing: str) -> None:
    entry = json.loads((folder / "manifest.json").read_text())["benchmark"]
    write_manifest(folder, dict(entry))
    load_results(small, folder, COMMAND)
    for value in (None, [], "x"):
        write_manifest(folder, {**entry, missing: value})
        with pytest.raises(DamagedFileError, match="does not say, as this version does, how files were made"):
            load_results(small, folder, COMMAND)
    del entry[missing]
    write_manifest(folder, entry)
    with pytest.raises(DamagedFileError, match="does not say"):
        load_folder(folder)


def test_an_altered_manifest_is_noticed(small: Experiment, folder: Path) -> None:
    path = folder / "manifest.json"
    whole = path.read_text()
    version = json.loads(whole)["benchmark"]["versions"]["numpy"]
    for altered in (whole.replace(f'"numpy": "{version}"', '"numpy": "1.0"'), whole.replace(": 0.95", ": 0.950")):
        assert altered != whole
        path.write_text(altered)
        with pytest.raises(DamagedFileError, match=r"manifest.json: is not what was written"):
            load_results(small, folder, COMMAND)
    seal(small, folder)
    assert path.read_text() == whole
    load_results(small, folder, COMMAND)
    path.write_text(whole[:-10])
    seal(small, folder)
    assert path.read_text() == whole and path.with_suffix(".damaged-1").read_text() == whole[:-10]

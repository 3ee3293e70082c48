"""The commands that read the tables of a benchmark, and the tables themselves."""

import hashlib
import json
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
import yaml
from commands import fatplan, finished, refused, small_files
from conftest import PAPER
from test_cli_json import document

FIGURES = ["report", "--figures-only"]


@pytest.fixture(scope="module")
def results(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small run of the paper's grid: all cells, few trials and descents; then its figures."""
    folder = tmp_path_factory.mktemp("results")
    small = folder / "paper.yaml"
    small.write_text(PAPER.read_text().replace("trials: 100", "trials: 3").replace("descents: 5000", "descents: 30"))
    for command in (["benchmark"], FIGURES):
        done = fatplan(*command, small, "--cache", cache_folder, "--results", folder)
        assert done.returncode == 0, done.stderr
    return folder / "paper"


def test_benchmark_writes_the_whole_grid(results: Path) -> None:
    table = pd.read_csv(results / "trials.csv")
    cells = table.groupby(["condition", "n_cycles", "policy"]).size()
    assert len(cells) == 3 * 3 * 13
    assert set(cells["single_expert"].drop("random", level="policy")) == {1}
    assert set(cells.drop("single_expert")) == {3}
    assert len(pd.read_csv(results / "planning_times.csv")) == len(table)
    assert "one deterministic run" in (results / "summary.txt").read_text()


def test_benchmark_contrasts_every_pair_of_every_family(results: Path) -> None:
    """Three families of 21 pairs in three lengths; of an expert's, 15 pairs are deterministic."""
    table = pd.read_csv(results / "contrasts.csv")
    assert list(table.groupby("family", sort=False).size()) == [63, 63, 63]
    assert table["note"].str.contains("deterministic").sum() == 45
    assert table["holm_p"].notna().sum() == table["paired_p"].notna().sum() > 100
    assert "single_expert: 63 comparisons, 18 tested: " in (results / "summary.txt").read_text()
    assert "contrasts.csv" in json.loads((results / "manifest.json").read_text())["benchmark"]["sha256"]


def test_figures_stand_beside_their_data(results: Path) -> None:
    for name in ("figure5a", "figure5b", "reactions", "torques"):
        assert (results / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "<svg" in (results / f"{name}.svg").read_text()[:2000]
        assert len(pd.read_csv(results / f"{name}.csv")) > 0
    data = pd.read_csv(results / "figure5a.csv")
    trials = pd.read_csv(results / "trials.csv")
    assert set(data["condition"]) == {"single_novice", "single_expert"}
    for row in data.to_dict("records"):
        keys = ["condition", "n_cycles", "policy"]
        cell = trials[(trials[keys] == [row[key] for key in keys]).all(axis=1)]
        assert cell["discounted_return"].mean() == pytest.approx(row["mean"], rel=1e-12)


@pytest.mark.slow
def test_rebuilding_figures_changes_no_byte(results: Path, cache_folder: Path) -> None:
    before = {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}
    experiment = results.parent / "paper.yaml"
    assert fatplan(*FIGURES, experiment, "--cache", cache_folder, "--results", results.parent).returncode == 0
    after = {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}
    assert before == after


def test_manifest_carries_configuration_versions_seed_and_hashes(results: Path) -> None:
    manifest = json.loads((results / "manifest.json").read_text(), parse_constant=pytest.fail)
    run = manifest["benchmark"]
    assert run["seed"] == 2023 and run["experiment"]["discount"] == 0.95
    assert {"fatplan", "python", "numpy", "numba", "pin", "casadi"} <= set(run["versions"])
    assert len(run["reactions"]) == 4
    for command in ("benchmark", "figures"):
        for name, digest in manifest[command]["sha256"].items():
            assert hashlib.sha256((results / name).read_bytes()).hexdigest() == digest


def test_figures_refuse_a_table_that_is_not_this_experiments(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(results, tmp_path / "paper")
    text = (results.parent / "paper.yaml").read_text()
    experiment = tmp_path / "paper.yaml"
    folders = ["--cache", cache_folder, "--results", tmp_path]
    for old, new, key in (("discount: 0.95", "discount: 0.9", "discount"), ("greedy", "keen", "benchmark, statistics")):
        experiment.write_text(text.replace(old, new).replace("kind: keen", "kind: greedy"))
        message = refused(2, *FIGURES, experiment, *folders)
        assert f"was made with other settings ({key})" in message and "Run `fatplan benchmark " in message
    experiment.write_text(text)
    table = tmp_path / "paper" / "trials.csv"
    table.write_text(table.read_text().replace("-0.0", "-0.1", 1))
    assert "is not what was written" in refused(4, *FIGURES, experiment, *folders)
    table.write_text(table.read_text().replace("-0.1", "-0.o", 1))
    assert "is not one of our tables" in refused(4, *FIGURES, experiment, *folders)


def test_claims_are_judged_from_the_published_tables(results: Path) -> None:
    claims = results.parent / "paper_claims.yaml"
    shutil.copy(PAPER.parent / "paper_claims.yaml", claims)
    before = json.loads((results / "manifest.json").read_text())
    done = fatplan("claims", claims, "--results", results.parent)
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(results / "claims.csv", keep_default_na=False)
    verdicts = {name: (table["verdict"] == name).sum() for name in ("reproduced", "not reproduced", "undetermined")}
    assert sum(verdicts.values()) == len(table) >= 22
    counts = ", ".join(f"{count} {name}" for name, count in verdicts.items())
    assert f"{len(table)} claims: {counts}." in done.stdout
    assert f"--results {results.parent} --bound` computes it" in done.stdout
    manifest = json.loads((results / "manifest.json").read_text())
    assert set(manifest.pop("claims")["sha256"]) == {"claims.csv", "claims_detail.csv"} and manifest == before
    files = [results / name for name in ("claims.csv", "claims_detail.csv", "manifest.json")]
    written = [file.read_bytes() for file in files]
    assert fatplan("claims", claims, "--results", results.parent).stdout == done.stdout
    assert [file.read_bytes() for file in files] == written


def test_claims_refuse_tables_that_are_not_the_experiments(results: Path, tmp_path: Path) -> None:
    claims = tmp_path / "claims.yaml"
    shutil.copy(PAPER.parent / "paper_claims.yaml", claims)
    experiment = shutil.copy(results.parent / "paper.yaml", tmp_path)
    message = refused(2, "claims", claims, "--results", tmp_path / "none")
    assert f"Run `fatplan benchmark {experiment} --results {tmp_path / 'none'}` first" in message
    (tmp_path / "paper.yaml").write_text(
        (tmp_path / "paper.yaml").read_text().replace("discount: 0.95", "discount: 0.9")
    )
    assert "was made with other settings (discount)" in refused(2, "claims", claims, "--results", results.parent)
    assert "No such file" in refused(2, "claims", tmp_path / "none.yaml")


@pytest.mark.slow
def test_the_report_is_written_from_the_published_tables(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    """It changes no table, and judges the claims that lie beside the experiment."""
    folder = Path(shutil.copytree(results.parent, tmp_path / "results"))
    claims = (PAPER.parent / "paper_claims.yaml").read_text()
    (folder / "paper_claims.yaml").write_text(claims)
    before = {name: (folder / "paper" / name).read_bytes() for name in ("trials.csv", "actions.csv", "contrasts.csv")}
    command = ["report", folder / "paper.yaml", "--cache", cache_folder, "--results", folder]
    done = fatplan(*command)
    assert done.returncode == 0, done.stderr
    page = (folder / "paper" / "report.html").read_bytes()
    assert len(page) < 10e6
    assert before == {name: (folder / "paper" / name).read_bytes() for name in before}
    assert b"not_significantly" not in page and b"For a novice user, with n_cycles = 5" in page
    assert b"not measured; <code>fatplan benchmark --regret --bound</code>" in page
    noted = json.loads((folder / "paper" / "manifest.json").read_text())["report"]["sha256"]
    assert {"report.html", "figure5a.svg", "estimates.csv", "cycle_maps.csv", "actions_taken.png"} <= set(noted)

    trials = folder / "paper" / "trials.csv"
    text = trials.read_text()
    trials.write_text("\n".join([*text.splitlines()[:-1], text.splitlines()[1]]) + "\n")
    assert "has duplicate rows: single_novice/5/random/0" in refused(4, *command)


@pytest.fixture(scope="module")
def restricted(results: Path, cache_folder: Path) -> tuple[Path, list[object]]:
    """A part of the grid: its folder, and the options that make it."""
    grid = ["--policies", "greedy", "--conditions", "multiple_novice", "--policies", "pomcp_0.1", "--cycles", 5]
    where = [results.parent / "paper.yaml", "--cache", cache_folder, "--results", results.parent]
    assert fatplan("benchmark", *where, *grid).returncode == 0
    return results.parent / "paper_cycles-5_conditions-multiple_novice_policies-greedy+pomcp_0.1", grid


@pytest.mark.parametrize("command", [FIGURES, pytest.param(["report"], marks=pytest.mark.slow)], ids="-".join)
def test_a_restricted_grid_is_reported_by_its_options_or_its_folder(
    restricted: tuple[Path, list[object]], cache_folder: Path, command: list[str]
) -> None:
    folder, grid = restricted
    experiment = folder.parent / "paper.yaml"
    where = [experiment, "--cache", cache_folder, "--results", folder.parent]
    by_options = document("report", *where, *grid, *command[1:])
    assert "figure5b.svg" in by_options["files"] and "figure5a.svg" not in by_options["files"]
    by_folder = document("report", folder, "--cache", cache_folder, *command[1:])
    assert by_folder["folder"] == by_options["folder"] == str(folder)
    for found in (by_options["files"], by_folder["files"]):
        found.pop("report.html", None)  # names the command
    assert by_folder["files"] == by_options["files"]
    message = refused(2, *command, folder, "--cache", cache_folder, "--seed", 3)
    assert "--seed: cannot be given with the results folder" in message
    message = refused(2, *command, *where, "--policies", "greedy")
    assert f"Run `fatplan benchmark {experiment} --policies greedy --cache" in message
    assert "is not a results folder" in refused(2, *command, folder.parent, "--cache", cache_folder)


def test_claims_of_a_restricted_grid_are_those_about_nothing_else(restricted: tuple[Path, list[object]]) -> None:
    folder, grid = restricted
    claims, file = yaml.safe_load((PAPER.parent / "paper_claims.yaml").read_text()), folder.parent / "two_claims.yaml"
    own = {"place": "x", "quote": "y", "relation": "better_mean", "conditions": ["multiple_novice"], "n_cycles": [5]}
    own |= {"policies": ["pomcp_0.1"], "others": ["greedy"]}
    both = {"experiment": "paper.yaml", "claims": {**claims["claims"], "own": own}}
    file.write_text(yaml.safe_dump(both, sort_keys=False))
    by_folder = document("claims", file, folder)
    assert [claim["claim"] for claim in by_folder["claims"]] == ["own"]
    assert by_folder["left_out"] == list(claims["claims"])
    assert document("claims", file, "--results", folder.parent, *grid) == by_folder
    assert "Not judged, for they are about more than this grid: " in fatplan("claims", file, folder).stdout
    file.write_text(yaml.safe_dump({"experiment": "paper.yaml", "claims": claims["claims"]}))
    assert "every claim is about more than the grid" in refused(2, "claims", file, folder)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs Chromium")
def test_a_browser_shows_the_report_without_a_complaint(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(results.parent, tmp_path / "results"))
    done = fatplan("report", folder / "paper.yaml", "--cache", cache_folder, "--results", folder)
    assert done.returncode == 0, done.stderr
    picture, page = tmp_path / "page.png", folder / "paper" / "report.html"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--window-size=1100,9000"]
    command = [
        "chromium",
        *options,
        f"--user-data-dir={tmp_path / 'profile'}",
        f"--screenshot={picture}",
        page.as_uri(),
    ]
    shown = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    assert "CONSOLE" not in shown.stderr and picture.stat().st_size > 100_000


@pytest.mark.slow
def test_compare_says_what_differs(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    grid = ["--cycles", 5, "--conditions", "single_expert", "--policies", "greedy", "--seed", 9]
    done = fatplan("benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path, *grid)
    assert done.returncode == 0, done.stderr
    (other,) = tmp_path.glob("paper_*")
    done = fatplan("compare", results, other, "--save", tmp_path / "side" / "by_side.html")
    assert done.returncode == 0, done.stderr
    assert ["benchmark.seed", "2023", "9"] in [line.split() for line in done.stdout.splitlines()]
    assert "Versions:\n  They are the same." in done.stdout
    assert "0.00 %" in done.stdout  # an expert's greedy robot is the same with every seed
    assert (tmp_path / "side" / "by_side.html").exists() and (tmp_path / "side" / "by_side.csv").exists()
    assert "there is no such table" in refused(2, "compare", results, tmp_path / "nowhere")
    assert "must end in .html" in refused(2, "compare", results, other, "--save", tmp_path / "x.txt")


@pytest.mark.slow
def test_the_same_as_json(results: Path, cache_folder: Path) -> None:
    """Every document has the hashes of what lies in the folder, or the rows of its tables."""
    where = [results.parent / "paper.yaml", "--cache", cache_folder, "--results", results.parent]
    ran = document("benchmark", *where)
    assert ran["runs"] == len(pd.read_csv(results / "trials.csv")) and ran["regret"] is ran["bounds"] is None
    table = pd.read_csv(results / "comparison.csv")
    assert [row["mean"] for row in ran["comparison"]] == list(table["mean"])
    assert [row["p_value"] is None for row in ran["comparison"]] == list(table["p_value"].isna())
    drawn = document("report", *where, "--figures-only")
    claims = results.parent / "paper_claims.yaml"
    shutil.copy(PAPER.parent / "paper_claims.yaml", claims)
    judged = document("claims", claims, "--results", results.parent)
    assert sum(judged["counts"].values()) == len(judged["claims"]) >= 22 and not judged["bounds"]
    assert judged["claims"][0]["quote"]
    for found in (ran, drawn, judged):
        assert found["files"]
        for name, digest in found["files"].items():
            assert hashlib.sha256((results / name).read_bytes()).hexdigest() == digest
    both = document("compare", results, results)
    assert len(both["contrasts"]) == 117 and both["same_worlds"] and both["settings"] == {}


@pytest.mark.parametrize("command", [FIGURES, pytest.param(["report"], marks=pytest.mark.slow)], ids="-".join)
def test_a_full_disk_leaves_what_was_there(results: Path, cache_folder: Path, command: list[str]) -> None:
    before = {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}
    where = [results.parent / "paper.yaml", "--cache", cache_folder, "--results", results.parent]
    done = finished(*command, *where, begin=small_files)
    assert done.returncode == 2 and done.stdout == "", done.stderr
    assert done.stderr.count("Error: ") == len(done.stderr.splitlines()) == 1 and "File too large" in done.stderr
    assert {name: (results / name).read_bytes() for name in before} == before
    assert not list(results.glob(".*"))

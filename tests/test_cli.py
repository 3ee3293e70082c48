"""The commands as a user types them: what they print, write, refuse, and the exit codes."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from conftest import PAPER

FATPLAN = [sys.executable, "-c", "from fatigue_planner.cli.entry import run; run()"]


def fatplan(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"COLUMNS": "200", "NO_COLOR": "1"}
    command = [*FATPLAN, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=environment, check=False, timeout=240)


def refused(code: int, *arguments: object) -> str:
    """The one message of a command that must fail with an exit code."""
    done = fatplan(*arguments)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    return done.stderr


@pytest.fixture(scope="module")
def results(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small run of the paper's grid: all cells, few trials and descents; then its figures."""
    folder = tmp_path_factory.mktemp("results")
    small = folder / "paper.yaml"
    small.write_text(PAPER.read_text().replace("trials: 100", "trials: 3").replace("descents: 5000", "descents: 30"))
    for command in ("benchmark", "figures"):
        done = fatplan(command, small, "--cache", cache_folder, "--results", folder)
        assert done.returncode == 0, done.stderr
    return folder / "paper"


def test_simulate_finds_what_is_there(cache_folder: Path) -> None:
    done = fatplan("simulate", PAPER, "--cache", cache_folder)
    assert done.returncode == 0
    assert "4 reactions, 4 found in the cache, nothing to simulate" in done.stdout
    assert done.stdout.count("hand within") == 4


def test_regret_and_bound_are_told_and_kept(cache_folder: Path, tmp_path: Path) -> None:
    """Five cycles of an expert: the bound is the optimum."""
    grid = ["--cycles", 5, "--conditions", "single_expert", "--policies", "greedy", "--policies", "alternating"]
    command = ["benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path, *grid, "--regret", "--bound"]
    done = fatplan(*command)
    assert done.returncode == 0, done.stderr
    assert "single_expert, 5 cycles; reference: lookahead over" in done.stdout
    assert "the least expected cost is 0.00" in done.stdout and "% above it" in done.stdout
    (folder,) = tmp_path.glob("paper_*")
    losses = pd.read_csv(folder / "regret.csv").set_index("policy")["run_loss"]
    assert 0 <= losses["greedy"] < losses["alternating"]
    gaps = pd.read_csv(folder / "bounds.csv").set_index("policy")["gap"]
    assert 0 <= gaps["greedy"] < gaps["alternating"]
    files = json.loads((folder / "manifest.json").read_text())["benchmark"]["sha256"]
    assert {"regret.csv", "bounds.csv", "trials.csv"} <= set(files)
    assert fatplan(*command).stdout == done.stdout


def test_benchmark_writes_the_whole_grid(results: Path) -> None:
    table = pd.read_csv(results / "trials.csv")
    cells = table.groupby(["condition", "n_cycles", "policy"]).size()
    assert len(cells) == 3 * 3 * 7
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


def test_rebuilding_figures_changes_no_byte(results: Path, cache_folder: Path) -> None:
    before = {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}
    experiment = results.parent / "paper.yaml"
    assert fatplan("figures", experiment, "--cache", cache_folder, "--results", results.parent).returncode == 0
    after = {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}
    assert before == after


def test_manifest_carries_configuration_versions_seed_and_hashes(results: Path) -> None:
    import hashlib
    import json

    manifest = json.loads((results / "manifest.json").read_text(), parse_constant=pytest.fail)
    run = manifest["benchmark"]
    assert run["seed"] == 2023 and run["experiment"]["discount"] == 0.95
    assert {"fatplan", "python", "numpy", "numba", "pin", "casadi"} <= set(run["versions"])
    assert len(run["reactions"]) == 4
    for command in ("benchmark", "figures"):
        for name, digest in manifest[command]["sha256"].items():
            assert hashlib.sha256((results / name).read_bytes()).hexdigest() == digest


def test_options_restrict_the_grid_in_a_folder_of_its_own(cache_folder: Path, tmp_path: Path) -> None:
    done = fatplan(
        "benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path, "--jobs", 1, "--cycles", 5, "--cycles", 20,
        "--conditions", "single_novice", "--policies", "greedy", "--policies", "pomcp_0.1", "--trials", 2,
        "--descents", 40, "--seed", 1,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (folder,) = [path for path in tmp_path.iterdir() if path.name != "paper"]
    assert (
        folder.name
        == "paper_cycles-20+5_conditions-single_novice_policies-greedy+pomcp_0.1_trials-2_descents-40_seed-1"
    )
    table = pd.read_csv(folder / "trials.csv")
    assert len(table) == 2 * 2 * 2 and set(table["n_cycles"]) == {5, 20}


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--cycles", "7"], "--cycles 7: not in the experiment; available: 5, 20, 100"),
        (["--policies", "best"], "--policies best: not in the experiment; available: random, alternating, greedy, "),
        (["--conditions", "x"], "--conditions x: not in the experiment; available: single_novice, "),
        (["--trials", "0"], "--trials"),
        (["--descents", "1000000000000"], "--descents"),
        (["--descents", "-5"], "--descents"),
        (["--jobs", "two"], "--jobs"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_bad_options(cache_folder: Path, tmp_path: Path, options: list[str], expected: str) -> None:
    assert expected in refused(2, "benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path, *options)


def test_missing_library_says_what_to_run(tmp_path: Path) -> None:
    message = refused(2, "benchmark", PAPER, "--cache", tmp_path, "--results", tmp_path)
    assert f"Run `fatplan simulate {PAPER} --cache {tmp_path}` first" in message
    assert not list(tmp_path.iterdir())


def test_damaged_library_is_exit_code_4_and_mended_by_simulate(cache_folder: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    shutil.copytree(cache_folder, cache)
    library = next(cache.glob("*.h5"))
    library.write_bytes(library.read_bytes()[:5000])
    message = refused(4, "benchmark", PAPER, "--cache", cache, "--results", tmp_path)
    assert library.name in message and "fatplan simulate" in message
    done = fatplan("simulate", PAPER, "--cache", cache)
    assert done.returncode == 0 and "set aside" in done.stderr and "3 found in the cache, 1 simulated" in done.stdout


def test_missing_table_says_what_to_run(cache_folder: Path, tmp_path: Path) -> None:
    assert f"Run `fatplan benchmark {PAPER} --cache" in refused(
        2, "figures", PAPER, "--cache", cache_folder, "--results", tmp_path
    )


def test_figures_refuse_a_table_that_is_not_this_experiments(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(results, tmp_path / "paper")
    text = (results.parent / "paper.yaml").read_text()
    experiment = tmp_path / "paper.yaml"
    folders = ["--cache", cache_folder, "--results", tmp_path]
    for old, new, key in (("discount: 0.95", "discount: 0.9", "discount"), ("greedy: {", "keen: {", "benchmark")):
        experiment.write_text(text.replace(old, new))
        message = refused(2, "figures", experiment, *folders)
        assert f"was made with other settings ({key})" in message and "Run `fatplan benchmark " in message
    experiment.write_text(text)
    table = tmp_path / "paper" / "trials.csv"
    table.write_text(table.read_text().replace("-0.0", "-0.1", 1))
    assert "is not what was written" in refused(4, "figures", experiment, *folders)
    table.write_text(table.read_text().replace("-0.1", "-0.o", 1))
    assert "is not one of our tables" in refused(4, "figures", experiment, *folders)


def test_the_readmes_workstation_runs(tmp_path: Path) -> None:
    """The README's YAML, laid over the paper's experiment, gives four usable motions."""
    import yaml

    block = (PAPER.parents[1] / "README.md").read_text().split("```yaml\n")[1].split("```")[0]
    experiment = yaml.safe_load(PAPER.read_text().replace("1e-8", "1.0e-8").replace("1e-6", "1.0e-6"))
    for key, value in yaml.safe_load(block).items():
        experiment[key] = value if key in {"actions", "workers"} else experiment[key] | value
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(experiment))
    done = fatplan("simulate", path, "--cache", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_bad_experiment(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER.read_text().replace("exploration_constant: 0.1,", "exploration_constant: -1,"))
    for command in ("simulate", "benchmark", "figures"):
        assert "exploration_constant = -1: input should be greater than or equal to 0" in refused(2, command, path)
    assert "No such file" in refused(2, "simulate", tmp_path / "none.yaml")


def test_unwritable_folders(cache_folder: Path, tmp_path: Path) -> None:
    """A file stands where the folder should be (permissions do not stop root)."""
    (tmp_path / "file").write_text("")
    inside = tmp_path / "file" / "below"
    assert "cannot write there" in refused(2, "simulate", PAPER, "--cache", inside)
    assert "cannot write there" in refused(2, "benchmark", PAPER, "--cache", cache_folder, "--results", inside)
    (tmp_path / "paper").write_text("")
    assert "cannot write there" in refused(2, "benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path)
    assert "cannot be written" in refused(2, "human", "export", PAPER, "--output", inside)


def test_human_report_writes_the_page_or_says_what_to_run_first(cache_folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "human.md"
    done = fatplan("human", "report", PAPER, "--cache", cache_folder, "--output", page)
    assert done.returncode == 0 and "6 values outside their band or range" in done.stdout
    text = page.read_text()
    assert text.startswith("# The digital human against the literature") and text.count("**OUTSIDE**") == 6
    message = refused(2, "human", "report", PAPER, "--cache", tmp_path / "none", "--output", page)
    assert f"Run `fatplan simulate {PAPER} --cache {tmp_path / 'none'}` first" in message


def test_target_out_of_reach_fails_and_is_not_kept(tmp_path: Path) -> None:
    """Near enough for the chain of all limbs, too far for a standing worker: found by simulating."""
    path = tmp_path / "far.yaml"
    text = PAPER.read_text().replace("x: 0.5, y: -0.25, z: 1.2", "x: 1.3, y: -0.25, z: 1.2")
    path.write_text(text.replace("time_step_s: 0.005", "time_step_s: 0.01"))
    done = fatplan("simulate", path, "--cache", tmp_path / "cache")
    assert done.returncode == 3, done.stderr
    failed = [line for line in done.stdout.splitlines() if "FAILED" in line]
    assert len(failed) == 2 and all("high/" in line and "closer" in line for line in failed)
    assert "2 of 4 reactions failed. The others are kept." in done.stdout
    assert len(list((tmp_path / "cache").glob("*.h5"))) == 2


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_interruption_keeps_what_is_finished(cache_folder: Path, tmp_path: Path, number: int, code: int) -> None:
    command = [
        *FATPLAN,
        "benchmark",
        str(PAPER),
        "--cache",
        str(cache_folder),
        "--results",
        str(tmp_path),
        "--jobs",
        "2",
    ]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        # a shell starts background jobs with SIGINT ignored, and children inherit that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
    )  # fmt: skip
    parts = tmp_path / "paper" / "parts"
    begin = time.monotonic()
    while not list(parts.glob("*/[0-9]*.json")) and time.monotonic() - begin < 120:
        time.sleep(0.1)
    at_the_signal = set(parts.glob("*/[0-9]*.json"))
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == code
    # what was stored is still there, and the work in progress has been finished and stored as well
    assert at_the_signal < set(parts.glob("*/[0-9]*.json"))
    assert "is kept; the same command goes on" in errors and "Traceback" not in errors


STOPPED_ON_IMPORT = """
import os, signal, sys
class Stopper:
    def find_spec(self, name, *_):
        if name == "fatigue_planner.cli.main":
            os.kill(os.getpid(), signal.SIGTERM)
sys.meta_path.insert(0, Stopper())
from fatigue_planner.cli.entry import run
run()
"""


def test_stopped_while_it_loads() -> None:
    done = subprocess.run([sys.executable, "-c", STOPPED_ON_IMPORT], capture_output=True, text=True, check=False)
    assert done.returncode == 143 and done.stderr.startswith("Stopped.") and len(done.stderr.splitlines()) == 1


def test_help_and_version() -> None:
    from typer.testing import CliRunner

    from fatigue_planner.cli.main import app

    for command in (
        [],
        *(
            [name]
            for name in (
                "simulate",
                "benchmark",
                "claims",
                "figures",
                "report",
                "compare",
                "sensitivity",
                "view",
                "validate",
                "schema",
                "doctor",
            )
        ),
    ):
        done = CliRunner().invoke(app, [*command, "--help"])
        assert done.exit_code == 0 and "Exit codes:" in done.output
    assert fatplan("--version").stdout.startswith("fatplan ")
    assert fatplan("nonsense").returncode == 2


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
    assert b"Not measured: <code>fatplan benchmark --regret --bound</code>" in page
    noted = json.loads((folder / "paper" / "manifest.json").read_text())["report"]["sha256"]
    assert {"report.html", "figure5a.svg", "estimates.csv", "cycle_maps.csv", "actions_taken.png"} <= set(noted)

    trials = folder / "paper" / "trials.csv"
    text = trials.read_text()
    trials.write_text("\n".join([*text.splitlines()[:-1], text.splitlines()[1]]) + "\n")
    assert "stands twice: single_novice/5/random/0" in refused(4, *command)


@pytest.mark.slow
def test_the_report_refuses_rows_of_no_cell(results: Path, cache_folder: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(results.parent, tmp_path / "results"))
    command = ["report", folder / "paper.yaml", "--cache", cache_folder, "--results", folder]
    trials = folder / "paper" / "trials.csv"
    trials.write_text(trials.read_text().replace("random,2,", "random,7,"))
    assert "rows are in no cell of the experiment: " in refused(4, *command)


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
    assert "benchmark.seed: 2023, 9" in done.stdout and "The versions are the same." in done.stdout
    assert "0.00\u00a0%" in done.stdout  # an expert's greedy robot is the same with every seed
    assert (tmp_path / "side" / "by_side.html").exists() and (tmp_path / "side" / "by_side.csv").exists()
    assert "there is no such table" in refused(2, "compare", results, tmp_path / "nowhere")
    assert "must end in .html" in refused(2, "compare", results, other, "--save", tmp_path / "x.txt")

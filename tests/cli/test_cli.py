"""The commands as a user types them: what they print, write, refuse, and the exit codes."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from commands import fatplan, refused
from conftest import PAPER


def test_simulate_finds_what_is_there(cache_folder: Path) -> None:
    done = fatplan("simulate", PAPER, "--cache", cache_folder)
    assert done.returncode == 0
    assert "4 reactions, 4 found in the cache, nothing to simulate" in done.stdout
    assert done.stdout.count("hand within") == 4


def test_missing_reactions_say_what_to_run(tmp_path: Path) -> None:
    message = refused(2, "benchmark", PAPER, "--cache", tmp_path, "--results", tmp_path)
    assert f"Run `fatplan simulate {PAPER} --cache {tmp_path}` first" in message
    assert not list(tmp_path.iterdir())


def test_a_damaged_entry_is_exit_code_4_and_mended_by_simulate(cache_folder: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    shutil.copytree(cache_folder, cache)
    entry = next(cache.glob("*.h5"))
    entry.write_bytes(entry.read_bytes()[:5000])
    message = refused(4, "benchmark", PAPER, "--cache", cache, "--results", tmp_path)
    assert entry.name in message and "fatplan simulate" in message
    done = fatplan("simulate", PAPER, "--cache", cache)
    assert done.returncode == 0 and "set aside" in done.stderr and "3 found in the cache, 1 simulated" in done.stdout


@pytest.mark.slow
def test_what_is_out_of_reach_is_kept_and_left_out_of_what_follows(tmp_path: Path) -> None:
    """Near enough for the chain of all limbs, too far for a standing worker: found by simulating."""
    path, cache, results = tmp_path / "far.yaml", tmp_path / "cache", tmp_path / "results"
    text = PAPER.read_text().replace("x: 0.5, y: -0.25, z: 1.2", "x: 1.3, y: -0.25, z: 1.2")
    text = text.replace("time_step_s: 0.01", "time_step_s: 0.02").replace("n_cycles: [5, 20, 100]", "n_cycles: [3]")
    path.write_text(text.replace("descents: 5000", "descents: 5").replace("trials: 100", "trials: 2"))
    for found in (0, 2):
        done = fatplan("simulate", path, "--cache", cache)
        assert done.returncode == 3, done.stderr
        failed = [line for line in done.stdout.splitlines() if "FAILED" in line]
        assert len(failed) == 2 and all("high/" in line and "closer" in line for line in failed)
        assert "2 of 4 reactions failed, and are left out of what follows:" in done.stdout
        assert len(list(cache.glob("*.h5"))) == 4 and done.stdout.count(" found, implausible;") == found
    left_out = "average_man cannot perform high (with arm or back): left out of this worker's conditions."
    for command in (["benchmark", "--dry-run"], ["benchmark"], ["report"]):
        done = fatplan(command[0], path, *command[1:], "--cache", cache, "--results", results)
        assert done.returncode == 0 and left_out in done.stderr, done.stderr
    assert left_out in (results / "paper/summary.txt").read_text()
    assert left_out.split(" (", maxsplit=1)[0] in (results / "paper/report.html").read_text()
    assert set((results / "paper/actions.csv").read_text().split("\n")[1].split(",")[-1].split(" ")) == {"0"}
    done = fatplan("view", path, "--cache", cache, "--save", tmp_path / "view.png")
    assert done.returncode == 0 and "average_man/high/back cannot be shown" in done.stderr, done.stderr
    message = refused(2, "view", path, "--cache", cache, "--reaction", "average_man/high/arm")
    assert "--reaction average_man/high/arm cannot be shown, because it cannot be performed: no admissible" in message


@pytest.mark.slow
def test_human_report_writes_the_page_or_says_what_to_run_first(cache_folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "human.md"
    done = fatplan("human", "report", PAPER, "--cache", cache_folder, "--output", page)
    assert done.returncode == 0 and "8 values outside their band or range" in done.stdout
    text = page.read_text()
    assert text.startswith("# The digital human against the literature") and text.count("**OUTSIDE**") == 8
    message = refused(2, "human", "report", PAPER, "--cache", tmp_path / "none", "--output", page)
    assert f"Run `fatplan simulate {PAPER} --cache {tmp_path / 'none'}` first" in message


def test_bad_experiment(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER.read_text().replace("exploration_constant: 0.1,", "exploration_constant: -1,"))
    for command in ("simulate", "benchmark", "report"):
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


@pytest.mark.slow
def test_regret_and_bound_are_told_and_kept(cache_folder: Path, tmp_path: Path) -> None:
    """Five cycles of an expert: the bound is the optimum. `fixed` is no policy that the paper ranks."""
    grid = ["--cycles", 5, "--conditions", "single_expert"]
    grid += [word for name in ("greedy", "alternating", "fixed") for word in ("--policies", name)]
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
    report = fatplan("report", PAPER, "--cache", cache_folder, "--results", tmp_path, *grid)
    assert report.returncode == 0, report.stderr
    # without the options they stay, as they belong to the same runs
    assert fatplan(*command[:-2]).stdout == done.stdout
    assert json.loads((folder / "manifest.json").read_text())["benchmark"]["sha256"] == files
    # with other settings they are removed, and it is said
    other = tmp_path / "other" / "paper.yaml"
    other.parent.mkdir()
    other.write_text(PAPER.read_text().replace("discount: 0.95", "discount: 0.9"))
    done = fatplan("benchmark", other, *command[2:-2])
    assert done.returncode == 0 and not (folder / "regret.csv").exists() and not (folder / "bounds.csv").exists()
    for file in ("regret.csv --regret", "bounds.csv --bound"):
        name, option = file.split()
        message = f"{folder / name}: was of an earlier run (different: discount) and is removed. `{option}` makes it"
        assert message in " ".join(done.stderr.split())


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


def test_missing_table_says_what_to_run(cache_folder: Path, tmp_path: Path) -> None:
    assert f"Run `fatplan benchmark {PAPER} --cache" in refused(
        2, "report", "--figures-only", PAPER, "--cache", cache_folder, "--results", tmp_path
    )

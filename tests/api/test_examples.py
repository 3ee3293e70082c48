"""Every example runs as its first lines say, in an empty folder."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

EXAMPLES = ROOT / "examples"
# A part of what each example prints; numbers are checked elsewhere.
OUTPUT = {
    "walk_a_worker": "average_man/low/back",
    "own_task": "Most tired:",
    "own_policy": "stubborn_10",
    "own_belief": "",
    "own_motion_task": "",
    "own_fatigue_law": "",
    "own_report_section": "",
    "train_agent": "learned",
    "tiger": "Mean return of 100 games by lookahead",
    "crying_baby": "exact value: -16.31",
    "rock_sample": "Mean return of 10 games of RockSample[7,8]",
    "light_dark": "Mean return of 20 games",
    "beside_a_robot": "cycle 6: ",
    "hidden_worker": "knows the truth",
}
# Run with arguments by the pages that show them.
SHOWN = {"simulated_recording": "docs/from-recordings.md"}


def test_every_example_is_tested() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == set(OUTPUT) | set(SHOWN)
    for name, page in SHOWN.items():
        assert f"$ python examples/{name}.py " in (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(OUTPUT))
def test_an_example_runs(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert OUTPUT[name] in done.stdout
    assert done.stderr == ""

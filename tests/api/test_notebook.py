"""A notebook's cells: run one after the other in a process whose main module is no file, and run once more."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

# What a kernel does, without one: docs/api.md names the real kernels that were tried.
KERNEL = """
import pathlib, sys
for name in sys.argv[1:]:
    exec(compile(pathlib.Path(name).read_text(), f"<{name}>", "exec"), vars(sys.modules["__main__"]))
"""
LOAD = """
import fatigue_planner as fp
experiment = fp.load("paper")
reactions = fp.simulate(experiment, CACHE)
scenario = fp.scenario(experiment, reactions)
assert fp.run(scenario, "greedy", 5).cycles["cost"].equals(fp.run(scenario, "greedy", 5).cycles["cost"])
"""
POLICY = """
from typing import Literal

class Always:
    def act(self, belief, rng):
        return CHOICE

@fp.register
class AlwaysSettings(fp.PolicySettings):
    kind: Literal["always"]
    def build(self):
        return self
    def act(self, belief, rng):
        return fp.decide(belief, "greedy")

assert fp.run(scenario, Always(), 2).cycles["action"].tolist() == [CHOICE, CHOICE]
assert type(fp.policy("always")) is AlwaysSettings
"""
PROCESSES = """
from fatigue_planner.core.executors.processes import LocalProcesses

def returns(choice):
    return fp.run(scenario, Always(), 2).cycles["action"][0], choice

assert sorted(LocalProcesses(2).run(returns, "ab")) == [(0, (CHOICE, "a")), (1, (CHOICE, "b"))]
"""
TASK_IN_A_CELL = """
from pathlib import Path
import yaml

content = yaml.safe_load(Path(PAPER).read_text())
content["preferences"]["arm"]["tasks"].append({"kind": "head_height", "weight": 1, "height_m": 1.5})
Path("mine.yaml").write_text(yaml.safe_dump(content))
try:
    fp.simulate(fp.load("mine.yaml"), CACHE)
    raise SystemExit("a text that is unknown cannot be part of a key")
except fp.FatplanError as error:
    assert "%%writefile" in str(error)
"""


@pytest.mark.slow
def test_cells_can_be_run_again(tmp_path: Path, cache_folder: Path) -> None:
    task = (ROOT / "examples/own_motion_task.py").read_text()
    cells = {
        "settings": f"CACHE, PAPER, CHOICE = {str(cache_folder)!r}, {str(ROOT / 'experiments/paper.yaml')!r}, 'low'",
        "load": LOAD, "policy": POLICY, "processes": PROCESSES, "choice": "CHOICE = 'high'",
        "task": task, "task_in_a_cell": TASK_IN_A_CELL,
    }  # fmt: skip
    for name, text in cells.items():
        (tmp_path / name).write_text(text)
    run = [*cells, "policy", "processes", "load"]
    done = subprocess.run(
        [sys.executable, "-c", KERNEL, *run], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and done.stderr == "", done.stderr

"""Memory does not grow with the length of a run but by its results: actions and returns of trials, no motions."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import PAPER, ROOT

from fatigue_planner.reactions.cache import ReactionCache

# What the parent may keep of a run of 100 cycles: its returns and actions, and their row in the tables.
BYTES_PER_TRIAL = 2500
MIB = 2**20

# Peak of the resident memory, of this process and of the largest of its workers, in bytes.
PEAKS = """
import json, resource
from pathlib import Path
peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
print(json.dumps([peak * 1024, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024]))
"""
BENCHMARK = """
import sys
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.tables import ACTIONS_FILE, TRIALS_FILE, publish_table, trial_table
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.build import load_cycle_profiles
from fatigue_planner.study.benchmark.selection import Selection, cells, selected

if __name__ == "__main__":
    _, paper, cache, out, trials = sys.argv
    experiment = load_experiment(Path(paper))
    grid = selected(experiment, Selection([100], ["single_novice"], ["random"], int(trials), None, None))
    own = cells(grid, load_cycle_profiles(experiment, Path(cache), "fatplan simulate"))
    results, _ = run_grid(own, Path(out), LocalProcesses(1), lambda job, n: None)
    publish_table(Path(out), trial_table(own, results), [TRIALS_FILE, ACTIONS_FILE])
"""
SIMULATE = """
import sys
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.motion.action import Position
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions.cache import ReactionCache

if __name__ == "__main__":
    _, paper, out, count = sys.argv
    experiment = load_experiment(Path(paper))
    high = experiment.actions["high"]
    actions = {}
    for number in range(int(count)):
        position = Position(x=0.5, y=-0.25, z=1.2 + number / 1000)
        goal = high.right_hand.model_copy(update={"position_m": position})
        actions[f"high{number}"] = high.model_copy(update={"right_hand": goal})
    brief = experiment.model_copy(
        update={
            "cycle": Cycle(reach_s=1.0, work_s=0.2, return_s=1.0), "actions": actions,
            "preferences": {"arm": experiment.preferences["arm"]},
            "accuracy": experiment.accuracy.model_copy(update={"hand_error_m": 0.05}),
        }
    )
    outcomes = ReactionCache(Path(out)).complete(reaction_requests(brief), LocalProcesses(1), lambda _: None)
    assert all(outcome.verdict != "failed" for outcome in outcomes)
"""


def peaks(program: str, folder: Path, *arguments: object) -> tuple[int, int]:
    """Peak memory of a process and its workers."""
    folder.mkdir(parents=True)
    (folder / "program.py").write_text("from pathlib import Path" + program + "".join(f"    {x}\n" for x in
                                       PEAKS.strip().splitlines()))  # fmt: skip
    command = [sys.executable, str(folder / "program.py"), *map(str, arguments)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout
    own, workers = json.loads(printed.splitlines()[-1])
    return own, workers


@pytest.mark.slow
def test_memory_is_flat_over_ten_thousand_trials(cache_folder: Path, tmp_path: Path) -> None:
    _, few, many = (  # the first compiles what is not compiled yet, which takes memory, too
        peaks(BENCHMARK, tmp_path / str(trials), PAPER, cache_folder, tmp_path / str(trials) / "out", trials)
        for trials in (5, 1000, 10_000)
    )
    print(f"parent {few[0] / MIB:.1f} -> {many[0] / MIB:.1f} MiB, worker {few[1] / MIB:.1f} -> {many[1] / MIB:.1f} MiB")
    assert many[1] < 1.02 * few[1]
    assert many[0] - few[0] < 9000 * BYTES_PER_TRIAL
    again = peaks(BENCHMARK, tmp_path / "again", PAPER, cache_folder, tmp_path / "10000" / "out", 10_000)
    assert again[0] - few[0] < 9000 * BYTES_PER_TRIAL  # when all is found, too


@pytest.mark.slow
def test_simulating_keeps_no_motions(tmp_path: Path) -> None:
    """A motion of these has 0.4 MiB; forty of them would be seen."""
    _, few, many = (peaks(SIMULATE, tmp_path / str(n), PAPER, tmp_path / str(n) / "cache", n) for n in (1, 4, 44))
    print(f"parent {few[0] / MIB:.1f} -> {many[0] / MIB:.1f} MiB, worker {few[1] / MIB:.1f} -> {many[1] / MIB:.1f} MiB")
    kept = sum(path.stat().st_size for path in ReactionCache(tmp_path / "44" / "cache").files())
    assert kept > 8 * MIB
    assert many[0] - few[0] < 4 * MIB and many[1] - few[1] < 8 * MIB

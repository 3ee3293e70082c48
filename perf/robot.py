"""How surely and how fast an arm's reach is known.

1,000 random poses of the UR5e on the ground: what `Cell.reach` does not reach is looked for by another solver, scipy's
trust region on Pinocchio's model, from 500 random starts each. Then the time per pose, reached and not.

    python perf/robot.py [POSES] [STARTS]
"""

import sys
import time
from pathlib import Path

import numpy as np

from fatigue_planner.robot.arm import load_arm
from fatigue_planner.robot.reach import Cell
from fatigue_planner.robot.settings import RobotBase, RobotSettings

sys.path += [str(Path(__file__).parents[1] / "tests" / "robot"), str(Path(__file__).parents[1] / "tests")]
from test_arm import found_by_another, random_targets


def main(poses: int, starts: int) -> None:
    cell = Cell(load_arm("ur5e"), RobotSettings(arm="ur5e", base_m=RobotBase(x=0.0)))
    base, rng = cell.settings.base_m.placement(), np.random.default_rng(7)
    targets = list(random_targets("ur5e", poses, seed=8))
    cell.reach(targets[0])  # compiles
    times_s: dict[bool, list[float]] = {True: [], False: []}
    missed, unreached = 0, 0
    for target in targets:
        began = time.process_time()
        found = cell.reach(target)
        times_s[found.reached].append(time.process_time() - began)
        if found.reached or "touch" in found.reason:
            continue
        unreached += 1
        missed += found_by_another(cell.arm, base, target, starts, rng)
    print(f"{poses} poses: {unreached} out of reach, of which another solver with {starts} starts reaches {missed}")
    for reached, times in times_s.items():
        print(f"{'reached' if reached else 'not reached'}: {1e3 * float(np.median(times)):.1f} ms of CPU per pose")


if __name__ == "__main__":
    main(*map(int, [*sys.argv[1:], "1000", "500"][:2]))

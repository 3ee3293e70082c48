"""How surely and how fast an arm's reach is known.

Random poses about each arm on the ground, until `Cell.reach` has not reached 1,000 of them: each is looked for by
another solver (tests/support/second_inverse.py) from 500 random starts. Missed is a pose for which that finds a posture
in which the arm touches nothing. Then the time per pose, reached and not.

    python perf/robot.py [UNREACHED] [STARTS]
"""

import sys
import time
from pathlib import Path

import numpy as np

from fatigue_planner.robot.arm import load_arm, shipped_arms
from fatigue_planner.robot.reach import Cell
from fatigue_planner.robot.settings import RobotBase, RobotSettings

sys.path += [str(Path(__file__).parents[1] / "tests" / folder) for folder in ("robot", "support", "")]
from test_arm import missed_by, random_targets


def main(wanted: int, starts: int) -> None:
    for name in shipped_arms():
        cell = Cell(load_arm(name), RobotSettings(arm=name, base_m=RobotBase(x=0.0)))
        rng = np.random.default_rng(7)
        times_s: dict[bool, list[float]] = {True: [], False: []}
        unreached, missed = [], 0
        for target in random_targets(name, 100 * wanted, seed=8):
            if not (times_s[True] or times_s[False]):
                cell.reach(target)  # compiles
            began = time.process_time()
            found = cell.reach(target)
            times_s[found.reached].append(time.process_time() - began)
            if not found.reached:
                unreached.append(found.reason)
                missed += missed_by(cell, name, target, starts, rng)
            if len(unreached) == wanted:
                break
        touching = sum("touch" in reason for reason in unreached)
        print(
            f"{name}: {sum(map(len, times_s.values()))} poses, {wanted} not reached ({touching} as the arm would touch "
            f"something), of which another solver with {starts} starts reaches {missed}"
        )
        for reached, times in times_s.items():
            median, most = 1e3 * np.quantile(times, (0.5, 0.99))
            print(
                f"  {'reached' if reached else 'not reached'}: {median:.1f} ms of CPU per pose, 99 % within {most:.1f}"
            )


if __name__ == "__main__":
    main(*map(int, [*sys.argv[1:], "1000", "500"][:2]))

"""How much of the cost comes from which joint."""

from collections.abc import Mapping

import numpy as np

from fatigue_planner.fatigue.parameters import JOINT_GROUPS
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import replay
from fatigue_planner.study.benchmark.trial import TrialResult

# The columns of a table of shares.
SHARES = ["point", "joint_group", "share"]


def cost_shares(cell: Cell, results: Mapping[int, TrialResult]) -> dict[str, float]:
    """By group of joints, its fraction of the discounted mean squared fatigue (Eq. 5) of a cell's runs; 0 for no cost.

    Every run is lived through again.
    """
    fatigue = np.array([replay(cell, trial, done.actions).fatigue for trial, done in sorted(results.items())])
    discount = cell.scenario.model.discount ** np.arange(cell.n_cycles)
    squared = np.einsum("t,rtj->j", discount, fatigue**2)
    total = squared.sum() or 1.0
    return {group: float(squared[entries].sum() / total) for group, entries in JOINT_GROUPS.items()}

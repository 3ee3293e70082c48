"""What planning is worth: roles of policies, savings against hand calculation, and the report's first sentences."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.planners.registry import policy
from fatigue_planner.study.benchmark.worth import Role, planning_worth, role_of, roles_of
from fatigue_planner.study.statistics.multiple_testing import Pair
from fatigue_planner.study.statistics.savings import savings

SETTINGS = StatisticsSettings(resamples=99)


def table_of(returns: dict[str, list[float]], condition: str = "c", same: bool = False) -> pd.DataFrame:
    rows = [(condition, 20, name, i, same, value) for name, values in returns.items() for i, value in enumerate(values)]
    return pd.DataFrame(
        rows, columns=["condition", "n_cycles", "policy", "trial", "deterministic", "discounted_return"]
    )


def test_a_saving_is_the_paired_difference_as_part_of_the_other_cost() -> None:
    first, second = [-1.0, -2.0, -3.0, -2.2], [-1.5, -2.4, -3.6, -2.1]
    (found,) = savings(table_of({"a": first, "b": second}), [Pair("c", 20, "a", "b")], SETTINGS, 1)
    difference, cost = np.array(first) - np.array(second), -np.mean(second)
    low, high = stats.t.interval(0.95, 3, difference.mean(), stats.sem(difference))
    assert found.share == pytest.approx(difference.mean() / cost)
    assert (found.low, found.high) == pytest.approx((low / cost, high / cost))
    turned = found.turned()
    assert (turned.share, turned.low, turned.high) == (-found.share, -found.high, -found.low)


def test_without_chance_a_saving_has_no_interval() -> None:
    (found,) = savings(table_of({"a": [-1.0], "b": [-1.25]}, same=True), [Pair("c", 20, "a", "b")], SETTINGS, 1)
    assert found.share == pytest.approx(0.2) and not found.low < found.high
    assert found.text() == "20.00 %"


@pytest.mark.parametrize(
    ("settings", "role"),
    [
        ({"kind": "random"}, None),
        ({"kind": "alternating"}, None),
        ({"kind": "greedy"}, Role.GREEDY),
        ({"kind": "greedy", "knows": "truth"}, None),
        ({"kind": "fixed"}, Role.FIXED),
        ({"kind": "periodic"}, Role.SCHEDULE),
        ({"kind": "periodic", "longest": 1}, Role.FIXED),
        ({"kind": "periodic", "sequence": ("a", "a")}, Role.FIXED),
        ({"kind": "periodic", "sequence": ("a", "b")}, Role.SCHEDULE),
        ({"kind": "robust_periodic"}, Role.SCHEDULE),
        ({"kind": "robust_periodic", "longest": 1}, Role.FIXED),
        ({"kind": "threshold", "fatigue_threshold": 0.2}, Role.REACTIVE),
        ({"kind": "lookahead", "depth": 1}, Role.PLANNING),
        ({"kind": "lookahead", "depth": 1, "knows": "truth"}, None),
        ({"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 5}, Role.PLANNING),
    ],
)
def test_roles(settings: dict[str, Any], role: Role | None) -> None:
    assert role_of(policy(settings)) == role


def with_policies(paper: Experiment, **kinds: dict[str, Any]) -> Experiment:
    policies = {name: policy(settings) for name, settings in kinds.items()}
    grid = paper.benchmark.model_copy(update={"policies": policies})
    return paper.model_copy(update={"benchmark": grid, "statistics": SETTINGS})


def test_the_best_of_every_role_is_compared_with_the_best_planner(paper: Experiment) -> None:
    experiment = with_policies(
        paper,
        low={"kind": "fixed", "action": "low"},
        high={"kind": "fixed", "action": "high"},
        late={"kind": "threshold", "fatigue_threshold": 0.5},
        rotation={"kind": "periodic"},
        near={"kind": "lookahead", "depth": 1},
        far={"kind": "lookahead", "depth": 3},
    )
    returns = {
        "low": [-4.0, -4.2], "high": [-3.0, -3.2], "late": [-2.5, -2.4], "rotation": [-2.0, -2.2],
        "near": [-2.1, -2.2], "far": [-1.9, -2.2],
    }  # fmt: skip
    assert roles_of(experiment)[Role.FIXED] == ["low", "high"]
    (found,) = planning_worth(experiment, table_of(returns))
    assert found.planner == "far"
    assert {role: saving.over for role, saving in found.savings.items()} == {
        Role.FIXED: "high", Role.REACTIVE: "late", Role.SCHEDULE: "rotation",
    }  # fmt: skip
    assert found.savings[Role.FIXED].share == pytest.approx(1 - 2.05 / 3.1)
    assert found.savings[Role.SCHEDULE].share == pytest.approx(1 - 2.05 / 2.1)


def test_nothing_is_said_where_nothing_plans(paper: Experiment) -> None:
    experiment = with_policies(paper, greedy={"kind": "greedy"}, rotation={"kind": "periodic"})
    assert planning_worth(experiment, table_of({"greedy": [-1.0, -1.1], "rotation": [-1.0, -1.2]})) == []

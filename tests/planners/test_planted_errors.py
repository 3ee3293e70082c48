"""Do the checks detect errors? An error planted in each part of the planner must make one of them fail."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from plain_python import plant_in_belief, plant_in_search
from small_problems import NOISY, pomcp, relaxed, small_model, tree_of, two_workers
from tree_checks import (
    assert_bayes,
    assert_counts,
    assert_exact_everywhere,
    assert_maxuct_everywhere,
    assert_means_everywhere,
    assert_observations_as_likely,
)

from fatigue_planner.planners.pomcp import policy as pomcp_module
from fatigue_planner.planners.pomcp.backups import back_up_exact, back_up_max, back_up_mean
from fatigue_planner.planners.pomcp.buffers import SearchParameters

DESCENTS = 300


def check(backup: str, expertise: float = 25.0) -> None:
    """All that must hold for a tree from one state, seen without error."""
    belief = relaxed(small_model(expertise))
    tree = tree_of(belief, pomcp(DESCENTS, 0.02, backup))
    assert_counts(tree, DESCENTS)
    assert_observations_as_likely(tree, belief)
    if backup == "mean":
        assert_means_everywhere(tree, belief)
    elif backup == "max":
        assert_maxuct_everywhere(tree, belief)
    else:
        assert_exact_everywhere(tree, 0.95)


def untried_counts_as_zero(node: Any) -> float:
    return float(node.value.max())


def worst_value(node: Any) -> float:
    return float(node.value[node.tried > 0].min())


def mean_over_reaching(_nodes: Any, node: Any, action: int, target: float, _parameters: SearchParameters) -> float:
    node.value[action] += (target - node.value[action]) / node.visited
    return target


def forgetting(back_up: Any) -> Callable[..., float]:
    """A backup that forgets to discount what lies beyond the successor."""
    return lambda nodes, node, action, target, parameters: (
        back_up.py_func(nodes, node, action, target, parameters._replace(discount=1.0))
        / (1 if back_up is back_up_exact else parameters.discount)
    )


def note_twice(node: Any, _discounted_return: float) -> None:
    node.visited += 1


def trying_twice(back_up: Any) -> Callable[..., float]:
    def twice(nodes: Any, node: Any, action: int, *others: Any) -> float:
        passed_on = back_up.py_func(nodes, node, action, *others)
        node.tried[action] += node.tried[action] == 7
        return float(passed_on)

    return twice


@pytest.mark.parametrize("backup", ["mean", "max", "exact"])
def test_without_an_error_every_check_passes(monkeypatch: pytest.MonkeyPatch, backup: str) -> None:
    plant_in_search(monkeypatch)
    check(backup)


@pytest.mark.parametrize(
    ("backup", "parts"),
    [
        ("max", {"best_value": untried_counts_as_zero}),
        ("max", {"best_value": worst_value}),
        ("max", {"back_up": back_up_mean.py_func}),
        ("exact", {"best_value": untried_counts_as_zero}),
        ("exact", {"back_up": back_up_mean.py_func}),
        ("mean", {"back_up": mean_over_reaching}),
        ("mean", {"back_up": back_up_max.py_func}),
        ("max", {"back_up": forgetting(back_up_max)}),
        ("exact", {"back_up": forgetting(back_up_exact)}),
        ("mean", {"note_return": note_twice}),
        ("max", {"note_return": note_twice}),
        ("max", {"back_up": trying_twice(back_up_max)}),
        ("mean", {"back_up": trying_twice(back_up_mean)}),
    ],
)
def test_an_error_in_a_part_is_seen(monkeypatch: pytest.MonkeyPatch, backup: str, parts: dict[str, Any]) -> None:
    """Wrong values of untried actions, wrong backups, a forgotten discount, wrong counts (too large for the tables)."""
    plant_in_search(monkeypatch, **parts)
    with pytest.raises((AssertionError, IndexError)):
        check(backup)


@pytest.mark.parametrize("backup", ["mean", "max", "exact"])
def test_an_error_in_the_discount_is_seen(monkeypatch: pytest.MonkeyPatch, backup: str) -> None:
    """Too large by one part in a million."""
    plant_in_search(monkeypatch)
    wrong = lambda c, discount, *others: SearchParameters(c, discount * (1 + 1e-6), *others)  # noqa: E731
    monkeypatch.setattr(pomcp_module, "SearchParameters", wrong)
    with pytest.raises(AssertionError):
        check(backup)


def likelihood_of_another(arrays: Any, _s: np.ndarray, _a: int, preference: int, observation: int) -> float:
    return float(arrays.observation[preference, 1 - observation])


def test_an_error_in_the_likelihood_is_seen_in_beliefs(monkeypatch: pytest.MonkeyPatch) -> None:
    belief = two_workers(NOISY)
    plant_in_belief(monkeypatch)
    assert_bayes(belief, [1, 0], [0, 1])
    plant_in_belief(monkeypatch, observation_probability=likelihood_of_another)
    with pytest.raises(AssertionError):
        assert_bayes(belief, [1, 0], [0, 1])


def test_an_error_in_what_is_seen_is_noticed_in_searches() -> None:
    """A search with the wrong quality of recognition: it takes a few thousand descents to show."""
    belief = two_workers(NOISY)
    assert_observations_as_likely(tree_of(belief, pomcp(4000, 10.0)), belief)
    wrong = two_workers(NOISY - [[0.05, -0.05], [0.05, -0.05]])
    with pytest.raises(AssertionError):
        assert_observations_as_likely(tree_of(wrong, pomcp(4000, 10.0)), belief)

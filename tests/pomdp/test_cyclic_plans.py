"""The values of cyclic plans against the moments of the fatigue, and what they are used for."""

from itertools import pairwise, product

import numpy as np
import pytest
from small_problems import STARTS, lookahead, relaxed, small_model

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.pomdp import cyclic_plans
from fatigue_planner.pomdp.choices.offset import OffsetChoice
from fatigue_planner.pomdp.cyclic_plans import MAX_PLANS, best_plan_value, mean_maps, plan_values
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans as all_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers


def return_of(plan: tuple[int, ...], model: FatiguePomdp, fatigue: np.ndarray, cycles: int) -> float:
    """The plan's expected discounted return from the first two moments of every entry, cycle by cycle."""
    shape = (len(model.actions), len(model.outcomes), -1)
    gain, offset = (table.reshape(shape)[..., : model.active_entries.size] for table in model.arrays[:2])
    mean, square, total = fatigue.copy(), fatigue**2, 0.0
    chances = model.probabilities(model.state(fatigue), 0)  # which for novices are the same always
    for cycle in range(cycles):
        g, o = gain[plan[cycle % len(plan)]], offset[plan[cycle % len(plan)]]
        square = chances @ (g**2 * square + 2 * g * o * mean + o**2)
        mean = chances @ (g * mean + o)
        total -= model.discount**cycle * square.sum() / model.entries
    return total


def test_plans_are_all_sequences_that_repeat_no_shorter_one() -> None:
    plans = all_plans(2)
    assert len(plans) == len(set(plans)) == 2 + 2 + 6 + 12 + 30 + 54
    assert (0, 1, 0, 1) not in plans and (0, 0) not in plans and (1, 0) in plans
    assert all_plans(25) == [(a,) for a in range(25)] + [(a, b) for a, b in product(range(25), repeat=2) if a != b]
    assert len(all_plans(10_000)) == 10_000 > MAX_PLANS  # single actions are always plans


@pytest.mark.parametrize("choices", [None, OffsetChoice(kind="offset", offsets={"y": 0.7})])
def test_values_are_the_returns_of_the_plans(monkeypatch: pytest.MonkeyPatch, choices: OffsetChoice | None) -> None:
    monkeypatch.setattr(cyclic_plans, "undominated", lambda values, *_: values)
    model = small_model(0.0, choices=choices)
    values = model.bound_arrays
    for index, plan in enumerate(all_plans(2)):
        for fatigue in STARTS:
            padded = np.pad(fatigue, (0, values.square.shape[2] - fatigue.size))
            value = (
                values.constant[0, index]
                + ((values.square[0, index] * padded + values.linear[0, index]) * padded).sum()
            )
            assert value == pytest.approx(return_of(plan, model, fatigue, 700), rel=1e-12)


def test_leaving_out_dominated_plans_changes_no_value(monkeypatch: pytest.MonkeyPatch) -> None:
    few = small_model(0.0).bound_arrays
    monkeypatch.setattr(cyclic_plans, "undominated", lambda values, *_: values)
    every = small_model(0.0).bound_arrays
    assert few.constant.size < every.constant.size == len(all_plans(2))
    rng, width = np.random.default_rng(5), every.square.shape[2]
    for fatigue in [*rng.uniform(0, 1, (300, 3)), np.zeros(3), np.ones(3)]:
        state = np.append(np.pad(fatigue, (0, width - 3)), 0.0)
        assert best_plan_value(few, state) == best_plan_value(every, state)


def test_every_worker_has_his_own_plans() -> None:
    workers = Workers(np.array([1.0, 2.0]), np.array([1.0, 0.5]), np.zeros(2))
    both = small_model(0.0).for_workers(workers)
    for number in (0, 1):
        alone = small_model(0.0).for_workers(workers.pick(np.array([number])))
        for fatigue in STARTS:
            expected = best_plan_value(alone.bound_arrays, alone.state(fatigue))
            assert best_plan_value(both.bound_arrays, both.state(fatigue, number)) == pytest.approx(expected, rel=1e-12)


def test_lookahead_over_plans_rises_with_its_depth_and_stays_below_the_optimum() -> None:
    """Each more exact cycle can only improve a policy's value; with 0 as leaf value it is above every optimum."""
    belief = relaxed(small_model(0.0))
    values = [lookahead(belief, depth, leaf_value="bound").max() for depth in range(1, 7)]
    assert all(later >= earlier - 1e-15 for earlier, later in pairwise(values))
    assert values[-1] <= lookahead(belief, 6).max()


def test_undiscounted_plans_have_no_value() -> None:
    gain = np.full((1, 1, 1, 8), 0.5)
    with pytest.raises(ExperimentError, match="discount below 1"):
        plan_values(mean_maps(gain, gain, np.ones(8), np.zeros((1, 1))), 1.0, 8)

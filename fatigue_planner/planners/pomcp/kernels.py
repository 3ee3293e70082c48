"""The interchangeable parts of a search and the kernels made of them.

To add a part: write its functions (see the placeholders in `search.py`), and add a line to BACKUPS,
EXPLORATIONS or LEAF_VALUES and to the Literal above it.
"""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.jit import inlined, kernel, specialised
from fatigue_planner.planners.expectimax import always_may, best_return, expected_now, last_cycle, may, observe
from fatigue_planner.planners.plan_leaves import last_cycles_and_plans
from fatigue_planner.planners.pomcp.backups import (
    back_up_exact,
    back_up_max,
    back_up_mean,
    expect_nothing,
    expect_outcomes,
)
from fatigue_planner.planners.pomcp.leaf_values import greedy_rollout, no_value, problem_bound, random_rollout
from fatigue_planner.planners.pomcp.recall import (
    catch_up,
    catch_up_with_nothing,
    keep_nothing,
    keep_reward,
    recall_nothing,
    recall_sure,
    take_any_step,
)
from fatigue_planner.planners.pomcp.rollouts import (
    any_legal,
    bound_until_the_end,
    follow_policy,
    greediest_legal,
    of_the_problem,
)
from fatigue_planner.planners.pomcp.search import grow
from fatigue_planner.planners.pomcp.ucb import note_nothing, note_spread, select_fixed, select_scaled
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, react_surely
from fatigue_planner.pomdp.parts import legal_always, terminal_never
from fatigue_planner.pomdp.problem import Pomdp

BackupName = Literal["mean", "max", "exact"]
ExplorationName = Literal["fixed", "scaled"]
LeafValueName = Literal["none", "random_rollout", "greedy_rollout", "bound"]

# Descriptions of settings that several policies share.
LEAF_VALUE = (
    "What a path is worth beyond its last cycle: nothing (none), a rollout of random or greedy actions, or the proven "
    "bound of the cost to come (bound)."
)
ROLLOUT_CYCLES = "Length of a rollout in cycles."

Parts = dict[str, Any]


class Backup(NamedTuple):
    """How values go up the tree; `with_chances`: the tree keeps the probabilities of the observations."""

    expect: Callable[[Pomdp], Any]
    back_up: Any
    with_chances: bool


class Exploration(NamedTuple):
    """How actions are chosen on the way down; `with_spread`: the tree keeps the spread of the returns."""

    select_action: Any
    note_return: Any
    with_spread: bool


def _expect_outcomes(model: Pomdp) -> Any:
    return specialised(
        expect_outcomes, inlined, **_without_step(model), OBSERVATION_REVEALS_OUTCOME=model.observation_reveals_outcome
    )


def rules(model: Pomdp) -> Parts:
    """What is legal, and what ends the task."""
    dynamics = model.dynamics
    return {"is_legal": dynamics.is_legal or legal_always, "is_terminal": dynamics.is_terminal or terminal_never}


def _rollout(model: Pomdp, policy: Callable[..., Any], *names: str) -> Any:
    """A rollout of a policy that calls some of the problem's functions."""
    legal = {"is_legal": rules(model)["is_legal"]}
    own = {name: model.parts.get(name) or getattr(model.dynamics, name) for name in names}
    choose = specialised(policy, inlined, **own, **({} if policy is of_the_problem else legal))
    return specialised(follow_policy, inlined, **rules(model), step=model.parts["step"], choose=choose)


def _random_rollout(model: Pomdp) -> Any:
    if model.dynamics.rollout is not None:
        return _rollout(model, of_the_problem, "rollout")
    if model.dynamics.shapes_the_search:
        return _rollout(model, any_legal)
    return specialised(random_rollout, inlined, step=model.parts["step"])


def _greedy_rollout(model: Pomdp) -> Any:
    if model.dynamics.shapes_the_search:
        return _rollout(model, greediest_legal, "expected_reward")
    parts = {name: model.parts[name] for name in ("expected_reward", "step")}
    return specialised(greedy_rollout, inlined, **parts)


def _problem_bound(model: Pomdp) -> Any:
    if model.dynamics.bound is None:
        raise ExperimentError("leaf value bound: this problem has none; use none, random_rollout or greedy_rollout.")
    if model.dynamics.is_terminal is not None:
        ends = rules(model)["is_terminal"]
        return specialised(bound_until_the_end, inlined, bound=model.dynamics.bound, is_terminal=ends)
    return specialised(problem_bound, inlined, bound=model.dynamics.bound)


def _without_step(model: Pomdp) -> Parts:
    return {name: part for name, part in model.parts.items() if name != "step"}


BACKUPS: dict[BackupName, Backup] = {
    "mean": Backup(lambda _: expect_nothing, back_up_mean, False),
    "max": Backup(lambda _: expect_nothing, back_up_max, False),
    "exact": Backup(_expect_outcomes, back_up_exact, True),
}
EXPLORATIONS: dict[ExplorationName, Exploration] = {
    "fixed": Exploration(select_fixed, note_nothing, False),
    "scaled": Exploration(select_scaled, note_spread, True),
}
LEAF_VALUES: dict[LeafValueName, Callable[[Pomdp], Any]] = {
    "none": lambda _: no_value,
    "random_rollout": _random_rollout,
    "greedy_rollout": _greedy_rollout,
    "bound": _problem_bound,
}


def bound_arrays_for(model: Pomdp, leaf_value: LeafValueName) -> Any:
    """What the leaf value reads of the problem besides its arrays: 0 for nothing."""
    return model.bound_arrays if leaf_value == "bound" else 0


def keeps_rewards(model: Pomdp) -> bool:
    """Whether nodes keep rewards, as a step that was taken once need not be taken again (`recall`)."""
    return isinstance(model, FatiguePomdp) and model.is_experts and model.observation_reveals_outcome


def steps_of(model: Pomdp) -> Parts:
    """The parts of a search that take steps."""
    if keeps_rewards(model):
        return {"recall": recall_sure, "catch_up": catch_up, "take_step": react_surely, "keep": keep_reward}
    take_step = specialised(take_any_step, inlined, step=model.parts["step"])
    return {
        "recall": recall_nothing, "catch_up": catch_up_with_nothing, "take_step": take_step, "keep": keep_nothing,
    }  # fmt: skip


def search_kernel(model: Pomdp, backup: BackupName, exploration: ExplorationName, leaf_value: LeafValueName) -> Any:
    """`search.grow` for a problem and these parts, compiled."""
    backup_parts, exploration_parts = BACKUPS[backup], EXPLORATIONS[exploration]
    return specialised(
        grow,
        kernel,
        **steps_of(model),
        select_action=exploration_parts.select_action,
        note_return=exploration_parts.note_return,
        expect=backup_parts.expect(model),
        back_up=backup_parts.back_up,
        leaf_value=LEAF_VALUES[leaf_value](model),
    )


def lookahead_kernel(model: Pomdp, leaf_value: LeafValueName) -> Any:
    """`expectimax.best_return` for a problem and a leaf value, compiled."""
    parts = _without_step(model)
    constants = {
        "OBSERVATION_REVEALS_OUTCOME": model.observation_reveals_outcome,
        "N_OBSERVATIONS": len(model.observations),
    }
    reveals = {"OBSERVATION_REVEALS_OUTCOME": model.observation_reveals_outcome}
    shared = {
        "observe": specialised(observe, inlined, **parts, **reveals),
        "may": specialised(may, inlined, **rules(model)) if model.dynamics.is_legal else always_may,
    }
    if values_whole_beliefs(model, leaf_value):
        end: Any = last_cycles_and_plans
    else:
        end = specialised(
            last_cycle,
            inlined,
            **parts,
            **constants,
            LEAVES=leaf_value != "none",
            expected_now=specialised(expected_now, inlined, expected_reward=parts["expected_reward"]),
            **shared,
            leaf_value=LEAF_VALUES[leaf_value](model),
        )
    return specialised(best_return, kernel, **parts, **constants, **shared, last_cycles=end)


def values_whole_beliefs(model: Pomdp, leaf_value: LeafValueName) -> bool:
    """Whether the leaves of a lookahead are beliefs with one cyclic plan each (`plan_leaves`), and not states."""
    return leaf_value == "bound" and isinstance(model, FatiguePomdp)

"""What a command asks of an experiment's grid, and the cells that result."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

import numpy as np

from fatigue_planner.core.errors import ExperimentError, SelectionError, listed
from fatigue_planner.core.files import DIGEST_LENGTH, digest_of
from fatigue_planner.experiment.build import scenario
from fatigue_planner.experiment.schema import Experiment, too_few_descents
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.planners.lookahead import ReferenceSettings, reference_for
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.reaction import ReactionName
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.effort import Lookahead, Search, check_effort

T = TypeVar("T")

MAX_SUFFIX_LENGTH = 120  # file systems end at 255


@dataclass(frozen=True)
class Selection:
    """What the options ask of the grid; None, or an empty list, leaves it as it is in the file."""

    cycles: Sequence[int] | None = None
    conditions: Sequence[str] | None = None
    policies: Sequence[str] | None = None
    trials: int | None = None
    descents: int | None = None
    seed: int | None = None

    def asked(self) -> dict[str, list[str]]:
        """What is asked for, by the name of its option; of a list every item once, in order."""
        found = {}
        for name, value in asdict(self).items():
            if isinstance(value, int):
                found[name] = [str(value)]
            elif value:
                found[name] = sorted(set(map(str, value)))
        return found

    def suffix(self) -> str:
        """How a changed grid's results folder differs in name, e.g. `_cycles-100_trials-3`."""
        suffix = "".join(f"_{name}-{'+'.join(values)}" for name, values in self.asked().items())
        return suffix if len(suffix) <= MAX_SUFFIX_LENGTH else f"_selection-{digest_of(suffix)[:DIGEST_LENGTH]}"


def choose(what: str, available: Sequence[T], wanted: Sequence[T] | None) -> list[T]:
    """The wanted items in the order of `available`; all, if nothing is wanted in particular.

    Raises SelectionError naming what is not available.
    """
    if not wanted:
        return list(available)
    unknown = [item for item in wanted if item not in available]
    if unknown:
        named, known = ", ".join(map(str, unknown)), ", ".join(map(str, available))
        raise SelectionError(f"--{what} {named}: not in the experiment; available: {known}.")
    return [item for item in available if item in wanted]


def selected(experiment: Experiment, wanted: Selection) -> Experiment:
    """The experiment with the grid that is asked for, and the figures of its conditions.

    Raises SelectionError for unknown names, and for fewer descents than actions.
    """
    grid = experiment.benchmark
    changes: dict[str, Any] = {
        "n_cycles": tuple(choose("cycles", grid.n_cycles, wanted.cycles)),
        "conditions": {
            name: grid.conditions[name] for name in choose("conditions", list(grid.conditions), wanted.conditions)
        },
        "policies": {
            name: _with_descents(grid.policies[name], wanted.descents, len(experiment.actions))
            for name in choose("policies", list(grid.policies), wanted.policies)
        },
        "trials": wanted.trials or grid.trials,
        "seed": grid.seed if wanted.seed is None else wanted.seed,
    }
    kept = {
        name: tuple(condition for condition in conditions if condition in changes["conditions"])
        for name, conditions in experiment.figures.items()
    }
    figures = {name: conditions for name, conditions in kept.items() if conditions}
    return experiment.model_copy(update={"benchmark": grid.model_copy(update=changes), "figures": figures})


def _with_descents(policy: PolicySettings, descents: int | None, n_actions: int) -> PolicySettings:
    if descents is None or not isinstance(policy, PomcpSettings):
        return policy
    if descents < n_actions:
        raise SelectionError(f"--descents {descents}: {too_few_descents(n_actions)}.")
    return policy.model_copy(update={"descents": descents, "seconds": None})


def cells(experiment: Experiment, profiles: Mapping[ReactionName, CycleProfile]) -> list[Cell]:
    """The cells of the experiment's grid.

    Raises ExperimentError for a decision that may take longer than the file allows, and for a policy that names an
    action which a condition's worker cannot perform.
    """
    grid = experiment.benchmark
    scenarios = {name: scenario(experiment, profiles, condition) for name, condition in grid.conditions.items()}
    planning = {name: policy for name, policy in grid.policies.items() if isinstance(policy, Lookahead | Search)}
    beliefs = [_initial_belief(scenario_of) for scenario_of in scenarios.values() if planning]
    for name, policy in grid.policies.items():
        _check_actions(name, policy, scenarios)
        for belief in beliefs if name in planning else ():
            check_effort(f"benchmark.policies.{name}", planning[name], belief, grid.max_decision_s)
    return [
        Cell(condition, n_cycles, policy, settings, scenarios[condition], grid.seed, grid.trials)
        for condition in grid.conditions
        for n_cycles in grid.n_cycles
        for policy, settings in grid.policies.items()
    ]


def _check_actions(name: str, policy: PolicySettings, scenarios: Mapping[str, Scenario]) -> None:
    for key, actions in policy.actions_named().items():
        for condition, scenario_of in scenarios.items():
            if missing := [action for action in dict.fromkeys(actions) if action not in scenario_of.model.actions]:
                raise ExperimentError(
                    f"benchmark.policies.{name}.{key}: {listed(missing)}: the worker of {condition} cannot perform it; "
                    f"choose among {listed(scenario_of.model.actions)}, or leave the condition out (--conditions)."
                )


def references(experiment: Experiment, grid: Sequence[Cell]) -> dict[str, ReferenceSettings]:
    """What the decisions in each condition of a grid are measured against.

    Raises ExperimentError for a reference that may take longer than the file allows.
    """
    chosen = experiment.benchmark.reference
    found = {}
    for name, scenario_of in {cell.condition: cell.scenario for cell in grid}.items():
        belief = _initial_belief(scenario_of)
        if chosen is not None:
            check_effort("benchmark.reference", chosen, belief, experiment.benchmark.max_decision_s)
        found[name] = chosen or reference_for(belief)
    return found


def _initial_belief(scenario_of: Scenario) -> Belief:
    return scenario_of.initial_belief("prior", scenario_of.model, np.random.default_rng(0))

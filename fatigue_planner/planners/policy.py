"""The base classes of a policy, which chooses the robot's action from a belief, and of the settings that build it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import listed
from fatigue_planner.core.plugins import Registry, plugin_sources
from fatigue_planner.core.settings import Settings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.problem import Pomdp
from fatigue_planner.pomdp.scenario import Knowledge

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Decision:
    """The action chosen, and what is known about the choice.

    action: index of the chosen action
    values (A,): estimated return of every action, NaN where unknown
    visits (A,): how often the search tried each action (0 without a search)
    depth: cycles looked ahead
    duration_s: wall-clock time of the decision
    reason: why this action was chosen, in words

    >>> belief = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))
    >>> decision = fp.policy("greedy").build().act(belief, np.random.default_rng(0))
    >>> isinstance(decision, fp.Decision), scenario.model.actions[decision.action] in ("high", "low")
    (True, True)
    """

    action: int
    values: Vector
    visits: Counts
    depth: int
    duration_s: float
    reason: str


class Rule(NamedTuple):
    """How a policy decides from nothing but what it believes, as compiled code.

    choose(problem): the function (arrays, memory, states, weights, rng) -> action, which draws nothing from `rng`
    memory(belief): what it works with, for beliefs of at most as many states
    most_states: beliefs of more states are decided otherwise
    """

    choose: Callable[[Pomdp], Any]
    memory: Callable[[Belief], Any]
    most_states: float = np.inf


class Policy(ABC):
    """A policy for one run of the task; a new one is made for every run.

    >>> class Always(fp.Policy):
    ...     def act(self, belief, rng):
    ...         return fp.Decision(1, np.zeros(2), np.zeros(2, int), 0, 0.0, "always the second")
    >>> fp.run(scenario, Always(), n_cycles=2).cycles["action"].tolist()
    ['low', 'low']
    """

    # Whether the policy's own random draws can change its choices in a problem without chance.
    draws_at_random = False

    @abstractmethod
    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action for this cycle. Called once per cycle, in order."""

    def observe(self, action: int, observation: int) -> None:  # noqa: B027 - most policies need not know
        """Called after every cycle with what was done and seen; the next belief contains it, too."""

    def ahead(self, belief: Belief, n_cycles: int, rng: np.random.Generator) -> Counts:
        """The actions of the coming cycles (n_cycles,), for a policy whose choices nothing that is observed can change.

        Where a class has this, or a `rule`, beside its `act`, the benchmark runs many trials at once, with the same
        results.
        """
        raise NotImplementedError

    def rule(self) -> Rule | None:
        """The policy as compiled code; None if it does not decide from its belief alone, or draws."""
        return None


class PolicySettings(Settings):
    """What an experiment file says about a policy; every kind has `kind: Literal["its name"]` and keys of its own.

    knows: what the policy knows about a worker with hidden parameters. prior: their distribution; average: it takes the
        average worker for the true one; truth: it knows the worker.

    >>> isinstance(experiment.benchmark.policies["greedy"], fp.PolicySettings)
    True
    """

    kind: str
    knows: Knowledge = Field(
        default="prior",
        description="What the policy knows about a worker with hidden parameters: their distribution (prior), the "
        "average worker, taken for the true one (average), or the true parameters (truth).",
    )

    def actions_named(self) -> dict[str, tuple[str, ...]]:
        """By key of these settings, the actions that it names: the experiment must have them."""
        return {}

    def faults(self) -> list[str]:
        """What is wrong with them that their form does not show, each with its key."""
        return []

    def sources(self) -> dict[str, str]:
        """What decides besides them and the package: digests of a plug-in's sources, and of data, by their names.

        Raises PluginError for what is in no file.
        """
        return plugin_sources(type(self))

    def plans_endlessly(self) -> bool:
        """Whether it weighs tasks without end, which have no cost without a discount below 1."""
        return False

    @abstractmethod
    def build(self) -> Policy:
        """A fresh policy for one run."""


POLICIES = Registry("policy", PolicySettings)  # type: ignore[type-abstract]


def action_number(chosen: object, names: Sequence[str]) -> int | None:
    """The number of an action that is given by name or number, None for what is no action."""
    if isinstance(chosen, str):
        return names.index(chosen) if chosen in names else None
    number = chosen.item() if isinstance(chosen, np.generic | np.ndarray) and chosen.ndim == 0 else chosen
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(names):
        return None
    return number


def expected_action(names: Sequence[str]) -> str:
    """What an action must be, as a message says it."""
    return f"{listed(names)}, or a number from 0 to {len(names) - 1}"


def plain_decision(action: int, values: Vector, depth: int, duration_s: float, reason: str, belief: Belief) -> Decision:
    """A decision without a search tree."""
    visits = np.zeros(values.size, np.int64)
    return Decision(action, values, visits, depth, duration_s, explained(reason, belief))


def explained(reason: str, belief: Belief) -> str:
    """The reason, and a note if the last observation was impossible under the model."""
    if belief.surprised:
        return f"{reason}; the last observation was impossible under the model, so the belief was widened"
    return reason

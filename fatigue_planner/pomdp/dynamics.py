"""The functions of a problem: three that every problem has, and more that say what is legal, what ends, what helps."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from fatigue_planner.core.jit import inlined, specialised
from fatigue_planner.pomdp import parts
from fatigue_planner.pomdp.told import checked

# The functions of a problem and what they are called with.
ARGUMENTS = {
    "outcome_probabilities": ("arrays", "state", "action", "probabilities"),
    "advance": ("arrays", "state", "action", "outcome"),
    "observation_probability": ("arrays", "state", "action", "outcome", "observation"),
    "step": ("arrays", "state", "action", "scratch", "rng"),
    "expected_reward": ("arrays", "state", "action", "probabilities", "moved"),
    "bound": ("bound_arrays", "state"),
    "is_legal": ("arrays", "state", "action"),
    "is_terminal": ("arrays", "state"),
    "draw_observation": ("arrays", "state", "action", "outcome", "observation", "rng"),
    "prior": ("arrays", "state", "action"),
    "rollout": ("arrays", "state", "rng"),
}


@dataclass(frozen=True)
class Dynamics:
    """The compiled functions of a problem. `arrays` is the problem's NamedTuple of arrays and numbers.

    outcome_probabilities(arrays, state, action, probabilities)
        fills `probabilities` (K,) with P(outcome | state, action)
    advance(arrays, state, action, outcome) -> reward
        moves `state` in place
    observation_probability(arrays, state, action, outcome, observation) -> P(observation | ...)
        `state` is the one after the action; where observations are continuous, the density at `observation` (W,)

    Everything else is optional. What a problem is:

    is_legal(arrays, state, action) -> truth value
        whether the state permits the action; what it forbids is never tried
    is_terminal(arrays, state) -> truth value
        whether the task has ended in this state; whoever acts in it sees that it has
    draw_observation(arrays, state, action, outcome, observation, rng)
        makes observations continuous: fills `observation` (W,) with a draw from their density; `state` is the one
        after the action

    What helps a search:

    prior(arrays, state, action) -> (visits, value)
        what is known of an action before it is tried: that it is worth `value`, as if tried `visits` times (0: nothing;
        at most 1000)
    rollout(arrays, state, rng) -> action
        the policy of rollouts (leaf value `rollout`), which may know the state
    bound(bound_arrays, state) -> value
        the value of the state, preferably a bound (leaf value `bound`); `bound_arrays` are `arrays`, unless a subclass
        of Pomdp says otherwise
    step(arrays, state, action, scratch, rng) -> (observation, reward)
        moves `state` in place at random: a short cut for the first three; `scratch` is (K,)
    expected_reward(arrays, state, action, probabilities, moved) -> reward
        also a short cut: the mean over the outcomes, whose probabilities it fills in; `moved` (L,) is scratch

    >>> from tiger import PROBLEM  # examples/tiger.py
    >>> isinstance(PROBLEM.dynamics, fp.Dynamics)
    True
    """

    outcome_probabilities: Callable[..., Any]
    advance: Callable[..., Any]
    observation_probability: Callable[..., Any]
    step: Callable[..., Any] | None = None
    expected_reward: Callable[..., Any] | None = None
    bound: Callable[..., Any] | None = None
    is_legal: Callable[..., Any] | None = field(default=None, kw_only=True)
    is_terminal: Callable[..., Any] | None = field(default=None, kw_only=True)
    draw_observation: Callable[..., Any] | None = field(default=None, kw_only=True)
    prior: Callable[..., Any] | None = field(default=None, kw_only=True)
    rollout: Callable[..., Any] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Raise ProblemError for a function that takes other arguments; one that is not compiled yet will be."""
        for name, arguments in ARGUMENTS.items():
            if getattr(self, name) is not None:
                object.__setattr__(self, name, checked(name, getattr(self, name), arguments))

    def functions(self) -> dict[str, Callable[..., Any] | None]:
        """The functions by name."""
        return {name: getattr(self, name) for name in ARGUMENTS}

    @property
    def shapes_the_search(self) -> bool:
        """Whether it has functions that only a search with a sparse tree knows (planners/pomcp/sparse)."""
        return any((self.is_legal, self.is_terminal, self.draw_observation, self.prior, self.rollout))

    def parts(self, n_observations: int) -> dict[str, Any]:
        """The names under which templates call these functions (see `jit.specialised`)."""
        basic = {
            "outcome_probabilities": self.outcome_probabilities,
            "advance": self.advance,
            "observation_probability": self.observation_probability,
        }
        if self.draw_observation is not None:
            unseen = {name: basic[name] for name in ("outcome_probabilities", "advance")}
            step = specialised(parts.sample_step_unseen, inlined, **unseen)
        else:
            whole = {**basic, "N_OBSERVATIONS": n_observations}
            step = self.step or specialised(parts.sample_step_from_parts, inlined, **whole)
        mean = self.expected_reward or specialised(parts.mean_over_outcomes, inlined, **basic)
        if self.is_terminal is None:
            return basic | {"step": step, "expected_reward": mean}
        ends = {"is_terminal": self.is_terminal}
        until_the_end: dict[str, Callable[..., Any]] = {
            "outcome_probabilities": parts.outcomes_until_the_end,
            "advance": parts.advance_until_the_end,
        }
        ending = {
            name: specialised(template, inlined, **ends, **{name: basic[name]})
            for name, template in until_the_end.items()
        }
        ending["expected_reward"] = specialised(parts.reward_until_the_end, inlined, **ends, expected_reward=mean)
        return basic | ending | {"step": step}

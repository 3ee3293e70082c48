"""The functions for scripts and notebooks: load, simulate, run; with names instead of indices.

`import fatigue_planner as fp` offers these functions and the classes they work with. The command line runs the same
code, so equal settings and seeds give equal numbers.
"""

import copy
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pandas as pd

from fatigue_planner.core.errors import MissingExtraError, SelectionError, listed
from fatigue_planner.core.executors.processes import LocalProcesses, available_cores
from fatigue_planner.core.random_streams import draw_random_numbers, random_stream
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.build import scenario as build_scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, action_number, plain_decision
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Knowledge, Scenario
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.trial import Episode, decided_cycles

if TYPE_CHECKING:
    from fatigue_planner.study.environments.environment import Environment
    from fatigue_planner.study.environments.vector import VectorEnvironment


class Actor(Protocol):
    """Your own policy: any object with this method, such as a `Policy`.

    >>> class Low:
    ...     def act(self, belief, rng):
    ...         return "low"
    >>> fp.decide(scenario, Low()).action
    'low'
    """

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision | str | int:
        """The action for this cycle: its name, its index, or a whole `Decision`."""


@dataclass(frozen=True)
class NamedDecision:
    """A decision, with names instead of indices.

    action: the action chosen. values, visits: by action, its estimated return (NaN where unknown) and how often a
    search tried it. depth: cycles looked ahead. duration_s: wall-clock seconds. reason: why, in words.

    >>> fp.decide(scenario, "greedy").reason
    'best expected reward of one cycle'
    """

    action: str
    values: dict[str, float]
    visits: dict[str, int]
    depth: int
    duration_s: float
    reason: str


@dataclass(frozen=True)
class Run:
    """One run of a policy.

    discounted_return: sum over the cycles t of discount^t r_t, with r_t = -C (Eq. 5): the higher, the better.
    cycles: a row per cycle: action, reaction (the motion preference chosen), observed (what it was recognised as), cost
        and planning_time_s.
    fatigue: (n_cycles, 78) after every cycle, by entry: a degree of freedom and a direction (`elbow_flexion:positive`).

    >>> run = fp.run(scenario, "alternating", n_cycles=4)
    >>> run.cycles["action"].tolist()
    ['high', 'low', 'high', 'low']
    """

    discounted_return: float
    cycles: pd.DataFrame
    fatigue: pd.DataFrame


class Reactions(Mapping[str, Reaction]):
    """An experiment's postural reactions by name (worker/action/preference).

    failures: by name, why a motion could not be performed; such a reaction is not in the mapping.
    """

    def __init__(self, reactions: Mapping[str, Reaction], failures: Mapping[str, str]) -> None:
        self._reactions, self.failures = dict(reactions), dict(failures)

    def __getitem__(self, name: str) -> Reaction:
        """The reaction with this name. Raises KeyError, with the reason if its motion failed."""
        if name in self.failures:
            raise KeyError(f"{name}: {self.failures[name]}")
        return self._reactions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._reactions)

    def __len__(self) -> int:
        return len(self._reactions)


def load(experiment: str | Path) -> Experiment:
    """The experiment of a file, or one that ships with fatplan by its name (`"paper"`), checked completely.

    Raises ExperimentError with every error in the file.

    >>> experiment = fp.load("paper")
    >>> list(experiment.actions)
    ['high', 'low']
    """
    return load_experiment(Path(experiment))


def simulate(experiment: Experiment, cache: str | Path = "cache", jobs: int | None = None) -> Reactions:
    """Every worker with every action and every motion preference, from the cache folder, or simulated and stored there.

    jobs: processes to use, by default one per core; the result does not depend on it. Motions that fail are in
    `failures`. Raises OutputFolderError if the folder cannot be written.

    >>> reactions = fp.simulate(experiment, cache)
    >>> bool(reactions["average_man/low/back"].torques_nm()["lumbar_flexion"].abs().max() > 50)
    True
    """
    store, requests = ReactionCache(Path(cache)), reaction_requests(experiment)
    outcomes = store.complete(requests, LocalProcesses(jobs or available_cores()), lambda _: None)
    failures = {str(outcome.name): outcome.failure for outcome in outcomes if outcome.verdict == "failed"}
    good = [request for request in requests if str(request.name) not in failures]
    loaded = store.stream(good, "fatplan simulate")
    performed = {str(reaction.name): reaction for reaction in loaded if isinstance(reaction, Reaction)}
    return Reactions(performed, failures)


def scenario(experiment: Experiment, reactions: Mapping[str, Reaction], condition: str | None = None) -> Scenario:
    """The POMDP of a condition of the experiment's benchmark, by default the first.

    Its actions are those that the worker can perform with every preference. Raises SelectionError for an unknown
    condition, FailedMotionError if its worker can perform no action.

    >>> scenario = fp.scenario(experiment, reactions, "single_novice")
    >>> scenario.model.actions, scenario.model.outcomes
    (('high', 'low'), ('arm', 'back'))
    """
    conditions = experiment.benchmark.conditions
    name = next(iter(conditions)) if condition is None else condition
    if name not in conditions:
        raise SelectionError(f"condition {name!r}: not in the experiment; available: {listed(conditions)}.")
    profiles = cycle_profiles(experiment, reactions.values())
    return replace(build_scenario(experiment, profiles, conditions[name]), name=name)


def decide(belief: Belief | Scenario, policy: "PolicyLike", rng: np.random.Generator | None = None) -> NamedDecision:
    """One decision, from a belief or at the start of a scenario.

    >>> decision = fp.decide(scenario, "greedy")
    >>> decision.action in {"high", "low"}, sorted(decision.values)
    (True, ['high', 'low'])
    """
    rng = np.random.default_rng(0) if rng is None else rng
    actor = _actor(policy)
    if isinstance(belief, Scenario):
        belief = belief.initial_belief(_knows(policy), belief.model, rng)
    return _named(actor.act(belief, rng), belief.model.actions)


def run(scenario: Scenario, policy: "PolicyLike", n_cycles: int = 100, seed: int = 0, trial: int = 0) -> Run:
    """Run the task for a number of cycles with a policy: settings, a kind, or an object of your own (see `Actor`).

    Runs of the same seed and trial meet the same worker, whatever the policy: they have common random numbers.

    >>> run = fp.run(scenario, "greedy", n_cycles=5)
    >>> len(run.cycles), run.discounted_return < 0
    (5, True)
    """
    return _run(scenario, policy, policy if isinstance(policy, str) else "policy", n_cycles, seed, trial)


def _run(scenario: Scenario, policy: "PolicyLike", name: str, n_cycles: int, seed: int, trial: int) -> Run:
    """See `run`; `name` chooses the random numbers of the policy's own."""
    random_numbers = draw_random_numbers(seed, scenario.name, n_cycles, trial)
    rng = random_stream(seed, "planner", scenario.name, n_cycles, trial, name)
    episode = Episode(scenario, random_numbers)
    model, belief = episode.model, scenario.initial_belief(_knows(policy), episode.model, rng)
    cycles = list(decided_cycles(episode, belief, _actor(policy), n_cycles, rng))
    columns = {
        "action": [model.actions[cycle.action] for cycle in cycles],
        "reaction": [model.outcomes[cycle.preference] for cycle in cycles],
        "observed": [model.observations[cycle.observation] for cycle in cycles],
        "cost": [-cycle.reward for cycle in cycles],
        "planning_time_s": [cycle.planning_time_s for cycle in cycles],
    }
    fatigue = pd.DataFrame([model.fatigue(cycle.state) for cycle in cycles], columns=list(ENTRIES))
    return Run(episode.discounted_return, pd.DataFrame(columns).rename_axis("cycle"), fatigue.rename_axis("cycle"))


def run_trials(
    scenario: Scenario, policies: Mapping[str, "PolicyLike"], n_cycles: int = 100, trials: int = 100, seed: int = 0
) -> pd.DataFrame:
    """Many runs of several policies, paired by common random numbers: a row per policy and trial.

    The columns are policy, trial, discounted_return, final_cost and peak_cost. With the names, settings and seed of a
    benchmark, policies have the returns in its trials.csv.

    >>> table = fp.run_trials(scenario, {"greedy": "greedy", "random": "random"}, n_cycles=5, trials=3)
    >>> table.groupby("policy")["discounted_return"].mean().idxmax()
    'greedy'
    """
    rows = []
    for name, chosen in policies.items():
        for trial in range(trials):
            result = _run(scenario, chosen, name, n_cycles, seed, trial)
            cost = result.cycles["cost"]
            rows.append((name, trial, result.discounted_return, cost.iloc[-1], cost.max()))
    return pd.DataFrame(rows, columns=["policy", "trial", "discounted_return", "final_cost", "peak_cost"])


def environment(problem: Scenario | Belief, n_cycles: int = 100) -> "Environment":
    """A Gymnasium environment of a scenario's task, or of a problem of your own from a belief.

    After `reset(seed=s)` its episodes are the trials 0, 1, ... of a benchmark with this seed. Raises MissingExtraError
    without Gymnasium, SelectionError for less than one cycle.

    >>> task = fp.environment(scenario, n_cycles=3)
    >>> observation, info = task.reset(seed=2023)
    >>> observation, reward, terminated, truncated, info = task.step("low")
    >>> reward < 0, scenario.model.observations[observation] in ("arm", "back"), info["fatigue"].shape
    (True, True, (78,))
    """
    _need_gymnasium()
    from fatigue_planner.study.environments.environment import Environment  # noqa: PLC0415 - optional

    return Environment(problem, n_cycles)


def vector_environment(problem: Scenario | Belief, count: int, n_cycles: int = 100) -> "VectorEnvironment":
    """So many environments side by side, stepped by compiled code: environment i is that of seed + i.

    Raises as `environment`.

    >>> tasks = fp.vector_environment(scenario, 64, n_cycles=3)
    >>> _ = tasks.reset(seed=2023)
    >>> observations, rewards, terminated, truncated, info = tasks.step(np.zeros(64, int))
    >>> rewards.shape, info["fatigue"].shape
    ((64,), (64, 78))
    """
    _need_gymnasium()
    from fatigue_planner.study.environments.vector import VectorEnvironment  # noqa: PLC0415 - optional

    return VectorEnvironment(problem, count, n_cycles)


def _need_gymnasium() -> None:
    if find_spec("gymnasium") is None:
        raise MissingExtraError("environments need Gymnasium: pip install 'fatigue-planner[gymnasium]'.")


PolicyLike = str | Mapping[str, Any] | PolicySettings | Actor


class _ActorPolicy(Policy):
    """A user's object as a policy; every run gets a copy, so that runs do not affect each other."""

    def __init__(self, actor: Actor) -> None:
        self._actor = copy.deepcopy(actor)

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act. Raises SelectionError if the choice is not an action."""
        begin = time.perf_counter()
        chosen = self._actor.act(belief, rng)
        if isinstance(chosen, Decision):
            return chosen
        actions = belief.model.actions
        index = action_number(chosen, actions)
        if index is None:
            raise SelectionError(f"{type(self._actor).__name__}.act: {chosen!r} is not one of {listed(actions)}.")
        unknown = np.full(len(actions), np.nan)
        return plain_decision(index, unknown, 0, time.perf_counter() - begin, "chosen by your policy", belief)

    def observe(self, action: int, observation: int) -> None:
        """See Policy.observe."""
        if hasattr(self._actor, "observe"):
            self._actor.observe(action, observation)


def _actor(chosen: PolicyLike) -> Policy:
    if isinstance(chosen, str | Mapping | PolicySettings):
        return policy(chosen).build()
    return _ActorPolicy(chosen)


def _knows(chosen: PolicyLike) -> Knowledge:
    return policy(chosen).knows if isinstance(chosen, str | Mapping | PolicySettings) else "prior"


def _named(decision: Decision, actions: tuple[str, ...]) -> NamedDecision:
    return NamedDecision(
        actions[decision.action],
        dict(zip(actions, decision.values.tolist(), strict=True)),
        dict(zip(actions, decision.visits.tolist(), strict=True)),
        decision.depth,
        decision.duration_s,
        decision.reason,
    )

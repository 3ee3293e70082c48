"""The content of an experiment file."""

import math
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StringConstraints, model_validator

from fatigue_planner.fatigue.parameters import FatigueSettings
from fatigue_planner.human.model import Tool, Worker
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.settings import Accuracy, Controller, Cycle
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.planners.settings import PolicySettings, ReferenceSettings
from fatigue_planner.pomdp.beliefs.registry import MOST_EXACT, BeliefSettings
from fatigue_planner.pomdp.hidden_worker import HiddenWorker, WorkerPrior
from fatigue_planner.settings import Settings
from fatigue_planner.statistics.settings import StatisticsSettings

LONGEST_NAME = 40
Name = Annotated[str, StringConstraints(pattern=rf"^[A-Za-z][A-Za-z0-9_.-]{{0,{LONGEST_NAME - 1}}}$")]
Level = Annotated[float, Field(ge=0, le=1)]

# Names of the files a results folder holds besides the figures of the returns.
RESERVED = (
    "trials", "actions", "comparison", "planning_times", "reactions", "courses", "places", "torques", "manifest",
    "summary", "regret", "bounds", "contrasts", "estimates", "fatigue", "cycle_maps", "actions_taken", "claims",
    "report",
)  # fmt: skip


class InitialState(Settings):
    """One state the worker may start in: fatigue by joint, the rest relaxed."""

    probability: float = Field(gt=0, le=1)
    fatigue: dict[str, Level] = Field(default_factory=dict)


class Condition(Settings):
    """What is varied between runs besides policy and length: the worker, what is known of the start, expertise.

    Where an experiment has one worker only, `worker` may be left out.
    """

    worker: Name | None = None
    initial_belief: Name
    # beta of Eq. 4; .inf is an expert. NaN fails ge=0. Left out where the hidden worker's is unknown.
    expertise: float | None = Field(default=None, ge=0, allow_inf_nan=True)
    # What the robot does not know of the worker: a name under hidden_workers; None: it knows him.
    hidden_worker: Name | None = None


class Benchmark(Settings):
    """The grid of runs (paper, section IV-E)."""

    conditions: dict[Name, Condition] = Field(min_length=1)
    policies: dict[Name, PolicySettings] = Field(min_length=1)
    n_cycles: tuple[Annotated[int, Field(ge=1, le=100_000)], ...] = Field(min_length=1)
    trials: int = Field(ge=1, le=1_000_000)
    seed: int = Field(ge=0)
    # What `--regret` measures decisions against; left out, the deepest affordable lookahead.
    reference: ReferenceSettings | None = None


class Experiment(Settings):
    """Everything that defines an experiment."""

    name: Name
    workers: dict[Name, Worker] = Field(min_length=1)
    tool: Tool
    cycle: Cycle
    actions: dict[Name, Action] = Field(min_length=1)
    preferences: dict[Name, Preference] = Field(min_length=1)
    controller: Controller
    accuracy: Accuracy
    fatigue: FatigueSettings
    discount: float = Field(ge=0, le=1)
    initial_beliefs: dict[Name, tuple[InitialState, ...]] = Field(min_length=1)
    hidden_workers: dict[Name, HiddenWorker] = Field(default_factory=dict)
    # P(o | u): preference -> recognised as -> probability; left out, a reaction is always recognised.
    recognition: dict[Name, dict[Name, Level]] | None = None
    # How beliefs are kept; left out, the exact set where it stays finite, else particles.
    belief: BeliefSettings | None = None
    benchmark: Benchmark
    statistics: StatisticsSettings
    # Figures of the returns: name -> conditions, one row of panels each.
    figures: dict[Name, tuple[Name, ...]]

    @model_validator(mode="after")
    def _check_names(self) -> Self:
        for name, states in self.initial_beliefs.items():
            total = sum(state.probability for state in states)
            if abs(total - 1) > 1e-9:
                raise ValueError(f"initial_beliefs.{name}: probabilities sum to {total:g}, not to 1")
        for name, condition in self.benchmark.conditions.items():
            if condition.worker is None and len(self.workers) > 1:
                raise ValueError(f"benchmark.conditions.{name}.worker: is missing; choose one of {self._workers()}")
            if condition.worker is not None and condition.worker not in self.workers:
                raise ValueError(
                    f"benchmark.conditions.{name}.worker: {condition.worker!r} is not one of {self._workers()}"
                )
            self._check_worker(f"benchmark.conditions.{name}", condition)
            if condition.initial_belief not in self.initial_beliefs:
                raise ValueError(
                    f"benchmark.conditions.{name}.initial_belief: {condition.initial_belief!r} is not one of "
                    f"{', '.join(self.initial_beliefs)}"
                )
        repeated = [n for n in self.benchmark.n_cycles if self.benchmark.n_cycles.count(n) > 1]
        if repeated:
            raise ValueError(f"benchmark.n_cycles: {repeated[0]} stands twice")
        self._check_families()
        for name, conditions in self.figures.items():
            if name.startswith(RESERVED):
                raise ValueError(f"figures.{name}: begins like another file's name; taken are {', '.join(RESERVED)}")
            unknown = [condition for condition in conditions if condition not in self.benchmark.conditions]
            if unknown or not conditions:
                raise ValueError(
                    f"figures.{name}: {', '.join(unknown) or 'no condition'}; known conditions: "
                    f"{', '.join(self.benchmark.conditions)}"
                )
        return self

    def _check_families(self) -> None:
        grid = self.benchmark
        for name, family in self.statistics.families.items():
            for key, known in (
                ("policies", grid.policies), ("against", grid.policies),
                ("conditions", grid.conditions), ("n_cycles", grid.n_cycles),
            ):  # fmt: skip
                unknown = [str(item) for item in getattr(family, key) or () if item not in known]
                if unknown:
                    raise ValueError(
                        f"statistics.families.{name}.{key}: {', '.join(unknown)}; known are "
                        f"{', '.join(map(str, known))}"
                    )

    def _check_worker(self, key: str, condition: Condition) -> None:
        hidden = HiddenWorker()
        if condition.hidden_worker is not None:
            if condition.hidden_worker not in self.hidden_workers:
                raise ValueError(
                    f"{key}.hidden_worker: {condition.hidden_worker!r} is not one of "
                    f"{', '.join(self.hidden_workers) or 'none: there are no hidden_workers'}"
                )
            hidden = self.hidden_workers[condition.hidden_worker]
        if condition.expertise is None and hidden.expertise is None:
            raise ValueError(f"{key}.expertise: is missing")
        if condition.expertise is not None and hidden.expertise is not None:
            raise ValueError(f"{key}.expertise: hidden_workers.{condition.hidden_worker} already gives one")

    @model_validator(mode="after")
    def _check_leaf_values(self) -> Self:
        named = {f"policies.{name}": policy for name, policy in self.benchmark.policies.items()}
        reference = self.benchmark.reference
        for name, planner in (named | ({"reference": reference} if reference else {})).items():
            if getattr(planner, "leaf_value", "none") == "bound" and self.discount == 1:
                raise ValueError(
                    f"benchmark.{name}.leaf_value: bound needs a discount below 1; use none or greedy_rollout"
                )
        certain = all(one.expertise == float("inf") for one in self.benchmark.conditions.values())
        if reference is not None and reference.leaf_value == "greedy_rollout" and not certain:
            raise ValueError(
                "benchmark.reference.leaf_value: greedy_rollout is noisy where choices are chance; use none or bound"
            )
        return self

    @model_validator(mode="after")
    def _check_recognition(self) -> Self:
        if self.recognition is None:
            return self
        if set(self.recognition) != set(self.preferences):
            raise ValueError(f"recognition: needs a line for each of {', '.join(self.preferences)}, and no other")
        for name, line in self.recognition.items():
            if abs(sum(line.values()) - 1) > 1e-9:
                raise ValueError(f"recognition.{name}: probabilities sum to {sum(line.values()):g}, not to 1")
        return self

    @model_validator(mode="after")
    def _check_belief(self) -> Self:
        if self.belief is not None and self.belief.kind == "exact":
            if self.recognition_errs():
                raise ValueError("belief.kind: exact needs reactions recognised without error; use particles")
            for name, hidden in self.hidden_workers.items():
                size = WorkerPrior(hidden, 0.0 if hidden.expertise is None else None).size
                if size > MOST_EXACT:
                    raise ValueError(
                        f"belief.kind: exact can hold {MOST_EXACT} workers, in hidden_workers.{name} there are "
                        f"{'infinitely many' if math.isinf(size) else size}; use particles"
                    )
        return self

    def recognition_errs(self) -> bool:
        """Whether a reaction may be taken for another one."""
        return any(line.get(name, 0.0) < 1 for name, line in (self.recognition or {}).items())

    def recognised(self) -> tuple[tuple[str, ...], NDArray[np.float64]]:
        """What a reaction can be recognised as, and the probabilities (preferences, observations)."""
        assert self.recognition is not None
        names = tuple(
            dict.fromkeys([*self.preferences, *(name for line in self.recognition.values() for name in line)])
        )
        rows = [[self.recognition[preference].get(name, 0.0) for name in names] for preference in self.preferences]
        return names, np.array(rows)

    def _workers(self) -> str:
        return ", ".join(self.workers)

    def worker_of(self, condition: Condition) -> str:
        """The name of a condition's worker."""
        return condition.worker or next(iter(self.workers))

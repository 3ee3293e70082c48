"""The content of an experiment file."""

from typing import Annotated, Self

from pydantic import Field, StringConstraints, model_validator

from fatigue_planner.fatigue.parameters import FatigueSettings
from fatigue_planner.human.model import Tool, Worker
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.settings import Accuracy, Controller, Cycle
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.planners.registry import PolicySettings
from fatigue_planner.settings import Settings

LONGEST_NAME = 40
Name = Annotated[str, StringConstraints(pattern=rf"^[A-Za-z][A-Za-z0-9_.-]{{0,{LONGEST_NAME - 1}}}$")]
Level = Annotated[float, Field(ge=0, le=1)]

# Names of the files a results folder holds besides the figures of the returns.
RESERVED = (
    "trials", "comparison", "planning_times", "reactions", "courses", "places", "torques", "manifest", "summary",
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
    # beta of Eq. 4; .inf is an expert. NaN fails ge=0.
    expertise: float = Field(ge=0, allow_inf_nan=True)


class Benchmark(Settings):
    """The grid of runs (paper, section IV-E)."""

    conditions: dict[Name, Condition] = Field(min_length=1)
    policies: dict[Name, PolicySettings] = Field(min_length=1)
    n_cycles: tuple[Annotated[int, Field(ge=1, le=100_000)], ...] = Field(min_length=1)
    trials: int = Field(ge=1, le=1_000_000)
    seed: int = Field(ge=0)


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
    benchmark: Benchmark
    significance_level: float = Field(gt=0, lt=1)
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
            if condition.initial_belief not in self.initial_beliefs:
                raise ValueError(
                    f"benchmark.conditions.{name}.initial_belief: {condition.initial_belief!r} is not one of "
                    f"{', '.join(self.initial_beliefs)}"
                )
        repeated = [n for n in self.benchmark.n_cycles if self.benchmark.n_cycles.count(n) > 1]
        if repeated:
            raise ValueError(f"benchmark.n_cycles: {repeated[0]} stands twice")
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

    def _workers(self) -> str:
        return ", ".join(self.workers)

    def worker_of(self, condition: Condition) -> str:
        """The name of a condition's worker."""
        return condition.worker or next(iter(self.workers))

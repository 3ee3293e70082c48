"""The content of an experiment file; the paper's values hold wherever a file says nothing else."""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StringConstraints, ValidationInfo, field_validator, model_validator

from fatigue_planner.core.errors import listed
from fatigue_planner.core.files import DIGEST_LENGTH
from fatigue_planner.core.settings import Name, Settings
from fatigue_planner.experiment.benchmark_settings import (
    RESTED,
    Benchmark,
    Condition,
    InitialState,
    Level,
    usual_conditions,
    usual_policies,
)
from fatigue_planner.experiment.cost_settings import CostSettings
from fatigue_planner.experiment.defaults import usual_beliefs, usual_figures, usual_preferences, usual_workers
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.fatigue.parameters import FatigueSettings
from fatigue_planner.human.anthropometry import HumanKind
from fatigue_planner.human.model import Tool, Worker
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.settings import MAX_TICKS, Accuracy, Controller, Cycle
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.beliefs.registry import MAX_EXACT, AnyBelief
from fatigue_planner.pomdp.choices.registry import AnyChoiceModel
from fatigue_planner.pomdp.cost import not_quadratic
from fatigue_planner.pomdp.hidden_worker import ROUNDING, HiddenWorker, WorkerPrior
from fatigue_planner.reactions.recorded import RecordingAccuracy
from fatigue_planner.robot.settings import RobotSettings

# What can be checked in half a second and named in one table.
MAX_ACTIONS = 10_000
MAX_REACTIONS = 100_000
MAX_CELLS = 100_000

# Preference, what it is recognised as, probability.
Recognition = dict[Name, dict[Name, Level]]

# The key of an import, as `fatplan record import` says it.
ImportKey = Annotated[str, StringConstraints(pattern=rf"^[0-9a-f]{{{DIGEST_LENGTH}}}$")]

# Names of the files a results folder holds besides the figures of the returns.
RESERVED = (
    "trials", "actions", "comparison", "planning_times", "reactions", "courses", "places", "torques", "manifest",
    "summary", "regret", "bounds", "contrasts", "estimates", "fatigue", "cycle_maps", "actions_taken", "claims",
    "report", "worth", "schedule",
)  # fmt: skip


class Experiment(Settings):
    """Everything that defines an experiment. Only its name and its actions have no default.

    >>> isinstance(experiment, fp.Experiment), list(experiment.preferences)
    (True, ['arm', 'back'])
    """

    name: Name = Field(description="Name of the experiment; results go to a folder of this name.")
    human: HumanKind = Field(
        default="natural",
        description="The digital human of all workers that name none: the paper's, to the letter of its text (paper), "
        "or one with passive joint moments, gaze and what else the paper leaves out (natural).",
    )
    workers: dict[Name, Worker] = Field(
        default_factory=usual_workers,
        min_length=1,
        max_length=50,
        description="Workers by name. Default: an average man of 1.75 m and 75 kg.",
    )
    tool: Tool = Field(default=Tool(mass_kg=0.0), description="Tool in the right hand. Default: none.")
    cycle: Cycle = Field(
        default=Cycle(), description="Phases of one cycle: reach, work and return, each with its duration in s."
    )
    actions: dict[Name, Action] = Field(
        min_length=1, max_length=MAX_ACTIONS, description="What the robot can choose between, by name."
    )
    robot: RobotSettings | None = Field(
        default=None,
        description="The robot that presents the object. Actions that it cannot present, or only too near to the "
        "worker, are left out of planning. Default: whatever is needed is presented.",
    )
    preferences: dict[Name, Preference] = Field(
        default_factory=usual_preferences,
        min_length=1,
        max_length=100,
        description="Ways in which the worker can react to an action, by name. Default: the paper's arm and back "
        "(section IV-C).",
    )
    controller: Controller = Field(default=Controller(), description="How the digital human moves.")
    recorded: dict[Name, dict[Name, dict[Name, ImportKey]]] = Field(
        default_factory=dict,
        max_length=50,
        description="Reactions that were recorded: worker, action, preference, and the key that `fatplan record "
        "import` says. All others are simulated.",
    )
    recording_accuracy: RecordingAccuracy = Field(
        default=RecordingAccuracy(),
        description="What a recorded motion must fulfil; one that misses a limit is not used.",
    )
    accuracy: Accuracy = Field(
        default=Accuracy(), description="What a simulated motion must fulfil; one that misses a limit is not used."
    )
    fatigue: FatigueSettings = Field(
        default=FatigueSettings(), description="How joints tire and recover (paper, Eq. 2 and section IV-B)."
    )
    cost: CostSettings = Field(
        default=CostSettings(),
        description="What fatigue costs, to the robot and to a worker of expertise. Default: Eq. 5.",
    )
    discount: float = Field(
        default=0.95,
        ge=0,
        le=1,
        description="Discount factor of a cycle, without unit; the paper's is 0.95 (section IV-D).",
    )
    initial_beliefs: dict[Name, Annotated[tuple[InitialState, ...], Field(max_length=1000)]] = Field(
        default_factory=usual_beliefs,
        min_length=1,
        max_length=1000,
        description="What the robot may know of the worker's fatigue at the start, by name: states with probabilities. "
        "Default: rested.",
    )
    hidden_workers: dict[Name, HiddenWorker] = Field(
        default_factory=dict,
        max_length=1000,
        description="What the robot may not know of a worker, by name: distributions of rates and expertise.",
    )
    choice_models: dict[Name, AnyChoiceModel] = Field(
        default_factory=dict,
        max_length=1000,
        description="By what a worker chooses preferences besides their cost, by name. Conditions that name none: by "
        "nothing (Eq. 4).",
    )
    recognition: Recognition | None = Field(
        default=None,
        description="Probabilities with which a reaction is recognised: preference, what it is recognised as, "
        "probability. Default: reactions are recognised without error.",
    )
    recognition_by_action: dict[Name, Recognition] = Field(
        default_factory=dict,
        max_length=MAX_ACTIONS,
        description="The same for single actions, whose reactions are told apart better or worse: action, preference, "
        "what it is recognised as, probability. Default: `recognition` for all.",
    )
    belief: AnyBelief | None = Field(
        default=None,
        description="How beliefs are kept. Default: the exact set where that is finite and small, else particles.",
    )
    benchmark: Benchmark = Field(
        default_factory=Benchmark,
        validate_default=True,
        description="The grid of runs: conditions, policies, lengths, trials.",
    )
    statistics: StatisticsSettings = Field(
        default=StatisticsSettings(), description="How policies are compared; fixed before results are seen."
    )
    figures: dict[Name, tuple[Name, ...]] = Field(
        default_factory=usual_figures,
        max_length=1000,
        description="Figures of the returns: name and conditions, one row of panels each. Default: all in one.",
    )

    @field_validator("workers", mode="before")
    @classmethod
    def _name_humans(cls, workers: Any, info: ValidationInfo) -> Any:
        """The human of the workers that name none."""
        if not isinstance(workers, dict) or "human" not in info.data:
            return workers
        human = info.data["human"]
        return {
            name: {**worker, "human": worker.get("human", human)} if isinstance(worker, dict) else worker
            for name, worker in workers.items()
        }

    @field_validator("benchmark", mode="before")
    @classmethod
    def _fill_in(cls, benchmark: Any, info: ValidationInfo) -> Any:
        """What is left out and follows from the rest: conditions from the names of workers and beliefs, policies."""
        if isinstance(benchmark, Benchmark):
            benchmark = {key: getattr(benchmark, key) for key in benchmark.model_fields_set}
        if not isinstance(benchmark, dict):
            return benchmark
        workers, beliefs = info.data.get("workers", {}), info.data.get("initial_beliefs", {})
        usual = {
            "conditions": usual_conditions(workers or ("",), beliefs or (RESTED,)),
            "policies": usual_policies(info.data.get("discount", 1.0)),
        }
        return usual | benchmark

    @model_validator(mode="after")
    def _check_across(self) -> Self:
        """What one part says of another; all faults at once, one per line."""
        faults = [
            *self._size_faults(), *self._initial_faults(), *self._condition_faults(), *self._budget_faults(),
            *self._named_action_faults(), *self._endless_faults(), *self._family_faults(), *self._figure_faults(),
            *self._leaf_value_faults(), *self._recognition_faults(), *self._belief_faults(), *self._choice_faults(),
            *self._recorded_faults(),
        ]  # fmt: skip
        if faults:
            raise ValueError("\n".join(faults))
        return self

    def _size_faults(self) -> Iterator[str]:
        reactions = len(self.workers) * len(self.actions) * len(self.preferences)
        if reactions > MAX_REACTIONS:
            yield f"actions: with all workers and preferences {reactions} reactions; at most {MAX_REACTIONS}"
        grid = self.benchmark
        if (size := len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)) > MAX_CELLS:
            yield f"benchmark: {size} combinations of conditions, n_cycles and policies; at most {MAX_CELLS}"
        yield from _repeated("benchmark.n_cycles", grid.n_cycles)
        if (ticks := self.cycle.duration_s / self.controller.time_step_s) > MAX_TICKS:
            yield (
                f"controller.time_step_s = {self.controller.time_step_s:g}: a cycle of {self.cycle.duration_s:g} s has "
                f"{ticks:.0f} of them; at most {MAX_TICKS}"
            )

    def _initial_faults(self) -> Iterator[str]:
        for name, states in self.initial_beliefs.items():
            yield from _not_one(f"initial_beliefs.{name}", [state.probability for state in states])

    def _condition_faults(self) -> Iterator[str]:
        for name, condition in self.benchmark.conditions.items():
            key = f"benchmark.conditions.{name}"
            if condition.worker is None and len(self.workers) > 1:
                yield f"{key}.worker: is missing; choose one of {listed(self.workers)}"
            if condition.worker is not None and condition.worker not in self.workers:
                yield f"{key}.worker: {condition.worker!r} is not one of {listed(self.workers)}"
            yield from self._hidden_faults(key, condition)
            if condition.initial_belief not in self.initial_beliefs:
                yield f"{key}.initial_belief: {condition.initial_belief!r} is not one of {listed(self.initial_beliefs)}"

    def _hidden_faults(self, key: str, condition: Condition) -> Iterator[str]:
        hidden = HiddenWorker()
        if condition.hidden_worker is not None:
            if condition.hidden_worker not in self.hidden_workers:
                known = listed(self.hidden_workers) or "none: there are no hidden_workers"
                yield f"{key}.hidden_worker: {condition.hidden_worker!r} is not one of {known}"
                return
            hidden = self.hidden_workers[condition.hidden_worker]
        if condition.expertise is None and hidden.expertise is None:
            yield f"{key}.expertise: is missing"
        if condition.expertise is not None and hidden.expertise is not None:
            yield f"{key}.expertise: hidden_workers.{condition.hidden_worker} already gives one"

    def _budget_faults(self) -> Iterator[str]:
        for name, policy in self.benchmark.policies.items():
            if not isinstance(policy, PomcpSettings) or policy.descents is None:
                continue
            if policy.descents < len(self.actions):
                key = f"benchmark.policies.{name}.descents"
                yield f"{key} = {policy.descents}: {too_few_descents(len(self.actions))}"

    def _named_action_faults(self) -> Iterator[str]:
        for name, policy in self.benchmark.policies.items():
            for key, actions in policy.actions_named().items():
                if unknown := [action for action in dict.fromkeys(actions) if action not in self.actions]:
                    known = listed(self.actions)
                    yield f"benchmark.policies.{name}.{key}: {listed(unknown)}: not among the actions {known}"

    def _endless_faults(self) -> Iterator[str]:
        for name, policy in self.benchmark.policies.items():
            if policy.plans_endlessly() and self.discount == 1:
                yield (
                    f"benchmark.policies.{name}: the best schedule is that of a task without end, which needs a "
                    "discount below 1; give a sequence"
                )

    def _family_faults(self) -> Iterator[str]:
        grid = self.benchmark
        known: dict[str, Collection[object]] = {
            "policies": grid.policies, "against": grid.policies, "conditions": grid.conditions,
            "n_cycles": grid.n_cycles,
        }  # fmt: skip
        named: list[tuple[str, Collection[object], Sequence[object]]] = [
            ("statistics.policies", grid.policies, self.statistics.policies or ())
        ]
        for name, family in self.statistics.families.items():
            named += [
                (f"statistics.families.{name}.{key}", names, getattr(family, key) or ()) for key, names in known.items()
            ]
        for path, names, items in named:
            if unknown := [item for item in items if item not in names]:
                yield f"{path}: {listed(unknown)}; known are {listed(names)}"
            yield from _repeated(path, items)

    def _figure_faults(self) -> Iterator[str]:
        known = self.benchmark.conditions
        for name, conditions in self.figures.items():
            if name.startswith(RESERVED):
                yield f"figures.{name}: begins like another file's name; taken are {', '.join(RESERVED)}"
            unknown = [condition for condition in conditions if condition not in known]
            if unknown or not conditions:
                yield f"figures.{name}: {listed(unknown) or 'no condition'}; known conditions: {listed(known)}"
            yield from _repeated(f"figures.{name}", conditions)

    def _leaf_value_faults(self) -> Iterator[str]:
        named = {f"policies.{name}": policy for name, policy in self.benchmark.policies.items()}
        reference = self.benchmark.reference
        for name, planner in (named | ({"reference": reference} if reference else {})).items():
            if getattr(planner, "leaf_value", "none") == "bound" and self.cost.fatigue != "mean_square":
                yield f"benchmark.{name}.leaf_value: bound {not_quadratic(self.cost.fatigue)}; or use none"
            if getattr(planner, "leaf_value", "none") == "bound" and self.discount == 1:
                yield f"benchmark.{name}.leaf_value: bound needs a discount below 1; use none or greedy_rollout"
        certain = all(condition.expertise == math.inf for condition in self.benchmark.conditions.values())
        if reference is not None and reference.leaf_value == "greedy_rollout" and not certain:
            yield "benchmark.reference.leaf_value: greedy_rollout is noisy where choices are chance; use none or bound"

    def _recognition_faults(self) -> Iterator[str]:
        if unknown := [action for action in self.recognition_by_action if action not in self.actions]:
            yield f"recognition_by_action: {listed(unknown)}: not among the actions {listed(self.actions)}"
        for key, matrix in self._recognitions():
            if set(matrix) != set(self.preferences):
                yield f"{key}: needs a line for each of {listed(self.preferences)}, and no other"
            for name, line in matrix.items():
                yield from _not_one(f"{key}.{name}", line.values())

    def _recognitions(self) -> Iterator[tuple[str, Recognition]]:
        """The matrices of recognition that are given, by their keys."""
        if self.recognition is not None:
            yield "recognition", self.recognition
        for action, matrix in self.recognition_by_action.items():
            yield f"recognition_by_action.{action}", matrix

    def _recorded_faults(self) -> Iterator[str]:
        parts: tuple[tuple[str, Collection[str]], ...] = (
            ("workers", self.workers), ("actions", self.actions), ("preferences", self.preferences),
        )  # fmt: skip
        names = (
            (worker, action, preference)
            for worker, actions in self.recorded.items()
            for action, preferences in actions.items()
            for preference in preferences
        )
        for name in names:
            for (kind, known), part in zip(parts, name, strict=True):
                if part not in known:
                    yield f"recorded.{'.'.join(name)}: {part!r} is not among the {kind} {listed(known)}"

    def _choice_faults(self) -> Iterator[str]:
        for name, choices in self.choice_models.items():
            for key, preferences in choices.preferences_named().items():
                if unknown := [preference for preference in preferences if preference not in self.preferences]:
                    known = listed(self.preferences)
                    yield f"choice_models.{name}.{key}: {listed(unknown)}: not among the preferences {known}"
        for name, condition in self.benchmark.conditions.items():
            if condition.choice_model is not None and condition.choice_model not in self.choice_models:
                known = listed(self.choice_models) or "none: there are no choice_models"
                yield f"benchmark.conditions.{name}.choice_model: {condition.choice_model!r} is not one of {known}"

    def _belief_faults(self) -> Iterator[str]:
        if self.belief is None or self.belief.kind != "exact":
            return
        if self.recognition_errs():
            yield "belief.kind: exact needs reactions recognised without error; use particles"
        for name, hidden in self.hidden_workers.items():
            size = WorkerPrior(hidden, 0.0 if hidden.expertise is None else None).size
            if size > MAX_EXACT:
                count = "infinitely many" if math.isinf(size) else size
                yield (
                    f"belief.kind: exact can hold {MAX_EXACT} workers, hidden_workers.{name} has {count}; use particles"
                )

    def recognition_errs(self) -> bool:
        """Whether a reaction may be taken for another one."""
        return any(line.get(name, 0.0) < 1 for _, matrix in self._recognitions() for name, line in matrix.items())

    def recognised(self, actions: Sequence[str]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
        """What a reaction can be recognised as, and the probabilities (1 or actions, preferences, observations)."""
        given = [name for _, matrix in self._recognitions() for line in matrix.values() for name in line]
        names = tuple(dict.fromkeys([*self.preferences, *given]))
        usual = self.recognition or {name: {name: 1.0} for name in self.preferences}
        matrices = [self.recognition_by_action.get(action, usual) for action in actions]
        if not self.recognition_by_action:
            matrices = [usual]
        return names, np.array(
            [[[matrix[u].get(name, 0.0) for name in names] for u in self.preferences] for matrix in matrices]
        )

    def worker_of(self, condition: Condition) -> str:
        """The name of a condition's worker."""
        return condition.worker or next(iter(self.workers))


def too_few_descents(n_actions: int) -> str:
    """What is wrong with a search that descends less often than there are actions: it never tries some of them."""
    return f"{n_actions} actions need at least {n_actions} descents, one for each"


def _repeated(key: str, items: Collection[object]) -> Iterator[str]:
    """A fault for the first item that is given twice."""
    seen: set[object] = set()
    for item in items:
        if item in seen:
            yield f"{key}: {item} is given twice"
            return
        seen.add(item)


def _not_one(key: str, probabilities: Collection[float]) -> Iterator[str]:
    """A fault unless the probabilities sum to 1."""
    if abs((total := sum(probabilities)) - 1) > ROUNDING:
        yield f"{key}: probabilities sum to {total:.12g}, not to 1"

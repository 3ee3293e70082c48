"""The cells of a benchmark."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fatigue_planner.core.files import digest_of_package
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.core.random_streams import draw_random_numbers, random_stream
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.benchmark.compiled_trials import can_be_compiled, compiled_trials
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.trial import TrialResult, run_trial

# What produces the numbers of a trial besides its settings and reactions: folders and modules of this package.
SOURCES = (
    "core/jit.py", "core/pcg64.py", "core/random_streams.py", "fatigue", "pomdp", "planners", "study/benchmark/cell.py",
    "study/benchmark/compiled_trials.py", "study/benchmark/trial.py",
)  # fmt: skip
# So many trials run together in compiled loops take less than a second.
COMPILED_TRIALS = 1000
NUMERICAL_LIBRARIES = ("numpy", "numba", "llvmlite", "scipy")


@dataclass(frozen=True)
class Cell(Job[TrialResult]):
    """One policy in one condition for one number of cycles."""

    condition: str
    n_cycles: int
    policy: str
    settings: PolicySettings
    scenario: Scenario
    seed: int
    trials: int

    result_type = TrialResult

    @property
    def name(self) -> str:
        """See Job.name."""
        return f"{self.condition}/{self.n_cycles}/{self.policy}"

    @property
    def effort(self) -> int:
        """See Job.effort."""
        return self.n_cycles

    def key(self) -> Any:
        """See Job.key."""
        return {
            "cell": [self.condition, self.n_cycles, self.policy, self.seed],
            "policy": self.settings.plain() | self.settings.sources(),
            "scenario": self.scenario.digest,
            "sources": digest_of_package(*SOURCES),
            "versions": versions_of(*NUMERICAL_LIBRARIES),
        }

    def is_deterministic(self) -> bool:
        """Whether every run is the same (paper, footnote 4): no chance in task or policy."""
        return self.scenario.leaves_nothing_to_chance() and not self.settings.build().draws_at_random

    def trial_numbers(self) -> range:
        """See Job.trial_numbers: a single trial where every run is the same."""
        return range(1 if self.is_deterministic() else self.trials)

    def run(self, trials: Sequence[int]) -> dict[int, TrialResult]:
        """See Job.run."""
        if can_be_compiled(self.scenario, self.settings):
            key = (self.seed, self.condition, self.n_cycles)
            return compiled_trials(self.scenario, self.settings, key, trials, self._planner)
        return self.run_one_by_one(trials)

    @property
    def trials_at_once(self) -> int:
        """See Job.trials_at_once."""
        return COMPILED_TRIALS if can_be_compiled(self.scenario, self.settings) else 1

    def run_one_by_one(self, trials: Sequence[int]) -> dict[int, TrialResult]:
        """The same results as `run`, with every decision asked for and timed."""
        self._load_compiled_code(trials if self.scenario.prior else trials[:1])
        results = {}
        for trial in trials:
            random_numbers = draw_random_numbers(self.seed, self.condition, self.n_cycles, trial)
            policy, knows = self.settings.build(), self.settings.knows
            results[trial] = run_trial(
                self.scenario, policy, knows, self.n_cycles, random_numbers, self._planner(trial)
            )
        return results

    def _planner(self, trial: int) -> np.random.Generator:
        """The planner's own stream in a trial."""
        return random_stream(self.seed, "planner", self.condition, self.n_cycles, trial, self.policy)

    def _load_compiled_code(self, trials: Sequence[int]) -> None:
        """Throw-away decisions, one per worker, so that no planning time includes loading or compiling code."""
        settings, rng = self.settings, np.random.default_rng(0)
        if isinstance(settings, PomcpSettings):
            settings = settings.model_copy(update={"descents": 1, "seconds": None})
        for trial in trials:
            hidden = draw_random_numbers(self.seed, self.condition, self.n_cycles, trial).worker
            model = self.scenario.worker(hidden)
            settings.build().act(self.scenario.initial_belief(settings.knows, model, rng), rng)

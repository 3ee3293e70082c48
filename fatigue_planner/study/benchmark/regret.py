"""What the decisions of finished runs lose, by the values of a reference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fatigue_planner.core.files import digest_of, digest_of_package
from fatigue_planner.core.random_streams import draw_random_numbers, random_stream
from fatigue_planner.planners.lookahead import LookaheadPolicy, ReferenceSettings
from fatigue_planner.study.benchmark.cell import SOURCES, Cell
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.replay import replay

# A loss below this fraction of the value is rounding.
ROUNDING = 1e-12
REGRET_SOURCES = ("study/benchmark/regret.py", "study/benchmark/replay.py")


@dataclass(frozen=True)
class Regret:
    """What the decisions of a run lose against a reference, by the reference's own values.

    decision_loss: mean over the decisions of max_a Q(b, a) - Q(b, action taken), >= 0
    run_loss: the sum of gamma^t times these; in the task without end its mean is what the policy's expected
        return falls short of the best, if Q is exact and the run long (performance-difference lemma, Kakade &
        Langford 2002). The reference, like the policies, does not know when the run ends: at the end of a short
        run it gives up some return for a future that is not counted.
    agreement: proportion of the decisions that lose nothing
    judged: digest of the actions
    """

    decision_loss: float
    run_loss: float
    agreement: float
    judged: str


@dataclass(frozen=True)
class RegretJob(Job[Regret]):
    """The regret of a cell's runs, from the actions they took; the reference knows a hidden worker's prior."""

    cell: Cell
    reference: ReferenceSettings
    actions: Mapping[int, Sequence[int]]

    result_type = Regret

    @property
    def name(self) -> str:
        """See Job.name."""
        return self.cell.name

    @property
    def effort(self) -> int:
        """See Job.effort."""
        return self.cell.n_cycles

    def key(self) -> Any:
        """See Job.key."""
        return [self.cell.digest(), self.reference.plain(), digest_of_package(*SOURCES, *REGRET_SOURCES)]

    def trial_numbers(self) -> range:
        """See Job.trial_numbers."""
        return self.cell.trial_numbers()

    def part(self, trials: Sequence[int]) -> "RegretJob":
        """See Job.part: the actions of the other trials stay here."""
        return replace(self, actions={trial: self.actions[trial] for trial in trials})

    def run(self, trials: Sequence[int]) -> dict[int, Regret]:
        """See Job.run."""
        return {trial: self._regret(trial) for trial in trials}

    def accepts(self, trial: int, result: Regret) -> bool:
        """See Job.accepts: a policy with a time budget may act otherwise when run again; a grid may be smaller."""
        return trial in self.actions and result.judged == digest_of(list(self.actions[trial]))

    def _regret(self, trial: int) -> Regret:
        cell, actions = self.cell, self.actions[trial]
        reference = LookaheadPolicy(self.reference)
        rng = random_stream(cell.seed, "reference", cell.condition, cell.n_cycles, trial, cell.policy)
        model = cell.scenario.worker(draw_random_numbers(cell.seed, cell.condition, cell.n_cycles, trial).worker)
        belief = cell.scenario.initial_belief("prior", model, rng)
        losses = np.zeros(len(actions))
        for cycle, (action, seen) in enumerate(zip(actions, replay(cell, trial, actions).observations, strict=True)):
            values = reference.values(belief, rng)
            loss = values.max() - values[action]
            losses[cycle] = loss if loss > ROUNDING * abs(values.max()) else 0.0
            belief = belief.update(action, seen, rng)
        weights = cell.scenario.model.discount ** np.arange(len(actions))
        judged = digest_of(list(actions))
        return Regret(float(losses.mean()), float(weights @ losses), float((losses == 0).mean()), judged)

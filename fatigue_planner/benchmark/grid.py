"""The cells of a benchmark and the selection a command makes of them."""

import math
from dataclasses import dataclass
from importlib.metadata import version

from fatigue_planner.files import digest_of, digest_of_package
from fatigue_planner.planners.registry import PolicySettings, build_policy
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp

# What produces the numbers of a trial besides its settings and reactions.
SOURCES = ("fatigue", "pomdp", "planners", "benchmark")


@dataclass(frozen=True)
class Cell:
    """One policy in one condition for one number of cycles."""

    condition: str
    n_cycles: int
    policy: str
    settings: PolicySettings
    model: FatiguePomdp
    initial: Belief
    seed: int
    trials: int

    @property
    def name(self) -> str:
        """How the cell is called in messages and files."""
        return f"{self.condition}/{self.n_cycles}/{self.policy}"

    def digest(self) -> str:
        """Key of the cell's trials: everything that decides them but their number."""
        model = self.model
        return digest_of(
            {
                "cell": [self.condition, self.n_cycles, self.policy, self.seed],
                "policy": self.settings.plain(),
                "expertise": repr(model.expertise),
                "discount": model.discount,
                "maps": [model.gain.tolist(), model.offset.tolist(), model.observation.tolist(), model.entries],
                "initial": [self.initial.states.tolist(), self.initial.weights.tolist()],
                "sources": digest_of_package(*SOURCES),
                "versions": {library: version(library) for library in ("numpy", "numba")},
            }
        )

    def is_deterministic(self) -> bool:
        """Whether every run is the same (paper, footnote 4): known start, expert, no dice in the policy."""
        certain = len(self.initial.weights) == 1 and self.model.expertise == math.inf
        return certain and not build_policy(self.model, self.settings).draws_at_random

    def trial_numbers(self) -> range:
        """The trials to run: one where every run is the same."""
        return range(1 if self.is_deterministic() else self.trials)

"""The cells of a benchmark and the selection a command makes of them."""

from dataclasses import dataclass
from importlib.metadata import version

from fatigue_planner.files import digest_of, digest_of_package
from fatigue_planner.planners.registry import build_policy
from fatigue_planner.planners.settings import PolicySettings, ReferenceSettings
from fatigue_planner.pomdp.situation import Situation

# What produces the numbers of a trial besides its settings and reactions.
SOURCES = ("fatigue", "pomdp", "planners", "benchmark", "streams.py")


@dataclass(frozen=True)
class Cell:
    """One policy in one condition for one number of cycles; with a reference, its regret is measured, too."""

    condition: str
    n_cycles: int
    policy: str
    settings: PolicySettings
    situation: Situation
    seed: int
    trials: int
    reference: ReferenceSettings | None = None

    @property
    def name(self) -> str:
        """How the cell is called in messages and files."""
        return f"{self.condition}/{self.n_cycles}/{self.policy}"

    def digest(self) -> str:
        """Key of the cell's trials: everything that decides them but their number."""
        return digest_of(
            {
                "cell": [self.condition, self.n_cycles, self.policy, self.seed],
                "policy": self.settings.plain(),
                "reference": self.reference.plain() if self.reference else None,
                "situation": self.situation.fingerprint(),
                "sources": digest_of_package(*SOURCES),
                "versions": {library: version(library) for library in ("numpy", "numba")},
            }
        )

    def is_deterministic(self) -> bool:
        """Whether every run is the same (paper, footnote 4): nothing left to chance, no dice in the policy."""
        return self.situation.leaves_nothing_to_chance() and not build_policy(self.settings).draws_at_random

    def trial_numbers(self) -> range:
        """The trials to run: one where every run is the same."""
        return range(1 if self.is_deterministic() else self.trials)

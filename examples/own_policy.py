"""Your own policy: keep each action for some cycles.

    python examples/own_policy.py

As a plug-in (`fatplan benchmark mine.yaml --plugin examples/own_policy.py`) an experiment file can name it:
`stubborn_3: {kind: stubborn, cycles: 3}`.
"""

from typing import Literal

import numpy as np
from pydantic import Field

import fatigue_planner as fp


class StubbornPolicy(fp.Policy):
    """Keep an action for some cycles, then take the next one."""

    def __init__(self, cycles: int) -> None:
        self._cycles, self._count = cycles, 0

    def act(self, belief: fp.Belief, rng: np.random.Generator) -> fp.Decision:
        """See Policy.act."""
        actions = len(belief.model.actions)
        action = self._count // self._cycles % actions
        self._count += 1
        return fp.Decision(action, np.full(actions, np.nan), np.zeros(actions, int), 0, 0.0, "keeps the action")


@fp.register
class StubbornSettings(fp.PolicySettings):
    """The same action for some cycles."""

    kind: Literal["stubborn"]
    cycles: int = Field(ge=1, description="Number of successive cycles with the same action.")

    def build(self) -> fp.Policy:
        """See PolicySettings.build."""
        return StubbornPolicy(self.cycles)


if __name__ == "__main__":
    experiment = fp.load("paper")
    scenario = fp.scenario(experiment, fp.simulate(experiment), "single_novice")
    policies = {"greedy": "greedy", "alternating": "alternating"}
    policies |= {f"stubborn_{cycles}": fp.policy({"kind": "stubborn", "cycles": cycles}) for cycles in (2, 5, 10)}
    table = fp.run_trials(scenario, policies, n_cycles=100, trials=20)
    print(table.groupby("policy")["discounted_return"].describe()[["mean", "std"]].sort_values("mean"))

"""The policies an experiment file can name.

To add a policy: write it (see `policy.Policy`), describe its settings in `settings.py`, name them in
PolicySettings there, and add a line to POLICY_KINDS here.
"""

from collections.abc import Callable
from typing import Any

from fatigue_planner.planners.baselines import AlternatingPolicy, GreedyPolicy, RandomPolicy
from fatigue_planner.planners.lookahead import LookaheadPolicy
from fatigue_planner.planners.policy import Policy
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.planners.settings import PolicySettings

POLICY_KINDS: dict[str, Callable[[Any], Policy]] = {
    "random": lambda _: RandomPolicy(),
    "alternating": lambda _: AlternatingPolicy(),
    "greedy": lambda _: GreedyPolicy(),
    "pomcp": PomcpPolicy,
    "lookahead": LookaheadPolicy,
}


def build_policy(settings: PolicySettings) -> Policy:
    """A fresh policy for one run."""
    return POLICY_KINDS[settings.kind](settings)

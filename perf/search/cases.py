"""The decisions on which searches are compared, by our search and by the C++ one."""

from dataclasses import dataclass

import numpy as np
from by_hand import Root, SearchByHand
from problems import Problem

from fatigue_planner.planners.pomcp.policy import PomcpPolicy, PomcpSettings

DESCENTS = 5000


@dataclass(frozen=True)
class Case:
    problem: Problem
    constant: float
    backup: str
    descents: int = DESCENTS

    def __str__(self) -> str:
        return f"{self.problem.name}, c = {self.constant}, {self.backup}"

    @property
    def settings(self) -> PomcpSettings:
        return PomcpSettings(
            kind="pomcp", backup=self.backup, exploration_constant=self.constant, descents=self.descents
        )


def ours(case: Case, seed: int) -> Root:
    """Our search, with what a decision does not contain: counts and depth."""
    tree = PomcpPolicy(case.settings).tree(case.problem.belief, np.random.default_rng(seed), 0.0)
    root = tree.nodes[0]
    return Root(root["value"], root["tried"], tree.nodes["tried"][: tree.size[0]].sum() / case.descents)


def by_hand(search: SearchByHand, case: Case, seed: int) -> Root:
    return search(case.problem.belief, case.descents, case.constant, case.backup == "max", seed)

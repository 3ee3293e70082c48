"""What an experiment says of its runs; what it leaves out is as in the paper."""

from collections.abc import Iterable
from typing import Annotated

from pydantic import Field

from fatigue_planner.core.settings import Name, Seed, Settings
from fatigue_planner.planners.baselines import AlternatingSettings, GreedySettings, RandomSettings
from fatigue_planner.planners.fixed import FixedSettings
from fatigue_planner.planners.lookahead import ReferenceSettings
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.planners.registry import AnyPolicy
from fatigue_planner.planners.threshold import ThresholdSettings

RESTED = "rested"

Level = Annotated[float, Field(ge=0, le=1)]


class InitialState(Settings):
    """One state the worker may start in: fatigue by joint, the rest relaxed."""

    probability: float = Field(gt=0, le=1, description="Probability of this state; those of all states sum to 1.")
    fatigue: dict[str, Level] = Field(
        default_factory=dict,
        description="Fatigue from 0 to 1 by entry (lumbar_flexion:negative), degree of freedom (lumbar_flexion), or "
        "either without its side; the rest is 0.",
    )


class Condition(Settings):
    """What is varied between runs besides policy and length: the worker, what is known of the start, expertise."""

    worker: Name | None = Field(
        default=None, description="The worker's name; may be left out where the experiment has one worker only."
    )
    initial_belief: Name = Field(description="What is known of the worker's fatigue at the start: an initial belief.")
    # NaN fails ge=0
    expertise: float | None = Field(
        default=None,
        ge=0,
        allow_inf_nan=True,
        description="Beta of Eq. 4 in 1 / cost: 0 chooses reactions blindly (novice), .inf always the least tiring one "
        "(expert). Left out where the hidden worker has one.",
    )
    hidden_worker: Name | None = Field(
        default=None, description="What the robot does not know of the worker: a hidden worker; left out, nothing."
    )
    choice_model: Name | None = Field(
        default=None,
        description="By what the worker chooses besides costs: a choice model; left out, nothing (Eq. 4).",
    )


def usual_conditions(workers: Iterable[str] = ("",), beliefs: Iterable[str] = (RESTED,)) -> dict[str, Condition]:
    """Every worker with every initial belief, as the paper's novice and expert; names without what all have."""
    workers, beliefs = list(workers), list(beliefs)
    return {
        "_".join([worker] * (len(workers) > 1) + [belief] * (len(beliefs) > 1) + [user]): Condition(
            worker=worker if len(workers) > 1 else None, initial_belief=belief, expertise=expertise
        )
        for worker in workers
        for belief in beliefs
        for user, expertise in (("novice", 0.0), ("expert", float("inf")))
    }


def paper_policies() -> dict[str, PolicySettings]:
    """The paper's seven (sections IV-D and IV-E)."""
    searches: dict[str, PolicySettings] = {
        f"{name}_{c}": PomcpSettings(kind="pomcp", backup=backup, exploration_constant=c, descents=5000)
        for name, backup in (("pomcp", "mean"), ("pomcpMax", "max"))
        for c in (0.1, 0.001)
    }
    return {
        "random": RandomSettings(kind="random"),
        "alternating": AlternatingSettings(kind="alternating"),
        "greedy": GreedySettings(kind="greedy"),
        **searches,
    }


def usual_policies(discount: float) -> dict[str, PolicySettings]:
    """The paper's seven, and what is done without planning: a fixed action, a reactive rule, the best schedule.

    So every report can say what planning is worth. The best schedule is that of a task without end, which has a value
    only with a discount below 1.
    """
    endless: dict[str, PolicySettings] = {
        "best_fixed": PeriodicSettings(kind="periodic", longest=1), "periodic": PeriodicSettings(kind="periodic")
    }  # fmt: skip
    reactive = {
        f"threshold_{level}": ThresholdSettings(kind="threshold", fatigue_threshold=level) for level in (0.1, 0.2)
    }
    return {
        **paper_policies(), "fixed": FixedSettings(kind="fixed"), **reactive, **(endless if discount < 1 else {})
    }  # fmt: skip


class Benchmark(Settings):
    """The grid of runs (paper, section IV-E)."""

    conditions: dict[Name, Condition] = Field(
        default_factory=usual_conditions,
        min_length=1,
        max_length=1000,
        description="Conditions by name. Default: every worker with every initial belief, as novice and as expert.",
    )
    policies: dict[Name, AnyPolicy] = Field(
        default_factory=paper_policies,
        min_length=1,
        max_length=1000,
        description="Policies by name. Default: the paper's seven (section IV-D), and what is done without planning: "
        "a fixed action, thresholds of fatigue, and, with a discount below 1, the best action and the best schedule.",
    )
    n_cycles: tuple[Annotated[int, Field(ge=1, le=100_000)], ...] = Field(
        default=(5, 20, 100),
        min_length=1,
        max_length=1000,
        description="Lengths of the task in cycles; the paper's are 5, 20 and 100 (section IV-E).",
    )
    trials: int = Field(
        default=100,
        ge=1,
        le=1_000_000,
        description="Runs of each policy in each condition and length; the paper's 100.",
    )
    seed: Seed = Field(default=2023, description="Seed of all random numbers.")
    reference: ReferenceSettings | None = Field(
        default=None,
        description="What --regret measures decisions against. Default: the deepest affordable lookahead.",
    )
    max_decision_s: float = Field(
        default=2.0,
        gt=0,
        le=3600,
        description="How long a decision of a policy or of the reference may take in s, by an estimate made "
        "beforehand; what may take longer is refused. Budgets given in seconds are what they say.",
    )

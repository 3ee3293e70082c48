"""fatplan: plan a cobot's choices so that a worker's fatigue stays low in the long run.

    import fatigue_planner as fp

The names below are public: they keep their meaning from one minor version to the next, and what has to change is
announced one minor version before, by a warning. All else may change at any time.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fatigue_planner.api import Actor as Actor
    from fatigue_planner.api import NamedDecision as NamedDecision
    from fatigue_planner.api import Run as Run
    from fatigue_planner.api import decide as decide
    from fatigue_planner.api import environment as environment
    from fatigue_planner.api import load as load
    from fatigue_planner.api import run as run
    from fatigue_planner.api import run_trials as run_trials
    from fatigue_planner.api import scenario as scenario
    from fatigue_planner.api import simulate as simulate
    from fatigue_planner.api import vector_environment as vector_environment
    from fatigue_planner.core.errors import FatplanError as FatplanError
    from fatigue_planner.core.jit import compiled as compiled
    from fatigue_planner.core.plugins import load_plugin as load_plugin
    from fatigue_planner.core.plugins import register as register
    from fatigue_planner.experiment.schema import Experiment as Experiment
    from fatigue_planner.fatigue.laws.law import FatigueLaw as FatigueLaw
    from fatigue_planner.live.clock import Clock as Clock
    from fatigue_planner.live.events import AlarmSettings as AlarmSettings
    from fatigue_planner.live.session import Session as Session
    from fatigue_planner.live.turn import CycleDecision as CycleDecision
    from fatigue_planner.motion.tasks.task import PreferenceTask as PreferenceTask
    from fatigue_planner.motion.tasks.task import Task as Task
    from fatigue_planner.output.reports.results.report import report_section as report_section
    from fatigue_planner.planners.policy import Decision as Decision
    from fatigue_planner.planners.policy import Policy as Policy
    from fatigue_planner.planners.policy import PolicySettings as PolicySettings
    from fatigue_planner.planners.registry import policy as policy
    from fatigue_planner.pomdp.beliefs.belief import Belief as Belief
    from fatigue_planner.pomdp.beliefs.exact import ExactBelief as ExactBelief
    from fatigue_planner.pomdp.beliefs.particles import ParticleBelief as ParticleBelief
    from fatigue_planner.pomdp.beliefs.registry import BeliefSettings as BeliefSettings
    from fatigue_planner.pomdp.problem import Dynamics as Dynamics
    from fatigue_planner.pomdp.problem import Pomdp as Pomdp
    from fatigue_planner.pomdp.scenario import Scenario as Scenario
    from fatigue_planner.reactions.reaction import Reaction as Reaction

# Every public name and where it is. They are loaded when they are first asked for: `fatplan --help` needs none of them.
_WHERE = {
    "api": (
        "Actor",
        "NamedDecision",
        "Run",
        "decide",
        "environment",
        "load",
        "run",
        "run_trials",
        "scenario",
        "simulate",
        "vector_environment",
    ),
    "core.errors": ("FatplanError",),
    "core.jit": ("compiled",),
    "core.plugins": ("load_plugin", "register"),
    "experiment.schema": ("Experiment",),
    "fatigue.laws.law": ("FatigueLaw",),
    "live.clock": ("Clock",),
    "live.events": ("AlarmSettings",),
    "live.session": ("Session",),
    "live.turn": ("CycleDecision",),
    "motion.tasks.task": ("PreferenceTask", "Task"),
    "output.reports.results.report": ("report_section",),
    "planners.policy": ("Decision", "Policy", "PolicySettings"),
    "planners.registry": ("policy",),
    "pomdp.beliefs.belief": ("Belief",),
    "pomdp.beliefs.exact": ("ExactBelief",),
    "pomdp.beliefs.particles": ("ParticleBelief",),
    "pomdp.beliefs.registry": ("BeliefSettings",),
    "pomdp.problem": ("Dynamics", "Pomdp"),
    "pomdp.scenario": ("Scenario",),
    "reactions.reaction": ("Reaction",),
}
_MODULE_OF = {name: f"fatigue_planner.{module}" for module, names in _WHERE.items() for name in names}

__version__ = version("fatigue-planner")
__all__ = ["__version__", *sorted(_MODULE_OF)]  # noqa: PLE0604 - all of these are names


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'fatigue_planner' has no attribute {name!r}")
    found = getattr(import_module(_MODULE_OF[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return __all__

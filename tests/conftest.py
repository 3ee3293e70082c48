"""What several tests share: the paper's experiment and its reactions, simulated once per session."""

from pathlib import Path

import pytest

from fatigue_planner.executors.processes import LocalProcesses
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_reactions, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction

ROOT = Path(__file__).parents[1]
PAPER = ROOT / "experiments" / "paper.yaml"


@pytest.fixture(scope="session")
def paper() -> Experiment:
    return load_experiment(PAPER)


@pytest.fixture(scope="session")
def cache_folder(paper: Experiment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache with the paper's reactions, made by the real simulation."""
    folder = tmp_path_factory.mktemp("cache")
    outcomes = ReactionCache(folder).complete(reaction_requests(paper), LocalProcesses(2), lambda _: None)
    assert [outcome.failure for outcome in outcomes] == [""] * 4
    return folder


@pytest.fixture(scope="session")
def reactions(paper: Experiment, cache_folder: Path) -> tuple[Reaction, ...]:
    return load_reactions(paper, cache_folder, "fatplan simulate")

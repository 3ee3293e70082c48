"""What several tests share: the paper's experiment, its reactions, simulated once per session, and keys of results."""

import os

# Threads of linear algebra that wait for each other on busy cores made imports of recordings nine times as slow.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import shutil
import socket
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from shifts import World

from fatigue_planner.core import files, provenance
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import load_cycle_profiles, load_reactions, reaction_requests, scenario
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction

ROOT = Path(__file__).parents[1]
PAPER = ROOT / "experiments" / "paper.yaml"
# Variable of the environment with a folder in which a program that runs tests again and again keeps reactions.
KEPT_REACTIONS = "FATPLAN_KEPT_REACTIONS"

# The same examples in every run, on a machine of any speed, and nothing remembered from one run to the next.
settings.register_profile("fatplan", derandomize=True, deadline=None, database=None, suppress_health_check=HealthCheck)
settings.load_profile("fatplan")


@pytest.fixture(scope="session")
def paper() -> Experiment:
    return load_experiment(PAPER)


@pytest.fixture(scope="session")
def cache_folder(paper: Experiment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache with the paper's reactions, made by the real simulation, or kept of these very requests and sources."""
    requests = reaction_requests(paper)
    if kept := os.environ.get(KEPT_REACTIONS):
        folder = Path(kept) / files.digest_of([request.digest for request in requests])
    else:
        folder = tmp_path_factory.mktemp("cache")
    outcomes = ReactionCache(folder).complete(requests, LocalProcesses(2), lambda _: None)
    assert [outcome.failure for outcome in outcomes] == [""] * 4
    return folder


@pytest.fixture(scope="session")
def reactions(paper: Experiment, cache_folder: Path) -> tuple[Reaction, ...]:
    return load_reactions(paper, cache_folder, "fatplan simulate")


@pytest.fixture(scope="session")
def task(paper: Experiment, cache_folder: Path) -> Scenario:
    """The paper's task with novices who prefer arm or back."""
    profiles = load_cycle_profiles(paper, cache_folder, "fatplan simulate")
    condition = "multiple_novice"
    return replace(scenario(paper, profiles, paper.benchmark.conditions[condition]), name=condition)


@pytest.fixture
def world(tmp_path: Path, task: Scenario, cache_folder: Path) -> World:
    """Where a shift happens."""
    return World(tmp_path, task, cache_folder)


@pytest.fixture
def no_files(tmp_path: Path) -> dict[str, Path]:
    """What can stand where a file should."""
    found = {name: tmp_path / name for name in ("folder", "pipe", "socket", "dangling", "loop", "zero", "none", "dots")}
    found["folder"].mkdir()
    os.mkfifo(found["pipe"])
    with socket.socket(socket.AF_UNIX) as server:
        here = Path.cwd()
        os.chdir(tmp_path)  # the path of a socket may have some hundred characters only
        try:
            server.bind("socket")
        finally:
            os.chdir(here)
    found["dangling"].symlink_to(tmp_path / "nowhere")
    found["loop"].symlink_to(found["loop"])
    found["zero"].symlink_to("/dev/zero")
    found["dots"] = tmp_path / "folder" / ".." / "folder" / "."
    (tmp_path / "file").write_text("name: x\n")
    found["below a file"] = tmp_path / "file" / "mine.yaml"
    found["too long"] = tmp_path / ("x" * 300)
    found["with NUL"] = tmp_path / "a\0b"
    return found


class Machine:
    """What a key of results is made from besides settings: the package's sources, here a copy, and its libraries.

    With a file or a library's version changed the key is taken again; the change is then undone.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self._monkeypatch = monkeypatch

    def with_another_file(self, file: str, key: Callable[[], str]) -> str:
        path = self.folder / file
        text = path.read_bytes()
        path.write_bytes(text + b"\n# changed\n")
        forget()
        changed = key()
        path.write_bytes(text)
        forget()
        return changed

    def with_another_version(self, library: str, key: Callable[[], str]) -> str:
        installed = provenance.version
        with self._monkeypatch.context() as patch:
            patch.setattr(provenance, "version", lambda name: installed(name) + (".1" if name == library else ""))
            forget()
            changed = key()
        forget()
        return changed


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Machine]:
    folder = Path(shutil.copytree(files.PACKAGE, tmp_path / "package", ignore=shutil.ignore_patterns("__pycache__")))
    with monkeypatch.context() as patch:
        patch.setattr(files, "PACKAGE", folder)
        forget()
        yield Machine(folder, monkeypatch)
    forget()


def forget() -> None:
    """Look at sources and versions again."""
    files.digests_of_package.cache_clear()
    provenance.versions_of.cache_clear()

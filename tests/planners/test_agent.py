"""Agents from outside: asked with observations, checked, reproducible, and part of the keys with what they read."""

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import fatplan
from conftest import PAPER, ROOT
from forgotten_plugins import forgotten_plugins
from small_problems import NOISY, SEVERAL, known

from fatigue_planner.core.errors import ExperimentError, PluginError
from fatigue_planner.core.plugins import load_plugin
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.planners.agent import AgentSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import replay

AGENTS = ROOT / "tests" / "support" / "agents.py"


@pytest.fixture(autouse=True)
def _agents() -> Iterator[None]:
    with forgotten_plugins():
        load_plugin(AGENTS)
        yield


def agent(name: str, data: Path | None = None, module: str = "agents") -> AgentSettings:
    return AgentSettings(kind="agent", agent=f"{module}:{name}", data=None if data is None else str(data))


def cell_of(settings: PolicySettings, trials: int = 6) -> Cell:
    return Cell("c", 7, "mine", settings, known(25.0, SEVERAL, NOISY), seed=3, trials=trials)


def test_it_acts_by_what_is_observed(tmp_path: Path) -> None:
    """First by nothing seen, the last observation; then by what was recognised, which is not always what happened."""
    (tmp_path / "table").write_bytes(bytes([1, 0, 1]))
    cell = cell_of(agent("Trained", tmp_path / "table"))
    taken = set()
    for trial, result in cell.run(range(6)).items():
        seen = replay(cell, trial, result.actions).observations
        assert result.actions == (1, *(1 - observation for observation in seen[:-1]))
        taken.add(result.actions)
    assert len(taken) > 3


def test_a_class_is_made_anew_for_every_run_and_draws_are_the_planners() -> None:
    assert {result.actions for result in cell_of(agent("Turns")).run(range(6)).values()} == {(1, 0, 1, 0, 1, 0, 1)}
    drawing = cell_of(agent("drawing"))
    once = drawing.run(range(6))
    assert once == {**drawing.run([5, 4]), **drawing.run(range(4))}
    assert len({result.actions for result in once.values()}) == 6
    assert {result.actions for result in cell_of(agent("first")).run(range(2)).values()} == {(0,) * 7}


@pytest.mark.parametrize("answer", [2, -1, 0.0, True, "c", None, (0,), np.array([0, 1]), np.nan])
def test_what_is_no_action_is_refused(answer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    module = load_plugin(AGENTS)
    monkeypatch.setattr(module, "ANSWER", answer)
    with pytest.raises(PluginError, match=r"the agent agents:answering returned .*; expected a, b, or a number from 0"):
        cell_of(agent("answering")).run([0])


@pytest.mark.parametrize("answer", [1, "b", np.int64(1), np.array(1), np.uint8(1)])
def test_an_action_is_a_number_or_a_name(answer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(load_plugin(AGENTS), "ANSWER", answer)
    assert cell_of(agent("answering")).run([0])[0].actions == (1,) * 7


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("agents:none", "agent = 'agents:none': the plug-in agents has no 'none'"),
        ("agents:number", "number is not a function or a class"),
        ("agents:of_one", r"of_one must take \(observation, rng\); it takes \(observation\)"),
        ("agents:NoCall", r"the class NoCall has no __call__\(self, observation, rng\)"),
        ("agents:Trained", r"Trained must take nothing; it takes \(data\)"),
        ("others:act", "no plug-in others is loaded; name its file: --plugin others.py"),
        ("os:getcwd", "no plug-in os is loaded"),
        ("agents", "agent: should be a module and a name in it, with a colon"),
        ("agents:a b", "agent: should be a module and a name in it, with a colon"),
        ("agents:first, data: DATA", "first is not a class, which data need"),
        ("agents:Turns, data: DATA", r"Turns must take the content of data; it takes \(\)"),
        ("agents:Trained, data: nowhere", "data = 'nowhere': should be a file of at most 64 MB"),
        ("agents:Trained, data: /dev/zero", "data = '/dev/zero': should be a file of at most 64 MB"),
    ],
)
def test_what_is_wrong_is_said_before_work_starts(settings: str, words: str, tmp_path: Path) -> None:
    chosen, *more = settings.replace("DATA", str(PAPER)).split(", ")
    text = PAPER.read_text(encoding="utf-8")
    line = f'random: {{kind: agent, agent: "{chosen}"{"".join(f", {one}" for one in more)}}}'
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("random: {kind: random}", line), encoding="utf-8")
    with pytest.raises(ExperimentError, match=rf"mine\.yaml: benchmark\.policies\.random.*{words}"):
        load_experiment(path)


def test_the_key_has_the_source_and_the_data(tmp_path: Path) -> None:
    source, data = tmp_path / "mine.py", tmp_path / "table"
    keys = []
    for text, content in (("", b"1"), ("# changed", b"1"), ("", b"2"), ("", b"1")):
        source.write_text(AGENTS.read_text() + text)
        data.write_bytes(content)
        load_plugin(source)
        keys.append(cell_of(agent("Trained", data, "mine")).digest())
    assert len(set(keys)) == 3 and keys[0] == keys[3]
    data.unlink()  # its content goes with the settings, to any machine
    with pytest.raises(ValueError, match="should be a file"):
        agent("Trained", data, "mine")


def test_the_data_go_with_the_settings(tmp_path: Path) -> None:
    data = tmp_path / "table"
    data.write_bytes(bytes([1, 1, 1]))
    settings = agent("Trained", data)
    data.unlink()
    sent = pickle.loads(pickle.dumps(settings))
    assert cell_of(sent).run([0])[0].actions == (1,) * 7 and sent.sources() == settings.sources()


@pytest.mark.slow
def test_the_benchmark_compares_it_and_tells_its_faults(cache_folder: Path, tmp_path: Path) -> None:
    """With statistics, in worker processes; a changed agent is run again; an error has its file and line."""
    text = PAPER.read_text(encoding="utf-8")
    path, plugin = tmp_path / "mine.yaml", tmp_path / "mine.py"
    text = text.replace("random: {kind: random}", 'mine: {kind: agent, agent: "mine:act"}')
    path.write_text(text.replace("policies: [random,", "policies: [mine,"), encoding="utf-8")
    command = ["benchmark", path, "--plugin", plugin, "--cache", cache_folder, "--results", tmp_path / "results"]
    command += ["--cycles", "5", "--trials", "6", "--conditions", "single_novice"]
    command += ["--policies", "mine", "--policies", "greedy"]
    plugin.write_text("def act(observation, rng):\n    return 'low'\n")
    done = fatplan(*command, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder = next((tmp_path / "results").glob("paper_*"))
    first = (folder / "actions.csv").read_text()
    assert "single_novice,5,mine,5,1 1 1 1 1" in first and "mine" in (folder / "contrasts.csv").read_text()
    plugin.write_text("def act(observation, rng):\n    return ['high', 'low', 'high'][observation]\n")
    assert fatplan(*command, cwd=tmp_path).returncode == 0
    assert (folder / "actions.csv").read_text() != first
    for source, words in (("return 3", "the agent mine:act returned 3"), ("return 1 / 0", "mine.py: line 2: ZeroDiv")):
        plugin.write_text(f"def act(observation, rng):\n    {source}\n")
        done = fatplan(*command, cwd=tmp_path)
        assert done.returncode == 2 and words in done.stderr and "Traceback" not in done.stderr

"""Plug-ins: found in files and installed packages, part of the keys of what they made, and told when they fail."""

import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from commands import fatplan, refused
from conftest import ROOT
from forgotten_plugins import forgotten_plugins

from fatigue_planner.core import plugins
from fatigue_planner.core.errors import ExperimentError, PluginError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.plugins import load_installed_plugins, load_plugin, plugin_sources, run_plugin
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import parse_experiment, read_content
from fatigue_planner.planners.policy import POLICIES, PolicySettings

PAPER = ROOT / "experiments/paper.yaml"
POLICY = """
from typing import Literal
import fatigue_planner as fp

class First(fp.Policy):
    def act(self, belief, rng):
        return fp.policy("greedy").build().act(belief, rng)

@fp.register
class FirstSettings(fp.PolicySettings):
    kind: Literal["{kind}"]
    level: int = 0
    def build(self):
        return First()
"""


TASK = """
from typing import Literal
import fatigue_planner as fp
from fatigue_planner.motion.tasks.segment_upright import SegmentUpright

@fp.register
class Straight(SegmentUpright):
    kind: Literal["straight"]
"""


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    """No plug-in outlives its test."""
    with forgotten_plugins():
        yield


def write(folder: Path, text: str, name: str = "mine") -> Path:
    path = folder / f"{name}.py"
    path.write_text(text)
    return path


def policies(**named: object) -> dict[str, PolicySettings]:
    content = read_content(PAPER)
    content["benchmark"] = content["benchmark"] | {"policies": named}
    content["statistics"] = {}
    return dict(parse_experiment(content, "mine.yaml").benchmark.policies)


def test_an_experiment_file_alone_runs_nobodys_code(tmp_path: Path) -> None:
    write(tmp_path, "raise SystemExit('run')")
    with pytest.raises(ExperimentError, match=r"first_1.kind = 'first': should be one of 'random', 'alternating'"):
        policies(first_1={"kind": "first"})


def test_a_file_adds_a_kind_and_its_mistakes_are_told_as_any_others(tmp_path: Path) -> None:
    load_plugin(write(tmp_path, POLICY.format(kind="first")))
    found = policies(first_1={"kind": "first", "level": 3}, greedy={"kind": "greedy"})
    assert found["first_1"].plain() == {"kind": "first", "knows": "prior", "level": 3}
    with pytest.raises(ExperimentError, match=r"policies.a.levle: unknown key; did you mean 'level'"):
        policies(a={"kind": "first", "levle": 3})
    with pytest.raises(ExperimentError, match=r"policies.a.level = 'x'"):
        policies(a={"kind": "first", "level": "x"})


def test_what_a_plug_in_decides_is_in_the_key(tmp_path: Path) -> None:
    keys = []
    for text in (POLICY.format(kind="first"), POLICY.format(kind="first") + "# changed\n"):
        load_plugin(write(tmp_path, text))
        keys.append(plugin_sources(type(policies(a={"kind": "first"})["a"])))
    assert keys[0] != keys[1] and list(keys[0]) == ["plug-in fatplan_plugin_mine"]
    assert plugin_sources(type(policies(a={"kind": "greedy"})["a"])) == {}


def test_a_reactions_key_has_the_plug_ins_of_its_tasks(tmp_path: Path) -> None:
    keys = []
    for text in (TASK, TASK + "# changed\n"):
        load_plugin(write(tmp_path, text))
        content = read_content(PAPER)
        task = {"kind": "straight", "segment": "thorax", "weight": 1.0}
        content["preferences"] = {**content["preferences"], "arm": {"tasks": (task,)}}
        requests = reaction_requests(parse_experiment(content, "mine.yaml"))
        keys.append({request.name.preference: request.key for request in requests})
    (before, after), back = [key["arm"] for key in keys], keys[0]["back"]
    assert before.settings == after.settings and before.digest != after.digest and back == keys[1]["back"]
    assert set(after.sources) - set(back.sources) == {"plug-in fatplan_plugin_mine"}
    assert after.is_current and back.is_current and not replace(after, sources={**after.sources, "x": "0"}).is_current
    assert type(after.motion_request().preference.tasks[0]).__name__ == "Straight"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("def (", r"mine.py: line 1: SyntaxError"),
        ("import nothing_like_it", r"mine.py: line 1: ModuleNotFoundError: No module named 'nothing_like_it'"),
        ("x = 1\ny = 1 / 0", r"mine.py: line 2: ZeroDivisionError"),
        (
            "import fatigue_planner as fp\n@fp.register\nclass A: pass",
            r"A must be derived from .*PolicySettings",
        ),
        ("import fatigue_planner as fp\n@fp.register\nclass A(fp.PolicySettings): pass", "A needs a name"),
        (POLICY.format(kind="greedy"), r"mine.py: the policy 'greedy' is already defined in fatigue_planner"),
    ],
)
def test_a_file_that_is_wrong_is_told_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(PluginError, match=words):
        load_plugin(write(tmp_path, text))


def test_a_file_that_is_not_there_or_has_no_modules_name_is_told(tmp_path: Path) -> None:
    with pytest.raises(PluginError, match="cannot be read"):
        load_plugin(tmp_path / "none.py")
    with pytest.raises(PluginError, match="letters, digits and _"):
        load_plugin(write(tmp_path, "", "my-policies"))
    load_plugin(write(tmp_path, ""))
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(PluginError, match="another plug-in has the same name"):
        load_plugin(write(other, ""))


def test_installed_packages_are_asked_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, POLICY.format(kind="installed"), "my_package")
    monkeypatch.syspath_prepend(tmp_path)
    asked = []

    def entry_points(group: str) -> list[EntryPoint]:
        asked.append(group)
        return [EntryPoint("mine", "my_package", group)]

    monkeypatch.setattr(plugins, "entry_points", entry_points)
    load_installed_plugins.cache_clear()
    assert set(policies(a={"kind": "installed"})) == {"a"} and "installed" in POLICIES.kinds()
    assert asked == ["fatigue_planner.plugins"]
    assert list(plugin_sources(type(policies(a={"kind": "installed"})["a"]))) == ["plug-in my_package"]
    del sys.modules["my_package"]


def test_a_broken_installed_plug_in_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda group: [EntryPoint("mine", "not_there", group)])
    load_installed_plugins.cache_clear()
    with pytest.raises(PluginError, match="the plug-in 'mine' of the installed package unknown: ModuleNotFoundError"):
        policies(a={"kind": "greedy"})


def test_a_command_loads_the_file_that_is_named(tmp_path: Path) -> None:
    experiment = tmp_path / "mine.yaml"
    experiment.write_text(PAPER.read_text().replace("    random: {kind: random}", "    random: {kind: first}"))
    assert "random.kind = 'first': should be one of" in refused(2, "validate", experiment)
    file = write(tmp_path, "raise ValueError('no')")
    assert f"--plugin {file}: line 1: ValueError: no." in refused(2, "validate", experiment, "--plugin", file)
    write(tmp_path, POLICY.format(kind="first"))
    done = fatplan("validate", experiment, "--plugin", file)
    assert done.returncode == 0 and "mine.yaml: ok" in done.stdout, done.stderr


def kind_of(settings: PolicySettings) -> str:
    return settings.kind


def test_workers_have_the_plug_ins_of_the_process_that_asks(tmp_path: Path) -> None:
    load_plugin(write(tmp_path, POLICY.format(kind="first")))
    settings = policies(a={"kind": "first"})["a"]
    assert list(LocalProcesses(1).run(kind_of, [settings])) == [(0, "first")]


def test_a_plug_in_is_run_from_its_source_where_its_file_is_not(tmp_path: Path) -> None:
    run_plugin("far", POLICY.format(kind="first").encode(), "/nowhere/far.py")
    assert "first" in POLICIES.kinds()


@pytest.mark.parametrize(
    ("act", "words"),
    [
        ("1 / 0", r"the plug-in \S*mine.py: line 7: ZeroDivisionError: division by zero\."),
        ("'high'", r"\S*mine.py: act returned 'high', not a Decision with an action from 0 to 1\."),
    ],
)
def test_a_policy_that_fails_at_work_is_told_with_its_line(
    act: str, words: str, tmp_path: Path, cache_folder: Path
) -> None:
    experiment = tmp_path / "mine.yaml"
    experiment.write_text(PAPER.read_text().replace("    random: {kind: random}", "    random: {kind: first}"))
    text = POLICY.format(kind="first").replace('fp.policy("greedy").build().act(belief, rng)', act)
    options = [
        "--plugin",
        write(tmp_path, text),
        "--cache",
        cache_folder,
        "--results",
        tmp_path,
        "--policies",
        "random",
    ]
    said = refused(2, "benchmark", experiment, *options, "--cycles", 5, "--trials", 1, "--jobs", 1)
    assert re.search(words, said), said

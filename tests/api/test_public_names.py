"""`import fatigue_planner as fp`: every public name is documented, has an example that runs, and is typed."""

import ast
import datetime
import doctest
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PAPER, ROOT
from forgotten_plugins import forgotten_plugins

import fatigue_planner as fp

NAMES = [name for name in fp.__all__ if not name.startswith("__")]


@pytest.fixture(scope="module")
def names(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    """What the examples start from; what they register is forgotten."""
    experiment = fp.load(PAPER)
    reactions = fp.simulate(experiment, cache_folder)
    scenario = fp.scenario(experiment, reactions, "single_novice")
    with forgotten_plugins():
        yield {
            "fp": fp, "np": np, "examples": ROOT / "examples", "experiment": experiment, "cache": cache_folder,
            "reactions": reactions, "scenario": scenario, "folder": tmp_path_factory.mktemp("shifts"),
            "datetime": datetime,
        }  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_documented_and_its_example_runs(name: str, names: dict[str, Any]) -> None:
    found = getattr(fp, name)
    text = inspect.getdoc(found) or ""
    assert text, name
    example = doctest.DocTestParser().get_doctest(text, dict(names), name, None, None)
    assert example.examples, f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert runner.run(example).failed == 0


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse((ROOT / "fatigue_planner/__init__.py").read_text())
    typed = {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("fatigue_planner.")
        for alias in node.names
    }
    assert typed == set(NAMES)
    assert (ROOT / "fatigue_planner/py.typed").exists()


def test_there_are_some_thirty_names() -> None:
    assert 20 <= len(NAMES) <= 36
    assert set(dir(fp)) == set(fp.__all__)
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = fp.simulat


def test_the_import_loads_no_other_module() -> None:
    program = "import sys, fatigue_planner; print(sorted(m for m in sys.modules if 'fatigue_planner.' in m))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

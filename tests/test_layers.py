"""The layout follows the data: a lower layer knows nothing of a higher one."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "fatigue_planner"
FOUNDATION = ["errors", "files", "settings", "compiled", "provenance", "streams", "yaml_reader"]
LAYERS = [
    "executors", "human", "exports", "motion", "reactions", "fatigue", "pomdp", "bounds", "planners", "benchmark",
    "statistics", "experiment", "claims", "sensitivity", "figures", "reports", "viewer", "cli",
]  # fmt: skip


def imported_layers(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("fatigue_planner."):
            names.add(node.module.split(".")[1])
        elif isinstance(node, ast.Import):
            names |= {alias.name.split(".")[1] for alias in node.names if alias.name.startswith("fatigue_planner.")}
    return names


def test_every_folder_and_module_has_a_place() -> None:
    found = {p.stem for p in PACKAGE.iterdir() if p.is_dir() or p.suffix == ".py"} - {"__init__", "__pycache__"}
    assert found == {*FOUNDATION, *LAYERS}


@pytest.mark.parametrize("layer", LAYERS)
def test_a_layer_imports_only_lower_ones(layer: str) -> None:
    allowed = {*FOUNDATION, *LAYERS[: LAYERS.index(layer) + 1]}
    for file in (PACKAGE / layer).rglob("*.py"):
        assert imported_layers(file) <= allowed, file


@pytest.mark.parametrize("module", FOUNDATION)
def test_the_foundation_imports_no_layer(module: str) -> None:
    assert not imported_layers(PACKAGE / f"{module}.py") & set(LAYERS)


def test_the_statistics_know_nothing_of_humans_or_planners() -> None:
    for file in (PACKAGE / "statistics").rglob("*.py"):
        assert imported_layers(file) <= {*FOUNDATION, "statistics"}, file

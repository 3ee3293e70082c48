"""The layout follows the data: a lower room knows nothing of a higher one; no files import each other in a circle."""

import ast
from collections.abc import Mapping, Set
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from conftest import ROOT

PACKAGE = ROOT / "fatigue_planner"
# From the ground up; a room imports only itself and those before it.
ROOMS = [
    "core", "human", "motion", "robot", "fatigue", "reactions", "ergonomics", "pomdp", "planners", "experiment",
    "study", "station", "recordings", "api", "live", "output", "cli",
]  # fmt: skip
# The same inside the rooms that have several: from the ground up.
INNER_ROOMS = {
    "study": ["statistics", "benchmark", "environments", "claims", "sensitivity"],
    "output": ["viewer", "figures", "reports"],
    "planners": ["schedules", "pomcp", "bounds"],
    "station": ["line"],
}
MAX_ROOMS, MAX_FLOORS = 17, 11

Graph = Mapping[str, Set[str]]


def dotted(file: Path) -> str:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports() -> Graph:
    """The modules of the package that every module imports, wherever the import stands in it."""
    modules = {dotted(file): file for file in PACKAGE.rglob("*.py")}
    found: dict[str, set[str]] = {}
    for name, file in modules.items():
        named = set()
        if name == "fatigue_planner":  # its face: public names, loaded when they are first asked for
            found[name] = set()
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                named |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.module is not None and node.level == 0, f"{file}: a relative import"
                named |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
        found[name] = {one for one in named if one in modules} - {name}
    return found


def floors(graph: Graph) -> int:
    """How many nodes the longest way down has. Raises CycleError."""
    height: dict[str, int] = {}
    for node in TopologicalSorter(graph).static_order():
        height[node] = 1 + max((height[below] for below in graph.get(node, ())), default=0)
    return max(height.values())


def between(depth: int) -> Graph:
    """The imports between the rooms of a depth: 1 are those at the top."""
    graph: dict[str, set[str]] = {}
    for module, named in imports().items():
        own = module.split(".")[1 : 1 + depth]
        if len(own) == depth:
            below = {".".join(one.split(".")[1 : 1 + depth]) for one in named if len(one.split(".")) > depth}
            graph.setdefault(".".join(own), set()).update(below - {".".join(own)})
    return graph


def test_there_are_few_rooms_and_every_one_has_a_place() -> None:
    found = {path.stem for path in PACKAGE.iterdir() if path.is_dir() or path.suffix == ".py"}
    assert found - {"__init__", "__main__", "__pycache__"} == set(ROOMS)
    assert len(ROOMS) <= MAX_ROOMS


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_lower_ones(room: str) -> None:
    assert between(1).get(room, set()) <= set(ROOMS[: ROOMS.index(room)])


@pytest.mark.parametrize("room", INNER_ROOMS)
def test_an_inner_room_imports_only_lower_ones(room: str) -> None:
    inner = [f"{room}.{name}" for name in INNER_ROOMS[room]]
    assert {name for name in between(2) if name in inner} == set(inner)
    for place, name in enumerate(inner):
        assert not between(2)[name] & set(inner[place:]), name


def test_the_house_is_not_high() -> None:
    assert floors(between(1)) <= MAX_FLOORS


def test_no_files_import_each_other_in_a_circle() -> None:
    assert floors(imports()) > 1  # raises CycleError, which names the circle


def test_the_statistics_know_nothing_of_humans_or_planners() -> None:
    for module, named in imports().items():
        if module.startswith("fatigue_planner.study.statistics"):
            allowed = ("fatigue_planner.core", "fatigue_planner.study.statistics", "fatigue_planner.experiment.stat")
            assert all(one.startswith(allowed) for one in named), module

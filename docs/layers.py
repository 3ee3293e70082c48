"""The rooms of the package and what they import from each other, as a picture: from the imports in the sources."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "fatigue_planner"

WIDTH, HEIGHT, GAP_X, GAP_Y, MARGIN = 140, 34, 32, 32, 12
STYLE = """
  rect { fill: #eef3f8; stroke: #4c6a88; }
  text { fill: #16324f; font: 15px sans-serif; text-anchor: middle; dominant-baseline: central; }
  .arrow { fill: none; stroke: #7d8fa3; stroke-width: 1.4; marker-end: url(#tip); }
  .tip { fill: #7d8fa3; }
"""


def imports_between_rooms() -> dict[str, set[str]]:
    """The rooms that each room imports from, wherever in a file the import stands."""
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    rooms -= {"__init__", "__main__"}
    graph: dict[str, set[str]] = {}
    for room in sorted(rooms):
        graph[room] = set()
        for file in [*PACKAGE.glob(f"{room}.py"), *(PACKAGE / room).rglob("*.py")]:
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and node.module == PACKAGE.name:
                    graph[room] |= {alias.name for alias in node.names}
                elif isinstance(node, ast.ImportFrom):
                    graph[room].add(_room(str(node.module)))
                elif isinstance(node, ast.Import):
                    graph[room] |= {_room(alias.name) for alias in node.names}
        graph[room] &= rooms - {room}
    return graph


def _room(module: str) -> str:
    package, _, inside = module.partition(".")
    return inside.partition(".")[0] if package == PACKAGE.name else ""


def floors(graph: dict[str, set[str]]) -> list[list[str]]:
    """The rooms from the ground up; every room stands on the floor above the highest that it imports from."""
    floor: dict[str, int] = {}
    for room in TopologicalSorter(graph).static_order():
        floor[room] = 1 + max((floor[below] for below in graph[room]), default=-1)
    return [sorted(room for room in floor if floor[room] == level) for level in range(max(floor.values()) + 1)]


def direct(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """The imports without those that others imply: `a` to `c` is left out where there are `a` to `b` to `c`."""
    below: dict[str, set[str]] = {}
    for room in TopologicalSorter(graph).static_order():
        below[room] = graph[room].union(*(below[other] for other in graph[room]))
    return {room: named - set().union(*(below[other] for other in named)) for room, named in graph.items()}


def picture() -> str:
    """The rooms as an SVG: the ground floor at the bottom, an arrow from each room to those it is built on."""
    graph = imports_between_rooms()
    levels = floors(graph)
    widest = max(map(len, levels))
    width = widest * (WIDTH + GAP_X) - GAP_X + 2 * MARGIN
    height = len(levels) * (HEIGHT + GAP_Y) - GAP_Y + 2 * MARGIN
    left, top = {}, {}
    for level, rooms in enumerate(reversed(levels)):
        used = len(rooms) * (WIDTH + GAP_X) - GAP_X
        for column, room in enumerate(rooms):
            left[room] = (width - used) / 2 + column * (WIDTH + GAP_X)
            top[room] = MARGIN + level * (HEIGHT + GAP_Y)
    lines = []
    for room, named in sorted(direct(graph).items()):
        for below in sorted(named):
            x0, x1 = left[room] + WIDTH / 2, left[below] + WIDTH / 2
            y0, y1 = top[room] + HEIGHT, top[below] - 2
            middle = (y0 + y1) / 2
            bends = f"{x0:g} {middle:g} {x1:g} {middle:g}"
            if y1 - y0 > HEIGHT + GAP_Y:  # past other floors: go aside first, so as not to cross their rooms
                bends = f"{x1:g} {y0 + 6:g} {x1:g} {y1 - GAP_Y:g}"
            lines.append(f'<path class="arrow" d="M{x0:g} {y0:g} C{bends} {x1:g} {y1:g}"/>')
    for room in sorted(graph):
        x, y = left[room], top[room]
        lines.append(f'<rect x="{x:g}" y="{y:g}" width="{WIDTH}" height="{HEIGHT}" rx="6"/>')
        lines.append(f'<text x="{x + WIDTH / 2:g}" y="{y + HEIGHT / 2:g}">{room}</text>')
    tip = '<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}">\n<style>{STYLE}</style>\n'
        f'<defs>{tip}<path class="tip" d="M0 0 L8 4 L0 8 z"/></marker></defs>\n' + "\n".join(lines) + "\n</svg>\n"
    )


if __name__ == "__main__":
    print(picture(), end="")

"""Reading YAML strictly: safe types only, no duplicate keys, no aliases, numbers like 1e-3 are numbers."""

import re
from pathlib import Path
from typing import Any

import yaml

from fatigue_planner.errors import ExperimentError

LARGEST_FILE_BYTES = 1_000_000


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader without its surprises."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem="aliases (*name) are not allowed", problem_mark=mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                raise yaml.MarkedYAMLError(problem=f"key {key!r} is not text", problem_mark=key_node.start_mark)
            if key in seen:
                raise yaml.MarkedYAMLError(problem=f"key {key!r} stands twice", problem_mark=key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


# Lists become tuples: settings are frozen.
_StrictLoader.add_constructor(
    "tag:yaml.org,2002:seq", lambda loader, node: tuple(loader.construct_object(item, deep=True) for item in node.value)
)

# YAML 1.2's numbers; PyYAML follows YAML 1.1, where 1e-3 is a string.
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def read_yaml(path: Path) -> Any:
    """The content of a YAML file. Raises ExperimentError naming the file and, where known, the line."""
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise ExperimentError(f"{path}: is larger than {LARGEST_FILE_BYTES} bytes; this is no experiment file.")
        return yaml.load(path.read_text(encoding="utf-8"), Loader=_StrictLoader)
    except OSError as error:
        raise ExperimentError(f"{path}: cannot be read ({error.strerror}).") from error
    except UnicodeDecodeError as error:
        raise ExperimentError(f"{path}: is not a text file in UTF-8.") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise ExperimentError(f"{path}: {place}{error.problem}.") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ExperimentError(f"{path}: is not valid YAML ({error}).") from error

"""Reading YAML strictly: safe types only, no duplicate keys, no aliases, numbers like 1e-3 are numbers."""

import re
from pathlib import Path
from typing import Any

import yaml

from fatigue_planner.errors import FatplanError

LARGEST_FILE_BYTES = 1_000_000
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


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

# YAML 1.2's numbers: in PyYAML's YAML 1.1 1e-3 is a string, 075 octal and 1:30 ninety.
_StrictLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _NUMBERS]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_DIGITS = list("-+.0123456789")
_StrictLoader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?\d+$"), _DIGITS)
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?$|^[-+]?\.(inf|Inf|INF)$|^\.(nan|NaN|NAN)$"),
    _DIGITS,
)
_StrictLoader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(str(node.value)))


def read_yaml(path: Path, error_type: type[FatplanError]) -> Any:
    """The content of a YAML file. Raises `error_type` naming the file and, where known, the line."""
    try:
        if not path.is_file():
            reason = "is not a file" if path.exists() else "No such file"
            raise error_type(f"{path.absolute()}: cannot be read ({reason}).")
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise error_type(f"{path}: is larger than {LARGEST_FILE_BYTES} bytes; this is not one of ours.")
        return yaml.load(path.read_text(encoding="utf-8"), Loader=_StrictLoader)
    except OSError as error:
        raise error_type(f"{path}: cannot be read ({error.strerror}).") from error
    except UnicodeDecodeError as error:
        raise error_type(f"{path}: is not a text file in UTF-8.") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise error_type(f"{path}: {place}{error.problem}.") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise error_type(f"{path}: is not valid YAML ({error}).") from error

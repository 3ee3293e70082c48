"""Reading YAML strictly: safe types only, no duplicate keys, no aliases, no tags, numbers like 1e-3 are numbers."""

import math
import re
import unicodedata
from pathlib import Path
from typing import Any, NoReturn

import yaml

from fatigue_planner.core.errors import MAX_SHOWN_LENGTH, FatplanError, shortened

# A file of ours has some kilobytes and hundreds of values. The limits keep every file readable within half a second.
MAX_FILE_BYTES = 500_000
MAX_VALUES = 10_000
DEEPEST = 40
MAX_DIGITS = 30

_STR, _INT, _FLOAT = (f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float"))
# Resolved as in PyYAML; numbers have rules of their own, and dates, merge keys and = are text to us.
_RESOLVED = ("tag:yaml.org,2002:null", "tag:yaml.org,2002:bool")
_MAY_STAND_IN_TEXT = "\t\n"


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader without its surprises."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = self._values = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent):
            _refuse("aliases (*name) are not allowed", event)
        if event.tag is not None:
            _refuse(f"tags (here {shortened(event.tag)}) are not allowed", event)
        self._depth, self._values = self._depth + 1, self._values + 1
        if self._depth > DEEPEST:
            _refuse(f"nested more than {DEEPEST} deep", event)
        if self._values > MAX_VALUES:
            _refuse(f"more than {MAX_VALUES} keys and values; this is not one of ours", event)
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            if key_node.tag != _STR:
                written = key_node.value if isinstance(key_node, yaml.ScalarNode) else "a list or mapping"
                _refuse(
                    f"key {written[:MAX_SHOWN_LENGTH] or '(nothing)'} is not text; put it in quotes if it is a name",
                    key_node,
                )
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                _refuse(f"key {shortened(key)} stands twice", key_node)
            seen.add(key)
        return super().construct_mapping(node, deep)


def _refuse(problem: str, where: Any) -> NoReturn:
    """Raise an error at an event or a node."""
    raise yaml.MarkedYAMLError(problem=problem, problem_mark=where.start_mark)


def _text(_loader: _StrictLoader, node: yaml.ScalarNode) -> str:
    """Text without the characters that steer a terminal, and without halves of characters."""
    text = str(node.value)
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") and character not in _MAY_STAND_IN_TEXT:
            _refuse(f"the character \\u{ord(character):04x} may not stand in text", node)
    return text


def _whole_number(_loader: _StrictLoader, node: yaml.ScalarNode) -> int:
    if len(node.value) > MAX_DIGITS:
        _refuse(f"{node.value[:MAX_DIGITS]}… is a number of {len(node.value)} digits; at most {MAX_DIGITS}", node)
    return int(node.value)


def _number(_loader: _StrictLoader, node: yaml.ScalarNode) -> float:
    """A number; one too large or too small to be held must not silently become .inf or 0."""
    text = str(node.value)
    if text.lstrip("+-").lower() in (".inf", ".nan"):
        return float(text.replace(".", "", 1))
    number = float(text)
    lost = number == 0 and re.search("[1-9]", re.split("[eE]", text)[0]) is not None
    if math.isinf(number) or lost:
        _refuse(f"{text[:MAX_SHOWN_LENGTH]} is too {'small' if lost else 'large'} a number", node)
    return number


# Lists become tuples: settings are frozen.
_StrictLoader.add_constructor(
    "tag:yaml.org,2002:seq", lambda loader, node: tuple(loader.construct_object(item, deep=True) for item in node.value)
)
_StrictLoader.add_constructor(_STR, _text)
_StrictLoader.add_constructor(_INT, _whole_number)
_StrictLoader.add_constructor(_FLOAT, _number)

# YAML 1.2's numbers: in PyYAML's YAML 1.1 1e-3 is a string, 075 octal and 1:30 ninety.
_StrictLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag in _RESOLVED]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_DIGITS = list("-+.0123456789")
_StrictLoader.add_implicit_resolver(_INT, re.compile(r"^[-+]?[0-9]+$"), _DIGITS)
_StrictLoader.add_implicit_resolver(
    _FLOAT,
    re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$|^[-+]?\.(inf|Inf|INF)$|^\.(nan|NaN|NAN)$"),
    _DIGITS,
)


def read_yaml(path: Path, error_type: type[FatplanError]) -> Any:
    """The content of a YAML file. Raises `error_type` naming the file and, where known, the line."""
    text = _read_text(path, error_type)
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise error_type(f"{path}: {place}{error.problem}.") from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        character = f"\\u{ord(text[error.position]):04x}"
        raise error_type(f"{path}: line {line}: the character {character} may not stand in a file.") from error
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # PyYAML's own: "\UFFFFFFFF"
        raise error_type(f"{path}: is not valid YAML ({error}).") from error


def _read_text(path: Path, error_type: type[FatplanError]) -> str:
    """The text of a file, never more than is allowed: the size a file states may be wrong."""
    try:
        if not path.is_file():  # a pipe could make us wait for ever, a device has no end
            reason = "is not a file" if path.exists() else "No such file"
            raise error_type(f"{path.absolute()}: cannot be read ({reason}).")
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise error_type(f"{path}: cannot be read ({error.strerror}).") from error
    if len(content) > MAX_FILE_BYTES:
        raise error_type(f"{path}: is larger than {MAX_FILE_BYTES} bytes; this is not one of ours.")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise error_type(f"{path}: line {line}: is not a text file in UTF-8.") from error

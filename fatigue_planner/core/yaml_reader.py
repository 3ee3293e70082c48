"""Reading YAML strictly: safe types only, no duplicate keys, no tags, numbers like 1e-3 are numbers.

Anchors, aliases and merge keys (`<<`) are allowed; the limits on size hold for what they are written out to.
"""

import itertools
import math
import re
import unicodedata
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import yaml
from yaml.composer import Composer

from fatigue_planner.core.errors import MAX_SHOWN_LENGTH, FatplanError, shortened

# A file of settings has some kilobytes and hundreds of values. The limits keep files readable within half a second.
MAX_FILE_BYTES = 500_000
MAX_VALUES = 10_000
MAX_DEPTH = 40
MAX_DIGITS = 30

_NULL, _BOOL, _STR, _INT, _FLOAT, _MERGE = (
    f"tag:yaml.org,2002:{name}" for name in ("null", "bool", "str", "int", "float", "merge")
)
# Resolved as in PyYAML; numbers have rules of their own, and dates and = are text to us.
_RESOLVED = (_NULL, _BOOL, _MERGE)
_ALLOWED_CONTROLS = "\t\n"
# Around these libyaml accepts what PyYAML's own parser does not, or breaks lines elsewhere.
_READ_DIFFERENTLY = frozenset("\t?\x85\u2028\u2029\ufeff")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?")


class _Size(NamedTuple):
    """How large a node is with its aliases written out: keys and values, characters of scalars, levels."""

    values: int
    characters: int
    levels: int


class _Strict(Composer):
    """What turns a parser's events into nodes: without the surprises of SafeLoader."""

    def __init__(self) -> None:
        Composer.__init__(self)
        self._depth = self._values = self._characters = 0
        self._levels_below = 0  # of the nodes composed so far inside the present one
        self._sizes: dict[str, _Size] = {}  # of the finished nodes that have an anchor

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[attr-defined]
        if isinstance(event, yaml.AliasEvent):
            return self._compose_alias(event, parent, index)
        if event.tag is not None:
            _refuse(f"tags (here {shortened(event.tag)}) are not allowed", event)
        if event.anchor in self.anchors:
            _refuse(f"anchor &{event.anchor[:MAX_SHOWN_LENGTH]} is given twice", event)
        before, siblings = (self._values, self._characters), self._levels_below
        self._depth, self._levels_below = self._depth + 1, 0
        characters = len(event.value) if isinstance(event, yaml.ScalarEvent) else 0
        self._grow(_Size(1, characters, 0), event)
        node = super().compose_node(parent, index)
        if isinstance(node, yaml.MappingNode):
            _check_keys(node)
        elif isinstance(node, yaml.SequenceNode):
            _check_commas(node)
        size = _Size(self._values - before[0], self._characters - before[1], self._levels_below + 1)
        if event.anchor is not None:
            self._sizes[event.anchor] = size
        self._depth, self._levels_below = self._depth - 1, max(siblings, size.levels)
        return node

    def _compose_alias(self, event: yaml.AliasEvent, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        name = str(event.anchor)
        if name in self._sizes:
            self._grow(self._sizes[name], event)
            self._levels_below = max(self._levels_below, self._sizes[name].levels)
        elif name in self.anchors:
            _refuse(f"alias *{name[:MAX_SHOWN_LENGTH]} is inside what it stands for", event)
        return super().compose_node(parent, index)

    def _grow(self, size: _Size, event: Any) -> None:
        """Count what is read, or what an alias stands for. Refuse what is too large before it is built."""
        self._values, self._characters = self._values + size.values, self._characters + size.characters
        written_out = ", aliases written out" if self._sizes else ""
        if self._depth + size.levels > MAX_DEPTH:
            _refuse(f"nested more than {MAX_DEPTH} deep{written_out}", event)
        if self._values > MAX_VALUES:
            _refuse(f"more than {MAX_VALUES} keys and values{written_out}; settings need a few hundred", event)
        if self._characters > MAX_FILE_BYTES:
            _refuse(f"more than {MAX_FILE_BYTES} characters{written_out}; settings need a few thousand", event)


class _Loader(_Strict, yaml.SafeLoader):
    """Reads with PyYAML's own parser, whose messages are the clearer ones."""

    def __init__(self, text: str) -> None:
        yaml.SafeLoader.__init__(self, text)
        _Strict.__init__(self)


# PyYAML can be built without libyaml.
_LIBYAML: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _FastLoader(_Strict, _LIBYAML):  # type: ignore[misc]
    """Reads with libyaml, four times as fast."""

    def __init__(self, text: str) -> None:
        _LIBYAML.__init__(self, text)
        _Strict.__init__(self)


def _check_keys(node: yaml.MappingNode) -> None:
    """Every key is text, and given once."""
    seen: set[str] = set()
    before: tuple[yaml.Node, yaml.Node] | None = None
    for key, value in node.value:
        if key.tag not in (_STR, _MERGE):
            if before is not None and _cut_number(before[1], key) and value.tag == _NULL:
                whole, decimals, name = before[1].value, key.value, before[0].value[:MAX_SHOWN_LENGTH]
                _refuse(f"{name}: {whole},{decimals} has a decimal comma; write {whole}.{decimals}", before[1])
            written = key.value if isinstance(key, yaml.ScalarNode) else "a list or mapping"
            _refuse(
                f"key {written[:MAX_SHOWN_LENGTH] or '(nothing)'} is not text; put it in quotes if it is a name", key
            )
        if key.value in seen:
            _refuse(f"key {shortened(key.value)} is given twice", key)
        seen.add(key.value)
        before = (key, value)


def _check_commas(node: yaml.SequenceNode) -> None:
    """In [0,5, 1] only some numbers have a space between them: 0.5 may be meant."""
    pairs = [(a, b) for a, b in itertools.pairwise(node.value) if a.end_mark.line == b.start_mark.line]
    close = [pair for pair in pairs if _cut_number(*pair) and _gap(*pair) == len(",")]
    if node.flow_style and close and any(_gap(*pair) > len(",") for pair in pairs):
        whole, decimals = (number.value for number in close[0])
        written = f"{whole},{decimals} in a list"
        _refuse(f"{written}: write {whole}.{decimals} for one number, '{whole}, {decimals}' for two", close[0][0])


def _cut_number(left: yaml.Node, right: yaml.Node) -> bool:
    """Whether a comma between two nodes may be meant as a decimal point."""
    scalars = left.tag == _INT and right.tag in (_INT, _FLOAT)
    return scalars and _DECIMAL_COMMA.fullmatch(f"{left.value},{right.value}") is not None


def _gap(left: yaml.Node, right: yaml.Node) -> int:
    """The characters between two nodes."""
    return int(right.start_mark.index - left.end_mark.index)


def decimal_comma_hint(value: object) -> str:
    """What to write instead of a text like '0,5', for the end of a message about it; empty for any other value."""
    if isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value.strip()[:MAX_SHOWN_LENGTH]):
        return f"; write {value.strip().replace(',', '.')}, with a decimal point"
    return ""


def _refuse(problem: str, where: Any) -> NoReturn:
    """Raise an error at an event or a node."""
    raise yaml.MarkedYAMLError(problem=problem, problem_mark=where.start_mark)


def _text(_loader: yaml.SafeLoader, node: yaml.ScalarNode) -> str:
    """Text without characters that control a terminal, and without halves of characters."""
    text = str(node.value)
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") and character not in _ALLOWED_CONTROLS:
            _refuse(f"the character \\u{ord(character):04x} is not allowed in text", node)
    return text


def _whole_number(_loader: yaml.SafeLoader, node: yaml.ScalarNode) -> int:
    if len(node.value) > MAX_DIGITS:
        _refuse(f"{node.value[:MAX_DIGITS]}… is a number of {len(node.value)} digits; at most {MAX_DIGITS}", node)
    return int(node.value)


def _number(_loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    """A number; one too large or too small to be held must not silently become .inf or 0."""
    text = str(node.value)
    if text.lstrip("+-").lower() in (".inf", ".nan"):
        return float(text.replace(".", "", 1))
    number = float(text)
    lost = number == 0 and re.search("[1-9]", re.split("[eE]", text)[0]) is not None
    if math.isinf(number) or lost:
        _refuse(f"{text[:MAX_SHOWN_LENGTH]} is too {'small' if lost else 'large'} a number", node)
    return number


# YAML 1.2's numbers: in PyYAML's YAML 1.1 1e-3 is a string, 075 octal and 1:30 ninety.
_DIGITS = list("-+.0123456789")
for _loader in (_Loader, _FastLoader):
    # Lists become tuples: settings are frozen.
    _loader.add_constructor(
        "tag:yaml.org,2002:seq",
        lambda loader, node: tuple(loader.construct_object(item, deep=True) for item in node.value),
    )
    _loader.add_constructor(_STR, _text)
    _loader.add_constructor(_INT, _whole_number)
    _loader.add_constructor(_FLOAT, _number)
    _loader.yaml_implicit_resolvers = {
        first: [(tag, pattern) for tag, pattern in resolvers if tag in _RESOLVED]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }
    _loader.add_implicit_resolver(_INT, re.compile(r"^[-+]?[0-9]+$"), _DIGITS)
    _loader.add_implicit_resolver(
        _FLOAT,
        re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$|^[-+]?\.(inf|Inf|INF)$|^\.(nan|NaN|NAN)$"),
        _DIGITS,
    )


def read_yaml(path: Path, error_type: type[FatplanError]) -> Any:
    """The content of a YAML file. Raises `error_type` naming the file and, where known, the line."""
    text = _read_text(path, error_type)
    try:
        return _unshared(_load(text))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        position = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise error_type(f"{path}: {position}{error.problem}.") from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        character = f"\\u{ord(text[error.position]):04x}"
        raise error_type(f"{path}: line {line}: the character {character} is not allowed in a file.") from error
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # PyYAML's own: "\UFFFFFFFF"
        raise error_type(f"{path}: is not valid YAML ({error}).") from error


def _load(text: str) -> Any:
    """The content of a text, as `_Loader` reads it. What libyaml refuses is read once more by what says why."""
    if _READ_DIFFERENTLY.isdisjoint(text):
        with suppress(yaml.YAMLError, ValueError, OverflowError):
            return yaml.load(text, Loader=_FastLoader)
    return yaml.load(text, Loader=_Loader)


def _unshared(value: Any) -> Any:
    """The value with a copy of its own for every alias, so that to change one is not to change another."""
    if isinstance(value, dict):
        return {key: _unshared(item) for key, item in value.items()}
    return tuple(map(_unshared, value)) if isinstance(value, tuple) else value


def _read_text(path: Path, error_type: type[FatplanError]) -> str:
    """The text of a file, never more than is allowed: the size that the system reports may be wrong."""
    try:
        if not path.is_file():  # a pipe could make us wait for ever, and a device has no end
            reason = "is not a file" if path.exists() else "No such file"
            raise error_type(f"{path.absolute()}: cannot be read ({reason}).")
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise error_type(f"{path}: cannot be read ({error.strerror}).") from error
    if len(content) > MAX_FILE_BYTES:
        raise error_type(f"{path}: is larger than {MAX_FILE_BYTES} bytes; settings need a few thousand.")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise error_type(f"{path}: line {line}: is not a text file in UTF-8.") from error

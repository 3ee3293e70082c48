"""Reference pages that follow from the program itself, as Markdown: its commands and the keys of experiments."""

from typing import Any

import typer
from typer.cli import get_docs_for_click

from fatigue_planner.cli.main import app
from fatigue_planner.core.settings import Settings

Schema = dict[str, Any]


def commands() -> str:
    """One section per command with its arguments and options, in the order of `fatplan --help`."""
    sections = []
    for name, command in typer.main.get_command(app).commands.items():
        command = command.load() if hasattr(command, "load") else command  # noqa: PLW2901 - commands load when called
        command.epilog = None  # the exit codes, which the page explains once
        context = typer.Context(command, info_name=name)
        sections.append(get_docs_for_click(obj=command, ctx=context, indent=1, name=name, call_prefix="fatplan"))
    return "\n".join(sections)


def keys_of(kind: type[Settings]) -> str:
    """One section per kind of settings with its keys, from the top of a file down."""
    root = kind.model_json_schema()
    definitions = root.get("$defs", {}) | {kind.__name__: root}
    order, sections = [kind.__name__], []
    for name in order:  # grows while it is gone through
        section, named = _settings(name, definitions[name])
        order += [other for other in named if other not in order]
        sections.append(section)
    return "\n".join(sections)


def _settings(name: str, schema: Schema) -> tuple[str, list[str]]:
    """The section of a kind of settings, and the kinds that it names."""
    required = schema.get("required", [])
    lines = [f"## {name}\n", " ".join(schema.get("description", "").split()) + "\n"]
    lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
    named: list[str] = []
    for key, value in schema.get("properties", {}).items():
        default = "required" if key in required else _default(value)
        meaning = " ".join(value.get("description", "").split())
        lines.append(
            "| " + " | ".join(_cell(text) for text in (f"`{key}`", _type(value, named), default, meaning)) + " |"
        )
    return "\n".join(lines) + "\n", named


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _default(value: Schema) -> str:
    default = value.get("default")
    if default is None or isinstance(default, dict | list):
        return "–"
    return f"`{str(default).lower() if isinstance(default, bool) else default}`"


def _type(value: Schema, named: list[str]) -> str:
    """What a key may have as its value, in words; adds the kinds of settings to `named`."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        named.append(name)
        return f"[{name}](#{name.lower()})"
    alternatives = value.get("anyOf") or value.get("oneOf")
    if alternatives:
        return " or ".join(_type(other, named) for other in alternatives if other.get("type") != "null")
    if "enum" in value or "const" in value:
        return " or ".join(f"`{allowed}`" for allowed in value.get("enum", [value.get("const")]))
    kind = value.get("type", "any")
    if kind == "array":
        items = value.get("items") or {"type": "any"}
        return f"list of {_type(items, named)}"
    if kind == "object":
        inner = [*value.get("patternProperties", {}).values(), value.get("additionalProperties")]
        return next((f"by name: {_type(found, named)}" for found in inner if isinstance(found, dict)), "by name")
    return kind + _limits(value)


def _limits(value: Schema) -> str:
    signs = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
    limits = [f"{sign} {value[key]:g}" for key, sign in signs.items() if abs(value.get(key, 1e9)) < 1e9]
    return " " + ", ".join(limits) if limits else ""

"""What a command has found: text for people, or one JSON document for programs (`--json`), on stdout.

Whatever else there is to say goes to stderr (`progress`). The keys of the documents are described in
docs/command-line.md; numbers are in SI units, which their keys end with. What is not there is null.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]


def present(document: Any, text: str, as_json: bool) -> None:
    """Print a command's result, once: `document`, a dataclass, as JSON if the user wants that, else `text`."""
    typer.echo(json_text(document) if as_json else text)


def json_text(value: Any) -> str:
    """Strict JSON: NaN is null, an infinite number the text "Infinity" or "-Infinity"."""
    return json.dumps(_plain(value), indent=1, ensure_ascii=False, allow_nan=False)


def _plain(value: Any) -> Any:
    """JSON values of dataclasses, mappings, sequences, paths and numpy's numbers."""
    if value is None or isinstance(value, str | bool):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Path):
        return str(value)
    number = value.item() if hasattr(value, "item") else value
    if isinstance(number, float) and not math.isfinite(number):
        return None if math.isnan(number) else "Infinity" if number > 0 else "-Infinity"
    if not isinstance(number, bool | int | float | str):
        raise TypeError(f"{type(value).__name__} has no place in a JSON document")
    return number

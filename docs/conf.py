"""How Sphinx builds the documentation: see `make docs`. Nothing is fetched, and every warning is an error."""

import re
import sys
from pathlib import Path

from pydantic import BaseModel
from sphinx.application import Sphinx

from fatigue_planner import __version__
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.station.schema import Station

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import layers  # noqa: E402 - beside this file
import references  # noqa: E402

project = "fatplan"
author = "The fatplan developers"
copyright = "2026, The fatplan developers"
release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["generated/*.md", "build"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # pages that include another one begin below its title

# Docstrings: single backticks are code, and types are shown by their short names.
default_role = "code"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "exclude-members": "model_config"}

html_theme = "furo"
html_title = f"fatplan {release}"
html_show_sourcelink = False
html_static_path: list[str] = []


def _generate(_app: Sphinx) -> None:
    """Write what follows from the sources: the picture of the layers, all commands, all keys of experiments."""
    folder = HERE / "generated"
    folder.mkdir(exist_ok=True)
    (folder / "layers.svg").write_text(layers.picture(), encoding="utf-8")
    (folder / "commands.md").write_text(references.commands(), encoding="utf-8")
    for kind in (Experiment, Station):
        path = folder / f"{kind.__name__.lower()}-keys.md"
        path.write_text(references.keys_of(kind), encoding="utf-8")


FIELD = re.compile(r"([a-z]\w*(?:, [a-z]\w*)*)((?: \([^)]*\))?: .*)")
ARRAY = re.compile(r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[~?(?:numpy\.)?(\w+)\]\]")


def _as_rst(_app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Make reStructuredText of a docstring: text with `code`, indented lines, and fields `name (shape): meaning`."""
    text: list[str] = []
    kind = ""  # of the last line: blank, text, field, block or example
    for line in lines:
        before, words = kind, _escaped(line.strip())
        if not words:
            kind = ""
        elif line.startswith(">>>") or before == "example":
            kind, words = "example", line
        elif field := FIELD.match(line):
            kind, words = "field", f"* ``{field[1]}``{_escaped(field[2])}"
        elif line.startswith(" ") and before == "field":
            kind, words = "field", f"  {words}"
        else:
            kind = "block" if line.startswith(" ") else "text"
        if kind and before and kind != before:
            text.append("")
        text.append(f"   | {words}" if kind == "block" else words)
    lines[:] = text


def _escaped(text: str) -> str:
    """The text without a meaning of *, | and _ outside of `code`."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([*|_])", r"\\\1", part) for part in parts)


def _signature(
    _app: Sphinx, _what: str, _name: str, thing: object, _options: object, signature: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """Shorten the types of arrays; settings have no signature, their keys are listed on a page of their own."""
    if isinstance(thing, type) and issubclass(thing, BaseModel):
        return "", None
    return signature and ARRAY.sub(r"\1 array", signature), result and ARRAY.sub(r"\1 array", result)


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("builder-inited", _generate)
    app.connect("autodoc-process-docstring", _as_rst)
    app.connect("autodoc-process-signature", _signature)

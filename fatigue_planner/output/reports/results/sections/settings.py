"""What the paper fixes and what was chosen, from the comments of the experiment file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.output.reports.html.blocks import Section, Table, Text

_LINE = re.compile(r"^(?P<indent> *)(?:- )?(?P<key>[A-Za-z_][\w.-]*):(?P<value>[^#]*?)(?:\s+#\s*(?P<comment>.*))?$")
_FIXED = re.compile(r"^\[paper (?P<place>[^\]]+)\]\s*(?P<rest>.*)$")
_OPEN = re.compile(r"^open\b[:;,]?\s*(?P<rest>.*)$")


@dataclass(frozen=True)
class Origin:
    """Where a setting comes from: `place` in the paper, or None where the paper leaves it open."""

    key: str
    value: str
    place: str | None
    comment: str


def origins(text: str) -> Iterator[Origin]:
    """The settings of an experiment file that a comment marks `[paper SECTION]` or `open`."""
    above: list[tuple[int, str]] = []
    for line in text.splitlines():
        found = _LINE.match(line)
        if found is None:
            continue
        indent = len(found["indent"])
        above = [(depth, key) for depth, key in above if depth < indent] + [(indent, found["key"])]
        key, value = ".".join(key for _, key in above), found["value"].strip()
        if fixed := _FIXED.match(found["comment"] or ""):
            yield Origin(key, value, fixed["place"], fixed["rest"])
        elif chosen := _OPEN.match(found["comment"] or ""):
            yield Origin(key, value, None, chosen["rest"])


def settings_section(file: Path) -> Section | None:
    """A table of the marked settings; none for a file without marks."""
    found = list(origins(file.read_text(encoding="utf-8")))
    if not found:
        return None
    rows = [[one.key, one.value, f"paper, {one.place}" if one.place else "open", one.comment] for one in found]
    fixed = sum(one.place is not None for one in found)
    return Section(
        "What the paper fixes, and what was chosen",
        [
            Text(
                f"`{file.name}` marks {len(found)} settings or groups of them: {fixed} are the paper's, "
                f"{len(found) - fixed} it leaves open, so that they were chosen."
            ),
            Table("Marked settings, as the file gives them.", ["setting", "value", "from", "comment"], rows),
        ],
    )

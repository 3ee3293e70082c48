"""What the paper fixes and what was chosen, from the comments of the experiment file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData

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


def settings_section(report_data: ReportData, figures: FigureFolder) -> Section | None:
    """A table of the marked settings; none for a file without marks."""
    file = report_data.file
    found = list(origins(file.read_text(encoding="utf-8")))
    if not found:
        return None
    rows = [[each.key, each.value, f"paper, {each.place}" if each.place else "open", each.comment] for each in found]
    fixed = sum(each.place is not None for each in found)
    return Section(
        "What the paper fixes, and what was chosen",
        [
            Text(
                f"`{file.name}` marks {len(found)} settings or groups of settings: {fixed} are the paper's; the "
                f"paper leaves {len(found) - fixed} open, so they were chosen."
            ),
            Table("Marked settings, as the file gives them.", ["setting", "value", "from", "comment"], rows),
        ],
    )

"""The page of a shift, and its data: for one worker, or for five or more together."""

from typing import Any

from fatigue_planner.core.files import publish_text
from fatigue_planner.core.provenance import versions
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import REPORT_FILE, Block, Code, Points, Section, Table, Text, page
from fatigue_planner.output.reports.shift.data import ShiftData, offset, stamp
from fatigue_planner.output.reports.shift.group import group_sections
from fatigue_planner.output.reports.shift.own import own_sections
from fatigue_planner.output.reports.shift.running import running_section

DATA_FILE = "report.json"
IS_NOT = (
    "This is no safety function, no medical finding and no measure of anybody's work. All fatigue is a model's "
    "estimate; no standard gives a limit for it, and none is given here."
)


def shift_report(data: ShiftData, worker: str | None, figures: FigureFolder, command: str) -> dict[str, Any]:
    """Write the report of a worker, or of all together (None), into the folder; what it says, as plain values.

    Raises OutputFolderError.
    """
    if worker is None:
        title = "A shift beside a robot"
        sentences, sections = group_sections(data, figures)
    else:
        title = "Your shift beside a robot"
        sentences, sections = own_sections(data, worker, figures)
    if data.is_rehearsal:
        sentences = ["This was a rehearsal: worker and robot were simulated.", *sentences]
    # few cycles of few workers could be counted from exact fractions
    exactly = bool(sections)
    sections = [*sections, running_section(data, worker, exactly), rests_on(data, command)]
    path = figures.folder / REPORT_FILE
    publish_text(path, page(title, _subtitle(data), [Points([*sentences, IS_NOT])], sections))
    figures.files.append(path)
    return {
        "journal": data.name,
        "fatplan": versions()["fatplan"],
        "rehearsal": data.is_rehearsal,
        "closed": data.record.is_closed,
        "began": stamp(data.record.local(0)),
        "ended": stamp(data.record.local(data.record.lasted_s)),
        "parts": [
            {
                "begun": stamp(data.record.local(part.segment.began_s)),
                "estimates_shown": part.scenario is not None,
                **part.segment.opened.plain(),
            }
            for part in data.parts
        ],
        "statements": sentences,
        "files": [file.name for file in figures.files],
    }


def _subtitle(data: ShiftData) -> str:
    began, ended = data.record.local(0), data.record.local(data.record.lasted_s)
    return (
        f"{began:%d %B %Y}, {began:%H:%M} to {ended:%H:%M} local time ({offset(ended)}). Written by fatplan "
        f"{versions()['fatplan']} from {data.name} alone; no number was typed by hand."
    )


def rests_on(data: ShiftData, command: str) -> Section:
    """With what the shift was begun, and what made the report."""
    rows = []
    for number, part in enumerate(data.parts):
        opened = part.segment.opened
        rows.append(
            [
                str(number + 1), stamp(data.record.local(part.segment.began_s)), opened.scenario_name or "–",
                str(opened.policy.get("kind", "–")), opened.safe_action, opened.versions.get("fatplan", "–"),
                opened.scenario[:16], "yes" if part.scenario else "no: the scenario was another",
            ]
        )  # fmt: skip
    header = ["part", "begun", "condition", "policy", "safe action", "fatplan", "scenario", "estimates shown"]
    caption = (
        "With what the shift was begun. Scenario: the first digits of the digest of task, worker, reactions and belief."
    )
    blocks: list[Block] = [Table(caption, header, rows), Text("This command writes the report again:"), Code(command)]
    if any(part.segment.opened.versions != versions() for part in data.parts):
        blocks.append(
            Text("The journal was written by other versions than this report: estimates may differ in the last digits.")
        )
    return Section("What this rests on", blocks)

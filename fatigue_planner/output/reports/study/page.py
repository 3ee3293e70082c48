"""The page of a sensitivity study."""

from fatigue_planner.core.provenance import versions
from fatigue_planner.output.reports.html.blocks import Block, Code, Section, Text
from fatigue_planner.output.reports.html.page import page
from fatigue_planner.output.reports.study.finished import FinishedStudy
from fatigue_planner.output.reports.study.sections import (
    claims_over_points,
    deciding,
    infeasible,
    lessons,
    over_all_cells,
    tried,
)


def study_page(study: FinishedStudy, command: str) -> str:
    """The page (HTML) of a study in its own folder; `command` makes it."""
    note = study.note
    provenance: list[Block] = [
        Text("This command makes the tables and this page again:"),
        Code(command),
        Text(
            f"Seed {note.seed}; {len(note.reactions)} reactions. Versions, configuration and hashes are in "
            "`manifest.json`."
        ),
    ]
    sections = [
        Section("Which settings decide", deciding(study, "")),
        Section("All conditions and lengths", [over_all_cells(study, "")]),
        claims_over_points(study, ""),
        Section("What was tried", [tried(study, "")]),
        Section("What cannot be performed", infeasible(study, "")),
        Section("Provenance", provenance),
    ]
    subtitle = f"Written by fatplan {versions()['fatplan']} from the tables beside this page; no number is typed."
    title = f"When does planning pay? The study {note.study.name}"
    return page(title, subtitle, [lessons(study)], [section for section in sections if section is not None])

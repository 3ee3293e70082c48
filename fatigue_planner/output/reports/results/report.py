"""The report of an experiment's results: one page a reviewer can check."""

from typing import Protocol

from fatigue_planner.core.provenance import versions
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Points, Section
from fatigue_planner.output.reports.html.page import page
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.actions import actions_section
from fatigue_planner.output.reports.results.sections.claims import claims_section
from fatigue_planner.output.reports.results.sections.fatigue import fatigue_section
from fatigue_planner.output.reports.results.sections.findings import findings
from fatigue_planner.output.reports.results.sections.losses import losses_section
from fatigue_planner.output.reports.results.sections.provenance import provenance_section
from fatigue_planner.output.reports.results.sections.reactions import reactions_section
from fatigue_planner.output.reports.results.sections.returns import returns_section
from fatigue_planner.output.reports.results.sections.sensitivity import sensitivity_section
from fatigue_planner.output.reports.results.sections.settings import settings_section


class SectionWriter(Protocol):
    """What a section is: a function."""

    def __call__(self, report_data: ReportData, figures: FigureFolder) -> Section | None:
        """The section, or None where the data have nothing for it; its figures and tables go to the folder."""


# The sections by name, in the order of the page.
SECTIONS: dict[str, SectionWriter] = {
    "returns": returns_section,
    "losses": losses_section,
    "fatigue": fatigue_section,
    "actions": actions_section,
    "reactions": reactions_section,
    "claims": claims_section,
    "sensitivity": sensitivity_section,
    "settings": settings_section,
    "provenance": provenance_section,
}


def report(report_data: ReportData, figures: FigureFolder) -> str:
    """The page (HTML) of an experiment; its figures and tables go to the folder of figures.

    Raises ClaimsError if claims lie beside the experiment that are about another one.
    """
    _ = report_data.courses  # raises before anything is written if a run does not come to its return
    found = findings(report_data)
    sections = [write(report_data, figures) for write in SECTIONS.values()]
    return page(
        f"Results of the experiment {report_data.experiment.name}",
        f"Written by fatplan {versions()['fatplan']} from {report_data.file.name} and the tables beside this page; no "
        "number was typed by hand.",
        [Points(found)],
        [section for section in sections if section is not None],
    )

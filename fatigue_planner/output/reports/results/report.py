"""The report of an experiment's results: one page a reviewer can check."""

from typing import Protocol, TypeVar

from fatigue_planner.core.errors import FatplanError, PluginError
from fatigue_planner.core.plugins import failure_text, origin_of
from fatigue_planner.core.provenance import versions
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Points, Section, page
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.actions import actions_section
from fatigue_planner.output.reports.results.sections.claims import claims_section
from fatigue_planner.output.reports.results.sections.fatigue import fatigue_section
from fatigue_planner.output.reports.results.sections.findings import findings
from fatigue_planner.output.reports.results.sections.losses import losses_section
from fatigue_planner.output.reports.results.sections.provenance import provenance_section
from fatigue_planner.output.reports.results.sections.reactions import reactions_section
from fatigue_planner.output.reports.results.sections.returns import returns_section
from fatigue_planner.output.reports.results.sections.sensitivity import readings_section, sensitivity_section
from fatigue_planner.output.reports.results.sections.settings import settings_section
from fatigue_planner.output.reports.results.sections.worth import worth_section


class SectionWriter(Protocol):
    """What a section is: a function."""

    __name__: str
    __qualname__: str

    def __call__(self, report_data: ReportData, figures: FigureFolder) -> Section | None:
        """The section, or None where the data have nothing for it; its figures and tables go to the folder."""


# The sections by name, in the order of the page.
SECTIONS: dict[str, SectionWriter] = {
    "worth": worth_section,
    "returns": returns_section,
    "losses": losses_section,
    "fatigue": fatigue_section,
    "actions": actions_section,
    "reactions": reactions_section,
    "claims": claims_section,
    "readings": readings_section,
    "sensitivity": sensitivity_section,
    "settings": settings_section,
    "provenance": provenance_section,
}
# Those that fatplan brings; the others are of plug-ins.
OWN_SECTIONS = frozenset(SECTIONS)

W = TypeVar("W", bound=SectionWriter)


def report_section(write: W) -> W:
    """Decorator of a plug-in's function that writes a section: the report has it under the function's name, at the end.

    The function gets the report's data and the folder of its figures (see `SectionWriter`). Raises PluginError if there
    is another section of this name.

    >>> from fatigue_planner.output.reports.page import Section, Text
    >>> @fp.report_section
    ... def last_cycle(report_data, figures):
    ...     cost = report_data.results.trials["final_cost"].mean()
    ...     return Section("The last cycle", [Text(f"It costs {cost:.4f} on average.")])
    """
    name = write.__name__
    known = SECTIONS.get(name)
    if known is not None and (name in OWN_SECTIONS or origin_of(known) != origin_of(write)):
        raise PluginError(f"{origin_of(write)}: the report section {name!r} is already defined in {origin_of(known)}.")
    SECTIONS[name] = write
    return write


def report(report_data: ReportData, figures: FigureFolder) -> str:
    """The page (HTML) of an experiment; its figures and tables go to the folder of figures.

    Raises ClaimsError if claims lie beside the experiment that are about another one; PluginError if a plug-in's
    section fails.
    """
    _ = report_data.courses  # raises before anything is written if a run does not come to its return
    found = findings(report_data)
    sections = [
        write(report_data, figures) if name in OWN_SECTIONS else _written(name, write, report_data, figures)
        for name, write in SECTIONS.items()
    ]
    return page(
        f"Results of the experiment {report_data.experiment.name}",
        f"Written by fatplan {versions()['fatplan']} from {report_data.file.name} and the tables beside this page; no "
        "number was typed by hand.",
        [Points(found)],
        [section for section in sections if section is not None],
    )


def _written(name: str, write: SectionWriter, report_data: ReportData, figures: FigureFolder) -> Section | None:
    """The section of a plug-in. Raises PluginError if it fails, or returns something else."""
    path = origin_of(write)
    try:
        section = write(report_data, figures)
    except FatplanError:
        raise
    except Exception as error:
        raise PluginError(f"the report section {name!r} of {path}: {failure_text(error, path)}.") from error
    if section is None or isinstance(section, Section):
        return section
    raise PluginError(f"the report section {name!r} of {path}: returned {type(section).__name__}, not a Section.")

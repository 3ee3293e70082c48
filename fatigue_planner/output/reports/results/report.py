"""The report of an experiment's results: one page a reviewer can check."""

from collections.abc import Sequence
from pathlib import Path

from fatigue_planner.core.errors import ClaimsError
from fatigue_planner.core.provenance import versions
from fatigue_planner.experiment.loader import find_shipped
from fatigue_planner.output.reports.html.blocks import Points, Section, counted
from fatigue_planner.output.reports.html.page import page
from fatigue_planner.output.reports.results.figure_folder import FigureFolder
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.actions import actions_section
from fatigue_planner.output.reports.results.sections.claims import claims_section, claims_sentence
from fatigue_planner.output.reports.results.sections.fatigue import fatigue_section
from fatigue_planner.output.reports.results.sections.findings import findings
from fatigue_planner.output.reports.results.sections.losses import losses_section
from fatigue_planner.output.reports.results.sections.provenance import provenance_section
from fatigue_planner.output.reports.results.sections.reactions import reactions_section
from fatigue_planner.output.reports.results.sections.returns import returns_section
from fatigue_planner.output.reports.results.sections.sensitivity import sensitivity_section
from fatigue_planner.output.reports.results.sections.settings import settings_section
from fatigue_planner.output.reports.study.finished import FinishedStudy
from fatigue_planner.study.claims.evaluation import evaluate
from fatigue_planner.study.claims.loader import load_claims


def report(
    report_data: ReportData, figures: FigureFolder, file: Path, commands: Sequence[str], study: FinishedStudy | None
) -> str:
    """The page (HTML) of the experiment in `file`; its figures and tables go to the figures' folder.

    Claims are judged where a file of claims lies beside the experiment's, `<its name>_claims.yaml`; `study` is a
    sensitivity study of the experiment.
    """
    file = find_shipped(file)
    found, claims = findings(report_data), None
    claims_file = file.with_name(f"{file.stem}_claims.yaml")
    if claims_file.exists():
        loaded = load_claims(claims_file)
        if loaded.experiment_file.resolve() != file.resolve():
            raise ClaimsError(f"{claims_file}: experiment: is {loaded.experiment_file}; should be {file.name}.")
        about = loaded.about(report_data.experiment.benchmark)
        if about:
            results, statistics = report_data.results, report_data.experiment.statistics
            judged = evaluate(about, results.trials, results.contrasts, statistics, results.bounds)
            claims = claims_section(judged, claims_file, figures)
            found.append(claims_sentence(judged))
        if left_out := len(loaded.claims) - len(about):
            found.append(f"{counted(left_out, 'claim')} of `{claims_file.name}` not judged: about more than this grid.")
    if study is not None:
        found.append(f"The study `{study.note.study.name}` of other settings: {study.lessons[0]}")
    sections: list[Section | None] = [
        returns_section(report_data, figures),
        losses_section(report_data, figures),
        fatigue_section(report_data, figures),
        actions_section(report_data, figures),
        reactions_section(report_data, figures),
        claims,
        sensitivity_section(study),
        settings_section(file),
        provenance_section(report_data, list(commands), file),
    ]
    return page(
        f"Results of the experiment {report_data.experiment.name}",
        f"Written by fatplan {versions()['fatplan']} from {file.name} and the tables beside this page; no number is "
        "typed.",
        [Points(found)],
        [section for section in sections if section is not None],
    )

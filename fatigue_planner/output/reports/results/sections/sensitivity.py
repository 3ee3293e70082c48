"""The sensitivity study of the experiment, where there is one."""

from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Block, Points, Section, Text
from fatigue_planner.output.reports.html.page import REPORT_FILE
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.study.page import claims_over_points, deciding, over_all_cells

MAX_SETTINGS = 8


def sensitivity_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """What one learns from the study and which settings decide; or the command that makes one."""
    study, title = report_data.study, "When does planning pay? Sensitivity"
    if study is None:
        how = "No sensitivity study of this experiment is among the results; `fatplan sensitivity` makes one."
        return Section(title, [Text(how)])
    where = f"../{study.folder.name}/"
    blocks: list[Block] = [
        Points(study.conclusions),
        *deciding(study, where, MAX_SETTINGS),
        over_all_cells(study, where),
    ]
    claims = claims_over_points(study, where)
    if claims is not None:
        blocks += claims.blocks
    return Section(
        title, [*blocks, Text(f"All settings, their levels and the reasons for them are in `{where}{REPORT_FILE}`.")]
    )

"""The studies of the experiment, where there are some: other readings of a text, and other settings."""

from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import REPORT_FILE, Block, Points, Section, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.study.page import claims_over_points, deciding, over_all_cells
from fatigue_planner.output.reports.study.side_by_side import side_by_side

MAX_SETTINGS = 8


def readings_section(report_data: ReportData, figures: FigureFolder) -> Section | None:
    """What holds under all, some and no readings, and the tables; None without such a study."""
    study = report_data.readings
    if study is None:
        return None
    where = f"../{study.folder.name}/"
    blocks = [block for section in side_by_side(study, where) for block in section.blocks]
    return Section("What holds under other readings of the paper", [Points(study.conclusions), *blocks])


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

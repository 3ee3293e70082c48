"""A paper's claims, one by one."""

from fatigue_planner.core.text import counted, listing
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.claims.evaluation import Evaluation
from fatigue_planner.study.claims.schema import VERDICTS
from fatigue_planner.study.statistics.pairing import records


def claims_section(report_data: ReportData, figures: FigureFolder) -> Section | None:
    """Every claim with its verdicts, the reasons, and the headroom of any policy."""
    evaluation, rows = report_data.claims, []
    if evaluation is None:
        return None
    for claim in records(evaluation.claims):
        asked = claim["relation"].replace("_", " ")
        texts = (claim["reason"], claim["numbers"], claim["room_to_win"])
        told = [text.rstrip(".") for text in texts if text]
        quote = f"“{claim['quote']}”" + (f" (read as: {claim['interpretation']})" if claim["interpretation"] else "")
        rows.append(
            [claim["place"], quote, asked, claim["verdict"], claim["paper_verdict"], ". ".join([*told, ""]).rstrip()]
        )
    caption = (
        f"The claims of `{report_data.claims_file.name}`. The verdict is that of the paired and corrected analysis, "
        "in which equality means a passed test of equivalence; beside it is that of the paper's own test. The "
        "numbers are differences of the returns in % of the cost."
    )
    file_name = figures.add_table("claims", evaluation.claims)
    figures.add_table("claims_detail", evaluation.detail)
    header = ["section", "claim", "asks", "verdict", "paper's test", "why, and numbers"]
    return Section(
        "The paper's claims",
        [Text(claims_sentence(evaluation)), Table(caption, header, rows, file_name)],
    )


def claims_sentence(evaluation: Evaluation) -> str:
    """How many claims have which verdict, by either analysis."""
    table = evaluation.claims
    modern, papers = (
        listing([f"{n} {'is' if n == 1 else 'are'} {v}" for v in VERDICTS for n in [(table[column] == v).sum()]])
        for column in ("verdict", "paper_verdict")
    )
    return (
        f"Of {counted(len(table), 'claim')} of the paper, {modern}; by the paper's own test of the same runs, {papers}."
    )

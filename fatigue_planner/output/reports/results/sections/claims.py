"""A paper's claims, one by one."""

from fatigue_planner.core.text import listing
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.claims.answers import VERDICTS
from fatigue_planner.study.claims.evaluation import Evaluation
from fatigue_planner.study.statistics.pairing import records


def claims_section(report_data: ReportData, figures: FigureFolder) -> Section | None:
    """Every claim with its verdicts; why, and how far any policy could win."""
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
        f"The claims of `{report_data.claims_file.name}`. Verdict: by the paired and corrected analysis, equality by a "
        "test of equivalence; beside it that of the paper's own test. Numbers: difference of the returns in % of the "
        "cost."
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
        listing([f"{(table[column] == verdict).sum()} {verdict}" for verdict in VERDICTS])
        for column in ("verdict", "paper_verdict")
    )
    return f"Of {len(table)} claims of the paper, {modern}; by the paper's own test of the same runs, {papers}."

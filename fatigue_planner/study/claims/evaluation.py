"""What the runs of a benchmark make of claims: pure functions of tables, and the tables for people to read."""

import textwrap
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.claims.analysis import Analysis
from fatigue_planner.study.claims.measurements import Headrooms, Measurements
from fatigue_planner.study.claims.relations import RELATIONS, ClaimJudgement, PairJudgement
from fatigue_planner.study.claims.schema import VERDICTS, Answer, Claim

CLAIMS_FILE = "claims.csv"
DETAIL_FILE = "claims_detail.csv"
INDENT = "    "  # of the lines below a claim's title
MAX_SHOWN = 3  # comparisons whose numbers stand beside a claim

CONTRAST_COLUMNS = [
    "difference", "relative_difference", "t_low", "t_high", "student_p", "paired_p", "holm_p", "equivalence_p"
]  # fmt: skip


class Judgements(NamedTuple):
    """Of a claim: by the paper's own analysis and by the modern one."""

    paper: ClaimJudgement
    modern: ClaimJudgement


@dataclass(frozen=True)
class Evaluation:
    """One row per claim (`_claims_table`), and one per comparison a claim consists of (`_detail_table`)."""

    claims: pd.DataFrame
    detail: pd.DataFrame


def evaluate(
    claims: Mapping[str, Claim],
    trials: pd.DataFrame,
    contrasts: pd.DataFrame,
    settings: StatisticsSettings,
    bounds: pd.DataFrame | None = None,
) -> Evaluation:
    """All there is to say of the claims.

    trials: the table of a benchmark; contrasts: of these trials; bounds: the costs no policy can beat (columns
    condition, n_cycles, cost_bound).
    """
    measurements = Measurements(trials, contrasts)
    judgements = _judge(claims, measurements, settings)
    headrooms = None if bounds is None else Headrooms(bounds, measurements, settings)
    return Evaluation(
        _claims_table(claims, judgements, measurements, headrooms), _detail_table(judgements, measurements, headrooms)
    )


def judge_claims(
    claims: Mapping[str, Claim], trials: pd.DataFrame, contrasts: pd.DataFrame, settings: StatisticsSettings
) -> dict[str, Judgements]:
    """The judgements alone, by claim: milliseconds."""
    return _judge(claims, Measurements(trials, contrasts), settings)


def _judge(
    claims: Mapping[str, Claim], measurements: Measurements, settings: StatisticsSettings
) -> dict[str, Judgements]:
    paper, modern = (
        Analysis(measurements, settings.significance_level, settings.equivalence_margin, modern)
        for modern in (False, True)
    )
    return {
        name: Judgements(*(RELATIONS[claim.relation].judge(claim, analysis) for analysis in (paper, modern)))
        for name, claim in claims.items()
    }


def _claims_table(
    claims: Mapping[str, Claim],
    judgements: Mapping[str, Judgements],
    measurements: Measurements,
    headrooms: Headrooms | None,
) -> pd.DataFrame:
    """One row per claim; lists are joined by blanks. room_to_win is empty where the claim is reproduced."""
    rows = []
    for name, claim in claims.items():
        paper, modern = judgements[name]
        unshown = RELATIONS[claim.relation].superiority and modern.answer is not Answer.HOLDS
        rows.append(
            {
                "claim": name,
                "place": claim.place,
                "quote": claim.quote,
                "interpretation": claim.interpretation,
                "conditions": " ".join(claim.conditions),
                "n_cycles": " ".join(map(str, claim.n_cycles)),
                "relation": claim.relation,
                "policies": " ".join(claim.policies),
                "others": " ".join(claim.others),
                "paper_verdict": paper.answer.verdict,
                "paper_reason": paper.reason,
                "verdict": modern.answer.verdict,
                "reason": modern.reason,
                "numbers": _numbers(claim, modern.decisive, measurements),
                "room_to_win": _headroom_text(modern.decisive, headrooms) if unshown else "",
            }
        )
    return pd.DataFrame(rows)


def _detail_table(
    judgements: Mapping[str, Judgements], measurements: Measurements, headrooms: Headrooms | None
) -> pd.DataFrame:
    """One row per comparison of a claim.

    Columns besides the answers: those of the contrast; largest_win and needed_win: as fractions of the second policy's
    mean cost (`measurements.Headroom`), where there is a bound.
    """
    rows = []
    for name, (paper, modern) in judgements.items():
        for old, new in zip(paper.parts, modern.parts, strict=True):
            measured = measurements.measured(new.pair)
            headroom = None if headrooms is None else headrooms.over_second(new.pair)
            contrast = {} if isinstance(measured, str) else vars(measured.contrast)
            rows.append(
                {"claim": name, **vars(new.pair)}
                | {"paper_answer": old.answer.value, "paper_reason": old.reason}
                | {"answer": new.answer.value, "reason": new.reason}
                | {column: contrast.get(column) for column in CONTRAST_COLUMNS}
                | {"largest_win": headroom and headroom.largest, "needed_win": headroom and headroom.needed}
            )
    return pd.DataFrame(rows)


def _numbers(claim: Claim, decisive: Sequence[PairJudgement], measurements: Measurements) -> str:
    several = len(claim.cells()) > 1
    shown = []
    for part in decisive[:MAX_SHOWN]:
        measured = measurements.measured(part.pair)
        if not isinstance(measured, str):
            cell = f"{part.pair.condition}, {part.pair.n_cycles} cycles: " if several else ""
            shown.append(cell + measured.numbers())
    more = len(decisive) - MAX_SHOWN
    return "; ".join(shown) + (f"; and {more} more" if shown and more > 0 else "")


def _headroom_text(decisive: Sequence[PairJudgement], headrooms: Headrooms | None) -> str:
    """Over the policies of the strongest comparisons, each once in every condition and length."""
    if headrooms is None:
        return "not known: no bounds.csv"
    found: dict[tuple[str, int, str], str] = {}
    for part in decisive:
        pair, headroom = part.pair, headrooms.over_second(part.pair)
        if headroom is not None:
            cell = f"{pair.condition}, {pair.n_cycles} cycles"
            found.setdefault((*pair.cell, pair.second), f"{cell}: {headroom.in_words(pair.second)}")
    return ". ".join(list(found.values())[:MAX_SHOWN]) or "not known: no bound for these conditions"


def claims_text(table: pd.DataFrame, width: int) -> str:
    """The table of `tables.claims_table`, a block per claim, wrapped to a width in characters; counts come last."""
    blocks = [_block(row, width) for row in table.to_dict("records")]
    return "\n\n".join([*blocks, _counts(table)]) + "\n"


def _block(row: Mapping[Hashable, Any], width: int) -> str:
    title = f"{row['claim']} (section {row['place']}): {row['verdict'].upper()}; by the paper's own test "
    lines = [
        f"“{row['quote']}”",
        f"Read as: {row['interpretation']}" if row["interpretation"] else "",
        f"{row['relation']}: {_listed(row['policies'])}{_others(row)}",
        f"Why: {row['reason']}.",
        f"Numbers (difference of the returns in % of the cost): {row['numbers']}." if row["numbers"] else "",
        f"Paper's own test: {row['paper_reason']}." if row["paper_reason"] != row["reason"] else "",
        f"Headroom: {row['room_to_win']}." if row["room_to_win"] else "",
    ]
    wrapped = [_wrap(title + row["paper_verdict"], width, "")]
    wrapped += [_wrap(line, width, INDENT) for line in lines if line]
    return "\n".join(wrapped)


def _wrap(line: str, width: int, indent: str) -> str:
    together = line.replace(" %", "\u00a0%")  # a no-break space, so that no number loses its unit
    return textwrap.fill(
        together, width, initial_indent=indent, subsequent_indent=INDENT, break_on_hyphens=False, break_long_words=False
    )


def _others(row: Mapping[Hashable, Any]) -> str:
    against = f" | {_listed(row['others'])}" if row["others"] else ""
    return f"{against} ({_listed(row['conditions'])}; {_listed(row['n_cycles'])} cycles)"


def _listed(names: str) -> str:
    return ", ".join(names.split())


def _counts(table: pd.DataFrame) -> str:
    return (
        f"{len(table)} claims: {_count(table['verdict'])}.\nBy the paper's own test of the same runs: "
        f"{_count(table['paper_verdict'])}."
    )


def _count(verdicts: pd.Series) -> str:
    counts = verdicts.value_counts()
    return ", ".join(f"{counts.get(name, 0)} {name}" for name in VERDICTS)

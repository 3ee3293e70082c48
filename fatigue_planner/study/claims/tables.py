"""What was found of the claims as tables."""

from collections.abc import Mapping

import pandas as pd

from fatigue_planner.study.claims.answers import Answer
from fatigue_planner.study.claims.headroom import Rooms
from fatigue_planner.study.claims.measurements import Comparison, Measurements
from fatigue_planner.study.claims.relations.registry import RELATIONS
from fatigue_planner.study.claims.relations.relation import Finding, Part
from fatigue_planner.study.claims.schema import Claim

CLAIMS_FILE = "claims.csv"
DETAIL_FILE = "claims_detail.csv"
MAX_SHOWN = 3  # comparisons whose numbers stand beside a claim

CONTRAST_COLUMNS = [
    "difference", "relative_difference", "t_low", "t_high", "student_p", "paired_p", "holm_p", "equivalence_p"
]  # fmt: skip
Findings = Mapping[str, tuple[Finding, Finding]]  # by claim: of the paper's own analysis and of the modern one


def claims_table(
    claims: Mapping[str, Claim], findings: Findings, measurements: Measurements, rooms: Rooms | None
) -> pd.DataFrame:
    """One row per claim; lists are joined by blanks. room_to_win is empty where the claim is reproduced."""
    rows = []
    for name, claim in claims.items():
        paper, modern = findings[name]
        relation = RELATIONS[claim.relation]
        unshown = modern.decisive if relation.superiority and modern.answer is not Answer.HOLDS else ()
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
                "room_to_win": _rooms_told(unshown, rooms),
            }
        )
    return pd.DataFrame(rows)


def detail_table(findings: Findings, measurements: Measurements, rooms: Rooms | None) -> pd.DataFrame:
    """One row per comparison of a claim.

    Columns besides the answers: those of the contrast; largest_win and needed_win: shares of the second policy's mean
    cost (`room.Room`), where there is a bound.
    """
    rows = []
    for name, (paper, modern) in findings.items():
        for old, new in zip(paper.parts, modern.parts, strict=True):
            comparison = measurements.compare(new.pair)
            room = None if rooms is None else rooms.over_second(new.pair)
            contrast = {} if isinstance(comparison, str) else vars(comparison.contrast)
            rows.append(
                {"claim": name, **vars(new.pair)}
                | {"paper_answer": old.judgement.answer.value, "paper_reason": old.judgement.reason}
                | {"answer": new.judgement.answer.value, "reason": new.judgement.reason}
                | {column: contrast.get(column) for column in CONTRAST_COLUMNS}
                | {"largest_win": room.largest if room else None, "needed_win": room.needed if room else None}
            )
    return pd.DataFrame(rows)


def _numbers(claim: Claim, decisive: tuple[Part, ...], measurements: Measurements) -> str:
    several = len(claim.places()) > 1
    shown = []
    for part in decisive[:MAX_SHOWN]:
        comparison = measurements.compare(part.pair)
        if isinstance(comparison, Comparison):
            place = f"{part.pair.condition}, {part.pair.n_cycles} cycles: " if several else ""
            shown.append(place + comparison.numbers())
    more = len(decisive) - MAX_SHOWN
    return "; ".join(shown) + (f"; and {more} more" if shown and more > 0 else "")


def _rooms_told(unshown: tuple[Part, ...], rooms: Rooms | None) -> str:
    """Over the policies of the strongest comparisons, each once in every condition and length."""
    if not unshown:
        return ""
    if rooms is None:
        return "not known: no bounds.csv"
    found: dict[tuple[str, int, str], str] = {}
    for part in unshown:
        pair, room = part.pair, rooms.over_second(part.pair)
        if room is not None:
            place = f"{pair.condition}, {pair.n_cycles} cycles"
            found.setdefault((pair.condition, pair.n_cycles, pair.second), f"{place}: {room.told(pair.second)}")
    return ". ".join(list(found.values())[:MAX_SHOWN]) or "not known: no bound for these conditions"

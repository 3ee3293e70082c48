"""The files of an assessment: everything as JSON, outcomes and indicators as tables."""

from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import pandas as pd

from fatigue_planner.core.files import publish_csv, publish_text
from fatigue_planner.core.settings import Settings
from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.station.assessment import Doing, StationAssessment
from fatigue_planner.station.robot_reach import ruled_out

INDICATOR_COLUMNS = [
    *Doing._fields, "indicator", "edition", "applies", "low", "high", "unit", "level_low", "level_high",
    "not_acceptable_s", "worst_time_s", "worst_part", "undecided", "text",
]  # fmt: skip
ASSESSMENT, PLACES, OUTCOMES, INDICATORS = "assessment.json", "places.csv", "outcomes.csv", "indicators.csv"


def write(assessment: StationAssessment, folder: Path, json_text: str) -> list[Path]:
    """The files in a folder. Raises OutputFolderError if they cannot be written."""
    files = [folder / name for name in (ASSESSMENT, PLACES, OUTCOMES, INDICATORS)]
    publish_text(files[0], json_text + "\n")
    publish_csv(files[1], pd.DataFrame(place_rows(assessment)))
    publish_csv(files[2], pd.DataFrame(outcome_rows(assessment)))
    publish_csv(files[3], pd.DataFrame(indicator_rows(assessment), columns=INDICATOR_COLUMNS))
    return files


def plain(value: Any) -> Any:
    """An assessment, or a part of it, as JSON values: phrases with their text, judgements in words."""
    if isinstance(value, Phrase):
        return {"key": value.template, "values": dict(value.values), "text": str(value)}
    if isinstance(value, Judgement | Settings):
        return value.plain()
    if isinstance(value, Enum):
        return value.name.lower()
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {name: plain(item) for name, item in value._asdict().items()}
    if isinstance(value, dict):
        return {key if isinstance(key, str) else "/".join(key): plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def place_rows(assessment: StationAssessment) -> Iterator[dict[str, Any]]:
    """One row per place of an operation, a map: where it is, who reaches it, how it is judged, how it tires."""
    robot = {} if assessment.robot is None else ruled_out(assessment.robot.places)
    for each in assessment.summaries:
        at = assessment.station.places[each.place]
        yield {
            "operation": each.operation,
            "place": each.place,
            "x_m": at.x,
            "y_m": at.y,
            "z_m": at.z,
            "reached_by": _joined(each.reached_by),
            "missed_by": _joined(each.missed_by),
            "level": "" if each.level is None else each.level.words,
            "by": _joined(rule.kind for rule in each.by),
            "warned_by": _joined(rule.kind for rule in each.warned_by),
            "highest_fatigue": each.peak,
            "most_tired_entry": each.entry,
            "fatigue_cost": each.cost,
            "left_out_by_robot": str(robot.get((each.operation, each.place), "")),
            "recommended": assessment.best.places.get(each.operation) == each.place,
        }


def outcome_rows(assessment: StationAssessment) -> Iterator[dict[str, Any]]:
    """One row per motion: what became of it."""
    for each in assessment.outcomes:
        yield {
            **each.doing._asdict(),
            "hands": "+".join(each.hands),
            "outcome": each.kind,
            "missed_m": each.missed_m,
            "too_weak_joint": each.joint,
            "largest_load_share": each.load_share,
            "largest_load_joint": each.load_joint,
            "implausible": _joined(finding.text for finding in each.findings),
            "limits_broken": _joined(f"{breach.limit + 1} ({breach.seconds:.1f} s)" for breach in each.breaches),
            "detail": each.detail,
        }


def indicator_rows(assessment: StationAssessment) -> Iterator[dict[str, Any]]:
    """One row per motion that may be used and indicator, then the whole cycles; no row says `cycle` for a place."""
    for each in assessment.judged:
        for judgement in each.judgements.values():
            yield {**each.doing._asdict(), **_judgement(judgement)}
    for cycle in assessment.cycles:
        for judgement in cycle.judgements.values():
            whole = {"worker": cycle.worker, "operation": "whole cycle", "place": "", "way": ""}
            yield {**whole, **_judgement(judgement)}


def _judgement(judgement: Judgement) -> dict[str, Any]:
    value, levels, times, worst = judgement.value, judgement.levels, judgement.times, judgement.worst
    return {
        "indicator": judgement.indicator,
        "edition": judgement.edition,
        "applies": judgement.applies,
        "low": value.low if value else None,
        "high": value.high if value else None,
        "unit": judgement.unit,
        "level_low": levels[0].words if levels else "",
        "level_high": levels[1].words if levels else "",
        "not_acceptable_s": times.not_acceptable_s if times else None,
        "worst_time_s": worst.time_s if worst else None,
        "worst_part": f"{worst.side} {worst.part}".strip() if worst else "",
        "undecided": _joined(decides.key for decides in judgement.decides),
        "text": judgement.text(),
    }


def _joined(texts: Iterable[str]) -> str:
    return "; ".join(texts)

"""What was found of a population, kept beside the motions: asked again only where something that decides it changed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import (
    DIGEST_LENGTH,
    digest_of,
    digest_of_package,
    publish_with_checksum,
    read_with_checksum,
)
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.reactions.key import NUMERICAL_LIBRARIES
from fatigue_planner.station.assessment import ReachShare
from fatigue_planner.station.population_reach import MEDIAN, Question, answered, questions, requests_of
from fatigue_planner.station.schema import Station

# What decides an answer besides what is asked: rooms of this package. What an experiment's file may say of planning
# does not.
SOURCES = ("core", "ergonomics", "experiment", "fatigue", "human", "motion", "reactions", "station")
FOLDER = "population"
_KEPT = TypeAdapter(ReachShare)


def reach_shares(
    station: Station, cache: Path, executor: Executor, progress: Callable[[], None] = lambda: None
) -> list[ReachShare]:
    """Who reaches every place of every operation, found in a folder of the cache or by trying.

    `progress` hears of every question that is answered. Raises OutputFolderError if the folder cannot be written.
    """
    asked = list(questions(station))
    keys = list(map(key, asked))
    files = [cache / FOLDER / f"{digest_of(each)[:DIGEST_LENGTH]}.json" for each in keys]
    found = {index: share for index, share in enumerate(map(_read, asked, keys, files)) if share is not None}
    for _ in found:
        progress()
    missing = [index for index in range(len(asked)) if index not in found]
    for number, share in executor.run(answered, [asked[index] for index in missing]):
        progress()
        if not isinstance(share, Lost):
            index = missing[number]
            found[index] = share
            publish_with_checksum(files[index], {"key": keys[index], "share": _KEPT.dump_python(share)})
    return [found[index] for index in sorted(found)]


def key(question: Question) -> dict[str, Any]:
    """All that decides an answer, as JSON values: what a worker of the median stature would do, of whom, by what.

    How operations, places and tools are called decides nothing.
    """
    return {
        "motions": [request.digest for request in requests_of(question, question.stature(MEDIAN))],
        "loaded": question.is_loaded,
        "sex": question.sex,
        "people": question.people.plain() if question.people else None,
        "sources": digest_of_package(*SOURCES),
        "versions": versions_of(*NUMERICAL_LIBRARIES),
    }


def _read(question: Question, wanted: dict[str, Any], file: Path) -> ReachShare | None:
    """What is kept of a question; None if there is nothing, or it is not what was written."""
    content = read_with_checksum(file) if file.is_file() else None
    if content is None or content.get("key") != wanted:
        return None
    try:
        share = _KEPT.validate_python(content["share"])
    except (ValidationError, KeyError):
        return None
    return replace(share, operation=question.operation, place=question.place)

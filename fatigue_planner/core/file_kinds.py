"""The kinds of files that users write, and which of them a file is."""

import shlex
from enum import StrEnum
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import FatplanError


class FileKind(StrEnum):
    """A kind of file."""

    EXPERIMENT = "experiment"
    CLAIMS = "claims"
    STUDY = "study"
    STATION = "station"
    LINE = "line"


# By kind, in the order of search: its keys, of which only such a file has the first; what it is in words; one that
# ships; the commands for it. A study may have claims, too.
_ABOUT = {
    FileKind.STUDY: (("factors",), "a study", "sensitivity", "`fatplan sensitivity`"),
    FileKind.CLAIMS: (("experiment", "claims"), "a file of claims", "paper_claims", "`fatplan claims`"),
    FileKind.LINE: (("crew", "stations"), "a line", "trim_line", "`fatplan rotate`"),
    FileKind.STATION: (("operations",), "a station", "car_line", "`fatplan assess` and `schedule`"),
    FileKind.EXPERIMENT: (("actions",), "an experiment", "paper", "`fatplan simulate`, `benchmark` and `report`"),
}


def kind_of(content: Any) -> FileKind:
    """The kind of a file's content, by its keys; an experiment if it has none of them."""
    known = content if isinstance(content, dict) else {}
    return next((kind for kind, (keys, *_) in _ABOUT.items() if not known.keys().isdisjoint(keys)), FileKind.EXPERIMENT)


def mapping_of_kind(path: Path, content: Any, kind: FileKind, error_type: type[FatplanError]) -> dict[str, Any]:
    """The content of a file of settings.

    Raises `error_type` if it is no mapping, or lacks the key of its kind and has that of another.
    """
    keys, words, example, _ = _ABOUT[kind]
    if not isinstance(content, dict):
        raise error_type(f"{path}: is not a mapping of settings; see experiments/{example}.yaml for an example.")
    found = kind_of(content)
    found_keys, found_words, _, commands = _ABOUT[found]
    if found is not kind and keys[0] not in content and not content.keys().isdisjoint(found_keys):
        wanted = f"{path}: is {found_words}, not {words}; it is for {commands}."
        if (found, kind) == (FileKind.STATION, FileKind.EXPERIMENT):
            wanted += (
                f" `fatplan assess {shlex.quote(str(path))} --explain --output DIR` writes the experiments it becomes."
            )
        raise error_type(wanted)
    return content

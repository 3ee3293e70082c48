"""What is on disk after a run, however it ended."""

import json
from pathlib import Path

import pandas as pd

from fatigue_planner.core.files import read_with_checksum
from fatigue_planner.reactions.cache import ReactionCache

# Wall-clock times, which are never the same twice.
TIMES = "planning_times.csv"


def visible(folder: Path) -> dict[str, bytes]:
    """What users and later runs see, times aside: parts and bounds hold them, too."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        if path.name.startswith(".") or path.name == TIMES:
            continue
        content = path.read_bytes()
        if path.parent.parent.name in ("parts", "bounds"):
            rows = json.loads(content)["trials"]
            kept = [
                {key: value for key, value in row.items() if not key.endswith("time_s") and key != "seconds"}
                for row in rows
            ]
            content = json.dumps(kept).encode()
        found[str(path.relative_to(folder))] = content
    return found


def assert_whole(folder: Path) -> None:
    """Every visible file is whole: entries by their seals, parts and bounds by theirs, tables by being one."""
    for path in folder.rglob("*"):
        if path.is_dir() or path.name.startswith("."):
            continue
        assert "damaged" not in path.name, path
        if path.suffix == ".h5":
            ReactionCache(path.parent).read(path)
        elif path.parent.name == "bounds" or path.parent.parent.name == "parts":
            assert read_with_checksum(path) is not None, path
        elif path.suffix == ".csv":
            assert path.read_bytes().endswith(b"\n") and len(pd.read_csv(path)), path
        elif path.suffix == ".json":
            json.loads(path.read_bytes())
        else:
            assert path.name in {"summary.txt", "experiment.yaml"} and path.read_bytes().endswith(b"\n"), path

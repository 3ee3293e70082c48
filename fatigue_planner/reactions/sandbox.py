"""The contents of HDF5 files, read by a process of its own: see `sandboxed_reader`."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.reading_process import Array, ReadingProcess

SCRIPT = Path(__file__).with_name("sandboxed_reader.py")
# CPU time of the reading process, so that neither a busy machine nor a stopped program makes a file unreadable.
MAX_SECONDS = 30


@dataclass(frozen=True)
class Layout:
    """What a file holds.

    datasets: name -> type ("f8", "i8", "S" for text) and shape, in which None stands for the number of rows
    most_rows: the most that any dataset has; most_text: the most bytes of a text
    """

    datasets: Mapping[str, tuple[str, tuple[int | None, ...]]]
    most_rows: int
    most_text: int


# No filter is looked for on the disk.
_READER = ReadingProcess(SCRIPT, "stored reactions", {"HDF5_PLUGIN_PRELOAD": "::"})


def read_hdf5(content: bytes, layout: Layout) -> dict[str, Array]:
    """The datasets of an HDF5 file's content, by name; what else is in it is not looked at.

    Raises UnreadableError if it is not of the layout, refers to other files, declares more than the layout allows, or
    makes HDF5 crash or go on for ever; ReaderError if the process that reads cannot be started.
    """
    request = {
        "datasets": dict(layout.datasets), "most_rows": layout.most_rows, "most_text": layout.most_text,
        "most_seconds": MAX_SECONDS,
    }  # fmt: skip
    _, arrays = _READER.read(content, request)
    return dict(zip(layout.datasets, arrays, strict=True))

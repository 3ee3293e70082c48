"""One look for all figures, and the folder they are saved in with their data, the same bytes every time."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.files import publish, publish_csv

# Okabe & Ito's palette, told apart by the colour-blind; markers tell apart without colour.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "D", "^", "v", "P", "X")
LINES = ("-", "--", "-.", ":")

SETTINGS: Any = {
    "figure.dpi": 100,
    "savefig.dpi": 200,
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "fatplan",
    "svg.fonttype": "path",  # looks the same where the font is not installed
}


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure in the common style, apart from matplotlib's global state."""
    mpl.rcParams.update(SETTINGS)
    return Figure(figsize=(width_in, height_in), layout="constrained")


def look(place: int) -> tuple[str, str]:
    """Marker and colour of the policy at a place of the experiment's order; both tell it apart."""
    return MARKERS[place % len(MARKERS)], COLOURS[(place + place // len(MARKERS)) % len(COLOURS)]


def publish_png(path: Path, figure: Figure) -> None:
    """Publish a figure as PNG, the same bytes every time."""
    publish(path, lambda temporary: figure.savefig(temporary, metadata={"Software": "fatplan"}, bbox_inches="tight"))


@dataclass(frozen=True)
class Picture:
    """A figure: its SVG, what it shows, the same in words for those who cannot see it, and the file of its data."""

    svg: str
    caption: str
    alternative: str
    data_file: str


class FigureFolder:
    """Saves figures and tables into a folder, and remembers the files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: list[Path] = []

    def add(self, name: str, figure: Figure, data: pd.DataFrame, caption: str = "", alternative: str = "") -> Picture:
        """Publish name.png, name.svg and the data behind them; returns the picture as a page shows it.

        Raises OutputFolderError.
        """
        png, svg = self.folder / f"{name}.png", self.folder / f"{name}.svg"
        publish_png(png, figure)
        metadata = {"Date": None, "Creator": "fatplan"}
        publish(svg, lambda path: figure.savefig(path, metadata=metadata, bbox_inches="tight"))
        self.files += [png, svg]
        return Picture(svg.read_text(encoding="utf-8"), caption, alternative, self.add_table(name, data))

    def add_table(self, name: str, data: pd.DataFrame) -> str:
        """Publish a table as CSV; returns the file's name. Raises OutputFolderError."""
        path = self.folder / f"{name}.csv"
        publish_csv(path, data)
        self.files.append(path)
        return path.name

"""One look for all figures, and the folder they are saved in with their data, the same bytes every time."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from fatigue_planner.core.files import publish, publish_csv
from fatigue_planner.core.text import format_label

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


@contextmanager
def house_style() -> Iterator[None]:
    """The common style in place of all that matplotlib was set to, which is set again afterwards.

    Also a decorator. Matplotlib reads settings while a figure is made and while it is saved, so both are done in it.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(SETTINGS)
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure, to be filled and saved in the house style."""
    assert mpl.rcParams["svg.hashsalt"] == SETTINGS["svg.hashsalt"], "a figure is made in house_style()"
    return Figure(figsize=(width_in, height_in), layout="constrained")


def wrapped(text: str, width_in: float, size_pt: float) -> str:
    """A title broken into lines that are no wider than this, of as many words each as fit."""
    font = FontProperties(size=size_pt)
    for columns in range(len(text), 1, -1):
        lines = textwrap.wrap(text, columns, break_on_hyphens=False)
        widths_pt = (text_to_path.get_text_width_height_descent(line, font, False)[0] for line in lines)
        if max(widths_pt) <= 72 * width_in:
            return "\n".join(lines)
    return text


def set_title(axes: Axes, text: str, size_pt: float = SETTINGS["axes.titlesize"]) -> None:
    """Give a panel of a grid a title that does not run into its neighbours'."""
    specification, figure = axes.get_subplotspec(), axes.get_figure(root=True)
    assert specification is not None and figure is not None
    # a quarter is for labels between the panels
    width_in = 0.75 * float(figure.get_size_inches()[0]) / specification.get_gridspec().ncols
    axes.set_title("\n".join(wrapped(line, width_in, size_pt) for line in text.splitlines()), fontsize=size_pt)


def look(index: int) -> tuple[str, str]:
    """Marker and colour of the policy with this index in the experiment's order; either tells it apart."""
    return MARKERS[index % len(MARKERS)], COLOURS[(index + index // len(MARKERS)) % len(COLOURS)]


def mark_policies(
    axes: Axes, shown: Sequence[str], policies: Sequence[str], marks: Mapping[str, tuple[float, Any]]
) -> None:
    """Give every policy shown a row, in it its mark: where it is, and how far its bar reaches (see `errorbar`)."""
    for index, policy in enumerate(shown):
        if policy in marks:
            (centre, error), (marker, colour) = marks[policy], look(list(policies).index(policy))
            axes.errorbar(centre, index, xerr=error, fmt=marker, color=colour, capsize=2.5, markersize=4.5)
    axes.set_yticks(range(len(shown)), [format_label(policy) for policy in shown])
    axes.set_ylim(len(shown) - 0.5, -0.5)


@house_style()
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

    @house_style()
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

"""One look for all figures, and saving them with their data, the same bytes every time."""

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


def save_figure(folder: Path, name: str, figure: Figure, data: pd.DataFrame) -> list[Path]:
    """Publish name.png, name.svg and the data behind them as name.csv; returns the paths."""
    paths = [folder / f"{name}.{kind}" for kind in ("png", "svg", "csv")]
    publish_png(paths[0], figure)
    publish(
        paths[1], lambda path: figure.savefig(path, metadata={"Date": None, "Creator": "fatplan"}, bbox_inches="tight")
    )
    publish_csv(paths[2], data)
    return paths

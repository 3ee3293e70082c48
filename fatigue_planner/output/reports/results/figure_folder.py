"""The figures of a results folder, saved as they are made."""

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.files import publish_csv
from fatigue_planner.output.figures.style import save_figure
from fatigue_planner.output.reports.html.blocks import Picture


class FigureFolder:
    """Saves figures and tables into a folder, and remembers the files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: list[Path] = []

    def add(self, name: str, figure: Figure, data: pd.DataFrame, caption: str, alternative: str) -> Picture:
        """Save a figure with its data; returns it as a page shows it. Raises OutputFolderError."""
        paths = save_figure(self.folder, name, figure, data)
        self.files += paths
        svg = next(path for path in paths if path.suffix == ".svg")
        return Picture(svg.read_text(encoding="utf-8"), caption, alternative, f"{name}.csv")

    def add_table(self, name: str, data: pd.DataFrame) -> str:
        """Save a table as CSV; returns the file's name. Raises OutputFolderError."""
        path = self.folder / f"{name}.csv"
        publish_csv(path, data)
        self.files.append(path)
        return path.name

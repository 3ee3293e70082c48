"""`fatplan compare`: two results folders side by side."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A results folder.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another results folder.")],
    save: Annotated[
        Path | None, typer.Option("--save", help="Also save a page (.html), with its table as CSV beside it.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Compare two results folders, A and B: their settings, their versions and the return of every policy.

    Each policy of A is compared with the same policy of B, run by run.
    """
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.results.compare import compare as compared
    from fatigue_planner.output.reports.results.compare import compare_page, compare_text
    from fatigue_planner.study.statistics.pairing import records

    if save is not None and save.suffix.lower() != ".html":
        raise SelectionError(f"--save {save}: the name must end in .html.")
    found = compared(first, second)
    text, files = compare_text(found), []
    if save is not None:
        figures = FigureFolder(writable_folder(save.parent))
        publish_text(save, compare_page(found, figures, save.stem))
        files = [save, *figures.files]
        text += "\n" + ", ".join(map(str, files))
    document = {
        "folders": found.names,
        "settings": found.settings,
        "versions": found.versions,
        "only": found.only,
        "same_worlds": found.same_worlds,
        "contrasts": records(found.contrasts),
        "files": files,
    }
    options.present(document, text, as_json)

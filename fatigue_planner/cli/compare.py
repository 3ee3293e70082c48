"""`fatplan compare`: two results folders side by side."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.errors import SelectionError
from fatigue_planner.files import publish_text, writable_folder


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A results folder.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another one.")],
    save: Annotated[
        Path | None, typer.Option("--save", help="Also save a page (.html), with its table as CSV beside it.")
    ] = None,
) -> None:
    """Set two results folders, A and B, side by side: settings, versions and the return of every policy in both.

    Each policy of A is compared with the same policy of B, run by run.
    """
    from fatigue_planner.reports.results.compare import compare as compared  # noqa: PLC0415 - loads matplotlib
    from fatigue_planner.reports.results.compare import compare_page, compare_text  # noqa: PLC0415
    from fatigue_planner.reports.results.gallery import Gallery  # noqa: PLC0415

    if save is not None and save.suffix.lower() != ".html":
        raise SelectionError(f"--save {save}: the name must end in .html.")
    found = compared(first, second)
    typer.echo(compare_text(found))
    if save is not None:
        gallery = Gallery(writable_folder(save.parent))
        publish_text(save, compare_page(found, gallery, save.stem))
        typer.echo(f"{save}, {gallery.files[0]}")

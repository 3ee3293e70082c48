"""`fatplan compare`: two results folders, or two assessments of a station, side by side."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A results folder, or that of a station: before.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another of the same kind: after.")],
    save: Annotated[
        Path | None, typer.Option("--save", help="Also save a page (.html), with its table as CSV beside it.")
    ] = None,
    language: Annotated[str, typer.Option("--language", help="Language of what is said of stations: en or de.")] = "en",
    as_json: options.Json = False,
) -> None:
    """Compare two results folders, A and B: their settings, their versions and the return of every policy.

    Each policy of A is compared with the same policy of B, run by run. Of two folders that `fatplan assess` wrote (or
    their assessment.json): what got better from A to B and what got worse, by place and by worker.
    """
    from fatigue_planner.output.reports.station.stored import is_assessment

    if save is not None and save.suffix.lower() != ".html":
        raise SelectionError(f"--save {save}: the name must end in .html.")
    kinds = [is_assessment(path) for path in (first, second)]
    if kinds[0] != kinds[1]:
        one, other = (first, second) if kinds[0] else (second, first)
        raise SelectionError(f"{one} is an assessment of a station, {other} is not: give two of the same kind.")
    if kinds[0]:
        document, text, files = _stations(first, second, save, language)
    else:
        document, text, files = _folders(first, second, save)
    if files:
        text += "\n" + ", ".join(map(str, files))
    options.present(document | {"files": files}, text, as_json)


Compared = tuple[dict[str, Any], str, Sequence[Path]]


def _folders(first: Path, second: Path, save: Path | None) -> Compared:
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.results.compare import compare, compare_page, compare_text
    from fatigue_planner.study.statistics.pairing import records

    found, files = compare(first, second), []
    if save is not None:
        figures = FigureFolder(writable_folder(save.parent))
        publish_text(save, compare_page(found, figures, save.stem))
        files = [save, *figures.files]
    document = {
        "folders": found.names,
        "settings": found.settings,
        "versions": found.versions,
        "only": found.only,
        "same_worlds": found.same_worlds,
        "contrasts": records(found.contrasts),
    }
    return document, compare_text(found), files


def _stations(first: Path, second: Path, save: Path | None, language: str) -> Compared:
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.reports.station.catalogue import catalogue_of
    from fatigue_planner.output.reports.station.compare import compare_stations
    from fatigue_planner.output.reports.station.compare_page import comparison_page, comparison_text
    from fatigue_planner.output.reports.station.stored import read_assessment

    found = compare_stations(read_assessment(first), read_assessment(second), catalogue_of(language))
    if save is not None:
        writable_folder(save.parent)
        publish_text(save, comparison_page(found))
    document = {
        "folders": [str(first), str(second)],
        "settings": found.settings,
        "places": [row._asdict() for row in found.places],
        "cannot": [row._asdict() for row in found.cannot],
        "shares": [row._asdict() for row in found.shares],
        "cycles": [row._asdict() for row in found.cycles],
    }
    return document, comparison_text(found), [save] if save else []

"""`fatplan live report` and `card`: what is read about a shift when it is over, and before it is introduced."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import live, options
from fatigue_planner.cli.progress import talk
from fatigue_planner.core.errors import SelectionError


def report(
    journal: live.JournalFile,
    worker: Annotated[
        str | None,
        typer.Option("--worker", metavar="PSEUDONYM", help="His own report; '' for a worker who was not named."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", help="The folder to write to. Default: beside the journal.")
    ] = None,
    experiment: Annotated[
        Path | None, typer.Option("--experiment", help="The experiment. Default: the one that the journal names.")
    ] = None,
    cache: Annotated[
        Path | None, typer.Option("--cache", help="Folder of its reactions. Default: the one that the journal names.")
    ] = None,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Write what the JOURNAL of a shift says: to a worker of his own, or of all, and then nothing of fewer than five.

    The folder's files are readable by you alone. A pseudonym is in none of them.
    """
    from fatigue_planner.core.files import find_shipped, publish_text, writable_folder
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.journal_file import pseudonyms, read_journal
    from fatigue_planner.live.record import record_of
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.output.reports.shift.data import ShiftData
    from fatigue_planner.output.reports.shift.page import DATA_FILE, shift_report

    record = record_of(read_journal(journal))
    if record is None:
        raise SelectionError(f"{journal}: is empty; no shift was begun.")
    whose = None
    if worker is not None:
        known = {pseudonym: random for random, pseudonym in pseudonyms(journal).items()} | {"": ""}
        if worker not in known or known[worker] not in record.workers:
            raise SelectionError(f"--worker {worker!r}: nobody of this pseudonym worked in {journal}.")
        whose = known[worker]
    opened = record.segments[-1].opened
    named = experiment or _named(journal, opened.experiment)
    if named is None:
        raise SelectionError(
            f"{journal}: names no experiment; give it with --experiment, and its reactions with --cache."
        )
    folder = cache or (journal.parent / opened.cache if opened.cache else options.DEFAULT_CACHE)
    loaded = load_experiment(find_shipped(named))
    task = live.task_of(loaded, opened.scenario_name or None, folder, options.command_line("simulate", named, folder))
    data = ShiftData.of(journal.name, record, task)
    output = output or journal.with_name(f"{journal.stem}-report" + ("" if worker is None else "-own"))
    talk().print("Replaying the journal ...")
    figures = FigureFolder(writable_folder(output))
    output.chmod(0o700)
    document = shift_report(data, whose, figures, _again(journal, worker))
    publish_text(output / DATA_FILE, options.json_text(document) + "\n")
    for file in (*figures.files, output / DATA_FILE):
        file.chmod(0o600)
    options.present(document, f"{output / REPORT_FILE} and its data.", as_json)


def _named(journal: Path, experiment: str) -> Path | None:
    """The experiment that a journal names: from its folder, or one that ships."""
    if not experiment:
        return None
    beside = journal.parent / experiment
    return beside if beside.is_file() else Path(experiment)


def _again(journal: Path, worker: str | None) -> str:
    return f"fatplan live report {journal.name}" + ("" if worker is None else " --worker YOUR-PSEUDONYM")

"""`fatplan live report` and `card`: what is read about a shift when it is over, and before it is introduced."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.cli import live, options
from fatigue_planner.cli.progress import talk
from fatigue_planner.core.errors import SelectionError, check_known


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
    from fatigue_planner.output.reports.page import REPORT_FILE

    output, document = write_report(journal, worker, output, experiment, cache)
    options.present(document, f"{output / REPORT_FILE} and its data.", as_json)


def write_report(
    journal: Path,
    worker: str | None = None,
    output: Path | None = None,
    experiment: Path | None = None,
    cache: Path | None = None,
) -> tuple[Path, dict[str, Any]]:
    """Write the report of a shift; its folder and what its data file holds. Raises SelectionError."""
    from fatigue_planner.core.files import find_shipped, publish_text, writable_folder
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.journal_file import pseudonyms, read_journal
    from fatigue_planner.live.record import record_of
    from fatigue_planner.output.figures.style import FigureFolder
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
    is_new = not output.exists()
    figures = FigureFolder(writable_folder(output))
    if is_new:
        output.chmod(0o700)
    _remove_report(output / DATA_FILE)
    document = shift_report(data, whose, figures, _again(journal, worker))
    publish_text(output / DATA_FILE, options.json_text(document) + "\n")
    for file in (*figures.files, output / DATA_FILE):
        file.chmod(0o600)
    return output, document


def _remove_report(data_file: Path) -> None:
    """Remove a report that was written before: it may be another worker's."""
    try:
        names = json.loads(data_file.read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, LookupError, TypeError):
        return
    for name in [*names, data_file.name]:
        data_file.with_name(Path(str(name)).name).unlink(missing_ok=True)


def _named(journal: Path, experiment: str) -> Path | None:
    """The experiment that a journal names: from its folder, or one that ships."""
    if not experiment:
        return None
    beside = journal.parent / experiment
    return beside if beside.is_file() else Path(experiment)


def _again(journal: Path, worker: str | None) -> str:
    return f"fatplan live report {journal.name}" + ("" if worker is None else " --worker YOUR-PSEUDONYM")


def card(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="An experiment, or the journal of a shift, which names one.")
    ],
    output: Annotated[Path, typer.Option("--output", help="The page to write.")] = Path("card.html"),
    condition: Annotated[
        str | None, typer.Option("--condition", help="Condition of the experiment's benchmark.")
    ] = None,
    keep_days: Annotated[
        int | None, typer.Option("--keep-days", min=1, help="For how many days journals are kept.")
    ] = None,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Write one page for the works council: what is processed about workers, what for, how long, and who sees it."""
    from fatigue_planner.core.files import find_shipped, publish_text
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.journal_file import read_journal
    from fatigue_planner.live.record import record_of
    from fatigue_planner.live.retention import is_journal
    from fatigue_planner.output.reports.shift.card import Told, card

    if output.suffix != ".html":
        raise SelectionError(f"--output {output}: should end in .html.")
    named: Path | None = source
    policy = "a lookahead of 2 cycles by default, or a policy of the experiment"
    if is_journal(source):
        record = record_of(read_journal(source))
        if record is None:
            raise SelectionError(f"{source}: is empty; no shift was begun.")
        opened = record.segments[-1].opened
        named, condition = _named(source, opened.experiment), opened.scenario_name or None
        policy = f"the policy `{opened.policy.get('kind', '?')}`"
        if named is None:
            raise SelectionError(f"{source}: names no experiment; give that instead.")
    assert named is not None
    loaded = load_experiment(find_shipped(named))
    if condition is not None:
        check_known("condition", condition, loaded.benchmark.conditions)
    publish_text(output, card(Told(loaded, condition, policy, keep_days)))
    options.present({"file": output}, f"{output}.", as_json)

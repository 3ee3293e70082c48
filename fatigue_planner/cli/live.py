"""`fatplan live`: what to do with the journal of a shift."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError
from fatigue_planner.core.text import counted

app = typer.Typer(name="live", help="Export, recover and clear the journal of a shift.", no_args_is_help=True)

JournalFile = Annotated[Path, typer.Argument(metavar="JOURNAL", help="The journal of a shift.")]


@app.command(epilog=options.EXIT_CODES)
def export(
    journal: JournalFile,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write.")],
    form: Annotated[
        Literal["csv", "jsonl"] | None, typer.Option("--format", help="Default: by the file's ending.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Write the events of a JOURNAL as a table (CSV) or as lines of JSON. Workers are random numbers in it."""
    import pandas as pd

    from fatigue_planner.core.files import canonical_json, publish_csv, publish_text
    from fatigue_planner.live.journal_file import read_journal

    form = form or {".csv": "csv", ".jsonl": "jsonl"}.get(file.suffix)  # type: ignore[assignment]
    if form is None:
        raise SelectionError(f"{file}: should end in .csv or .jsonl, or give --format.")
    rows = [
        {"number": one.number, "seconds": one.seconds, "utc": one.utc, **one.event.plain()}
        for one in read_journal(journal)
    ]
    if form == "jsonl":
        publish_text(file, "".join(f"{canonical_json(row)}\n" for row in rows))
    else:
        nested = [
            {key: json.dumps(value) if isinstance(value, dict | list) else value for key, value in row.items()}
            for row in rows
        ]
        publish_csv(file, pd.DataFrame(nested).convert_dtypes())
    options.present({"file": file, "events": len(rows)}, f"{file}: {counted(len(rows), 'event')}.", as_json)


@app.command(epilog=options.EXIT_CODES)
def recover(
    journal: JournalFile,
    into: Annotated[Path, typer.Argument(metavar="NEW", help="The new journal.")],
    as_json: options.Json = False,
) -> None:
    """Copy what is intact of a damaged JOURNAL, from its beginning, to a NEW one, with which a shift can go on."""
    from fatigue_planner.live.journal_file import recover

    events = recover(journal, into)
    options.present({"file": into, "events": len(events)}, f"{into}: {counted(len(events), 'event')}.", as_json)


@app.command(epilog=options.EXIT_CODES)
def erase(
    journal: JournalFile,
    pseudonym: Annotated[str, typer.Argument(metavar="PSEUDONYM", help="The worker's pseudonym.")],
    as_json: options.Json = False,
) -> None:
    """Erase what joins a worker's events in a JOURNAL to a PSEUDONYM. The events, which name nobody, stay."""
    from fatigue_planner.live.journal_file import erase

    if not erase(journal, pseudonym):
        raise SelectionError(f"{journal}: no worker has the pseudonym {pseudonym!r}.")
    options.present({"journal": journal, "erased": True}, f"{journal}: {pseudonym} is erased.", as_json)

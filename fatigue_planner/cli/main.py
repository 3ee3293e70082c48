"""The command `fatplan` and its subcommands: options in, work by the rooms below, messages out.

Commands import what they work with when they are called, so that help, version and mistakes are answered at once.
"""

from typing import Annotated

import typer

from fatigue_planner import __version__
from fatigue_planner.cli import cache, clients, human, live, options, record, record_import, shift_report
from fatigue_planner.cli.assess import assess
from fatigue_planner.cli.benchmark import benchmark
from fatigue_planner.cli.claims import claims
from fatigue_planner.cli.compare import compare
from fatigue_planner.cli.doctor import doctor
from fatigue_planner.cli.init import init
from fatigue_planner.cli.reach import reach
from fatigue_planner.cli.recognise import recognise
from fatigue_planner.cli.record_fit import fit
from fatigue_planner.cli.report import report
from fatigue_planner.cli.rotate import rotate
from fatigue_planner.cli.schedule import schedule
from fatigue_planner.cli.sensitivity import sensitivity
from fatigue_planner.cli.simulate import simulate
from fatigue_planner.cli.validate import schema, validate
from fatigue_planner.cli.view import view
from fatigue_planner.cli.watch import watch
from fatigue_planner.core.errors import SelectionError

app = typer.Typer(
    name="fatplan",
    help="Plan a cobot's choices so that a worker's fatigue stays low in the long run.",
    epilog=options.EXIT_CODES,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
COMMANDS = (
    init, assess, rotate, simulate, benchmark, reach, schedule, claims, report, compare, sensitivity, view, validate,
    schema, doctor,
)  # fmt: skip
for command in COMMANDS:
    app.command(epilog=options.EXIT_CODES)(command)
live.app.command(epilog=options.EXIT_CODES)(watch)
live.app.command(epilog=options.EXIT_CODES)(clients.rehearse)
live.app.command(epilog=options.EXIT_CODES)(clients.ur)
live.app.command(epilog=options.EXIT_CODES)(clients.lsl)
live.app.command(epilog=options.EXIT_CODES)(clients.recognise)
live.app.command(epilog=options.EXIT_CODES)(shift_report.report)
live.app.command(epilog=options.EXIT_CODES)(shift_report.card)
record.app.command(epilog=options.EXIT_CODES)(recognise)
record.app.command(epilog=options.EXIT_CODES)(fit)
record.app.command("import", epilog=options.EXIT_CODES)(record_import.import_)
for group in (human.app, cache.app, live.app, record.app):
    app.add_typer(group, epilog=options.EXIT_CODES)


@app.command(hidden=True, add_help_option=False, context_settings={"ignore_unknown_options": True})
def figures(arguments: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Say what this command is called now."""
    raise SelectionError("`fatplan figures` is now `fatplan report --figures-only`.")


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fatplan {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass

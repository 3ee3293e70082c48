"""The command `fatplan` and its subcommands: options in, work by the layers below, messages out."""

from typing import Annotated

import typer

from fatigue_planner import __version__
from fatigue_planner.cli.lazy_import import LazyCommand, LazyGroup
from fatigue_planner.cli.options import EXIT_CODES


class _Commands(LazyGroup):
    lazy = (
        LazyCommand(
            "init",
            "Write a short, commented experiment, NAME.yaml, to fill in with a task of your own.",
            "fatigue_planner.cli.init:init",
        ),
        LazyCommand(
            "simulate",
            "Simulate the digital human for every action and motion preference of an EXPERIMENT.",
            "fatigue_planner.cli.simulate:simulate",
        ),
        LazyCommand(
            "benchmark",
            "Run every policy of an EXPERIMENT in every condition and compare their returns.",
            "fatigue_planner.cli.benchmark:benchmark",
        ),
        LazyCommand(
            "claims",
            "Judge every claim of a CLAIMS file: reproduced, not reproduced or undetermined, with numbers and reason.",
            "fatigue_planner.cli.claims:claims",
        ),
        LazyCommand(
            "figures",
            "Draw the figures of an EXPERIMENT: returns per policy, postural reactions, their loads and costs.",
            "fatigue_planner.cli.figures:figures",
        ),
        LazyCommand(
            "report",
            "Write the report of an EXPERIMENT: one page (HTML) that opens offline and prints, with its figures and "
            "tables.",
            "fatigue_planner.cli.report:report",
        ),
        LazyCommand(
            "compare",
            "Set two results folders, A and B, side by side: settings, versions and the return of every policy in "
            "both.",
            "fatigue_planner.cli.compare:compare",
        ),
        LazyCommand(
            "sensitivity",
            "Find out for which settings planning is worth while, and which of them decide it.",
            "fatigue_planner.cli.sensitivity:sensitivity",
        ),
        LazyCommand(
            "view",
            "Show the digital human performing the reactions of an EXPERIMENT.",
            "fatigue_planner.cli.view:view",
        ),
        LazyCommand(
            "validate",
            "Check a FILE of settings completely, without doing anything: all faults are told at once.",
            "fatigue_planner.cli.validate:validate",
        ),
        LazyCommand(
            "schema",
            "Print the JSON Schema of a kind of file, for editors that complete and check YAML while one types.",
            "fatigue_planner.cli.schema:schema",
        ),
        LazyCommand(
            "doctor",
            "Check this installation: versions, solvers, compiler, HDF5, folders, viewer and browser, each by using "
            "it.",
            "fatigue_planner.cli.doctor:doctor",
        ),
        LazyCommand("human", "Show or export the digital human of an experiment.", "fatigue_planner.cli.human:app"),
        LazyCommand("cache", "Look after the cache of reactions.", "fatigue_planner.cli.cache:app"),
    )


app = typer.Typer(
    name="fatplan",
    cls=_Commands,
    help="Plan a cobot's choices so that a worker's fatigue stays low in the long run.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


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

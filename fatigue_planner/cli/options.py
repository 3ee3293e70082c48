"""Options that several commands share."""

import shlex
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from fatigue_planner.executors.processes import available_cores

ExperimentFile = Annotated[Path, typer.Argument(metavar="EXPERIMENT", help="The experiment file (YAML).")]
CacheFolder = Annotated[Path, typer.Option("--cache", help="Folder of the simulated reactions.")]
ResultsFolder = Annotated[Path, typer.Option("--results", help="Folder of the results.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, help="Processes to use; results do not depend on it.")]

DEFAULT_EXPERIMENT = Path("experiments/paper.yaml")
DEFAULT_CACHE = Path("cache")
DEFAULT_RESULTS = Path("results")
ALL_CORES = available_cores()
EXIT_CODES = (
    "Exit codes: 0 done; 1 internal error; 2 bad input or usage; 3 finished, but some parts failed; "
    "4 a stored file is damaged; 130 or 143 interrupted, with everything finished so far kept."
)


def command_line(command: str, experiment: Path, cache: Path, results: Path = DEFAULT_RESULTS) -> str:
    """The command a message tells to run, with the folders the user named."""
    words = ["fatplan", command, str(experiment)]
    if cache != DEFAULT_CACHE:
        words += ["--cache", str(cache)]
    if results != DEFAULT_RESULTS:
        words += ["--results", str(results)]
    return shlex.join(words)


def talk() -> Console:
    """Where progress and messages go: the terminal's error stream, apart from results."""
    return Console(stderr=True, highlight=False, soft_wrap=True)


def counter(console: Console) -> Progress:
    """A progress bar that counts pieces of work."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console)

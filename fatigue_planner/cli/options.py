"""Options that several commands share, and what they stand for."""

import json
import shlex
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.core.errors import MissingExtraError, SelectionError
from fatigue_planner.core.executors.processes import LocalProcesses, available_cores

if TYPE_CHECKING:
    from fatigue_planner.core.executors.executor import Executor
    from fatigue_planner.study.benchmark.selection import Selection

ExperimentFile = Annotated[
    Path, typer.Argument(metavar="EXPERIMENT", help="The experiment file (YAML), or the name of one that ships.")
]
CacheFolder = Annotated[Path, typer.Option("--cache", help="Folder of the simulated reactions.")]
ResultsFolder = Annotated[Path, typer.Option("--results", help="Folder of the results.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, help="Number of processes; results do not depend on it.")]
Dask = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="ADDRESS",
        help="Work on the Dask cluster whose scheduler is at tcp://HOST:PORT or tls://HOST:PORT, instead of --jobs.",
    ),
]


def _load_plugins(files: list[Path] | None) -> list[Path] | None:
    if files:
        from fatigue_planner.core.plugins import load_plugin

        for file in files:
            load_plugin(file)
    return files


# Loaded while the options are read; the commands have nothing to do with them.
Plugins = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE",
        callback=_load_plugins,
        help="Run this Python file first: it adds kinds of policies, beliefs, motion tasks or report sections "
        "(repeatable).",
    ),
]
PageLanguage = Annotated[str, typer.Option("--language", help="Language of the page: en or de.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]

# Restrictions of the grid, as `Selection` has them.
MAX_NUMBER = 1_000_000  # trials or descents: the schema's limit of both
Cycles = Annotated[list[int] | None, typer.Option(help="Only this number of cycles (repeatable).")]
Conditions = Annotated[list[str] | None, typer.Option(help="Only this condition (repeatable).")]
Policies = Annotated[list[str] | None, typer.Option(help="Only this policy (repeatable).")]
Trials = Annotated[int | None, typer.Option(min=1, max=MAX_NUMBER, help="Trials per cell instead of the file's.")]
Descents = Annotated[int | None, typer.Option(min=1, max=MAX_NUMBER, help="Descents of every POMCP policy.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Seed instead of the file's.")]

DEFAULT_EXPERIMENT = Path("paper")
DEFAULT_CACHE = Path("cache")
DEFAULT_RESULTS = Path("results")
ALL_CORES = available_cores()
EXIT_CODES = (
    "Exit codes: 0 done; 1 internal error; 2 bad input or usage; 3 finished, but some parts failed; "
    "4 a stored file is damaged; 130 or 143 interrupted, with everything finished so far kept."
)


def command_line(
    command: str,
    experiment: Path,
    cache: Path,
    results: Path = DEFAULT_RESULTS,
    selection: "Selection | None" = None,
) -> str:
    """The command a message tells to run, with the restrictions and the folders the user named."""
    words = ["fatplan", command, str(experiment)]
    if plugins := sys.modules.get("fatigue_planner.core.plugins"):
        words += [word for _, _, path in plugins.loaded_files() for word in ("--plugin", path)]
    for name, values in selection.asked().items() if selection else ():
        words += [word for value in values for word in (f"--{name}", value)]
    if cache != DEFAULT_CACHE:
        words += ["--cache", str(cache)]
    if results != DEFAULT_RESULTS:
        words += ["--results", str(results)]
    return shlex.join(words)


def source_of(folder: Path, wanted: "Selection") -> "tuple[Path, Selection]":
    """The experiment file in a results folder, and the restrictions it was made with.

    Raises SelectionError if other ones are wanted; and as `load_source`.
    """
    from fatigue_planner.study.benchmark.results import load_source

    for name in wanted.asked():
        raise SelectionError(f"--{name}: cannot be given with the results folder {folder}, which has its own grid.")
    return load_source(folder, "fatplan benchmark EXPERIMENT")


def executor_of(jobs: int, dask: str | None) -> "Executor":
    """Where to work: on a cluster, or in `jobs` processes here. Raises ClusterError, MissingExtraError."""
    if dask is None:
        return LocalProcesses(jobs)
    if find_spec("distributed") is None:
        raise MissingExtraError("--dask needs Dask's distributed: pip install 'fatigue-planner[dask]'.")
    from fatigue_planner.core.executors.dask import DaskCluster

    return DaskCluster(dask)


def present(document: Mapping[str, Any], text: str, as_json: bool) -> None:
    """Print a command's result, once, on stdout: a JSON document for programs if the user wants that, else text.

    Everything else there is to say goes to stderr (`progress`). docs/command-line.md lists the keys of the documents.
    """
    typer.echo(json_text(document) if as_json else text)


def json_text(document: Any) -> str:
    """Strict JSON of dataclasses, mappings, sequences, paths and numpy's numbers.

    NaN is null, an infinite number the text "Infinity" or "-Infinity".
    """
    from pydantic_core import to_json

    text = to_json(document, inf_nan_mode="constants", fallback=lambda number: number.item())
    strict = json.loads(text, parse_constant={"NaN": None, "Infinity": "Infinity", "-Infinity": "-Infinity"}.get)
    return json.dumps(strict, indent=1, ensure_ascii=False, allow_nan=False)

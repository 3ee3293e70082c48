"""`fatplan sensitivity`: how results depend on settings that could have been chosen differently."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, run_jobs, talk, warn
from fatigue_planner.core.errors import ExperimentError

if TYPE_CHECKING:
    from fatigue_planner.core.executors.executor import Executor
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.study.sensitivity.design import Point
    from fatigue_planner.study.sensitivity.reactions import Reacted
    from fatigue_planner.study.sensitivity.study import Study
    from fatigue_planner.study.sensitivity.tables import StudyRuns

DEFAULT_STUDY = Path("sensitivity")

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="The study file (YAML).")]


def sensitivity(
    study: StudyFile = DEFAULT_STUDY,
    jobs: options.Jobs = options.ALL_CORES,
    dask: options.Dask = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Find out for which settings planning is worthwhile, and which settings decide that.

    A STUDY names the settings of an experiment that could have been chosen differently. They are changed one at a time
    and all at once (a space-filling design). The study `readings` compares readings of the paper's text. Reactions in
    the cache are not simulated again. The same command continues an interrupted run where it stopped, and ends with
    the same tables.
    """
    from fatigue_planner.core.files import writable_folder
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.study.sensitivity.design import design
    from fatigue_planner.study.sensitivity.study import load_study

    settings, executor = load_study(study), options.executor_of(jobs, dask)
    points = design(settings)
    store = writable_folder(results / settings.settings.name / "parts")
    command = options.command_line("sensitivity", study, cache, results)
    reacted = _react(settings, points, ReactionCache(writable_folder(cache)), executor, command)
    runs = _run(settings, reacted, store, executor)
    document, names = _publish(settings, reacted, runs, results / settings.settings.name, command)
    conclusions = "\n".join(f"{number}. {sentence}" for number, sentence in enumerate(document["lessons"], start=1))
    options.present(document, f"{conclusions}\n\n{document['folder']}: {names}", as_json)


def _react(
    study: "Study", points: "Sequence[Point]", cache: "ReactionCache", executor: "Executor", command: str
) -> "list[Reacted]":
    from fatigue_planner.study.sensitivity.reactions import react, unique_requests

    console = talk()
    total = len(unique_requests(points))
    with progress(f"Reactions of {len(points)} points", total, kept=("reactions", cache.folder)) as counter:
        reacted = react(
            points, cache, executor, lambda outcome: counter.advance(pieces=outcome.verdict != "failed"), command
        )
    warn(cache.damaged)
    feasible = sum(one.profiles is not None for one in reacted)
    console.print(f"{feasible} of {len(reacted)} points can be performed.")
    if not feasible:
        raise ExperimentError(f"{study.settings.name}: no point can be performed; the first: {reacted[0].reason}")
    return reacted


def _run(study: "Study", reacted: "Sequence[Reacted]", store: Path, executor: "Executor") -> "StudyRuns":
    from fatigue_planner.study.benchmark.estimate import decisions_left, duration_text, estimated_seconds
    from fatigue_planner.study.sensitivity.tables import StudyGrid

    console = talk()
    grid = StudyGrid(reacted)
    left = decisions_left(grid.cells, store)
    time = duration_text(estimated_seconds(grid.cells, left, executor.workers))
    console.print(
        f"{len(grid.cells)} different cells, {sum(left)} decisions left: about {time} with {executor.workers} workers."
    )
    return grid.runs(run_jobs(grid.cells, store, executor, "Decisions", "runs"), study.settings)


def _publish(
    study: "Study", reacted: "Sequence[Reacted]", runs: "StudyRuns", folder: Path, command: str
) -> tuple[dict[str, Any], str]:
    """Write all tables, figures and the page; the JSON document, and the names of the files for people."""
    from fatigue_planner.core.files import publish_csv, publish_text
    from fatigue_planner.core.provenance import MANIFEST_FILE, publish_manifest
    from fatigue_planner.output.figures.sensitivity import draw_study
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.output.reports.study.finished import CONCLUSIONS_FILE, FIGURES, read_study
    from fatigue_planner.output.reports.study.page import study_page
    from fatigue_planner.study.sensitivity.gains import judge
    from fatigue_planner.study.sensitivity.reactions import unique_digests
    from fatigue_planner.study.sensitivity.tables import study_tables

    tables = study_tables(study, reacted, runs, None if study.claims is None else judge(study.claims))
    files = [folder / CONCLUSIONS_FILE]
    publish_text(files[0], "".join(f"{sentence}\n" for sentence in tables.conclusions))
    for name, table in tables.files().items():
        files.append(folder / f"{name}.csv")
        publish_csv(files[-1], table)
    drawn = draw_study(study, [one.point for one in reacted], tables, folder / FIGURES)
    configuration = {
        "study": study.settings.plain(),
        "experiment": study.base.plain(),
        "seed": study.base.benchmark.seed,
        "reactions": unique_digests([one.point for one in reacted]),
        "figures": [path.stem for path in drawn if path.suffix == ".svg"],
    }
    hashes = publish_manifest(folder, "sensitivity", configuration, [*files, *drawn])
    publish_text(folder / REPORT_FILE, study_page(read_study(folder), command))
    folders = [f"{FIGURES}/"] if drawn else []
    names = ", ".join([REPORT_FILE, *(path.name for path in files), *folders, MANIFEST_FILE])
    feasible = sum(one.profiles is not None for one in reacted)
    document = {
        "folder": folder,
        "files": hashes,
        "points": len(reacted),
        "feasible": feasible,
        "lessons": tables.conclusions,
    }
    return document, names

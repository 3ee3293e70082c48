"""`fatplan sensitivity`: how results depend on choices that could have been made otherwise."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from fatigue_planner.cli.json_output import StudyRun
from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_RESULTS,
    CacheFolder,
    Jobs,
    ResultsFolder,
    command_line,
)
from fatigue_planner.cli.output import Json, present
from fatigue_planner.cli.progress import progress, talk, warn
from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.files import publish_csv, publish_text, writable_folder
from fatigue_planner.core.provenance import MANIFEST_FILE, publish_manifest
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.study.benchmark.estimate import decisions_left, duration_text, estimated_seconds
from fatigue_planner.study.sensitivity.design import Point, design
from fatigue_planner.study.sensitivity.reactions import Reacted, react, unique_digests, unique_requests
from fatigue_planner.study.sensitivity.robustness import judge
from fatigue_planner.study.sensitivity.run import StudyGrid
from fatigue_planner.study.sensitivity.study import Study, load_study
from fatigue_planner.study.sensitivity.tables import study_tables

DEFAULT_STUDY = Path("experiments/sensitivity.yaml")

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="The study file (YAML).")]


def sensitivity(
    study: StudyFile = DEFAULT_STUDY,
    jobs: Jobs = ALL_CORES,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
    as_json: Json = False,
) -> None:
    """Find out for which settings planning is worth while, and which of them decide it.

    A STUDY names the settings of an experiment that could have been chosen otherwise. They are changed one at a time
    and all at once (a space-filling design). Reactions in the cache are not simulated again; an interrupted run goes on
    where it stopped when it is started again, and ends in the same tables.
    """
    settings = load_study(study)
    points = design(settings)
    store = writable_folder(results / settings.settings.name / "parts")
    command = command_line("sensitivity", study, cache, results)
    executor = LocalProcesses(jobs)
    reacted = _react(settings, points, ReactionCache(writable_folder(cache)), executor, command)
    trials = _run(reacted, store, executor)
    done, names = _publish(settings, reacted, trials, results / settings.settings.name, command)
    lessons = "\n".join(f"{number}. {sentence}" for number, sentence in enumerate(done.lessons, start=1))
    present(done, f"{lessons}\n\n{done.folder}: {names}", as_json)


def _react(
    study: Study, points: Sequence[Point], cache: ReactionCache, executor: Executor, command: str
) -> list[Reacted]:
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


def _run(reacted: Sequence[Reacted], store: Path, executor: Executor) -> Mapping[str, pd.DataFrame]:
    console = talk()
    grid = StudyGrid(reacted)
    left = decisions_left(grid.cells, store)
    time = duration_text(estimated_seconds(grid.cells, left, executor.workers))
    console.print(
        f"{len(grid.cells)} different cells, {sum(left)} decisions left: about {time} with {executor.workers} workers."
    )
    runs = sum(len(cell.trial_numbers()) for cell in grid.cells)
    effort = sum(len(cell.trial_numbers()) * cell.effort for cell in grid.cells)
    with progress("Decisions", runs, effort, kept=("runs", store)) as counter:
        trials, warnings = grid.run(store, executor, lambda job, n: counter.advance(n, n * job.effort))
    warn(warnings)
    return trials


def _publish(
    study: Study, reacted: Sequence[Reacted], trials: Mapping[str, pd.DataFrame], folder: Path, command: str
) -> tuple[StudyRun, str]:
    """Everything on disk: what was made, and the names of the files for people."""
    from fatigue_planner.output.figures.sensitivity import draw_study  # noqa: PLC0415 - loads matplotlib
    from fatigue_planner.output.reports.html.page import REPORT_FILE  # noqa: PLC0415 - loads jinja2
    from fatigue_planner.output.reports.study.finished import FIGURES, LESSONS_FILE, read_study  # noqa: PLC0415 - with it
    from fatigue_planner.output.reports.study.page import study_page  # noqa: PLC0415

    tables = study_tables(study, reacted, trials, None if study.claims is None else judge(study.claims))
    files = [folder / LESSONS_FILE]
    publish_text(files[0], "".join(f"{sentence}\n" for sentence in tables.lessons))
    for name, table in tables.files().items():
        files.append(folder / f"{name}.csv")
        publish_csv(files[-1], table)
    drawn = draw_study(study, [one.point for one in reacted], tables, writable_folder(folder / FIGURES))
    configuration = {
        "study": study.settings.plain(),
        "experiment": study.base.plain(),
        "seed": study.base.benchmark.seed,
        "reactions": unique_digests([one.point for one in reacted]),
        "figures": [path.stem for path in drawn if path.suffix == ".svg"],
    }
    hashes = publish_manifest(folder, "sensitivity", configuration, [*files, *drawn])
    publish_text(folder / REPORT_FILE, study_page(read_study(folder), command))
    names = ", ".join([REPORT_FILE, *(path.name for path in files), f"{FIGURES}/", MANIFEST_FILE])
    feasible = sum(one.profiles is not None for one in reacted)
    return StudyRun(folder, hashes, len(reacted), feasible, tables.lessons), names

"""`fatplan assess`: an ergonomist's station, from a file to an answer."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, warn

if TYPE_CHECKING:
    from fatigue_planner.core.executors.executor import Executor
    from fatigue_planner.ergonomics.result import Phrase
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.assessment import Outcome, RobotPlace, StationAssessment
    from fatigue_planner.station.schema import Station


# About how many motions are tried to find who of a population reaches a place.
EFFORT_OF_A_QUESTION = 4
# So many lines of a kind are printed; the page has all of them.
MOST_LINES = 6


def assess(
    station: Annotated[
        Path, typer.Argument(metavar="STATION", help="The station file (YAML), or the name of one that ships.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder of the results of this station.")
    ] = None,
    explain: Annotated[
        bool,
        typer.Option(
            "--explain",
            help="Print the experiments that the station becomes (YAML), without what breaks its limits or its robot "
            "cannot present, and stop; with --output, write them there.",
        ),
    ] = False,
    changes: Annotated[
        bool, typer.Option("--changes", help="Also compute what single changes of the station would do (minutes).")
    ] = False,
    language: options.PageLanguage = "en",
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    jobs: options.Jobs = options.ALL_CORES,
    as_json: options.Json = False,
) -> None:
    """Assess a STATION: who can work where, what is not acceptable by which rule, and which place is best.

    Every worker does every operation at every place in every way. What cannot be reached, or only as nobody would work,
    is an answer, not an error. Files in the results folder: assess.html, a page to hand on; assessment.json,
    places.csv, outcomes.csv and indicators.csv.
    `fatplan init --station NAME` writes a station to fill in.
    """
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.reports.station.catalogue import catalogue_of
    from fatigue_planner.output.reports.station.page import PAGE, pictured, station_page
    from fatigue_planner.output.reports.station.pictures import postures_of
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.assess import assess as assess_station
    from fatigue_planner.station.assess import planned
    from fatigue_planner.station.loader import load_station
    from fatigue_planner.station.population_reach import questions
    from fatigue_planner.station.tables import plain, write

    texts = catalogue_of(language)
    settings = load_station(station)
    executor, store = options.executor_of(jobs, None), ReactionCache(cache)
    command = options.command_line("assess", station, cache, results)
    if explain:
        _explain(settings, store, executor, command, output, as_json)
        return
    folder = writable_folder(output or results / settings.name)
    plan = planned(settings, changes)
    motions, asked = sum(map(len, plan.tasks)), len(list(questions(settings)))
    effort = motions + EFFORT_OF_A_QUESTION * asked
    with progress("Simulating", motions, effort, kept=("motions", cache)) as counter:
        found = assess_station(
            plan, store, executor, command, lambda made: counter.advance(pieces=made.kept),
            lambda: counter.advance(pieces=0, effort=EFFORT_OF_A_QUESTION),
        )  # fmt: skip
    warn(store.damaged)
    document = plain(found)
    page = station_page(found, postures_of(found, pictured(found), store, command), texts)
    files = [folder / PAGE, *write(found, folder, options.json_text(document))]
    publish_text(files[0], page)
    options.present(document | {"files": files}, "\n".join([*_text(found), "", _written(folder, files)]), as_json)


def _text(found: "StationAssessment") -> list[str]:
    """What an ergonomist needs first, then who of a population can, then what it rests on."""
    from fatigue_planner.station.statements import of_changes, of_population, of_robot, of_rotation, of_sensing

    lines = [f"{found.station.name}: {', '.join(_worker(found, index) for index in range(len(found.workers)))}"]
    lines += capped(found.headline)
    lines += capped(list(of_robot(found.station, found.robot)))
    lines += capped([*of_rotation(found.rotation), *of_sensing(found.station, found.best, found.sensing)])
    changes = [*capped(list(of_changes(found.changes, found.best)))]
    lines += ["", "What one change would do:", *changes] if found.changes else changes
    lines += ["", "Of the population:", *capped(list(of_population(found.shares)))]
    return [*lines, "", "What this rests on:", *capped(found.assumptions)]


def capped(phrases: "Sequence[Phrase]") -> Iterator[str]:
    """Sentences as lines; of each kind only the first ones, then how many more there are."""
    from fatigue_planner.output.reports.station.page import PAGE

    of_kind, so_far = Counter(phrase.template for phrase in phrases), Counter[str]()
    for phrase in phrases:
        so_far[phrase.template] += 1
        if so_far[phrase.template] <= MOST_LINES:
            yield f"  {phrase}."
        elif so_far[phrase.template] == MOST_LINES + 1:
            yield f"  … and {of_kind[phrase.template] - MOST_LINES} more of this kind, see {PAGE}."


def _worker(found: "StationAssessment", index: int) -> str:
    facts = found.workers[index]
    return f"{facts.name} ({100 * facts.stature_m:.0f} cm, {facts.mass_kg:.0f} kg, {facts.handedness}-handed)"


def _written(folder: Path, files: list[Path]) -> str:
    return f"{folder}: {', '.join(path.name for path in files)}"


def _explain(
    station: "Station",
    store: "ReactionCache",
    executor: "Executor",
    command: str,
    output: Path | None,
    as_json: bool,
) -> None:
    """The experiments as YAML documents; each is a file for `fatplan simulate` and all other commands.

    With limits or a robot, the motions are simulated first: what breaks one, or it cannot present, is not in them.
    """
    import yaml

    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.experiment.loader import complete_content
    from fatigue_planner.station.bound_experiments import bound_experiments
    from fatigue_planner.station.examine import examine
    from fatigue_planner.station.outcomes import tasks_of

    outcomes: Sequence[Outcome] = ()
    robot: Sequence[RobotPlace] = ()
    if station.limits or station.robot is not None:
        tasks = tasks_of(station)
        with progress("Simulating", len(tasks), kept=("motions", store.folder)) as counter:
            examined = examine(
                [station], store, executor, command, lambda made: counter.advance(pieces=made.kept), [tasks]
            )
        outcomes, robot = examined[0].outcomes, examined[0].robot
        warn(store.damaged)
    contents: dict[str, Any] = {}
    texts, left_out, files = [], {}, []
    for name, experiment, reasons in bound_experiments(station, outcomes, robot):
        text = "".join(f"# left out: {reason}\n" for reason in reasons)
        if experiment is None:
            texts.append(f"# {name}: nothing is left\n{text}")
        else:
            complete = complete_content(experiment)
            own = ("name", "human", "workers", "cycle", "actions", "preferences", "controller", "accuracy")
            contents[name] = {key: complete[key] for key in own}
            written = yaml.safe_dump(contents[name], sort_keys=False, default_flow_style=None, width=120)
            texts.append(f"# {name}.yaml\n{text}{written}")
            if output is not None:
                files.append(writable_folder(output) / f"{name}.yaml")
                publish_text(files[-1], text + written)
        if reasons:
            left_out[name] = reasons
    text = "---\n".join(texts).rstrip() if output is None else "\n".join(map(str, files)) or "nothing is left"
    options.present({"experiments": contents, "left_out": left_out, "files": files}, text, as_json)

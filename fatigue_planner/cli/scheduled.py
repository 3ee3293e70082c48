"""What `fatplan schedule` makes a schedule of: the conditions of an experiment, or the workers of a station."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.errors import SelectionError
from fatigue_planner.core.executors.executor import Executor

if TYPE_CHECKING:
    from fatigue_planner.experiment.statistics_settings import StatisticsSettings
    from fatigue_planner.human.model import Human
    from fatigue_planner.output.figures.schedule_card import Step
    from fatigue_planner.output.reports.station.wording import Wording
    from fatigue_planner.pomdp.scenario import Scenario
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.examine import Examined
    from fatigue_planner.station.schema import Station
    from fatigue_planner.study.benchmark.selection import Selection


@dataclass(frozen=True)
class Drawn:
    """The worker of a card, how that one is called there, and each step by the action that it is."""

    human: "Human"
    label: str
    steps: Mapping[str, "Step"]


@dataclass(frozen=True)
class Scheduled:
    """Scenarios by condition, and how to run them.

    choice: what one is called of what is chosen; labels: of the conditions, on the card; left_out: what is not chosen
    from, and why; places: of a station, what every action is, by operation; drawn: what a card shows of actions.
    """

    name: str
    choice: str
    scenarios: "Mapping[str, Scenario]"
    labels: Mapping[str, str]
    n_cycles: int
    seed: int
    trials: int
    longest: int
    statistics: "StatisticsSettings"
    left_out: Sequence[str]
    places: Mapping[str, Mapping[str, str]]
    drawn: Callable[[Sequence[str]], Drawn]


def scheduled_experiment(file: Path, wanted: "Selection", cache: Path) -> Scheduled:
    """The conditions of an experiment, all or those wanted. Raises what loading and `load_cycle_profiles` raise."""
    from fatigue_planner.core.text import format_label
    from fatigue_planner.experiment.build import load_cycle_profiles, reaction_requests, scenario
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.human.model import build_human
    from fatigue_planner.output.figures.schedule_card import Step, where_hands_are
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.reaction import Reaction
    from fatigue_planner.study.benchmark.selection import selected

    settings = load_experiment(file)
    if settings.discount == 1:
        raise SelectionError(f"{file}: discount = 1: a schedule repeats for ever; it needs a discount below 1.")
    asked = selected(settings, wanted)
    simulate = options.command_line("simulate", file, cache)
    profiles = load_cycle_profiles(asked, cache, simulate)
    grid = without_infeasible(asked, profiles, profiles.ruled_out)
    conditions = grid.benchmark.conditions

    def drawn(actions: Sequence[str]) -> Drawn:
        worker, shown = grid.worker_of(next(iter(conditions.values()))), next(iter(grid.preferences))
        requests = [
            request
            for request in reaction_requests(grid)
            if (request.name.worker, request.name.preference) == (worker, shown) and request.name.action in actions
        ]
        steps = {
            one.name.action: Step(one, where_hands_are(grid.actions[one.name.action]))
            for one in ReactionCache(cache).stream(requests, simulate)
            if isinstance(one, Reaction)
        }
        label = f"{format_label(worker)}, {format_label(shown)} reaction"
        return Drawn(build_human(grid.workers[worker]), label, steps)

    return Scheduled(
        settings.name,
        "action",
        {name: scenario(grid, profiles, condition) for name, condition in conditions.items()},
        {name: _capital(format_label(name)) for name in conditions},
        max(grid.benchmark.n_cycles),
        grid.benchmark.seed,
        grid.benchmark.trials,
        8,
        grid.statistics,
        omissions(asked, profiles, profiles.ruled_out),
        {},
        drawn,
    )


def scheduled_station(file: Path, wanted: "Selection", cache: Path, executor: Executor) -> Scheduled:
    """The workers of a station, all or those wanted, at the places that it allows; what is missing is simulated.

    Raises what `load_station` and `examine` raise; SelectionError for an unknown worker, or if nothing is allowed.
    """
    from fatigue_planner.experiment.statistics_settings import StatisticsSettings
    from fatigue_planner.output.reports.station.catalogue import ENGLISH, catalogue_of
    from fatigue_planner.output.reports.station.wording import Wording
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.examine import examine
    from fatigue_planner.station.loader import load_station
    from fatigue_planner.station.outcomes import tasks_of
    from fatigue_planner.station.rotation import LONGEST, named_combinations, rotation_scenarios
    from fatigue_planner.station.sensing import CYCLES, SEED
    from fatigue_planner.station.workers import facts_of
    from fatigue_planner.study.benchmark.selection import choose

    whole = load_station(file)
    chosen = choose("conditions", list(whole.workers), wanted.conditions)
    station = whole.model_copy(update={"workers": {name: whole.workers[name] for name in chosen}})
    store, command, tasks = ReactionCache(cache), options.command_line("schedule", file, cache), tasks_of(station)
    with progress("Simulating", len(tasks), kept=("motions", cache)) as counter:
        (found,) = examine([station], store, executor, command, lambda made: counter.advance(made.kept), [tasks])
    warn(store.damaged)
    reasons = [str(each) for each in (*found.best.excluded.values(), found.best.together) if each is not None]
    scenarios = rotation_scenarios(found, store, command)
    if not scenarios:
        raise SelectionError(f"{file}: no place is allowed that a schedule could have: {'; '.join(reasons)}.")
    wording = Wording(catalogue_of(ENGLISH), [facts_of(station, name) for name in station.workers])
    return Scheduled(
        station.name,
        "place" if len(station.operations) == 1 else "combination of places",
        scenarios,
        {name: _capital(wording.worker(name)) for name in station.workers},
        CYCLES,
        SEED if wanted.seed is None else wanted.seed,
        wanted.trials or 1,
        LONGEST,
        StatisticsSettings(),
        reasons,
        named_combinations(found),
        lambda actions: _drawn_station(found, store, command, wording, actions),
    )


def _drawn_station(
    found: "Examined", store: "ReactionCache", command: str, wording: "Wording", actions: Sequence[str]
) -> Drawn:
    """The first worker at the places of the operation whose place changes most."""
    from fatigue_planner.core.text import format_label
    from fatigue_planner.human.model import build_human
    from fatigue_planner.output.figures.schedule_card import Step
    from fatigue_planner.station.rotation import named_combinations

    station, worker = found.station, next(iter(found.station.workers))
    combinations = {name: places for name, places in named_combinations(found).items() if name in actions}
    operation = max(station.operations, key=lambda each: len({places[each] for places in combinations.values()}))
    number = list(station.operations).index(operation)
    steps, task = {}, None
    for name, places in combinations.items():
        task = found.tasks[found.doings(worker, places)[number]]
        (reaction,) = found.case([task.doing], store, command).reactions()
        where = [_where(station, each, place) for each, place in places.items()]
        steps[name] = Step(reaction, "\n".join(where))
    assert task is not None
    label = wording.worker(worker)
    if len(station.operations) > 1:
        label += f", {format_label(operation)}"
    return Drawn(build_human(task.request.motion.worker), label, steps)


def _where(station: "Station", operation: str, place: str) -> str:
    from fatigue_planner.core.text import format_label

    at, tool = station.places[place], station.tool_at(operation, place)
    away_m = math.hypot(at.x, at.y) if station.feet == "free" else at.x
    words = [f"{100 * at.z:.0f} cm high, {100 * away_m:.0f} cm ahead", *([format_label(tool)] if tool else [])]
    if len(station.operations) > 1:
        words.insert(0, f"{format_label(operation)}: {format_label(place)}")
    return ", ".join(words)


def _capital(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"

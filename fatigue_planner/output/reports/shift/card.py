"""The card: on one page, what is processed about workers beside a robot, what for, how long, and who sees it.

It names the laws that the documentation names, and asserts nothing about them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from fatigue_planner.core.provenance import versions
from fatigue_planner.core.text import counted, format_label, listing
from fatigue_planner.experiment.robot_cell import RobotCell
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.output.reports.page import Points, Section, Table, Text, page
from fatigue_planner.output.reports.shift.group import FEWEST
from fatigue_planner.pomdp.hidden_worker import HiddenWorker

RATES = {
    "fatigue_rate_factor": "how fast he tires",
    "recovery_rate_factor": "how fast he recovers",
    "expertise": "how well he chooses what tires least",
}
BLANK = "……………………………………"
LAWS = (
    "GDPR, Art. 4, 5, 6, 9, 15 to 17, 35, 88; EU AI Act, Art. 5, 12, 14, 26(7) and "
    "Annex III 4(b); ISO 10218-1 and -2:2025; Machinery Regulation (EU) 2023/1230; in Germany BetrVG 87(1) 6. Whether "
    "and how they apply is for the employer and the works council to find out; this is no legal advice."
)


@dataclass(frozen=True)
class Told:
    """What a card is about: an experiment, the condition if it is known, and for how many days journals are kept."""

    experiment: Experiment
    condition: str | None
    policy: str
    keep_days: int | None


def card(told: Told) -> str:
    """The page (HTML)."""
    experiment = told.experiment
    subtitle = (
        f"For the works council and for those who work in the task {experiment.name}"
        f"{f', {format_label(told.condition)}' if told.condition else ''}. Written by fatplan {versions()['fatplan']}."
    )
    cell = None if experiment.robot is None else RobotCell(experiment)
    stopped = {action: cell.stopped(action) if cell else "" for action in experiment.actions}
    actions = [action for action, reason in stopped.items() if not reason]
    reactions = listing(list(experiment.preferences))
    purpose = (
        f"Cycle by cycle the robot does one of {counted(len(actions), 'action')} ({listing(actions)}). Which one, is "
        "decided so that the estimated fatigue of the worker's muscles stays low. Nothing else is it for."
    )
    return page(
        "Card: a robot that minds fatigue",
        subtitle,
        [Text(purpose), *([] if cell is None else [Text(_left_out(cell, stopped))])],
        [
            Section("What is processed, how long, and who sees it", [_data(told, reactions)]),
            Section("What a worker can do", [Points(_rights())]),
            Section("What it is not, and laws to look at", [Points(_is_not()), Text(LAWS)]),
            Section("To be filled in by the employer", [_blanks(told)]),
        ],
    )


def _left_out(cell: RobotCell, stopped: Mapping[str, str]) -> str:
    """Which actions the robot never does, and why."""
    named = [f"{action} ({reason})" for action, reason in stopped.items() if reason]
    limit_m = cell.cell.settings.clearance_m
    never = f"It cannot present, and so never does: {listing(named)}. " if named else ""
    return (
        f"{never}An action in which its arm would come nearer than {limit_m:g} m to the worker, by the simulation, is "
        "left out for this worker. That is no safety distance."
    )


def _data(told: Told, reactions: str) -> Table:
    kept = "no limit is set" if told.keep_days is None else counted(told.keep_days, "day")
    own = f"the worker; the employer only means over {FEWEST} or more"
    rows = [
        [f"how he did the work: {reactions}, or how likely each; how long it took", "recogniser of the employer",
         f"journal: {kept}", own],
        ["pauses, cycles in which he did nothing", "told, or by the clock", f"journal: {kept}", own],
        ["what the robot was told, why, and what it did", "fatplan, robot", f"journal: {kept}",
         "the worker; how the program ran: all"],
        ["a pseudonym, joined to a random number", "whoever serves the station",
         f"a table of its own: {kept}, or until it is erased", "who may read the journal"],
        ["fatigue of muscle groups, with its uncertainty" + _hidden(told), "estimated",
         "memory; follows from the journal", f"the most tired: who may look at the operators' page; all: {own}"],
    ]  # fmt: skip
    caption = (
        f"Decided by {told.policy}. Not processed: names, pictures, motions, heart rate or mood. Nothing leaves the "
        "machine. The journal's file can be read by the account alone that runs the program."
    )
    return Table(caption, ["what", "from where", "kept", "seen by"], rows)


def _hidden(told: Told) -> str:
    conditions = told.experiment.benchmark.conditions
    condition = conditions.get(told.condition or "")
    name = condition.hidden_worker if condition else None
    workers = [told.experiment.hidden_workers[name]] if name else []
    if condition is None:
        workers = list(told.experiment.hidden_workers.values())
    learnt = [words for key, words in RATES.items() if any(_varies(one, key) for one in workers)]
    return f"; {listing(learnt)}" if learnt else ""


def _varies(worker: HiddenWorker, key: str) -> bool:
    return key in worker.model_fields_set


def _rights() -> list[str]:
    return [
        "Switch it off for himself at any time: from the next cycle on a schedule decides, and what was believed of "
        "him is forgotten (`advise`).",
        "Pause, and have the robot do something else: what it does counts, not what it was told.",
        "Read his own report of every shift (`fatplan live report --worker`), get its data, and have his pseudonym "
        "erased (`fatplan live erase`).",
    ]


def _is_not() -> list[str]:
    return [
        "No safety function: it moves nothing and clears no stop. The robot's program has its own timer and default.",
        "No medical finding, and no measure of a day's load: the model forgets within minutes.",
        "No comparison, ranking or appraisal of workers, and nothing about their mood.",
    ]


def _blanks(told: Told) -> Table:
    kept = BLANK if told.keep_days is None else counted(told.keep_days, "day")
    rows = [
        ["Responsible, and whom to ask", BLANK],
        ["Agreed purpose", BLANK],
        ["Journals are removed after", kept],
        ["Who holds the tokens to look and to act", BLANK],
        ["Date, employer, works council", BLANK],
    ]
    return Table("Before the robot is used so.", ["what", "agreed"], rows)

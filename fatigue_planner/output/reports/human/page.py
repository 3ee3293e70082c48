"""The page that compares a worker's digital human with the literature."""

from collections.abc import Mapping, Sequence

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from fatigue_planner.core.text import fixed, signed_percent
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import Worker, build_human
from fatigue_planner.output.reports.human import tables, torques
from fatigue_planner.output.reports.human.references import references
from fatigue_planner.output.reports.human.tables import SourcedTable
from fatigue_planner.reactions.reaction import Reaction

# The body for which the sums and bands of the source `plausibility` were made.
EXPECTED_FOR = ("male", 1.75, 75.0)
NOTEWORTHY = 0.20  # a deviation the page mentions in words
TOLERANCE = 0.10  # from the general curve of endurance
NUMERIC = "0123456789+−–"  # what the cells of a column of numbers begin with


def human_page(
    worker: Worker,
    fatigue: FatigueSettings,
    reactions: Sequence[Reaction],
    command: str,
    predicted: SourcedTable | None = None,
    picture: str = "",
) -> str:
    """The page, as Markdown, of a worker and his or her `reactions`; `command` writes it.

    predicted: what `predictions` found; picture: name of a picture of the reactions beside the page.
    """
    human = build_human(worker)
    postures, from_hand = torques.postures(worker, human)
    parameters = fatigue_parameters(fatigue, maximum_torque(worker.strength))
    endurance = tables.endurance(parameters)
    loader = PackageLoader("fatigue_planner.output.reports.human", "")
    environment = Environment(
        loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    return environment.get_template("page.md.j2").render(
        table=markdown_table,
        noteworthy=noteworthy,
        outside=outside,
        farthest=farthest,
        met=met,
        cite=cite,
        fixed=fixed,
        command=command,
        worker=worker,
        guide_only=(worker.sex, worker.height_m, worker.mass_kg) != EXPECTED_FOR,
        degrees_of_freedom=human.model.nv - 6,
        mass_kg=human.mass_kg,
        masses=tables.masses(worker, human),
        heights=tables.heights(worker, human),
        breadths=tables.breadths(human),
        centre_of_mass=tables.centre_of_mass(worker, human),
        plausibility=tables.plausibility(reactions),
        implausible=sum(bool(reaction.findings) for reaction in reactions),
        predicted=predicted,
        picture=picture,
        ranges=tables.ranges(),
        postures=postures,
        from_hand=from_hand,
        reactions=torques.reaction_torques(reactions),
        strengths=tables.strengths(worker),
        strength_sets=tables.strength_sets(),
        endurance=endurance,
        model=model_in_words(parameters),
        from_general=abs(endurance.deviations["general"]),
        tolerance=TOLERANCE,
    )


def model_in_words(parameters: FatigueParameters) -> str:
    """What the column of the fatigue law's endurance times is."""
    rates = np.unique(parameters.fatigue_rate)
    if parameters.law.kind == "ma" and rates.size == 1:
        return f"−ln(f) / (k f) with k = {fixed(60 * float(rates[0]), 2)} per minute for every joint"
    return (
        f"the law {parameters.law.kind} from rest until f = 1 − fatigue, in each bracket with the rates of the curve's "
        "joint, in its own column with those of the general curve"
    )


def markdown_table(table: SourcedTable) -> str:
    """A table in Markdown; columns of numbers are aligned to the right."""
    columns = zip(*table.rows, strict=True)
    ruler = ["---:" if all(cell[0] in NUMERIC for cell in column) else "---" for column in columns]
    return "\n".join(f"| {' | '.join(line)} |" for line in (table.header, ruler, *table.rows))


def noteworthy(what: str, deviations: Mapping[str, float]) -> str:
    """A sentence that names every deviation above 20 %, or says that there is none; `what` says from what."""
    large = [f"{name} ({signed_percent(d)})" for name, d in deviations.items() if abs(d) > NOTEWORTHY]
    if not large:
        return f"Nothing deviates by more than {fixed(100 * NOTEWORTHY, 0)} % from {what}."
    return f"More than {fixed(100 * NOTEWORTHY, 0)} % from {what}: {', '.join(large)}."


def farthest(deviations: Mapping[str, float]) -> str:
    """The largest deviation, with its name."""
    if not deviations:
        return "nothing to compare"
    name = max(deviations, key=lambda label: abs(deviations[label]))
    return f"{name} ({signed_percent(deviations[name])})"


def met(inside: Mapping[str, bool]) -> str:
    """`3 of 5`."""
    return f"{sum(inside.values())} of {len(inside)}"


def outside(what: str, inside: Mapping[str, bool]) -> str:
    """A sentence that names what lies outside `what`."""
    names = [name for name, is_inside in inside.items() if not is_inside]
    return f"Outside {what}: {', '.join(names)}." if names else f"Everything is inside {what}."


def cite(names: Sequence[str]) -> str:
    """The sources and their marks, as a list."""
    sources = references().sources
    return "\n".join(["Sources:", "", *(f"- **{name}** [{sources[name].mark}] {sources[name].text}" for name in names)])

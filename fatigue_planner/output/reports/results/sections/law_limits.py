"""What the fatigue law forgets, and what it says cannot be done."""

import math
from collections.abc import Iterator, Mapping

from fatigue_planner.core.text import format_label, percent, significant
from fatigue_planner.fatigue.capacity import Capacity, capacity
from fatigue_planner.fatigue.entries import JOINT_GROUPS
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.skeleton import without_side
from fatigue_planner.output.figures.costs import entry_label
from fatigue_planner.output.reports.page import Block, Points, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.reactions.reaction import ReactionName

# A break forgets nearly all after this many half-lives: a hundredth is left.
FORGOTTEN_HALF_LIVES = math.log2(100)


def law_limits(report_data: ReportData) -> Iterator[Block]:
    """What to know of the fatigue law before its results are believed."""
    yield from forgetting(next(iter(report_data.fatigue.values())))  # workers differ in strength only
    yield from _shortfalls(report_data)


def forgetting(parameters: FatigueParameters) -> Iterator[Block]:
    """How fast the law forgets fatigue at rest, joint by joint, and what cannot matter under it."""
    rates = parameters.law.rest_rate(parameters)
    slowest = {without_side(group): indices[rates[indices].argmin()] for group, indices in JOINT_GROUPS.items()}
    half_lives = {joint: math.log(2) / rates[entry] for joint, entry in slowest.items()}
    shortest, longest = min(half_lives.values()), max(half_lives.values())
    times = f"{significant(longest, 2)} s at every joint"
    if shortest < longest:
        times = f"{significant(shortest, 2)} to {significant(longest, 2)} s, depending on the joint"
    yield Text(
        f"Under the fatigue law {parameters.law.kind} fatigue halves at rest in {times}; after "
        f"{significant(FORGOTTEN_HALF_LIVES * longest / 60, 2)} minutes of rest less than 1 % of it is left. So longer "
        "breaks, the order of tasks over hours and the length of a shift cannot matter in these results."
    )
    if shortest < longest:
        rows = [
            [
                format_label(joint),
                significant(parameters.fatigue_rate[entry]),
                significant(rates[entry]),
                significant(half_lives[joint], 2),
            ]
            for joint, entry in slowest.items()
        ]
        header = ["joint", "fatigue rate, 1/s", "recovery at rest, 1/s", "half-life, s"]
        yield Table("How fast each joint tires and recovers.", header, rows)


def _shortfalls(report_data: ReportData) -> Iterator[Block]:
    """Which loads exceed what is left, in every reaction repeated from rest and in the longest runs."""
    capacities = {
        reaction.name: capacity(reaction.motion, report_data.fatigue[reaction.name.worker])
        for reaction in report_data.reactions
    }
    found = {name: own.if_repeated() for name, own in capacities.items()}
    lines = [
        f"{name}: in cycle {short.cycle} {entry_label(short.entry)}, {short.time_s:.1f} s after its beginning"
        for name, short in found.items()
        if short is not None
    ]
    if not lines:
        yield Text("No reaction, however often it is repeated, asks a joint for more than is left of its strength.")
        return
    yield Text(
        f"{len(lines)} of {len(found)} reactions, repeated from rest, come to ask a joint for more than is left of its "
        "strength: from there on they cannot be done as asked, and the law describes what nobody could do."
    )
    yield Points(lines)
    rows = list(_unmet_runs(report_data, capacities))
    if rows:
        header = ["condition", "policy", "cycles that ask too much", "first", "joint"]
        caption = (
            f"Runs of {report_data.longest} cycles in which a load exceeds what is left, where the worker is known."
        )
        yield Table(caption, header, rows)


def _unmet_runs(report_data: ReportData, capacities: Mapping[ReactionName, Capacity]) -> Iterator[list[str]]:
    """For every condition and policy with such runs: the share of cycles, and the first of any run with its joint."""
    conditions = report_data.experiment.benchmark.conditions
    for (condition, n_cycles, policy), runs in report_data.courses.items():
        if n_cycles != report_data.longest or conditions[condition].hidden_worker is not None:
            continue
        worker, short, total = report_data.experiment.worker_of(conditions[condition]), [], 0
        for course in runs:
            starts = [course.start, *course.fatigue[:-1]]
            for number, (start, (action, preference)) in enumerate(zip(starts, course.reactions, strict=True), 1):
                total += 1
                own = capacities[ReactionName(worker, action, preference)]
                if (start > own.highest_start).any():
                    short.append((number, own.first_shortfall(start, number)))
        if short:
            number, first = min(short, key=lambda pair: pair[0])
            assert first is not None
            when = f"cycle {number}, {first.time_s:.1f} s"
            share = percent(len(short) / total, 0)
            yield [format_label(condition), format_label(policy), share, when, entry_label(first.entry)]

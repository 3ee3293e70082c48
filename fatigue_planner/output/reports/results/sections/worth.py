"""What planning is worth over what is done without it: first sentences of the report, and a table."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label, listing
from fatigue_planner.output.figures.style import FigureFolder, house_style, look, new_figure
from fatigue_planner.output.reports.page import Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.worth import ALTERNATIVES, PlanningWorth, Role, planning_worth, roles_of

# What is done without planning, as part of a sentence; what is said of the schedule comes last.
WORDS = {
    Role.FIXED: "the best fixed action", Role.REACTIVE: "the best reactive rule", Role.GREEDY: "the best greedy policy",
    Role.SCHEDULE: "the best schedule",
}  # fmt: skip


def worth_sentences(report_data: ReportData) -> list[str]:
    """A sentence for every condition, over the longest runs, and what could not be compared."""
    found = planning_worth(report_data.experiment, report_data.results.trials)
    sentences = [_sentence(worth) for worth in found if worth.n_cycles == report_data.longest]
    roles = roles_of(report_data.experiment)
    missing = [role for role in (*ALTERNATIVES, Role.PLANNING) if role not in roles]
    if missing:
        over = "" if Role.PLANNING in missing else f" over {listing([str(role) for role in missing])}"
        kinds = listing([f"`{ALTERNATIVES.get(role, 'lookahead')}`" for role in missing])
        sentences.append(f"What planning is worth{over} is not known: the benchmark has no policy of kind {kinds}.")
    return sentences


def _sentence(worth: PlanningWorth) -> str:
    parts = [
        worth.savings[role].compared(f"{words} (`{worth.savings[role].over}`)")
        for role, words in WORDS.items()
        if role in worth.savings
    ]
    loop = ", which is what closing the loop is worth" if Role.SCHEDULE in worth.savings else ""
    begin = f"{format_label(worth.condition).capitalize()}, {worth.n_cycles} cycles: planning (`{worth.planner}`)"
    return f"{begin} costs {listing(parts)}{loop}."


def worth_section(report_data: ReportData, figures: FigureFolder) -> Section | None:
    """The same for every number of cycles, and a figure of the longest; none where no policy plans, or all do."""
    found = planning_worth(report_data.experiment, report_data.results.trials)
    if not found:
        return None
    compared = [role for role in ALTERNATIVES if any(role in worth.savings for worth in found)]
    rows = [
        [
            format_label(worth.condition), str(worth.n_cycles), format_label(worth.planner),
            *(worth.savings[role].text() if role in worth.savings else "–" for role in compared),
        ]
        for worth in found
    ]  # fmt: skip
    data = pd.DataFrame([vars(saving) for worth in found for saving in worth.savings.values()])
    level = 1 - report_data.experiment.statistics.significance_level
    caption = (
        "What the best policy that plans saves of the cost of the best one that does not: the same runs, paired by "
        f"common random numbers, with {100 * level:g} % intervals (t) where chance has a part. Negative: it costs more."
    )
    header = ["condition", "cycles", "planner", *(f"over {role}" for role in compared)]
    note = (
        "The best of several policies of a kind is chosen by the same runs, which flatters whichever side has more. A "
        "schedule is repeated whatever happens: what planning saves over the best is what closing the loop is worth."
    )
    longest = [worth for worth in found if worth.n_cycles == report_data.longest]
    picture = figures.add("worth", worth_figure(longest), data, caption, " ".join(map(_sentence, longest)))
    return Section("What planning is worth", [picture, Table("The same in numbers.", header, rows), Text(note)])


@house_style()
def worth_figure(found: Sequence[PlanningWorth]) -> Figure:
    """By condition, what planning saves over every alternative, with intervals."""
    figure = new_figure(6.8, 1.2 + 0.75 * len(found))
    axes = figure.subplots()
    roles = [role for role in ALTERNATIVES if any(role in worth.savings for worth in found)]
    for number, role in enumerate(roles):
        there = [(row, worth.savings[role]) for row, worth in enumerate(found) if role in worth.savings]
        places = [row + 0.16 * (number - (len(roles) - 1) / 2) for row, _ in there]
        shares = [100 * saving.share for _, saving in there]
        ends = [
            [100 * max(saving.share - saving.low, 0) if saving.low < saving.high else 0 for _, saving in there],
            [100 * max(saving.high - saving.share, 0) if saving.low < saving.high else 0 for _, saving in there],
        ]
        marker, colour = look(number)
        label = f"over {role}" + (" (closing the loop)" if role == Role.SCHEDULE else "")
        axes.errorbar(shares, places, xerr=ends, fmt=marker, color=colour, markersize=4.5, capsize=2, label=label)
    axes.axvline(0, color="0.6", linewidth=0.8)
    axes.set_yticks(range(len(found)), [format_label(worth.condition) for worth in found])
    axes.set_ylim(len(found) - 0.5, -0.5)
    axes.set_xlabel(f"saved by planning, % of the cost over {found[0].n_cycles} cycles")
    axes.grid(axis="x", color="0.9")
    axes.set_axisbelow(True)
    figure.legend(loc="outside upper center", ncols=2, frameon=False)
    return figure

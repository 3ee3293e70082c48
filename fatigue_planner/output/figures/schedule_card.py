"""A schedule as one printable card: what to do in every cycle, drawn, and what it is good for."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.human.model import Human
from fatigue_planner.motion.action import Action
from fatigue_planner.output.figures.postures import SIDE, draw_human, fit_panels, landmarks, working_hands
from fatigue_planner.output.figures.style import house_style, new_figure, wrapped
from fatigue_planner.reactions.reaction import Reaction

# A4 on its side, with margins; steps in rows of so many.
WIDTH_IN, HEIGHT_IN, ACROSS = 10.7, 7.3, 4


class Step(NamedTuple):
    """A step of a schedule: a motion, shown at mid-work, and in words where the hands are then."""

    reaction: Reaction
    where: str


@house_style()
def schedule_card(
    title: str,
    actions: Sequence[str],
    human: Human,
    steps: Mapping[str, Step],
    notes: Sequence[str],
) -> tuple[Figure, pd.DataFrame]:
    """The card, and its steps as a table; `steps` by action."""
    figure = new_figure(WIDTH_IN, HEIGHT_IN)
    rows = math.ceil(len(actions) / ACROSS)
    across = min(len(actions), ACROSS)
    parts: Any = figure.subfigures(2, 1, height_ratios=[3.2, 1.0])
    top, bottom = parts
    figure.suptitle(wrapped(title, 0.9 * WIDTH_IN, 17), fontsize=17, fontweight="bold")
    panels = top.subplots(rows, across, squeeze=False).ravel()
    rows_of_table = []
    for number, (panel, action) in enumerate(zip(panels, actions, strict=False), start=1):
        reaction, where = steps[action]
        points = landmarks(human, reaction.motion.configuration[reaction.motion.middle("work")])
        draw_human(panel, human, points, SIDE, working_hands(reaction))
        panel.set_title(wrapped(f"{number}. {format_label(action)}", 0.9 * WIDTH_IN / across, 13), fontsize=13)
        folded = "\n".join(wrapped(line, 0.95 * WIDTH_IN / across, 8.5) for line in where.split("\n"))
        panel.text(0.5, -0.02, folded, transform=panel.transAxes, ha="center", va="top", fontsize=8.5)
        rows_of_table.append({"step": number, "action": action, "where": where})
    for panel in panels[len(actions) :]:
        panel.set_axis_off()
    fit_panels(panels[: len(actions)], human)
    text = [wrapped(note, 0.85 * WIDTH_IN, 11).replace("\n", "\n    ") for note in notes]
    bottom.text(0.04, 0.92, "\n".join(f"•  {note}" for note in text), fontsize=11, va="top", linespacing=1.5)
    return figure, pd.DataFrame(rows_of_table)


def where_hands_are(action: Action) -> str:
    """Where the hands begin to work, in words."""
    places = []
    for side, goal in action.goals().items():
        position = goal.path()[0].position_m
        places.append(f"{side} hand {100 * position.z:.0f} cm high, {100 * position.x:.0f} cm ahead")
    return "\n".join(places)

"""The postural reactions at mid-work (like the paper's Figure 2) and the torques they cost."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.fatigue.cycle_map import loads
from fatigue_planner.fatigue.parameters import ENTRIES, FatigueParameters
from fatigue_planner.figures.stick_figure import draw_human, set_view
from fatigue_planner.figures.style import COLOURS, new_figure, words
from fatigue_planner.human.model import Human
from fatigue_planner.reactions.reaction import Reaction


def mid_work(reaction: Reaction) -> int:
    """The tick in the middle of the work phase."""
    work = reaction.motion.phase("work")
    return int(work.start + work.stop) // 2


def posture_figure(human: Human, reactions: Sequence[Reaction]) -> tuple[Figure, pd.DataFrame]:
    """Every reaction at mid-work, and the positions of all body landmarks as data."""
    figure = new_figure(2.3 * len(reactions), 3.4)
    rows = []
    ground = np.array([[-0.25, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.25, 0.3], [-0.25, -0.3]])
    for place, reaction in enumerate(reactions, start=1):
        axes = figure.add_subplot(1, len(reactions), place, projection="3d")
        axes.plot(ground[:, 0], ground[:, 1], np.zeros(len(ground)), color="0.8", linewidth=0.8)
        points = draw_human(axes, human, reaction.motion.configuration[mid_work(reaction)])
        set_view(axes)
        axes.set_title(f"{words(reaction.name.action)}, {words(reaction.name.preference)} reaction")
        for landmark, position in points.items():
            rows.append({"action": reaction.name.action, "preference": reaction.name.preference, "landmark": landmark}
                        | dict(zip(("x_m", "y_m", "z_m"), position, strict=True)))  # fmt: skip
    return figure, pd.DataFrame(rows)


def torque_table(reactions: Sequence[Reaction], parameters: FatigueParameters) -> pd.DataFrame:
    """Mean load of every entry during work: N.m and share of the maximum torque, per reaction."""
    rows = []
    for reaction in reactions:
        mean = loads(reaction.motion.torque_nm[reaction.motion.phase("work")]).mean(axis=0)
        for entry, torque, maximum in zip(ENTRIES, mean, parameters.maximum_torque_nm, strict=True):
            rows.append(
                {
                    "action": reaction.name.action,
                    "preference": reaction.name.preference,
                    "entry": entry,
                    "mean_torque_nm": torque,
                    "share_of_maximum": torque / maximum,
                }
            )
    return pd.DataFrame(rows)


def torque_figure(reactions: Sequence[Reaction], parameters: FatigueParameters) -> tuple[Figure, pd.DataFrame]:
    """Loads above the fatigue threshold during work, as share of strength; the table holds all entries."""
    table = torque_table(reactions, parameters)
    table["threshold"] = np.tile(parameters.threshold, len(reactions))
    tiring = set(table.loc[table["share_of_maximum"] > table["threshold"], "entry"])
    entries = [entry for entry in ENTRIES if entry in tiring]
    figure = new_figure(7.2, 0.55 + 0.062 * max(len(entries), 4) * (len(reactions) + 1))
    axes = figure.subplots()
    height = 0.85 / len(reactions)
    for place, reaction in enumerate(reactions):
        own = table[(table["action"] == reaction.name.action) & (table["preference"] == reaction.name.preference)]
        shares = own.set_index("entry").loc[entries, "share_of_maximum"].to_numpy()
        axes.barh(
            np.arange(len(entries)) + (place - (len(reactions) - 1) / 2) * height,
            100 * shares,
            height,
            color=COLOURS[place % len(COLOURS)],
            label=f"{words(reaction.name.action)}, {words(reaction.name.preference)}",
        )
    thresholds = sorted(set(100 * parameters.threshold))
    for threshold in thresholds:
        axes.axvline(threshold, color="0.3", linewidth=0.8, linestyle="--")
    axes.set_yticks(range(len(entries)), [_entry_label(entry) for entry in entries])
    axes.invert_yaxis()
    axes.set_xlabel("mean load during work, % of the maximum torque (dashed: threshold of fatigue)")
    axes.legend(frameon=False, loc="lower right")
    return figure, table


def _entry_label(entry: str) -> str:
    freedom, direction = entry.split(":")
    return f"{words(freedom)} {'+' if direction == 'positive' else '−'}"

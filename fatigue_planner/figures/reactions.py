"""The postural reactions at mid-work (like the paper's Figure 2) and the torques they cost."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fatigue_planner.fatigue.cycle_map import loads
from fatigue_planner.fatigue.parameters import DIRECTIONS, ENTRIES, FatigueParameters
from fatigue_planner.figures.human_drawing import FRONT, SIDE, draw_human, draw_joint_loads, landmarks
from fatigue_planner.figures.style import COLOURS, new_figure, words
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]


def mid_work(reaction: Reaction) -> int:
    """The tick in the middle of the work phase."""
    work = reaction.motion.phase("work")
    return int(work.start + work.stop) // 2


def posture_figure(
    human: Human, reactions: Sequence[Reaction], parameters: FatigueParameters
) -> tuple[Figure, pd.DataFrame]:
    """Every reaction at mid-work from two sides, joints coloured by load; landmarks and loads as data."""
    figure = new_figure(1.85 * len(reactions), 5.2)
    axes = figure.subplots(2, len(reactions), squeeze=False)
    rows = []
    for column, reaction in enumerate(reactions):
        tick = mid_work(reaction)
        points = landmarks(human, reaction.motion.configuration[tick])
        shares = joint_shares(loads(reaction.motion.torque_nm[tick : tick + 1])[0] / parameters.maximum_torque_nm)
        for row, view in enumerate((SIDE, FRONT)):
            draw_human(axes[row, column], human, points, view)
            if column == 0:
                axes[row, column].text(
                    -0.05, 0.5, view.name, transform=axes[row, column].transAxes, rotation=90, va="center"
                )
            discs = draw_joint_loads(axes[row, column], points, shares, view)
        axes[0, column].set_title(f"{words(reaction.name.action)}, {words(reaction.name.preference)} reaction")
        share_at = {joint.child: shares[joint.name] for joint in JOINTS}
        for landmark, position in points.items():
            rows.append(
                {"action": reaction.name.action, "preference": reaction.name.preference, "landmark": landmark}
                | dict(zip(("x_m", "y_m", "z_m"), position, strict=True))
                | {"share_of_maximum": share_at.get(landmark, np.nan)}
            )
    label = "largest load at the joint, % of the maximum torque (blue square: the tool)"
    figure.colorbar(discs, ax=list(axes[1]), location="bottom", shrink=0.7, aspect=50, label=label, extend="max")
    return figure, pd.DataFrame(rows)


def joint_shares(share: Vector) -> dict[str, float]:
    """Largest share of strength in any degree of freedom and direction of each compound joint; share (78,)."""
    by_entry = dict(zip(ENTRIES, share, strict=True))
    return {
        joint.name: max(by_entry[f"{dof.name}:{way}"] for dof in joint.degrees_of_freedom for way in DIRECTIONS)
        for joint in JOINTS
    }


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
            hatch="" if place < len(COLOURS) else "///",
            label=f"{words(reaction.name.action)}, {words(reaction.name.preference)}",
        )
    thresholds = sorted(set(100 * parameters.threshold))
    for threshold in thresholds:
        axes.axvline(threshold, color="0.3", linewidth=0.8, linestyle="--")
    axes.set_yticks(range(len(entries)), [_entry_label(entry) for entry in entries])
    axes.invert_yaxis()
    axes.set_xlabel(
        "mean load during work, % of the maximum torque (dashed: threshold of fatigue)\n"
        "+ flexion, right bend, left or inward turn, abduction, thumb side; − the opposite"
    )
    axes.legend(frameon=False, loc="lower right")
    return figure, table


def _entry_label(entry: str) -> str:
    freedom, direction = entry.split(":")
    return f"{words(freedom)} {'+' if direction == 'positive' else '−'}"

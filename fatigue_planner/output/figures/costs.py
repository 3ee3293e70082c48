"""What reactions cost: loads as bars, as a map of colours and over the cycle; and long-run costs by position."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.load import load_share, loads, strength_nm
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.motion.action import Action
from fatigue_planner.output.figures.postures import FEW
from fatigue_planner.output.figures.style import COLOURS, house_style, new_figure, set_title
from fatigue_planner.pomdp.cost import FatigueCost
from fatigue_planner.reactions.reaction import Reaction, ReactionName

MAX_LOADED = 6  # entries drawn over time
FEWEST_PLACES = 6


def torque_table(reactions: Sequence[Reaction], parameters: Mapping[str, FatigueParameters]) -> pd.DataFrame:
    """Mean load of every entry during work: N.m, share of the worker's (mean) strength, and the threshold.

    NaN where a recording does not show it.
    """
    rows = []
    for reaction in reactions:
        own = parameters[reaction.name.worker]
        work = reaction.motion.phase("work")
        mean, strength = loads(reaction.motion.torque_nm[work]).mean(axis=0), strength_nm(reaction.motion, own)
        mean[np.tile(reaction.assumed, 2)] = np.nan
        most = strength[0] if len(strength) == 1 else strength[work].mean(axis=0)
        rows += [
            reaction.name._asdict()
            | {"entry": entry, "mean_torque_nm": torque, "share_of_maximum": torque / strongest, "threshold": threshold}
            for entry, torque, strongest, threshold in zip(ENTRIES, mean, most, own.threshold, strict=True)
        ]
    return pd.DataFrame(rows)


@house_style()
def torque_figure(
    reactions: Sequence[Reaction], parameters: Mapping[str, FatigueParameters]
) -> tuple[Figure, pd.DataFrame]:
    """Loads above the fatigue threshold during work, as share of strength; the table holds all entries."""
    table = torque_table(reactions, parameters)
    tiring = set(table.loc[table["share_of_maximum"] > table["threshold"], "entry"])
    entries = [entry for entry in ENTRIES if entry in tiring] or list(ENTRIES[:1])
    shares = np.array(
        [
            table.loc[(table[list(ReactionName._fields)] == list(r.name)).all(axis=1)]
            .set_index("entry")
            .loc[entries, "share_of_maximum"]
            for r in reactions
        ]
    )
    thresholds = sorted(set(table["threshold"]))
    return (_bars if len(reactions) <= FEW else _colours)(reactions, entries, shares, thresholds), table


def _bars(
    reactions: Sequence[Reaction], entries: Sequence[str], shares: np.ndarray, thresholds: Sequence[float]
) -> Figure:
    figure = new_figure(7.2, 0.55 + 0.062 * max(len(entries), 4) * (len(reactions) + 1))
    axes = figure.subplots()
    height = 0.85 / len(reactions)
    for index, reaction in enumerate(reactions):
        axes.barh(
            np.arange(len(entries)) + (index - (len(reactions) - 1) / 2) * height,
            100 * shares[index],
            height,
            color=COLOURS[index % len(COLOURS)],
            hatch="" if index < len(COLOURS) else "///",
            label=_label(reaction, reactions),
        )
    for threshold in thresholds:
        axes.axvline(100 * threshold, color="0.3", linewidth=0.8, linestyle="--")
    axes.set_yticks(range(len(entries)), [entry_label(entry) for entry in entries])
    axes.invert_yaxis()
    axes.set_xlabel(
        "mean load during work, % of the maximum torque (dashed: threshold of fatigue)\n"
        "+ flexion, right bend, left or inward turn, abduction, thumb side; − the opposite"
    )
    axes.legend(frameon=False, loc="lower right")
    return figure


def _colours(
    reactions: Sequence[Reaction], entries: Sequence[str], shares: np.ndarray, thresholds: Sequence[float]
) -> Figure:
    figure = new_figure(2.6 + 0.2 * len(entries), 1.9 + 0.13 * len(reactions))
    axes = figure.subplots()
    image = axes.imshow(100 * shares, cmap="YlOrRd", vmin=0, vmax=60, aspect="auto")
    axes.set_xticks(range(len(entries)), [entry_label(entry) for entry in entries], rotation=90, fontsize=6)
    axes.set_yticks(range(len(reactions)), [_label(reaction, reactions) for reaction in reactions], fontsize=5.5)
    bar = figure.colorbar(image, ax=axes, extend="max", label="mean load during work, % of the maximum torque")
    for threshold in thresholds:
        bar.ax.axhline(100 * threshold, color="black", linewidth=0.8, linestyle="--")
    return figure


@house_style()
def course_figure(
    reactions: Sequence[Reaction], parameters: Mapping[str, FatigueParameters]
) -> tuple[Figure, pd.DataFrame]:
    """The most loaded entries over the cycle, one panel per reaction; the table holds ten rows a second."""
    across = min(len(reactions), 4)
    figure = new_figure(2.6 * across + 1.6, 2.1 * -(-len(reactions) // across) + 0.4)
    axes = figure.subplots(-(-len(reactions) // across), across, squeeze=False, sharex=True, sharey=True)
    shares = [load_share(r.motion, parameters[r.name.worker]) for r in reactions]
    drawn = np.argsort(-np.max([share.mean(axis=0) for share in shares], axis=0))[:MAX_LOADED]
    rows = []
    for panel in axes.flat[len(reactions) :]:
        panel.set_axis_off()
    for index, (reaction, share) in enumerate(zip(reactions, shares, strict=True)):
        panel, motion = axes.flat[index], reaction.motion
        every = max(round(0.1 / motion.time_step_s), 1)
        times = np.arange(0, len(share), every) * motion.time_step_s
        for colour, entry in enumerate(drawn):
            panel.plot(
                times, 100 * share[::every, entry], color=COLOURS[colour], linewidth=1.1,
                linestyle="--" if ENTRIES[entry].startswith("left") else "-",
                label=entry_label(ENTRIES[entry]),
            )  # fmt: skip
            rows += [
                reaction.name._asdict() | {"time_s": time, "entry": ENTRIES[entry], "share_of_maximum": value}
                for time, value in zip(times, share[::every, entry], strict=True)
            ]
        work = motion.phase("work")
        panel.axvspan(work.start * motion.time_step_s, work.stop * motion.time_step_s, color="0.92", zorder=0)
        set_title(panel, _label(reaction, reactions))
    figure.supxlabel(
        "time in the cycle, s (grey: work; dashed: left side; the six entries with the highest mean load)", fontsize=9
    )
    figure.supylabel("load, % of the maximum torque", fontsize=9)
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False)
    return figure, pd.DataFrame(rows)


def _label(reaction: Reaction, among: Sequence[Reaction]) -> str:
    """The name of a reaction, with its worker only where there are several."""
    parts = reaction.name if len({other.name.worker for other in among}) > 1 else reaction.name[1:]
    return ", ".join(format_label(part) for part in parts)


def entry_label(entry: str) -> str:
    """An entry as it stands in a figure: its degree of freedom and direction."""
    freedom, direction = entry.split(":")
    return f"{format_label(freedom)} {'+' if direction == 'positive' else '−'}"


def place_table(
    actions: Mapping[str, Action], profiles: Mapping[ReactionName, CycleProfile], cost: FatigueCost
) -> pd.DataFrame:
    """Where each action begins its work (its first hand), and the long-run cost of every reaction there.

    The long-run cost is that after the same reaction has been repeated for ever: at the fixed point f = b / (1 - a) of
    its cycle map.
    """
    rows = []
    for name, profile in profiles.items():
        cycle = profile.cycle_map()
        goal = next(iter(actions[name.action].goals().values()))
        position = goal.path()[0].position_m
        fatigue = np.where(cycle.offset > 0, cycle.offset / np.maximum(1 - cycle.gain, 1e-300), 0.0)
        rows.append(
            name._asdict()
            | {
                "x_m": position.x,
                "y_m": position.y,
                "z_m": position.z,
                "long_run_cost": float(cost.of(fatigue)) + profile.posture_cost,
            }
        )
    return pd.DataFrame(rows)


@house_style()
def place_figure(table: pd.DataFrame, worker: str, preferences: Sequence[str]) -> Figure | None:
    """Panels of a worker's costs over the two coordinates that vary most, one per preference; None for few places."""
    own = table[table["worker"] == worker]
    spread = {axis: int(own[axis].nunique()) for axis in ("x_m", "y_m", "z_m")}
    across, up = sorted(sorted(spread, key=lambda axis: -spread[axis])[:2])
    if own.groupby([across, up]).ngroups < FEWEST_PLACES or min(spread[across], spread[up]) < 2:
        return None
    figure = new_figure(1.75 * len(preferences) + 1.4, 3.6)
    axes = figure.subplots(1, len(preferences), squeeze=False, sharey=True)[0]
    low, high = own["long_run_cost"].min(), own["long_run_cost"].max()
    for panel, preference in zip(axes, preferences, strict=True):
        at = own[own["preference"] == preference].groupby([across, up], as_index=False)["long_run_cost"].mean()
        if at.empty:  # no place can be worked at with this preference
            panel.set_axis_off()
            continue
        grid = at.pivot_table(index=up, columns=across, values="long_run_cost")
        image = panel.pcolormesh(
            grid.columns, grid.index, grid.to_numpy(), cmap="viridis_r", vmin=low, vmax=high, shading="nearest"
        )
        best = at.loc[at["long_run_cost"].idxmin()]
        panel.plot(best[across], best[up], marker="*", color="white", markersize=11, markeredgecolor="0.2")
        set_title(panel, f"{format_label(preference)} reaction")
        panel.set_xlabel(f"{across[0]} of the hand, m")
        panel.set_aspect("equal")
        panel.set_xticks(grid.columns, [f"{position:g}" for position in grid.columns], rotation=90)
        panel.set_yticks(grid.index, [f"{position:g}" for position in grid.index])
    axes[0].set_ylabel(f"{up[0]} of the hand, m")
    figure.colorbar(image, ax=list(axes), label="cost when repeated for ever (star: least)")
    return figure

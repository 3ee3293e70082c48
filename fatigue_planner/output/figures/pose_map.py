"""What working at each position of the hand costs in the long run, as a map."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.motion.action import Action
from fatigue_planner.output.figures.style import house_style, new_figure, set_title
from fatigue_planner.pomdp.cost import FatigueCost
from fatigue_planner.reactions.reaction import ReactionName

FEWEST_PLACES = 6


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
    figure.colorbar(image, ax=list(axes), label="cost when repeated for ever: mean of squared fatigue\n(star: least)")
    return figure

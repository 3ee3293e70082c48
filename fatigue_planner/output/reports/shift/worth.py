"""What following the plan was worth, in words and as a table."""

import math

import pandas as pd

from fatigue_planner.core.text import counted, percent, percent_range
from fatigue_planner.live.hindsight import SAMPLES, Hindsight
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Section, Table, Text
from fatigue_planner.study.statistics.pairing import records


def worth_words(worth: Hindsight | None) -> list[str]:
    """What the plan was worth, in a sentence for every other plan."""
    found = []
    for plan in worth.others if worth else ():
        assert worth is not None
        saving, low, high = worth.saving(plan)
        interval = f"(90 % interval {_interval(low, high)})"
        if not math.isfinite(saving):
            found.append(f"By the model, {plan} would have cost no fatigue, and what the robot did cost some.")
        elif low <= 0 <= high:
            found.append(f"By the model, what the robot did cost as much fatigue as {plan} would have {interval}.")
        else:
            word = "less" if saving > 0 else "more"
            found.append(
                f"By the model, what the robot did cost {percent(abs(saving))} {word} fatigue than {plan} would have "
                f"(90 % interval of what was saved: {_interval(low, high)})."
            )
    return found


def worth_section(worth: Hindsight | None, figures: FigureFolder) -> Section | None:
    """What following the plan was worth."""
    if worth is None:
        return None
    table = pd.DataFrame(
        [
            {"plan": "as it was", "mean_cost": worth.followed.mean() / worth.cycles},
            *(
                {"plan": plan, "mean_cost": costs.mean() / worth.cycles}
                | dict(zip(("saving", "low", "high"), worth.saving(plan), strict=True))
                for plan, costs in worth.others.items()
            ),
        ]
    )
    file = figures.add_table("worth", table)
    rows = [
        [row["plan"], f"{row['mean_cost']:.4f}", _share(row["saving"]), _interval(row["low"], row["high"])]
        if row["plan"] in worth.others else [row["plan"], f"{row['mean_cost']:.4f}", "–", "–"]
        for row in records(table)
    ]  # fmt: skip
    caption = (
        f"The mean cost of fatigue (Eq. 5 of the paper) of {counted(worth.cycles, 'cycle')} as they were, "
        "and as other plans would have made them; saved: of the cost of that plan. The interval holds 90 % of "
        f"{SAMPLES} workers drawn from what was believed in the end."
    )
    return Section(
        "What following the plan was worth",
        [
            Table(caption, ["plan", "mean cost", "saved", "90 % interval"], rows, file),
            Text(
                "This is an estimate, not a measurement: nobody worked under the other plans. Every worker drawn lived "
                "through the shift as it was, and again under each other plan, with the same pauses, durations and "
                "chances. Both plans were chosen before the shift. It rests on the model of fatigue and of how a "
                "worker chooses; that these are wrong is not in the interval."
            ),
        ],
    )


def _share(saving: float) -> str:
    """A fraction that was saved; of a plan that would have cost nothing there is none."""
    return percent(saving) if math.isfinite(saving) else "–"


def _interval(low: float, high: float) -> str:
    """The fractions between which most workers are; some may have no lower end."""
    return percent_range(low, high) if math.isfinite(low) else f"up to {_share(high)}"

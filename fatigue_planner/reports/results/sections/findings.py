"""What one learns, at the top of the report."""

import pandas as pd

from fatigue_planner.figures.style import words
from fatigue_planner.reports.html.blocks import Points
from fatigue_planner.reports.html.words import listing, percent, percent_range
from fatigue_planner.reports.results.material import Material
from fatigue_planner.statistics.contrast import Contrast, Verdict, contrast_of, is_compared
from fatigue_planner.statistics.rows import cells_of, records


def findings(material: Material) -> Points:
    """A few sentences, each from the tables."""
    grid, trials = material.experiment.benchmark, material.results.trials
    items = [
        f"{len(grid.policies)} policies in {len(grid.conditions)} conditions over "
        f"{listing([str(n) for n in grid.n_cycles])} cycles: {len(trials)} runs, seed {grid.seed}.",
        _leaders(material),
        *_against_the_anchor(material),
    ]
    if material.gaps is not None:
        items.append(_most_to_win(material, material.gaps))
    return Points(items)


def _leaders(material: Material) -> str:
    best = material.comparison[material.comparison["rank"] == 1]["policy"].value_counts()
    total = int(best.sum())
    return (
        "The best mean has "
        + listing([f"`{policy}` in {count}" for policy, count in best.items()])
        + f" of {total} cells (condition and number of cycles)."
    )


def _against_the_anchor(material: Material) -> list[str]:
    """For every condition the policy with the best mean in the longest runs, beside the anchor."""
    level, sentences = material.experiment.statistics.significance_level, []
    for condition, n_cycles, cell in cells_of(material.comparison):
        others = [row["policy"] for row in records(cell) if row["policy"] != material.anchor]
        pair = (condition, n_cycles, others[0], material.anchor) if others else None
        if n_cycles != material.longest or pair is None or not is_compared(material.contrasts, *pair):
            continue
        found = contrast_of(material.contrasts, *pair)
        sentences.append(
            f"{words(condition)}, {n_cycles} cycles: the best besides `{material.anchor}` is `{others[0]}`; its cost "
            f"is {_difference(found)} ({_words(found, level)})."
        )
    return sentences


def _difference(found: Contrast) -> str:
    side = "lower" if found.difference > 0 else "higher"
    share = percent(abs(found.relative_difference))
    if found.standard_error == 0:
        return f"{share} {side}"
    ends = (found.t_low / found.mean_cost, found.t_high / found.mean_cost)
    low, high = ends if found.difference > 0 else (-ends[1], -ends[0])
    return f"{share} {side}, interval {percent_range(low, high)}"


def _words(found: Contrast, level: float) -> str:
    if found.standard_error == 0:
        return "one deterministic run each"
    return {
        Verdict.BETTER: "a significant difference",
        Verdict.WORSE: "a significant difference",
        Verdict.EQUIVALENT: "equivalent within the margin",
        Verdict.UNDETERMINED: "undetermined",
    }[found.verdict(level)]


def _most_to_win(material: Material, gaps: pd.DataFrame) -> str:
    last = gaps[(gaps["n_cycles"] == material.longest) & (gaps["policy"] == material.anchor)]
    shares = [f"{percent(max(row['gap'], 0) / (1 + row['gap']))} ({words(row['condition'])})" for row in records(last)]
    return (
        f"Over {material.longest} cycles no policy whatsoever can cost less than `{material.anchor}` by more than "
        f"{listing(shares)}: a proved bound."
    )

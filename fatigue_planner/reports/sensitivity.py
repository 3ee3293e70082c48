"""The page of a sensitivity study: what one learns, which settings decide, what cannot be performed."""

from collections import Counter
from collections.abc import Sequence

import pandas as pd

from fatigue_planner.reports.markdown import table
from fatigue_planner.sensitivity.factors.factor import level_text
from fatigue_planner.sensitivity.lessons import at_headline, percent
from fatigue_planner.sensitivity.reactions import Reacted
from fatigue_planner.sensitivity.study import Study

LONGEST_REASON = 160


def sensitivity_page(
    study: Study,
    sentences: Sequence[str],
    reacted: Sequence[Reacted],
    gains: pd.DataFrame,
    importance: pd.DataFrame,
    claims: pd.DataFrame | None,
    figures: Sequence[str],
) -> str:
    """The page, as Markdown; `figures` are the paths of its images from where it stands."""
    settings = study.settings
    sections = [
        f"# Sensitivity: {settings.name}",
        "Written by `fatplan sensitivity`, not by hand.",
        *(f"{number}. {sentence}" for number, sentence in enumerate(sentences, start=1)),
        "## Which settings decide",
        f"Gains of {settings.headline.planner}, {settings.headline.condition}, {settings.headline.n_cycles} cycles.",
        importance_text(study, importance),
        *(f"![]({path})" for path in figures),
        "## All conditions and lengths",
        "At the combinations of all settings: how often the planner is significantly better or worse, and its gain.",
        _cells(reacted, gains),
        "## What was tried",
        _factors(study),
        "## What cannot be performed",
        _infeasible(reacted),
    ]
    if claims is not None:
        sections += ["## The paper's claims", _claims(claims)]
    return "\n\n".join(section for section in sections if section) + "\n"


def importance_text(study: Study, importance: pd.DataFrame) -> str:
    """A table of all factors for the headline's planner, condition and length, against every baseline."""
    here = at_headline(importance, study.settings.headline)
    here = here[here["planner"] == study.settings.headline.planner]
    rows = [
        [
            str(row["baseline"]),
            str(row["factor"]),
            _percent(row["share"]),
            f"{_percent(row['share_low'])} to {_percent(row['share_high'])}",
            "–" if pd.isna(row["p_value"]) else f"{row['p_value']:.2g}",
            _percent(row["swing"]),
            f"{row['least_at']} → {row['most_at']}" if row["swing"] > 0 else "–",
        ]
        for _, row in here.iterrows()
    ]
    header = ["gain over", "setting", "variance explained", "95 % interval", "p", "swing alone", "least → most at"]
    return table(header, rows)


def _percent(share: float) -> str:
    return "–" if pd.isna(share) else percent(share)


def _cells(reacted: Sequence[Reacted], gains: pd.DataFrame) -> str:
    names = {one.point.name for one in reacted if one.point.design == "space filling"}
    groups = gains[gains["point"].isin(names)].groupby(["planner", "baseline", "condition", "n_cycles"], sort=False)
    rows = [
        [
            *map(str, key),
            f"{(own['verdict'] == 'better').sum()} / {(own['verdict'] == 'worse').sum()} of {len(own)}",
            percent(own["gain"].median()),
            f"{percent(own['gain'].min())} to {percent(own['gain'].max())}",
        ]
        for key, own in groups
        if isinstance(key, tuple)
    ]
    if not rows:
        return "None of the combinations can be performed."
    header = ["planner", "baseline", "condition", "cycles", "better / worse", "median gain", "least to most"]
    return table(header, rows)


def _factors(study: Study) -> str:
    base = study.base_levels()
    rows = [
        [name, ", ".join(map(level_text, factor.all_levels())), level_text(base[name]), factor.reason]
        for name, factor in study.settings.factors.items()
    ]
    return table(["setting", "levels alone", "base", "why these"], rows)


def _infeasible(reacted: Sequence[Reacted]) -> str:
    counts = Counter(one.point.design for one in reacted)
    failed = [one for one in reacted if one.profiles is None]
    lost = Counter(one.point.design for one in failed)
    summary = "; ".join(f"{design}: {lost[design]} of {count} points" for design, count in counts.items())
    rows = [[one.point.name, _short(one.reason)] for one in failed]
    return f"{summary}." + (f"\n\n{table(['point', 'why'], rows)}" if rows else "")


def _short(reason: str) -> str:
    text = reason.replace("|", "/")
    return text if len(text) <= LONGEST_REASON else f"{text[:LONGEST_REASON]}…"


def _claims(claims: pd.DataFrame) -> str:
    wide = claims.pivot_table(index="claim", columns="verdict", values="points", fill_value=0, sort=False)
    rows = [[str(claim), *(f"{count:.0f}" for count in counts)] for claim, counts in wide.iterrows()]
    return table(["claim", *map(str, wide.columns)], rows)

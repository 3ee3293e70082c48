"""The figures of a sensitivity study."""

from collections.abc import Sequence
from pathlib import Path

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.gain_trends import trend_figure, trend_table
from fatigue_planner.output.figures.importance import importance_figure
from fatigue_planner.output.figures.style import save_figure
from fatigue_planner.output.figures.tornado import tornado_figure, tornado_table
from fatigue_planner.study.sensitivity.conclusions import DECIDING, at_headline
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.study import Study
from fatigue_planner.study.sensitivity.tables import StudyTables


def draw_study(study: Study, points: Sequence[Point], tables: StudyTables, folder: Path) -> list[Path]:
    """A tornado chart per baseline; where combinations can be performed, importance and trends; the headline's."""
    headline, baselines = study.settings.headline, study.settings.baselines
    gains, importance = (
        here[here["planner"] == headline.planner]
        for here in (at_headline(tables.gains, headline), at_headline(tables.importance, headline))
    )
    files = []
    for baseline in baselines:
        table = tornado_table(points, gains[gains["baseline"] == baseline])
        where = f"{format_label(headline.condition)}, {headline.n_cycles} cycles"
        title = f"{format_label(headline.planner)} over {format_label(baseline)}, {where}"
        files += save_figure(folder, f"tornado_{baseline}", tornado_figure(table, title), table)
    if importance["share"].notna().any():
        files += save_figure(folder, "importance", importance_figure(importance, baselines), importance)
        deciding = importance.loc[importance["baseline"] == baselines[0], "factor"].iloc[:DECIDING]
        factors = {name: study.settings.factors[name] for name in deciding}
        trends = trend_table(points, gains, list(factors))
        files += save_figure(folder, "trends", trend_figure(trends, factors, baselines), trends)
    return files

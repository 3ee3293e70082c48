"""A section of the report of your own: what the last cycle costs, as a figure and a table.

As a plug-in (`fatplan report mine.yaml --plugin examples/own_report_section.py`) the report ends with it.
"""

import fatigue_planner as fp
from fatigue_planner.output.figures.style import house_style, new_figure
from fatigue_planner.output.reports.page import Section, Table, Text


@fp.report_section
@house_style()
def last_cycle(report_data, figures):
    """What the last cycle of the longest runs costs on average; nothing if no run has two cycles."""
    if report_data.longest < 2:
        return None
    trials = report_data.results.trials
    longest = trials[trials["n_cycles"] == report_data.longest]
    costs = longest.groupby(["condition", "policy"], sort=False)["final_cost"].mean().reset_index()
    rows = [[row.condition, row.policy, f"{row.final_cost:.6f}"] for row in costs.itertuples()]

    figure = new_figure(5, 0.8 + 0.2 * len(rows))
    axes = figure.subplots()
    axes.barh([f"{condition}, {policy}" for condition, policy, _ in rows], costs["final_cost"])
    axes.set_xlabel("cost")
    in_words = "; ".join(f"{condition}, {policy}: {cost}" for condition, policy, cost in rows)
    picture = figures.add("last_cycle", figure, costs, "What the last cycle costs.", in_words)

    text = Text(f"The mean cost of the last of {report_data.longest} cycles, over all trials.")
    table = Table("Mean over the trials.", ["condition", "policy", "cost"], rows, picture.data_file)
    return Section("The last cycle", [text, picture, table])

"""Figures: no ambient setting changes them, nothing in them is cut off or printed over something else."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from conftest import ROOT
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from fatigue_planner.experiment.build import reaction_requests, worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import build_human, joint_index
from fatigue_planner.output.figures.costs import course_figure
from fatigue_planner.output.figures.postures import filmstrip, posture_figure
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.results.sections.fatigue import fatigue_figure
from fatigue_planner.output.reports.results.sections.returns import estimate_figure, returns_figure
from fatigue_planner.output.viewer.motion_clip import motion_clip_of
from fatigue_planner.reactions.reaction import Reaction

LONG = "a_name_that_is_longer_than_any_panel_is_wide"
# Draws the returns of two policies, as a process of its own.
DRAWING = """
import sys
from pathlib import Path
import pandas as pd
from fatigue_planner.output.reports.results.sections.returns import returns_figure
from fatigue_planner.output.figures.style import FigureFolder
columns = ["condition", "n_cycles", "policy", "mean", "standard_deviation", "p_value", "verdict"]
rows = [("novice", 5, "greedy", -0.1, 0.01, 0.2, "ns"), ("novice", 5, "random", -0.3, 0.02, float("nan"), "")]
table = pd.DataFrame(rows, columns=columns)
FigureFolder(Path(sys.argv[1])).add("drawn", returns_figure(table, ["novice"], ["random", "greedy"]), table)
"""
HOSTILE_RC = """
text.usetex: True
font.family: serif
font.size: 20
axes.facecolor: pink
axes.prop_cycle: cycler('color', ['k'])
savefig.facecolor: yellow
savefig.dpi: 30
svg.fonttype: none
lines.linewidth: 9
axes.formatter.use_locale: True
"""


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def drawn(folder: Path, cwd: Path, **environment: str) -> dict[str, str]:
    folder.mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("MPL", "MATPLOTLIB"))}
    env = kept | {"PYTHONPATH": str(ROOT)} | environment
    done = subprocess.run(
        [sys.executable, "-c", DRAWING, folder], cwd=cwd, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return digests(folder)


@pytest.mark.slow
def test_no_ambient_setting_changes_or_breaks_a_figure(tmp_path: Path) -> None:
    hostile = tmp_path / "hostile"
    hostile.mkdir()
    (hostile / "matplotlibrc").write_text(HOSTILE_RC)
    settings = {
        "MPLBACKEND": "module://not_installed.backend", "MPLCONFIGDIR": str(tmp_path / "empty"),
        "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "COLUMNS": "0", "NO_COLOR": "1", "FORCE_COLOR": "1",
        "PANDAS_FUTURE_INFER_STRING": "0",
    }  # fmt: skip
    plain = drawn(tmp_path / "plain", tmp_path)
    assert set(plain) == {"drawn.png", "drawn.svg", "drawn.csv"}
    assert drawn(tmp_path / "ambient", hostile, **settings) == plain


def test_settings_of_a_notebook_are_neither_used_nor_changed(tmp_path: Path) -> None:
    """As a library: matplotlib and pandas are set by the user before and after drawing."""

    def draw(folder: Path) -> dict[str, str]:
        table = comparison("novice")
        FigureFolder(folder).add("drawn", returns_figure(table, ["novice"], ["random", "greedy"]), table)
        return digests(folder)

    plain = draw(tmp_path / "plain")
    own = {"font.size": 20, "text.usetex": True, "savefig.facecolor": "yellow", "svg.hashsalt": "mine"}
    with mpl.rc_context(own), pd.option_context("display.precision", 2, "display.max_rows", 1):
        mpl.use("svg")
        before = mpl.rcParams.copy()
        assert draw(tmp_path / "set") == plain
        assert mpl.rcParams == before


def comparison(condition: str) -> pd.DataFrame:
    rows = [(condition, 5, "greedy", -0.1, 0.01, 0.2, "ns"), (condition, 5, "random", -0.3, 0.02, np.nan, "")]
    columns = ["condition", "n_cycles", "policy", "mean", "standard_deviation", "p_value", "verdict"]
    return pd.DataFrame(rows, columns=columns)


def named(reaction: Reaction, action: str, preference: str) -> Reaction:
    return replace(reaction, name=reaction.name._replace(action=action, preference=preference))


def overhead(reaction: Reaction) -> Reaction:
    """The same with the right arm raised throughout: the fist is higher than the head."""
    configuration = reaction.motion.configuration.copy()
    configuration[:, 7 + joint_index("right_shoulder_flexion")] = np.radians(175)
    configuration[:, 7 + joint_index("right_elbow_flexion")] = 0
    return replace(reaction, motion=replace(reaction.motion, configuration=configuration))


@pytest.fixture(scope="module")
def parameters(paper: Experiment) -> FatigueParameters:
    return worker_fatigue(paper)["average_man"]


def assert_nothing_is_cut(figure: Figure) -> None:
    """What is drawn in data's units lies within the limits of its panel."""
    panels = [panel for panel in figure.axes if any(isinstance(patch, Polygon) for patch in panel.patches)]
    assert panels
    for panel in panels:
        box, ((left, right), (low, high)) = panel.dataLim, (panel.get_xlim(), panel.get_ylim())
        assert left <= box.x0 and box.x1 <= right and low <= box.y0 and box.y1 <= high, panel.get_title()


def assert_titles_are_apart(figure: Figure) -> None:
    figure.draw_without_rendering()
    shown: Sequence[Axes] = [panel for panel in figure.axes if panel.get_title()]
    boxes = [panel.title.get_window_extent() for panel in shown]
    for number, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[number + 1 :]), shown[number].get_title()


def test_an_arm_overhead_is_not_cut_off(
    paper: Experiment, reactions: tuple[Reaction, ...], parameters: FatigueParameters
) -> None:
    raised = [overhead(reactions[0]), *reactions[1:]]
    figure, table = posture_figure(build_human(paper.workers["average_man"]), raised, parameters)
    assert table["z_m"].max() > 1.95
    assert_nothing_is_cut(figure)
    assert len({panel.get_ylim() for panel in figure.axes[:8]}) == 1  # all people are of one scale
    clip = motion_clip_of(reaction_requests(paper)[0], raised[0], parameters)
    assert_nothing_is_cut(filmstrip([clip], []))


@pytest.mark.parametrize("count", [4, 24])
def test_titles_of_postures_do_not_run_into_each_other(
    paper: Experiment, reactions: tuple[Reaction, ...], parameters: FatigueParameters, count: int
) -> None:
    many = [named(reactions[number % 4], f"{LONG}_{number}", LONG) for number in range(count)]
    figure, _ = posture_figure(build_human(paper.workers["average_man"]), many, parameters)
    assert_titles_are_apart(figure)


def test_titles_with_long_names_do_not_run_into_each_other(
    paper: Experiment, reactions: tuple[Reaction, ...], parameters: FatigueParameters
) -> None:
    lengths, names = [5, 20, 100], [LONG, f"{LONG}_too"]
    returns = pd.concat([comparison(name).assign(n_cycles=n_cycles) for name in names for n_cycles in lengths])
    estimates = returns.assign(extra_cost_share=0.1, low_share=0.0, high_share=0.2, anchor="greedy")
    fatigue = pd.DataFrame(
        [(name, "greedy", f"{LONG}_{group}", cycle, 0.1) for name in names for group in range(4) for cycle in (1, 2)],
        columns=["condition", "policy", "joint_group", "cycle", "highest_fatigue"],
    )
    long = [named(reactions[number], f"{LONG}_{number}", LONG) for number in range(4)]
    for figure in (
        returns_figure(returns, names, ["greedy", "random"]),
        estimate_figure(estimates, 0.01, ["greedy", "random"]),
        fatigue_figure(fatigue, ["greedy"]),
        course_figure(long, {"average_man": parameters})[0],
    ):
        assert_titles_are_apart(figure)

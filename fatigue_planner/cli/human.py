"""`fatplan human`: the worker of an experiment, shown or exported."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli.options import DEFAULT_CACHE, DEFAULT_EXPERIMENT, CacheFolder, ExperimentFile, command_line
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_reactions
from fatigue_planner.exports.urdf import urdf_text
from fatigue_planner.exports.worker_tables import joint_frame, segment_frame
from fatigue_planner.files import publish_text
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import build_human
from fatigue_planner.reports.page import human_page

app = typer.Typer(help="Show or export the digital human of an experiment.", no_args_is_help=True)


@app.command()
def show(experiment: ExperimentFile = DEFAULT_EXPERIMENT) -> None:
    """Print the worker's segments, ranges of motion and strengths."""
    worker = load_experiment(experiment).worker
    typer.echo(f"{worker.sex}, {worker.height_m} m, {worker.mass_kg} kg, strength {worker.strength}\n")
    typer.echo(segment_frame(worker).to_string(index=False, float_format="{:.4f}".format))
    typer.echo()
    typer.echo(joint_frame(worker).to_string(index=False, float_format="{:.1f}".format))


@app.command()
def export(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    output: Annotated[Path, typer.Option(help="The URDF file to write.")] = Path("human.urdf"),
    tool: Annotated[bool, typer.Option(help="With the experiment's tool in the right hand.")] = False,
) -> None:
    """Write the digital human as URDF; the pelvis is the root and free."""
    settings = load_experiment(experiment)
    human = build_human(settings.worker, settings.tool.mass_kg if tool else 0.0)
    strength = maximum_torques(settings.worker.strength)
    publish_text(output, urdf_text(human.model, strength, settings.controller.velocity_limit_radps))
    typer.echo(f"{output}: {len(human.model.names) - 2} joints, {human.mass_kg:.1f} kg")


@app.command()
def report(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    output: Annotated[Path, typer.Option(help="The Markdown page to write.")] = Path("docs/human.md"),
    cache: CacheFolder = DEFAULT_CACHE,
) -> None:
    """Write a page that compares the worker and the simulated reactions with the literature."""
    settings = load_experiment(experiment)
    reactions = load_reactions(settings, cache, command_line("simulate", experiment, cache))
    page = human_page(
        settings.worker, settings.tool.mass_kg, settings.fatigue, reactions, f"fatplan human report {experiment}"
    )
    publish_text(output, page)
    typer.echo(f"{output}: {page.count('**OUTSIDE**')} values outside their band or range")

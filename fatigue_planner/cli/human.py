"""`fatplan human`: the workers of an experiment, shown, exported, or compared with the literature."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment

Workers = Annotated[list[str] | None, typer.Option(help="Only this worker (repeatable).")]

OneWorker = Annotated[str | None, typer.Option("--worker", help="The worker, if the experiment has several.")]

app = typer.Typer(
    name="human",
    help="Show a digital human, export it, or compare it with the literature.",
    no_args_is_help=True,
)


@app.command(epilog=options.EXIT_CODES)
def show(experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT, workers: Workers = None) -> None:
    """Print the workers' segments, ranges of motion and strengths."""
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.human.worker_tables import joint_frame, segment_frame
    from fatigue_planner.study.benchmark.selection import choose

    known = load_experiment(experiment).workers
    for name in choose("workers", list(known), workers):
        person = known[name]
        about = f"{person.sex}, {person.height_m} m, {person.mass_kg} kg, strength {person.strength}"
        typer.echo(f"{name}: {about}\n")
        typer.echo(segment_frame(person).to_string(index=False, float_format="{:.4f}".format))
        typer.echo()
        typer.echo(joint_frame(person).to_string(index=False, float_format="{:.1f}".format))
        typer.echo()


@app.command(epilog=options.EXIT_CODES)
def export(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    output: Annotated[
        Path | None, typer.Option(help="The URDF file to write; results/<experiment>/<worker>.urdf if not given.")
    ] = None,
    worker: OneWorker = None,
    tool: Annotated[
        bool, typer.Option(help="With the experiment's tool, in the right hand unless tool.hand says left.")
    ] = False,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Write the digital human as URDF; the pelvis is the root and free.

    A comment in the file lists the joints in the order of the motions; programs that read it may sort them otherwise.
    """
    from fatigue_planner.core.files import publish_text
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.human.joint_data import maximum_torque
    from fatigue_planner.human.model import build_human
    from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
    from fatigue_planner.human.urdf import urdf_text

    settings = load_experiment(experiment)
    name = _one_worker(settings, worker)
    person = settings.workers[name]
    output = output or options.DEFAULT_RESULTS / settings.name / f"{name}.urdf"
    held_kg = settings.tool.mass_kg if tool else 0.0
    human = build_human(person, *((0.0, held_kg) if settings.tool.hand == "left" else (held_kg, 0.0)))
    strength = maximum_torque(person.strength).vectors()
    publish_text(output, urdf_text(human, strength, settings.controller.velocity_limit_radps))
    joints = len(DEGREES_OF_FREEDOM)
    document = {
        "file": output,
        "worker": name,
        "joints": joints,
        "mass_kg": human.mass_kg,
        "joint_order": DEGREES_OF_FREEDOM,
    }
    options.present(document, f"{output}: {joints} joints, {human.mass_kg:.1f} kg", as_json)


@app.command(epilog=options.EXIT_CODES)
def report(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    output: Annotated[
        Path | None, typer.Option(help="The Markdown page to write; results/<experiment>/<worker>.md if not given.")
    ] = None,
    worker: OneWorker = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Write a page that compares a worker and the simulated reactions with the literature."""
    from fatigue_planner.core.files import publish_text
    from fatigue_planner.experiment.build import load_reactions, worker_fatigue
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.human.model import build_human
    from fatigue_planner.output.figures.postures import posture_figure
    from fatigue_planner.output.figures.style import publish_png
    from fatigue_planner.output.reports.human.page import human_page
    from fatigue_planner.output.reports.human.predictions import predictions

    settings = load_experiment(experiment)
    name = _one_worker(settings, worker)
    output = output or options.DEFAULT_RESULTS / settings.name / f"{name}.md"
    reactions = load_reactions(settings, cache, options.command_line("simulate", experiment, cache))
    own = [reaction for reaction in reactions if reaction.name.worker == name and not reaction.key.recorded]
    command = f"fatplan human report {experiment}" + (f" --worker {name}" if worker else "")
    person, picture = settings.workers[name], ""
    if own:
        figure, _ = posture_figure(build_human(person), own, worker_fatigue(settings)[name])
        publish_png(output.with_suffix(".png"), figure)
        picture = output.with_suffix(".png").name
    page = human_page(person, settings.fatigue, own, command, predictions(person), picture)
    publish_text(output, page)
    outside = page.count("**OUTSIDE**")
    document = {"file": output, "worker": name, "outside": outside}
    options.present(document, f"{output}: {outside} values outside their band or range", as_json)


def _one_worker(settings: "Experiment", wanted: str | None) -> str:
    """The worker named, or the only one. Raises SelectionError if there are several and none is named."""
    from fatigue_planner.study.benchmark.selection import choose

    if wanted is None and len(settings.workers) > 1:
        raise SelectionError(f"--worker: is missing; choose one of {', '.join(settings.workers)}.")
    (name,) = choose("worker", list(settings.workers), [wanted] if wanted else None)
    return name

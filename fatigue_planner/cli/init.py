"""`fatplan init`: a file to begin with."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import ExperimentError, OutputFolderError

EXPERIMENT = """\
# Your own workstation. Change what is below, then run
#   fatplan validate {file}     is the file right, and what does it leave to defaults?
#   fatplan simulate {file}     how a worker reacts to every action
#   fatplan view {file}         watch it
#   fatplan benchmark {file}    which policy keeps fatigue low?
# All keys are explained in the documentation, on the page "Keys of an experiment file".
name: {name}
human: natural                     # with the physiology that the paper's human leaves out

workers:
  anna: {{height_m: 1.68, mass_kg: 65, sex: female}}     # m, kg

tool: {{mass_kg: 1.5}}               # in the right hand

cycle:                             # s
  reach_s: 4
  work_s: 6
  return_s: 4

# What the robot can choose between: where it holds the object on which the worker works.
# x forward, y left, z up, in m, from the centre between the worker's feet.
actions:
  shelf:
    right_hand:
      position_m: {{x: 0.45, y: -0.2, z: 1.2}}
      orientation_deg: {{y: -90}}    # the fist points forward, thumb up
  bench:
    right_hand:
      position_m: {{x: 0.4, y: -0.2, z: 0.9}}
      orientation_deg: {{y: -90}}
"""


def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the experiment, or of its file: NAME.yaml.")],
    as_json: options.Json = False,
) -> None:
    """Write a short, commented experiment, NAME.yaml, to fill in with a task of your own."""
    import yaml
    from pydantic import TypeAdapter, ValidationError

    from fatigue_planner.core.files import publish_text
    from fatigue_planner.core.settings import Name
    from fatigue_planner.experiment.error_messages import NAME_PATTERN

    name = name.removesuffix(".yaml")
    try:
        TypeAdapter(Name).validate_python(name)
    except ValidationError as error:
        raise ExperimentError(f"NAME = {name!r}: {NAME_PATTERN}.") from error
    file = Path(f"{name}.yaml")
    if file.exists() or file.is_symlink():
        raise OutputFolderError(f"{file}: exists already and stays as it is; choose another NAME.")
    written_name = yaml.safe_dump(name).splitlines()[0]  # in quotes where YAML needs them: no
    publish_text(file, EXPERIMENT.format(file=file, name=written_name))
    options.present({"file": file, "name": name}, f"{file}: written; its comments say how to go on.", as_json)

"""`fatplan init`: a file to begin with, an experiment's, a station's or a line's."""

from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import ExperimentError, OutputFolderError, SelectionError

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

STATION = """\
# Your own workstation. Change what is below, then run
#   fatplan validate {file}     is the file right?
#   fatplan assess {file}       who can work where, what is not acceptable, which place is best
# What is not known is left out: a score that needs it then becomes a range, and says which input decides.
# All keys are explained in the documentation, on the page "A workstation".
name: {name}
about: {{company: "", plant: "", assessor: "", date: ""}}     # for the page; decides nothing

# Percentiles of stature (5 small, 95 tall), or measured people. Strength is a percentile of its own.
workers:
  small_woman: {{percentile: 5, sex: female}}
  tall_man: {{percentile: 95, sex: male}}
  anna: {{height_m: 1.68, mass_kg: 65, sex: female, handedness: left}}     # m, kg
# population: {{female: {{stature_m: {{mean: 1.66, sd: 0.065}}}}, male: {{stature_m: {{mean: 1.79, sd: 0.07}}}}}}

tools:
  screwdriver: 1.2 kg
# gun: {{mass_kg: 3, force_n: {{z: -40}}}}     # N on the hand while it works: x forward, y left, z up

# Where the hand works: x forward, y left, z up, in m, from the ground between the feet.
places:
  shelf: {{x: 0.45, y: -0.2, z: 1.4}}
  bench: {{x: 0.4, y: -0.2, z: 1.0, orientation_deg: {{y: -90}}}}     # the fist points forward, thumb up

# Everything that is done in every cycle, each at one of its places.
operations:
  screw:
    places: [shelf, bench]          # to choose from
    seconds: 10                     # at the place, the way excluded
    hand: either                    # right, left, either (the worker's better one), both
    tool: screwdriver
    times_per_cycle: 1
#   coupling: good                  # how the hand holds it: good, fair, poor, unacceptable
#   actions_per_minute: 6           # similar actions of the hand: screws, clips
#   effort_share: 0.3               # grip, as a share of the largest
#   shock: false                    # impact wrench, hammer

cycle: {{duration_s: 30}}             # the takt; what the operations leave of it is rest

# What nobody may be asked for: it excludes places and ways.
# limits: [{{measure: upper_arm_elevation, above_deg: 60, at_most_s: 5}}]
shift: {{hours: 8, breaks: [{{at_min: 120, minutes: 15}}, {{at_min: 270, minutes: 30}}]}}
"""

LINE = """\
# A line of your own. Change what is below, then run
#   fatplan validate {file}     is the file right, and are those of its stations?
#   fatplan rotate {file}       who works where in which slot of the shift, and what does that gain?
# All keys are explained in the documentation, on the page "Rotation at a line".
name: {name}

# Each has one worker all the time. A file of your own (`fatplan init --station NAME` writes one) lies beside this one;
# these three ship with fatplan. The order is that in which workers usually go on.
stations:
  lamps: {{file: trim_lamps}}
  seats: {{file: trim_seats}}
  clips: {{file: trim_clips, cycles_per_hour: 85}}     # without it, the pace is that of the station's cycle

# Pseudonyms or percentiles, no names; at least as many as stations. Body and strength as in a station's file.
crew:
  small_woman: {{percentile: 20, sex: female}}
  median_man: {{percentile: 50, sex: male}}
  measured: {{height_m: 1.84, mass_kg: 82, sex: male, not_at: [clips]}}     # where he may not work, for other reasons

shift: {{hours: 8, breaks: [{{at_min: 120, minutes: 15}}, {{at_min: 270, minutes: 30}}]}}
slots: 8                            # equally long times of work, between which workers may change places
# Where a rule forbids even the best that a worker can do: said (the worker may work there, and that is said), left_out.
forbidden: said
# What is balanced: acceptable_effort (of all joints), dose (damage), cumulative_strain_index (of the hands).
measure: acceptable_effort
"""


def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the experiment, or of its file: NAME.yaml.")],
    station: Annotated[
        bool, typer.Option("--station", help="A workstation for `fatplan assess` instead of an experiment.")
    ] = False,
    line: Annotated[
        bool, typer.Option("--line", help="A line of stations for `fatplan rotate` instead of an experiment.")
    ] = False,
    as_json: options.Json = False,
) -> None:
    """Write a short, commented experiment, workstation or line, NAME.yaml, to fill in with a task of your own."""
    import yaml
    from pydantic import TypeAdapter, ValidationError

    from fatigue_planner.core.files import publish_text
    from fatigue_planner.core.settings import Name
    from fatigue_planner.experiment.error_messages import NAME_PATTERN

    if station and line:
        raise SelectionError("--station and --line: give one of them.")
    name = name.removesuffix(".yaml")
    try:
        TypeAdapter(Name).validate_python(name)
    except ValidationError as error:
        raise ExperimentError(f"NAME = {name!r}: {NAME_PATTERN}.") from error
    file = Path(f"{name}.yaml")
    if file.exists() or file.is_symlink():
        raise OutputFolderError(f"{file}: exists already and stays as it is; choose another NAME.")
    written_name = yaml.safe_dump(name).splitlines()[0]  # in quotes where YAML needs them: no
    publish_text(file, (STATION if station else LINE if line else EXPERIMENT).format(file=file, name=written_name))
    options.present({"file": file, "name": name}, f"{file}: written; its comments say how to go on.", as_json)

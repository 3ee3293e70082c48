"""Tables of the page: the model's masses, lengths, ranges, strengths and endurance beside those of their sources."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from fatigue_planner.core.text import fixed, signed_percent
from fatigue_planner.fatigue.entries import entry_indices
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.anthropometry import segment_table
from fatigue_planner.human.joint_data import ranges_of_motion
from fatigue_planner.human.model import Human, Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.human.strength_sets import load_strengths, shipped_sets
from fatigue_planner.motion.plausibility import BARS
from fatigue_planner.motion.quality import Quality
from fatigue_planner.output.reports.human.hand_calculation import standing_masses
from fatigue_planner.output.reports.human.references import Endurance, Interval, references
from fatigue_planner.reactions.reaction import Reaction

NONE = "–"  # the cell of a number that no source gives


OTHER_MASSES = ("dempster", "dhm66", "dumas")
STRENGTH_COLUMNS = ("kamon", "anderson_young", "anderson_older")
# Entries that the table of the sets shows: the joints that carry the paper's task.
SET_ENTRIES = {
    "back extension": "lumbar_flexion:negative",
    "shoulder flexion": "shoulder_flexion:positive",
    "elbow flexion": "elbow_flexion:positive",
    "radial deviation": "wrist_deviation:positive",
    "hip extension": "hip_flexion:negative",
    "knee extension": "knee_flexion:negative",
    "plantar flexion": "ankle_flexion:negative",
}
# Biacromial breadth and span of ANSUR II in % of stature; of the eight subjects the range of shares of stature.
MEASURED_BREADTHS = {
    "between the shoulder joints": ("23.7; 22.4 (between the acromia)", (35.4 / 168, 44 / 178)),
    "arm span": ("103.3; 101.9", (163 / 168, 197 / 182)),
}
ENDURANCE_LOADS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
# Where the model has to follow the general curve of endurance.
TESTED_LOADS = (0.2, 0.5)


@dataclass(frozen=True)
class SourcedTable:
    """A table, and what the sentences below it are made from.

    `deviations` (model / source - 1) and `inside` (whether a value is within its bounds) by label; `cited`
    names the sources.
    """

    header: Sequence[str]
    rows: list[list[str]] = field(default_factory=list)
    deviations: dict[str, float] = field(default_factory=dict)
    inside: dict[str, bool] = field(default_factory=dict)
    cited: list[str] = field(default_factory=list)


def interval(bounds: Interval | None, digits: int = 1) -> str:
    """`least to most`, one number if both are the same, a dash for none."""
    return NONE if bounds is None else " to ".join(dict.fromkeys(fixed(bound, digits) for bound in bounds))


def verdict(value: float, bounds: Interval | None) -> str:
    """`inside` or `OUTSIDE` of the bounds, a dash if there are none."""
    return NONE if bounds is None else "inside" if bounds[0] <= value <= bounds[1] else "**OUTSIDE**"


def deviation_from(value: float, bounds: Interval) -> float:
    """Relative distance of a value from the nearer end of an interval; 0 within it."""
    return value / min(max(value, bounds[0]), bounds[1]) - 1


def masses(worker: Worker, human: Human) -> SourcedTable:
    """Masses of the model's bodies beside de Leva's sum and three other sources."""
    sources = [f"{source}, %" for source in ("de Leva", *OTHER_MASSES)]
    header = [
        "segment (one side)",
        "model, kg",
        "model, %",
        *(cell for name in sources for cell in (name, "deviation")),
    ]
    table = SourcedTable(header, cited=["de_leva", *OTHER_MASSES])
    for name, group in references().segment_masses.items():
        mass = sum(human.anthropometry.segment(part).mass_kg for part in group.bodies)
        percent = 100 * mass / worker.mass_kg
        own = sum(segment_table().segments[row][worker.sex].mass_percent for row in group.rows)
        row = [name, fixed(mass, 2), fixed(percent, 2), fixed(own, 2), signed_percent(percent / own - 1)]
        for source in OTHER_MASSES:
            value = group.percent[source]
            other = value[worker.sex] if isinstance(value, dict) else value
            table.deviations[f"{name} from {source}"] = percent / other - 1
            row += [fixed(other, 2), signed_percent(percent / other - 1)]
        table.rows.append(row)
    return table


def standing_straight(human: Human) -> tuple[dict[str, float], float]:
    """Heights of the model's frames by name and of its centre of mass above the ground, in m, all joint angles 0."""
    data = human.model.createData()
    configuration = np.concatenate([[0, 0, 0, 0, 0, 0, 1.0], np.zeros(len(DEGREES_OF_FREEDOM))])
    pin.framesForwardKinematics(human.model, data, configuration)
    heights = {frame.name: float(data.oMf[i].translation[2]) for i, frame in enumerate(human.model.frames)}
    ground = heights["right_sole"]
    centre = float(pin.centerOfMass(human.model, data, configuration)[2])
    return {name: height - ground for name, height in heights.items()}, centre - ground


def heights(worker: Worker, human: Human) -> SourcedTable:
    """Heights of joints and landmarks beside fractions of stature and the range of measured subjects."""
    cells = [cell for source in ("winter", "dhm66") for cell in (f"{source}, cm", "deviation")]
    table = SourcedTable(
        ["height of", "model, cm", *cells, "measured, cm", "verdict"], cited=["winter", "dhm66", "subjects"]
    )
    model, _ = standing_straight(human)
    for name, landmark in references().heights.items():
        height = model[landmark.body] - (human.anthropometry.length(landmark.below) if landmark.below else 0)
        row = [name, fixed(100 * height)]
        for source in ("winter", "dhm66"):
            if source in landmark.share:
                expected = landmark.share[source] * worker.height_m
                table.deviations[f"{name} from {source}"] = height / expected - 1
                row += [fixed(100 * expected), signed_percent(height / expected - 1)]
            else:
                row += [NONE, NONE]
        measured = None
        if landmark.measured:
            shares = [subject[landmark.measured] / subject["height_cm"] for subject in references().measured_subjects]
            measured = (min(shares) * worker.height_m, max(shares) * worker.height_m)
            label = f"{name} ({signed_percent(deviation_from(height, measured))})"
            table.inside[label] = measured[0] <= height <= measured[1]
        shown = measured and (100 * measured[0], 100 * measured[1])
        table.rows.append([*row, interval(shown), verdict(height, measured)])
    return table


def centre_of_mass(worker: Worker, human: Human) -> SourcedTable:
    """Height of the centre of mass by Pinocchio, by a moment sum of the model's table, and by Winter's."""
    table = SourcedTable(
        ["calculation", "cm", "% of stature", "model's deviation"], cited=["de_leva", "dempster", "winter"]
    )
    pairs = standing_masses(human.anthropometry)
    winter = sum(
        part.mass * (part.lower + part.from_lower * (part.upper - part.lower))
        for part in references().winter_body.values()
    )
    _, model = standing_straight(human)
    calculations = {
        "model, by Pinocchio": model,
        "moment sum of the model's segment table, by hand [C]": (
            sum(mass * height for mass, height in pairs) / sum(mass for mass, _ in pairs)
        ),
        "moment sum of Winter's segments (HAT, thighs, shanks, feet), by hand [C]": winter * worker.height_m,
    }
    for name, height in calculations.items():
        table.deviations[name] = model / height - 1
        cells = [fixed(100 * height), fixed(100 * height / worker.height_m, 2)]
        table.rows.append([name, *cells, signed_percent(model / height - 1)])
    return table


def ranges() -> SourcedTable:
    """Both ends of every range of motion, what the sources say, and whether the model is between them."""
    table = SourcedTable(["end of the range", "model, °", "sources, °", "verdict"])
    for row in references().ranges_of_motion:
        name = " + ".join(freedom.replace("_", " ") for freedom in row.freedoms)
        ours = [ranges_of_motion()[freedom] for freedom in row.freedoms]
        table.cited.extend(source for source in row.ranges if source not in table.cited)
        for end, value in enumerate((sum(motion.min for motion in ours), sum(motion.max for motion in ours))):
            said = {source: angle for source, ends in row.ranges.items() if (angle := ends[end]) is not None}
            if not said:
                continue
            bounds = (min(said.values()), max(said.values()))
            label = f"{name}, {'most' if end else 'least'}"
            distance = abs(value - min(max(value, bounds[0]), bounds[1]))
            table.inside[f"{label} (by {fixed(distance, 0)}°)"] = bounds[0] <= value <= bounds[1]
            listed = ", ".join(f"{source} {fixed(angle, 0)}" for source, angle in said.items())
            table.rows.append([label, fixed(value, 0), listed, verdict(value, bounds)])
    return table


def _strengths(name: str) -> dict[str, tuple[float, str]]:
    """Torque in N.m and source of every entry of the middle and the right side of a set, by name without side."""
    return {
        f"{freedom.removeprefix('right_')}:{direction}": (entry.torque_nm, entry.source)
        for (freedom, direction), entry in load_strengths(name).entries.items()
    }


def strengths(worker: Worker) -> SourcedTable:
    """The worker's strengths beside every source that measured the same entry."""
    columns = [cell for name in STRENGTH_COLUMNS for cell in (f"{name}, N·m", "ratio")]
    sources, own = references().strengths, _strengths(worker.strength)
    table = SourcedTable(["entry (right side)", "set, N·m", *columns, "others, N·m (ratio)", "the set's own source"])
    sides = [name.removeprefix("right_") for name in DEGREES_OF_FREEDOM if not name.startswith(f"{SIDES[1]}_")]
    for entry in (f"{freedom}:{direction}" for freedom in sides for direction in ("positive", "negative")):
        torque, source = own[entry]
        known = {name: value for name, row in sources.items() if (value := row.torque_nm(entry, worker)) is not None}
        label = entry.replace("_", " ").replace(":", ", ")
        row = [label, fixed(torque)]
        for name in STRENGTH_COLUMNS:
            row += [fixed(known[name], 0), fixed(torque / known[name], 2)] if name in known else [NONE, NONE]
        listed = [
            f"{name} {fixed(value)} ({fixed(torque / value, 2)})"
            for name, value in known.items()
            if name not in STRENGTH_COLUMNS
        ]
        table.rows.append([*row, ", ".join(listed) or NONE, source])
        table.deviations.update({f"{label} from {name}": torque / value - 1 for name, value in known.items()})
        table.cited.extend(name for name in known if name not in table.cited)
    table.cited.sort(key=list(sources).index)
    return table


def strength_sets() -> SourcedTable:
    """The sets that ship with the package, with what tells them apart."""
    table = SourcedTable(["set", "who", *(f"{name}, N·m" for name in SET_ENTRIES)])
    for name in shipped_sets():
        own = _strengths(name)
        shown = [fixed(own[entry][0]) for entry in SET_ENTRIES.values()]
        table.rows.append([f"`{name}`", load_strengths(name).population, *shown])
    return table


def endurance_times_s(curve: Endurance, load: float, parameters: FatigueParameters) -> tuple[float, float]:
    """How long a load, of the strength, can be held: by the worker's law at the curve's joint, and as measured."""
    entry = entry_indices(curve.joint, "endurance")[0]
    return float(parameters.law.endurance_s(load, parameters)[entry]), curve.time_s(load)


def largest_deviation(curve: Endurance, parameters: FatigueParameters) -> float:
    """The relative deviation of the model from a curve, with its sign, where it is largest in .2 <= f <= .5."""
    times = [endurance_times_s(curve, float(load), parameters) for load in np.linspace(*TESTED_LOADS, 61)]
    return max((model / measured - 1 for model, measured in times), key=abs)


def endurance(parameters: FatigueParameters) -> SourcedTable:
    """Endurance times by the worker's fatigue law and by the measured curves, with the largest deviation from each."""
    curves = references().endurance
    header = ["load f, of the strength", "model, s", *(f"{name}, s" for name in curves)]
    table = SourcedTable(header, cited=["frey_law", "kamon_endurance"])
    for load in ENDURANCE_LOADS:
        times = {name: endurance_times_s(curve, load, parameters) for name, curve in curves.items()}
        cells = [f"{fixed(measured, 0)} ({signed_percent(model / measured - 1)})" for model, measured in times.values()]
        table.rows.append([fixed(load), fixed(times["general"][0], 0), *cells])
    table.deviations.update({name: largest_deviation(curve, parameters) for name, curve in curves.items()})
    return table


def plausibility(reactions: Sequence[Reaction]) -> SourcedTable:
    """The bars of a plausible motion, their reasons, and the worst of the reactions at each."""
    table = SourcedTable(["what is seen of a motion", "bar", "worst", "reaction", "why this bar"])
    seen = {one.name: one.quality.plausibility for one in reactions if isinstance(one.quality, Quality)}
    for name, bar in BARS.items():
        worst = max(seen, key=lambda of: float(getattr(seen[of], name)), default=None)
        value = 0.0 if worst is None else getattr(seen[worst], name) * bar.factor
        label = bar.text.format(name="a joint" if "joint" in bar.named_by else "two parts of the body")
        whose = str(worst) if worst is not None and value > 0 else NONE
        cells = [f"{bar.most * bar.factor:g} {bar.unit}", fixed(value, 1), whose]
        table.rows.append([label, *cells, bar.reason])
        table.inside[label] = value <= bar.most * bar.factor
    return table


def breadths(human: Human) -> SourcedTable:
    """Breadth of the shoulders and arm span beside those of measured people, as shares of stature."""
    person = human.anthropometry
    arm = sum(person.length(name) for name in ("upper_arm_length", "forearm_length", "hand_length"))
    shoulders = 2 * person.length("shoulder_half_width")
    table = SourcedTable(["breadth", "model, % of stature", "ANSUR II, men; women", "subjects", "verdict"])
    for name, value in (("between the shoulder joints", shoulders), ("arm span", shoulders + 2 * arm)):
        survey, measured = MEASURED_BREADTHS[name]
        share = value / person.stature_m
        bounds = (100 * measured[0], 100 * measured[1])
        table.rows.append([name, fixed(100 * share), survey, interval(bounds), verdict(100 * share, bounds)])
        table.inside[name] = measured[0] <= share <= measured[1]
    return table

"""Segment masses, heights of joints and the height of the centre of mass, beside their sources."""

import numpy as np
import pinocchio as pin

from fatigue_planner.human.anthropometry import Anthropometry, segment_table
from fatigue_planner.human.model import Human, Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.output.reports.human.hand_calculation import standing_masses
from fatigue_planner.output.reports.human.markdown import (
    deviation_from,
    noteworthy,
    number,
    outside,
    signed_percent,
    table,
    verdict,
)
from fatigue_planner.output.reports.human.references import references

OTHER_MASSES = ("dempster", "dhm66", "dumas")


def masses_section(worker: Worker) -> str:
    """Masses of the model's bodies beside de Leva's sum and three other sources."""
    body = Anthropometry(worker.height_m, worker.mass_kg, worker.sex)
    rows, deviations = [], {}
    for name, group in references().segment_masses.items():
        mass = sum(body.segment(part).mass_kg for part in group.bodies)
        share = 100 * mass / worker.mass_kg
        own = sum(segment_table().segments[row][worker.sex].mass_percent for row in group.rows)
        cells = [name, number(mass, 2), number(share, 2), number(own, 2), signed_percent(share / own - 1)]
        for source in OTHER_MASSES:
            percent = group.percent[source]
            other = percent[worker.sex] if isinstance(percent, dict) else percent
            cells += [number(other, 2), signed_percent(share / other - 1)]
            deviations[f"{name} from {source}"] = share / other - 1
        rows.append(cells)
    header = ["segment (one side)", "model, kg", "model, %", "de Leva, %", "deviation"]
    for source in OTHER_MASSES:
        header += [f"{source}, %", "deviation"]
    return "\n\n".join(
        [
            "## Segment masses",
            table(header, rows),
            "The model's neck is split off de Leva's trunk, so head and neck together weigh more than de Leva's head, "
            "and the trunk less, by the same mass.",
            noteworthy("its source", deviations),
            references().cite("de_leva", *OTHER_MASSES),
        ]
    )


def body_height_m(human: Human, body: str) -> float:
    """Height of a body's origin above the ground, standing straight."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, _straight(human))
    frames = data.oMf
    ground = frames[human.model.getFrameId("right_sole")].translation[2]
    return float(frames[human.model.getFrameId(body)].translation[2] - ground)


def centre_of_mass_height_m(human: Human) -> float:
    """Height of the model's centre of mass above the ground, standing straight."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, _straight(human))
    ground = data.oMf[human.model.getFrameId("right_sole")].translation[2]
    return float(pin.centerOfMass(human.model, data, _straight(human))[2] - ground)


def _straight(human: Human) -> np.ndarray:
    return np.concatenate([[0, 0, 0, 0, 0, 0, 1.0], np.zeros(len(DEGREES_OF_FREEDOM))])


def heights_section(worker: Worker, human: Human) -> str:
    """Heights of joints and landmarks beside fractions of stature and the range of measured subjects."""
    body = human.anthropometry
    rows, deviations, inside, cited = [], {}, {}, set()
    for name, row in references().heights.items():
        height = body_height_m(human, row.body) - (body.length(row.below) if row.below else 0)
        cells = [name, number(100 * height)]
        for source in ("winter", "dhm66"):
            share = row.share.get(source)
            deviation = height / (share * worker.height_m) - 1 if share else None
            cells += [number(100 * share * worker.height_m if share else None), signed_percent(deviation)]
            if deviation is not None:
                deviations[f"{name} from {source}"] = deviation
                cited.add(source)
        measured = _measured_m(row.measured, worker.height_m) if row.measured else None
        if measured:
            inside[f"{name} ({signed_percent(deviation_from(height, measured))})"] = (
                measured[0] <= height <= measured[1]
            )
        shown = f"{number(100 * measured[0])} to {number(100 * measured[1])}" if measured else "–"
        rows.append([*cells, shown, verdict(height, measured)])
    header = ["height of", "model, cm", "winter, cm", "deviation", "dhm66, cm", "deviation", "measured, cm", "verdict"]
    return "\n\n".join(
        [
            "## Heights of joints and landmarks, standing straight",
            table(header, rows),
            "“Measured” is the range of eight subjects' heights as shares of their stature, times this worker's: the "
            "independent test. The model's own lengths come from winter (limbs, shoulder) and dhm66 (trunk), so no "
            "deviation there only says that it is built as meant.",
            f"{outside('the measured range', inside)} {noteworthy('its source', deviations)}",
            references().cite(*sorted(cited, reverse=True), "subjects"),
        ]
    )


def _measured_m(key: str, stature_m: float) -> tuple[float, float]:
    """The range of the measured subjects' heights, scaled to a stature."""
    shares = [subject[key] / subject["height_cm"] for subject in references().measured_subjects]
    return min(shares) * stature_m, max(shares) * stature_m


def centre_of_mass_section(worker: Worker, human: Human) -> str:
    """Height of the centre of mass by Pinocchio, by a moment sum of the model's table, and by Winter's."""
    masses = standing_masses(human.anthropometry)
    by_hand = sum(mass * height for mass, height in masses) / sum(mass for mass, _ in masses)
    winter = sum(
        part.mass * (part.lower + part.from_lower * (part.upper - part.lower))
        for part in references().winter_body.values()
    )
    model = centre_of_mass_height_m(human)
    heights = {
        "model, by Pinocchio": model,
        "moment sum of the model's segment table, by hand [C]": by_hand,
        "moment sum of Winter's segments (HAT, thighs, shanks, feet), by hand [C]": winter * worker.height_m,
    }
    deviations = {name: model / height - 1 for name, height in heights.items()}
    rows = [
        [name, number(100 * height), number(100 * height / worker.height_m, 2), signed_percent(deviations[name])]
        for name, height in heights.items()
    ]
    return "\n\n".join(
        [
            "## Height of the centre of mass, standing straight",
            table(["calculation", "cm", "% of stature", "model's deviation"], rows),
            noteworthy("these sums", deviations),
            "No measured height was at hand.",
            references().cite("de_leva", "dempster", "winter"),
        ]
    )

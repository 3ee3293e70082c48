"""The end of a station's page: what is not computed, and what is to be filled in by hand."""

from collections.abc import Iterator, Mapping

import numpy as np

from fatigue_planner.output.reports.page import Points, Table, Text
from fatigue_planner.output.reports.station.blocks import AnyBlock, table
from fatigue_planner.output.reports.station.pictures import Posture
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station.assessment import Doing, StationAssessment

# Methods that need what a simulation of single motions cannot know, or whose rules could not be read in full.
NOT_COMPUTED = (
    "OCRA checklist: technical actions are not visible in a simulated motion; recovery depends on the organisation.",
    "EAWS: its tables of points could not be read, and the method is to be used by trained people.",
    "LiFFT and Shoulder Tool: the way from a moment to damage, and the equation of risk, could not be read in full.",
    "LMM (Marras): its coefficients could not be found in a source.",
    "Vibration, climate, light, noise, hand-arm grip and mental load are not simulated.",
)


def not_computed(
    assessment: StationAssessment, postures: Mapping[Doing, Posture], wording: Wording
) -> Iterator[AnyBlock]:
    """The methods that are not computed, with why, and what is known of their inputs."""
    yield Points([wording.say(each) for each in NOT_COMPUTED])
    rows = []
    for cycle in assessment.cycles:
        if all(doing in postures for doing in cycle.doings):
            seconds = np.sum([_seconds(postures[doing], assessment) for doing in cycle.doings], axis=0)
            rows.append([wording.worker(cycle.worker), *(wording.number(each, 1) for each in seconds)])
    header = ["Worker", "Trunk 20 to 60°", "Trunk above 60°", "Upper arm 60 to 80°", "Upper arm from 80°",
              "Wrist bent above 15°"]  # fmt: skip
    caption = "What these methods ask for and is known: seconds of the cycle in a posture, of the worse side."
    if rows:
        yield table(wording, caption, header, rows)


def _seconds(posture: Posture, assessment: StationAssessment) -> list[float]:
    seen = posture.seen
    often = assessment.station.operations[posture.judged.doing.operation].times_per_cycle
    arm, wrist = seen.arm_raised_deg.max(axis=1), np.abs(seen.wrist_deg).max(axis=1)
    within = [
        (seen.trunk_deg > 20) & (seen.trunk_deg <= 60), seen.trunk_deg > 60, (arm > 60) & (arm < 80), arm >= 80,
        wrist > 15,
    ]  # fmt: skip
    return [float(np.count_nonzero(each)) * seen.step_s * often for each in within]


def form(wording: Wording) -> Iterator[AnyBlock]:
    """The fields of a risk assessment."""
    yield Text(wording.say("A computation does not replace a look at the workplace, nor asking those who work there."))
    blank = [[str(number), "", "", "", "", ""] for number in range(1, 5)]
    header = ["No.", "Hazard or load", "Measure", "Responsible", "By when", "Effectiveness checked on, by, result"]
    yield table(wording, "Measures.", header, blank)


def signatures(wording: Wording) -> Table:
    """Who signs."""
    roles = ["Analyst", "Occupational safety", "Works council"]
    rows = [[wording.say(role), "", "", ""] for role in roles]
    return table(wording, "Who has taken note.", ["Role", "Name", "Date", "Signature"], rows)

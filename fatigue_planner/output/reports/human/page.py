"""The page that compares a worker's digital human with the literature."""

from collections.abc import Sequence

from fatigue_planner.fatigue.parameters import FatigueSettings
from fatigue_planner.human.model import Human, Worker, build_human
from fatigue_planner.output.reports.human.body import centre_of_mass_section, heights_section, masses_section
from fatigue_planner.output.reports.human.endurance import endurance_section
from fatigue_planner.output.reports.human.postures import postures_section
from fatigue_planner.output.reports.human.ranges import ranges_section
from fatigue_planner.output.reports.human.reaction_torques import reactions_section
from fatigue_planner.output.reports.human.strengths import sets_section, strengths_section
from fatigue_planner.reactions.reaction import Reaction

# The body for which the sums and bands of the source `plausibility` were made.
EXPECTED_FOR = ("male", 1.75, 75.0)

GUIDE_ONLY = (
    "The torques expected and the bands below were made for a man of 1.75 m and 75 kg; for this worker they are a "
    "guide only."
)

MARKS = """Marks of the sources: **[R]** read in the source named, or in public code or text that transcribes it;
**[C]** computed from numbers that were read; **[M]** recalled, not checked. A deviation is model / source − 1."""


def human_page(
    worker: Worker, tool_mass_kg: float, fatigue: FatigueSettings, reactions: Sequence[Reaction], command: str
) -> str:
    """The page, as Markdown, of a worker whose `reactions` were simulated with a tool; `command` writes it."""
    human = build_human(worker)
    sections = [
        "# The digital human against the literature",
        f"Written by `{command}`, not by hand: change the data or the model, and run it again.",
        MARKS,
        _worker_section(worker, human),
        masses_section(worker),
        heights_section(worker, human),
        centre_of_mass_section(worker, human),
        ranges_section(),
        postures_section(worker),
        reactions_section(build_human(worker, tool_mass_kg), tool_mass_kg, reactions),
        strengths_section(worker),
        sets_section(),
        endurance_section(fatigue.fatigue_rate_per_s),
    ]
    return "\n\n".join(sections) + "\n"


def _worker_section(worker: Worker, human: Human) -> str:
    lines = [
        "## The worker",
        f"{worker.sex}, {worker.height_m:g} m, {worker.mass_kg:g} kg, strength set `{worker.strength}`. "
        f"The model: {human.model.nv - 6} degrees of freedom, {human.mass_kg:.1f} kg.",
    ]
    if (worker.sex, worker.height_m, worker.mass_kg) != EXPECTED_FOR:
        lines.append(GUIDE_ONLY)
    return "\n\n".join(lines)

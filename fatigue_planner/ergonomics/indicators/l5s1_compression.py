"""Compression of the disc L5/S1, as one extensor muscle at an uncertain lever: a range."""

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Span
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM

Vector = NDArray[np.float64]

# The lever of the one muscle in m: 5 cm in older texts, 7.5 cm for large men (recalled).
LEVERS_M = (0.075, 0.05)
# NIOSH 1981, as textbooks quote it: 3400 N is the action limit, 6400 N the maximum permissible one.
ACTION_N, MOST_N = 3400.0, 6400.0
ABOVE = [body for body in BODIES if body.endswith(("abdomen", "thorax", "neck", "head", "arm", "hand"))]


def compression_n(moment_nm: Vector, weight_n: Vector, inclination_deg: Vector, lever_m: float) -> Vector:
    """Compression from the moment about L5/S1, the weight above it, and how far the spine there leans."""
    return np.asarray(np.abs(moment_nm) / lever_m + weight_n * np.cos(np.radians(inclination_deg)))


class L5S1Compression(Indicator):
    """The largest compression of the cycle, from the longest to the shortest lever that texts give."""

    title: ClassVar[str] = "compression at L5/S1"
    edition: ClassVar[str] = "one muscle with a lever of 5 to 7.5 cm; limits of NIOSH 1981"
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["l5s1_compression"] = Field(
        default="l5s1_compression", description="Compression of the disc L5/S1 by one muscle, as a range."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        low, high, worst, parts = 0.0, 0.0, None, {}
        for operation in job.operations:
            moment, weight = moment_nm(operation), weight_n(operation)
            leaning = operation.posture.lumbar_deg
            least, most = (compression_n(moment, weight, leaning, lever) for lever in LEVERS_M)
            instant = int(most.argmax())
            if most[instant] > high:
                low, high = float(least[instant]), float(most[instant])
                worst = Moment(operation.name, float(operation.posture.time_s[instant]), "", "low back")
                parts = {"moment_nm": float(moment[instant]), "weight_n": float(weight[instant])}
                parts["inclination_deg"] = float(leaning[instant])
        levels = tuple(
            Level.ACCEPTABLE if force <= ACTION_N else Level.INVESTIGATE if force <= MOST_N else Level.NOT_ACCEPTABLE
            for force in (low, high)
        )
        words = ("up to 3.4 kN", "above 3.4 kN", "above 6.4 kN")
        return self.answer(
            value=Span(low / 1000, high / 1000),
            digits=1,
            unit="kN",
            levels=(levels[0], levels[1]),
            words=(words[levels[0]], words[levels[1]]),
            worst=worst,
            parts=parts,
            remarks=(
                Phrase("One muscle with a lever of 5 to 7.5 cm: a rough estimate, with one digit."),
                Phrase("Muscles that work against each other, and the abdomen's pressure, are left out."),
            ),
        )


def moment_nm(operation: Operation) -> Vector:
    """Net moment about L5/S1 of flexion and side bend together, of muscles and tissue, at every instant, (n,)."""
    net = (operation.motion.torque_nm + operation.motion.tissue_nm)[:: operation.stride]
    joints = [DEGREES_OF_FREEDOM.index(name) for name in ("lumbar_flexion", "lumbar_lateral")]
    return np.asarray(np.linalg.norm(net[:, joints], axis=1))


def weight_n(operation: Operation) -> Vector:
    """Weight of the body above L5/S1 and of what the hands hold, and what presses them down, at every instant, (n,)."""
    person = operation.request.worker.anthropometry()
    body_kg = sum(person.segment(body).mass_kg for body in ABOVE)
    pressed_n = -operation.motion.hand_force_n[:: operation.stride, [2, 5]].sum(axis=1)
    return np.asarray((body_kg + operation.held_kg.sum(axis=1)) * GRAVITY_MPS2 + pressed_n)

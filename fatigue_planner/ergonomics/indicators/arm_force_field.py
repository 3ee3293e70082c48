"""Percent capable by the Arm Force Field: how many people's arms can exert what the hands exert where they are."""

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics import arm_force_field as field
from fatigue_planner.ergonomics.indicators.percent_capable import CapableShare, capable_percent
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Moment, Origin, Phrase, Span
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES, SIDES

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# A hand that exerts less, in N, is not judged.
LEAST_N = 1.0


class ArmForceField(CapableShare):
    """The share of people of the worker's sex whose arms are strong enough; the least of both hands and all instants.

    What a hand exerts is the weight that it holds and what it presses with. The arm's weight is the worker's.
    """

    title: ClassVar[str] = "percent capable by the Arm Force Field"
    edition: ClassVar[str] = (
        "La Delfa & Potvin 2017, coefficients of 2025-06-24; recalled: men 1.66 times as strong, the limit of a quarter"
    )
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["arm_force_field"] = Field(
        default="arm_force_field",
        description="Share of people whose arms are strong enough (La Delfa, Potvin 2017).",
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        least, worst, parts = 101.0, None, {}
        for operation in job.operations:
            for index, side in enumerate(SIDES):
                exerted = exerted_n(operation)[:, index]
                size = np.linalg.norm(exerted, axis=1)
                if not (size >= LEAST_N).any():
                    continue
                strength, gravity = strengths(operation, side, exerted)
                share = np.where(size >= LEAST_N, capable_percent(size - gravity, strength, field.VARIATION), 100.0)
                instant = int(share.argmin())
                if share[instant] < least:
                    least = float(share[instant])
                    worst = Moment(operation.name, float(operation.posture.time_s[instant]), side, "arm")
                    parts = {"force_n": float(size[instant]), "mean_strength_n": float(strength[instant])}
                    parts["of_gravity_n"] = float(gravity[instant])
        if worst is None:
            return self.does_not_apply(Phrase("the hands hold nothing and press against nothing"))
        level = self.level_of(least)
        return self.answer(
            value=Span(least, least),
            unit="%",
            levels=(level, level),
            words=(self.words[level],) * 2,
            worst=worst,
            parts=parts,
            remarks=(Phrase("Of people of the worker's sex; forces that are held, not thrown."),),
        )


def exerted_n(operation: Operation) -> NDArray[np.float64]:
    """What the hands exert at every instant, (n, 2, 3) N in world axes; a stated load goes straight up."""
    lifted = np.zeros((len(operation.posture.time_s), len(SIDES), 3))
    if operation.stated.load_kg is not None:
        lifted[:, :, 2] = operation.load_kg * GRAVITY_MPS2
        return lifted
    lifted[:, :, 2] = operation.held_kg * GRAVITY_MPS2
    return np.asarray(lifted - operation.motion.hand_force_n[:: operation.stride].reshape(-1, len(SIDES), 3))


def strengths(operation: Operation, side: str, exerted: Matrix) -> tuple[Vector, Vector]:
    """Mean strength along forces (n, 3), without gravity, and what gravity adds, each (n,) N."""
    person = operation.request.worker.anthropometry()
    poses = poses_of(tree_of(person), operation.motion.configuration[:: operation.stride])
    at = {body: poses.origin_m[:, BODIES.index(body)] for body in BODIES}
    axes = field.shoulder_axes(at["right_upper_arm"], at["left_upper_arm"], at["neck"], at["abdomen"])
    size = np.linalg.norm(exerted, axis=1, keepdims=True)
    along = np.where(size >= LEAST_N, exerted / np.maximum(size, LEAST_N), [0.0, 0.0, 1.0])
    hand, wrist, elbow = (
        field.outwards(point - at[f"{side}_upper_arm"], axes, side)
        for point in (poses.points(f"{side}_hand", person.grip_m()), at[f"{side}_hand"], at[f"{side}_forearm"])
    )
    force = field.outwards(along, axes, side)
    down = field.outwards(np.tile([0.0, 0.0, -1.0], (len(along), 1)), axes, side)
    strength = field.FACTOR[person.sex] * field.strength_n(hand, force)
    return strength, field.gravity_n(hand, wrist, elbow, force, down, person.mass_kg)

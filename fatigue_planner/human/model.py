"""The digital human as a Pinocchio model, standing on the ground."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import DataFileError, told_apart
from fatigue_planner.core.settings import Settings
from fatigue_planner.human.anthropometry import Anthropometry, HumanKind, Sex
from fatigue_planner.human.joint_data import posture
from fatigue_planner.human.multibody import multibody, stand
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.human.stance import stance_deg
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH

Vector = NDArray[np.float64]
Point = tuple[float, float, float]

# A natural stance: soles flat to a hundredth of a millimetre, centre of mass 2 cm inside heel and toe.
STANCE_TOLERANCE = 1e-5
STANCE_MARGIN_M = 0.02


def _usual_stance(worker: Mapping[str, Any]) -> dict[str, float]:
    """The stance of a worker whose other settings are these; empty if they are not complete."""
    if {"human", "height_m", "mass_kg", "sex"} - worker.keys():
        return {}
    return dict(stance_deg(Anthropometry(worker["height_m"], worker["mass_kg"], worker["sex"], worker["human"])))


class Worker(Settings):
    """A worker as an experiment describes him or her."""

    height_m: float = Field(ge=1.4, le=2.1, description="Stature in m.")
    mass_kg: float = Field(ge=40, le=150, description="Body mass in kg.")
    sex: Sex = Field(description="Decides how the mass is distributed over the segments (de Leva 1996).")
    human: HumanKind = Field(
        default="natural",
        description="The digital human: with the physiology that the paper leaves out (natural), or without it "
        "(paper). Default in an experiment: its `human`.",
    )
    strength: str = Field(
        default_factory=lambda worker: "average_woman" if worker.get("sex") == "female" else "average_man",
        min_length=1,
        max_length=MAX_PATH_LENGTH,
        description="Maximum joint torques in N.m: the name of a set that ships with fatplan, or a YAML file; "
        "average_woman:p5 is a set at a percentile of strength. Default: the average man's or woman's, by sex.",
    )
    natural_posture_deg: dict[str, float] = Field(
        default_factory=_usual_stance,
        description="Stance in which every cycle begins and to which all joints are drawn: angles in degrees by degree "
        "of freedom, the rest 0; a name without right_ or left_ means both sides. Default: the stance of the human.",
    )

    def anthropometry(self) -> Anthropometry:
        """The lengths and masses of the worker's body."""
        return Anthropometry(self.height_m, self.mass_kg, self.sex, self.human)


class Tool(Settings):
    """A hand tool: a point mass at the centre of a fist.

    hand: the hand that holds it. Left out, it is the hand that works; where both do, the right one, as in the paper.
    """

    mass_kg: float = Field(ge=0, le=30, description="Mass of the tool in kg; the paper's is 5 kg (section IV-A).")
    held: Literal["cycle", "work"] = Field(
        default="cycle", description="Whether the tool is in the hand during the whole cycle or only during work."
    )
    hand: Literal["right", "left"] | None = Field(
        default=None,
        description="Hand that holds the tool; it must have a goal in every action. Default: the hand that works, or "
        "the right one where both do.",
    )


@dataclass(frozen=True)
class Human:
    """A Pinocchio model of a worker and what the controller needs to know of it.

    Joint vectors hold the 39 degrees of freedom in the order of `skeleton.DEGREES_OF_FREEDOM`;
    configurations (46,) put position and quaternion (x, y, z, w) of the pelvis before them,
    velocities (45,) the pelvis' twist in its own frame. The world's origin is on the ground, at the
    centre between the two soles. Frames: one per body, named after it, `<side>_grip` at the centre of
    each fist and `<side>_sole` at the centre of each sole.
    """

    model: pin.Model
    anthropometry: Anthropometry
    stance: Vector
    sole_half_length_m: float
    sole_half_breadth_m: float

    @property
    def mass_kg(self) -> float:
        """Total mass, with what the hands hold."""
        return float(pin.computeTotalMass(self.model))


def build_human(
    worker: Worker,
    right_hand_kg: float = 0.0,
    left_hand_kg: float = 0.0,
    right_at_m: Point = (0.0, 0.0, 0.0),
    left_at_m: Point = (0.0, 0.0, 0.0),
) -> Human:
    """The digital human of a worker, with point masses in the hands, at points from the fists' centres in their axes.

    Raises DataFileError if the natural posture names an unknown degree of freedom, leaves a range of
    motion or does not stand on flat soles.
    """
    body = worker.anthropometry()
    model = multibody(body)
    for side, mass, at_m in (("right", right_hand_kg, right_at_m), ("left", left_hand_kg, left_at_m)):
        if mass > 0:
            grip = model.frames[model.getFrameId(f"{side}_grip")]
            point = pin.Inertia(mass, np.array(at_m), np.zeros((3, 3)))
            model.appendBodyToJoint(grip.parentJoint, point, grip.placement)
    heel, toe, half_breadth, _ = body.sole_rectangle()
    stance = stand(model, posture(worker.natural_posture_deg, "natural_posture_deg"))
    human = Human(model, body, stance, (toe - heel) / 2, half_breadth)
    _check_stance(human)
    return human


def _check_stance(human: Human) -> None:
    """Raise DataFileError unless both soles lie flat and the centre of mass is well above them."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    for side in ("right", "left"):
        sole = data.oMf[human.model.getFrameId(f"{side}_sole")]
        if abs(sole.translation[2]) > STANCE_TOLERANCE or 1 - sole.rotation[2, 2] > STANCE_TOLERANCE:
            raise DataFileError(
                f"natural_posture_deg: the {side} sole does not lie flat on the ground; bend both legs alike, or so "
                "that their soles meet the ground together."
            )
    forward = float(pin.centerOfMass(human.model, data, human.stance)[0])
    farthest = human.sole_half_length_m - STANCE_MARGIN_M
    if abs(forward) > farthest:
        away, allowed = told_apart(100 * abs(forward), 100 * farthest, ".1f")
        raise DataFileError(
            f"natural_posture_deg: the body leans, its centre of mass is {away} cm "
            f"{'in front of' if forward > 0 else 'behind'} the middle of the soles (allowed: {allowed} cm). Upright "
            "legs have hip_flexion = knee_flexion - ankle_flexion, e.g. 2.5, 5 and 2.5."
        )


def joint_index(name: str) -> int:
    """Index of a degree of freedom in a joint vector."""
    return DEGREES_OF_FREEDOM.index(name)

"""What an experiment says of every motion: phases, weights, gains, limits and accuracy."""

from typing import Annotated, Literal

from pydantic import Field

from fatigue_planner.core.settings import Settings

Positive = Annotated[float, Field(gt=0, le=1e9)]
# A phase lasts at least some ticks of the longest time step, at most ten minutes.
Duration = Annotated[float, Field(ge=0.1, le=600)]
# A cycle has at most so many ticks: half an hour at 10 ms, some 300 MB.
MAX_TICKS = 180_000

Side = Literal["right", "left"]
PhaseName = Literal["reach", "work", "return"]
PHASES: tuple[PhaseName, ...] = ("reach", "work", "return")

Segment = Literal[
    "pelvis", "abdomen", "thorax", "neck", "head",
    "right_upper_arm", "left_upper_arm", "right_forearm", "left_forearm", "right_thigh", "left_thigh",
    "right_shank", "left_shank",
]  # fmt: skip


class Cycle(Settings):
    """The phases of one cycle (paper, section IV-A: reach, work, return; 16 s in all)."""

    reach_s: Duration
    work_s: Duration
    return_s: Duration
    # What of the hand follows its trajectory on the way home: pose, or position only.
    return_hand: Literal["pose", "position"] = "pose"

    @property
    def duration_s(self) -> float:
        """Length of one cycle."""
        return self.reach_s + self.work_s + self.return_s


class Weights(Settings):
    """Weights of the tasks in the sum of squared acceleration errors (paper, section IV-C)."""

    centre_of_mass: Positive
    hand: Positive
    posture: Positive


class Stiffnesses(Settings):
    """Proportional gains in 1/s^2; the derivative gain is always critical, 2 sqrt(stiffness)."""

    centre_of_mass: Positive
    hand: Positive
    segment: Positive
    posture: Positive
    contact: Positive


class Regularisation(Settings):
    """Weights that make the solution unique where no task does (closed chain of both legs)."""

    relative_torque: Positive
    relative_wrench: Positive


class Controller(Settings):
    """Settings of the whole-body quadratic program."""

    time_step_s: float = Field(ge=1e-4, le=0.02)
    solver: Literal["daqp", "qpoases"]
    weights: Weights
    stiffness_per_s2: Stiffnesses
    regularisation: Regularisation
    # How far in front of its position in the stance the centre of mass is held.
    centre_of_mass_shift_m: float = Field(default=0.0, ge=-0.1, le=0.1)
    friction_coefficient: float = Field(gt=0, le=2)
    torque_limit_factor: Positive
    velocity_limit_radps: Positive
    acceleration_limit_radps2: Positive


class Accuracy(Settings):
    """What a motion must fulfil to be used."""

    hand_error_m: Positive
    hand_turn_rad: Positive
    equation_of_motion_nm: Positive
    limit_violation: Positive
    eased_position_rad: Positive
    foot_displacement_m: Positive
    energy_error_share: Positive

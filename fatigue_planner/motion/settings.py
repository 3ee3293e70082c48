"""What an experiment says of every motion: phases, weights, gains, limits and accuracy."""

from typing import Annotated, Literal, Self

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

    reach_s: Duration = Field(
        default=5.0, description="Duration in s of the way from the natural posture to the target; open in the paper."
    )
    work_s: Duration = Field(default=6.0, description="Duration in s of the work at the target (paper, section IV-A).")
    return_s: Duration = Field(default=5.0, description="Duration in s of the way back; open in the paper.")
    return_hand: Literal["pose", "position", "free"] = Field(
        default="free",
        description="What of the hand follows a trajectory on the way back: its pose; its position, so that it may "
        "turn freely; or nothing (free), so that the posture task alone brings the body home.",
    )

    @property
    def duration_s(self) -> float:
        """Length of one cycle."""
        return self.reach_s + self.work_s + self.return_s


class Weights(Settings):
    """Weights of the tasks in the sum of squared acceleration errors (paper, section IV-C)."""

    centre_of_mass: Positive = Field(
        default=1000.0, description="Weight of holding the centre of mass above the feet, without unit."
    )
    hand: Positive = Field(default=10.0, description="Weight of moving the hands along their paths, without unit.")
    posture: Positive = Field(
        default=1.0, description="Weight of drawing all joints to the natural posture, without unit."
    )


class Stiffnesses(Settings):
    """Proportional gains in 1/s^2; the derivative gain is always critical, 2 sqrt(stiffness).

    All are open in the paper; docs/deviations.md gives the reason of each.
    """

    centre_of_mass: Positive = Field(default=10.0, description="Gain of the centre of mass in 1/s^2.")
    hand: Positive = Field(
        default=1600.0,
        description="Gain of the hands in 1/s^2; above (0.7 / time_step_s)^2 they are no longer well damped.",
    )
    segment: Positive = Field(default=10.0, description="Gain of tasks on body segments in 1/s^2.")
    posture: Positive = Field(default=4.0, description="Gain of the joints towards a posture in 1/s^2.")
    contact: Positive = Field(default=100.0, description="Gain of the soles towards the ground in 1/s^2.")

    def or_all(self, stiffness_per_s2: float | None) -> Self:
        """These gains, or the given one in place of each."""
        if stiffness_per_s2 is None:
            return self
        return type(self)(**dict.fromkeys(type(self).model_fields, stiffness_per_s2))


class Regularisation(Settings):
    """Weights that make the solution unique where no task does (closed chain of both legs)."""

    relative_torque: Positive = Field(
        default=0.01, description="Weight of the joint torques relative to the strength, without unit."
    )
    relative_wrench: Positive = Field(
        default=0.01, description="Weight of the ground's forces relative to the body weight, without unit."
    )


class Controller(Settings):
    """Settings of the whole-body quadratic program. The paper fixes the weights; docs/deviations.md tells the rest."""

    time_step_s: float = Field(
        default=0.01, ge=1e-4, le=0.02, description="Time step of the simulation in s. Halving 0.01 s changes little."
    )
    solver: Literal["daqp", "qpoases"] = Field(default="daqp", description="Solver of the quadratic program.")
    weights: Weights = Field(
        default=Weights(), description="Weights of the tasks that every motion has (paper, section IV-C)."
    )
    stiffness_per_s2: Stiffnesses = Field(
        default=Stiffnesses(), description="Proportional gains of the tasks in 1/s^2; damping is critical."
    )
    regularisation: Regularisation = Field(
        default=Regularisation(), description="Small weights that make the solution unique where no task does."
    )
    centre_of_mass_shift_m: float = Field(
        default=0.0,
        ge=-0.1,
        le=0.1,
        description="How far in m, forward, the centre of mass is held from where it is in the stance.",
    )
    friction_coefficient: float = Field(
        default=0.5,
        gt=0,
        le=2,
        description="Friction between sole and ground, without unit; 0.5 is a usual minimum for workshop floors.",
    )
    torque_limit_factor: Positive = Field(
        default=1.0, description="Limit of every joint torque as a multiple of the worker's strength, without unit."
    )
    velocity_limit_radps: Positive = Field(default=10.0, description="Limit of every joint velocity in rad/s.")
    acceleration_limit_radps2: Positive = Field(
        default=10.0, description="How hard a joint may brake before the end of its range, in rad/s^2."
    )


class Accuracy(Settings):
    """What a motion must fulfil to be used."""

    hand_error_m: Positive = Field(
        default=0.01, description="Largest distance in m between a hand and its target during work."
    )
    hand_turn_rad: Positive = Field(
        default=0.05,
        description="Largest angle in rad between a hand and its target during work, where an orientation is given.",
    )
    equation_of_motion_nm: Positive = Field(
        default=1e-8, description="Largest residual of the equation of motion in N.m (N for forces)."
    )
    limit_violation: Positive = Field(
        default=1e-6, description="Largest violation of friction, contact, limits and balance, in SI units."
    )
    eased_position_rad: Positive = Field(
        default=0.002, description="How far in rad a joint may pass its range where its bounds had to give way."
    )
    foot_displacement_m: Positive = Field(default=0.001, description="How far in m a foot may slide during a cycle.")
    energy_error_share: Positive = Field(
        default=0.01,
        description="Largest difference between energy change and work done, as a fraction of the work done.",
    )

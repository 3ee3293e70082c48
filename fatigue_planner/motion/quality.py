"""How good a motion is: which joints are at their torque limit, what it fulfils, and the verdict on it."""

from dataclasses import asdict, dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import told_apart
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.plausibility import Plausibility
from fatigue_planner.motion.settings import Accuracy

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

AT_LIMIT = 0.999  # of the maximum torque

Verdict = Literal["ok", "degraded", "implausible", "failed"]

# Values that inform, or have a message of their own.
NOT_BARS = (
    "work_hand_error_m", "work_hand_turn_rad", "largest_load_share", "largest_load_joint", "saturated_share",
    "saturated_joint", "eased_ticks", "eased_radps2", "plausibility", "tested_causes",
)  # fmt: skip
REMEDIES = {
    "foot_displacement_m": "a smaller controller.time_step_s helps",
    "energy_error_share": "a smaller controller.time_step_s helps",
}


class Saturation(NamedTuple):
    """The joint that is at its limit for the largest share of the ticks (empty if none is), that share, and the first
    such tick.
    """

    joint: str
    share: float
    first_tick: int


def saturation(torque_nm: Matrix, positive_nm: Vector, negative_nm: Vector) -> Saturation:
    """Saturation of torques (T, 39) with maxima (39,) in both directions; where there is none, the share is 0."""
    at_limit = (torque_nm >= AT_LIMIT * positive_nm) | (torque_nm <= -AT_LIMIT * negative_nm)
    share = at_limit.mean(axis=0)
    joint = int(share.argmax())
    name = DEGREES_OF_FREEDOM[joint] if share[joint] > 0 else ""
    return Saturation(name, float(share[joint]), int(at_limit[:, joint].argmax()))


@dataclass(frozen=True)
class Quality:
    """The worst value over all ticks of everything a motion has to fulfil (SI; violations <= 0 are none).

    not_finite counts values that are not finite. record_error is how far the record is from what follows
    from itself and from what was asked for: that it starts at rest in the stance, follows its own
    accelerations, has the prescribed forces on the hands and notes the hands' true errors (SI).
    largest_load_share is the largest mean load of a joint during work, as a share of its strength.
    torque_violation_nm is of the muscles' torques; tissue_violation_nm is how far the torques that are billed to
    tissue are from its published moments at the end of each tick and what stops may bear.
    saturated_share is the share of the work during which a joint's torque is at its limit, for the joint
    where it is largest. eased_ticks counts the ticks at which joint accelerations had to leave their
    bounds, by up to eased_radps2. plausibility: what an observer sees of the motion. tested_causes: why the hands miss
    their targets, where they miss them by the usual accuracy, as found by trying (see `causes`); else empty.
    """

    not_finite: int
    record_error: float
    equation_of_motion_nm: float
    friction_violation_n: float
    unilateral_violation_n: float
    centre_of_pressure_violation_m: float
    wrench_cone_violation: float
    torque_violation_nm: float
    tissue_violation_nm: float
    position_violation_rad: float
    velocity_violation_radps: float
    centre_of_mass_violation_m: float
    energy_error_share: float
    foot_displacement_m: float
    work_hand_error_m: float
    work_hand_turn_rad: float
    largest_load_share: float
    largest_load_joint: str
    saturated_share: float
    saturated_joint: str
    eased_ticks: int
    eased_radps2: float
    plausibility: Plausibility
    tested_causes: str = ""

    def faults(self, required: Accuracy) -> list[str]:
        """What is not fulfilled, in words; empty for a motion that can be used."""
        faults = []
        if not self.work_hand_error_m <= required.hand_error_m:
            error, allowed = told_apart(self.work_hand_error_m * 100, required.hand_error_m * 100, ".1f")
            weak = f"; {self.saturated_joint} is at its maximum torque {self.saturated_share:.0%} of the time"
            faults.append(
                f"the hand stays {error} cm from its target during work (allowed: {allowed} cm)"
                f"{weak if self.saturated_share > 0 else ''}{f'. {self.tested_causes}' if self.tested_causes else ''}"
            )
        if not self.work_hand_turn_rad <= required.hand_turn_rad:
            error, allowed = told_apart(self.work_hand_turn_rad, required.hand_turn_rad, ".3f")
            faults.append(
                f"the hand stays {error} rad from its orientation during work (allowed: {allowed} rad); turn the "
                "object, or leave orientation_deg out"
            )
        bounds = {
            "equation_of_motion_nm": required.equation_of_motion_nm,
            "foot_displacement_m": required.foot_displacement_m,
            "energy_error_share": required.energy_error_share,
            "position_violation_rad": required.eased_position_rad if self.eased_ticks else required.limit_violation,
        }
        for name, value in asdict(self).items():
            bound = bounds.get(name, required.limit_violation)
            if name not in NOT_BARS and not value <= bound:
                remedy = f"; {REMEDIES[name]}" if name in REMEDIES and not self.plausibility.findings() else ""
                found, allowed = told_apart(value, bound, ".2e")
                faults.append(f"{name} = {found} (allowed: {allowed}{remedy})")
        # a body that is contorted does not get better by smaller steps
        return [*faults, *(finding.text for finding in self.plausibility.findings())] if faults else []

    def verdict(self, required: Accuracy) -> Verdict:
        """failed; implausible: possible, but not as a person would move; degraded: limits had to be eased; or ok."""
        if self.faults(required):
            return "failed"
        return self.kept_as()

    def kept_as(self) -> Verdict:
        """The verdict on a motion that fulfils everything: such a motion is used, whatever else is said of it."""
        if self.plausibility.findings():
            return "implausible"
        return "degraded" if self.eased_ticks else "ok"

    def remarks(self) -> list[str]:
        """What there is to say of a motion that fulfils everything: what makes it implausible, and what was eased."""
        return [*(finding.text for finding in self.plausibility.findings()), *filter(None, [self.degradation()])]

    def degradation(self) -> str:
        """What was eased, and how much, in words; empty if nothing was."""
        if not self.eased_ticks:
            return ""
        return (
            f"joint accelerations had to leave their bounds at {self.eased_ticks} ticks, by up to "
            f"{self.eased_radps2:.1f} rad/s^2; a joint passes its range by up to "
            f"{max(self.position_violation_rad, 0.0):.1e} rad"
        )

"""How many people of the worker's sex are strong enough at every joint (as 3DSSPP asks it)."""

from functools import cache
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field
from scipy.special import ndtr

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Span
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES, without_side

Vector = NDArray[np.float64]

# Three quarters of a population is the usual criterion (Snook 1978; NIOSH 1981 and the UAW-GM programme for women). A
# quarter is the strength limit of NIOSH's 1981 guide for men, above which work is not allowed (recalled).
ENOUGH, TOO_FEW = 75.0, 25.0
# Coefficients of variation in the positive and the negative direction. Hip, knee and ankle: Anderson, Madigan &
# Nussbaum 2007, ages 18 to 25; shoulder and elbow: the arm's, La Delfa & Potvin 2017.
VARIATION: dict[Sex, dict[str, tuple[float, float]]] = {
    "male": {"hip_flexion": (0.22, 0.30), "knee_flexion": (0.17, 0.25), "ankle_flexion": (0.15, 0.23)},
    "female": {"hip_flexion": (0.26, 0.26), "knee_flexion": (0.19, 0.18), "ankle_flexion": (0.22, 0.33)},
}
ARM, ASSUMED = 0.277, 0.28
# Whose mean strengths those of a sex are.
MEAN: dict[Sex, str] = {"male": "average_man", "female": "average_woman"}


def capable_percent(load: ArrayLike, mean: ArrayLike, variation: ArrayLike) -> Vector:
    """The share in % of people whose strength, normal with a mean and a coefficient of variation, reaches a load."""
    return np.asarray(100 * ndtr((1 - np.asarray(load) / np.asarray(mean)) / np.asarray(variation)))


class CapableShare(Indicator):
    """Methods whose value is a share of people in %: the smaller, the worse."""

    words: ClassVar[tuple[str, str, str]] = (
        "enough people can do it",
        "fewer than three quarters can do it",
        "fewer than a quarter can do it",
    )

    @staticmethod
    def level_of(percent: float) -> Level:
        """The level of a share in %."""
        if percent < TOO_FEW:
            return Level.NOT_ACCEPTABLE
        return Level.INVESTIGATE if percent < ENOUGH else Level.ACCEPTABLE


class PercentCapable(CapableShare):
    """The share of people of the worker's sex, with his body, who have the torque of the weakest link at any instant.

    Strength is normal at each joint, its mean that of the average man or woman; joints are not combined.
    """

    title: ClassVar[str] = "percent capable by torque"
    edition: ClassVar[str] = "strength sets of the average man and woman; normal distribution at each joint"
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["percent_capable"] = Field(
        default="percent_capable", description="Share of people who are strong enough at every joint."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        least, worst, joint = 101.0, None, ""
        for operation in job.operations:
            sex = operation.request.worker.sex
            positive, negative = mean_strength(sex)
            torque = operation.motion.torque_nm[:: operation.stride]
            up, down = np.array([variation(name, sex) for name in DEGREES_OF_FREEDOM]).T
            share = capable_percent(
                np.abs(torque), np.where(torque >= 0, positive, negative), np.where(torque >= 0, up, down)
            )
            instant, index = np.unravel_index(int(share.argmin()), share.shape)
            if share[instant, index] < least:
                least, joint = float(share[instant, index]), DEGREES_OF_FREEDOM[int(index)]
                side = next((one for one in SIDES if joint.startswith(one)), "")
                part = without_side(joint).replace("_", " ")
                worst = Moment(operation.name, float(operation.posture.time_s[int(instant)]), side, part)
        level = self.level_of(least)
        remarks = [
            Phrase("Of people of the same sex and body; their strengths vary by {low:g} to {high:g} %.",
                   {"low": 15, "high": 33}),
            Phrase("Where no variation was found, {assumed:g} % is assumed.", {"assumed": 100 * ASSUMED}),
        ]  # fmt: skip
        return self.answer(
            value=Span(least, least),
            unit="%",
            levels=(level, level),
            words=(self.words[level],) * 2,
            worst=worst,
            remarks=tuple(remarks),
        )


@cache
def mean_strength(sex: Sex) -> tuple[Vector, Vector]:
    """The mean strengths of a sex in the positive and the negative direction, each (39,) N.m."""
    return maximum_torque(MEAN[sex]).vectors()


def variation(freedom: str, sex: Sex) -> tuple[float, float]:
    """The coefficient of variation of a degree of freedom's strength, in the positive and the negative direction."""
    name = without_side(freedom)
    otherwise = ARM if name.startswith(("shoulder", "elbow")) else ASSUMED
    return VARIATION[sex].get(name, (otherwise, otherwise))

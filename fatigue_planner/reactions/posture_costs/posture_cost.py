"""What every kind of posture cost is: a weight, and the share of the cycle in a posture that is to be avoided."""

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.human.model import Human
from fatigue_planner.motion.motion import Motion

Array = NDArray[np.float64]


class PostureCost(Settings):
    """A posture that costs; every kind has `kind: Literal["its name"]` and says in which ticks it is taken."""

    kind: str
    weight: float = Field(
        gt=0,
        le=10,
        description="What a whole cycle in this posture adds to a cycle's cost, in the unit of that cost, which is 0 "
        "for the rested and 1 for the exhausted; half a cycle adds half. There is no usual value: it says how much "
        "fatigue the posture is worth to you.",
    )

    @abstractmethod
    def taken(self, human: Human, motion: Motion) -> NDArray[np.bool_]:
        """In which ticks the worker is in the posture, (T,)."""

    def of(self, human: Human, motion: Motion) -> float:
        """What the posture of a motion costs: the weight times the share of the cycle in it."""
        return self.weight * float(self.taken(human, motion).mean())


def positions_m(human: Human, motion: Motion, bodies: Sequence[str]) -> Array:
    """The origins of bodies (the joint centres at their near ends) in every tick, (T, bodies, 3) m."""
    model = human.model
    data, frames = model.createData(), [model.getFrameId(body) for body in bodies]
    found = np.empty((len(motion.configuration), len(frames), 3))
    for tick, configuration in enumerate(motion.configuration):
        pin.forwardKinematics(model, data, configuration)
        for index, frame in enumerate(frames):
            found[tick, index] = pin.updateFramePlacement(model, data, frame).translation
    return found


def angles_deg(lines: Array, upwards: float) -> Array:
    """Angles (...,) in degrees of lines (..., 3) from the vertical, up (1) or down (-1)."""
    cosine = upwards * lines[..., 2] / np.linalg.norm(lines, axis=-1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))))

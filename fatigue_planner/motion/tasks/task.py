"""What every acceleration task of the whole-body program is (paper, Eq. 3: the sum over i of w_i Delta_i).

A task wants an acceleration and knows the one the body would have: it writes the rows of
    Delta = || J a - (desired - drift) ||^2,   desired = a_ref + K_d (v_ref - v) + K_p (x_ref - x),
with a the generalised acceleration (45,) and critical damping, K_d = 2 sqrt(K_p).
"""

from abc import ABC, abstractmethod
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.plugins import Registry
from fatigue_planner.core.settings import Settings
from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import PHASES, PhaseName, Positive, Stiffnesses

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Task(ABC):
    """One term of the objective: `rows` equations of a weight.

    >>> import own_motion_task  # examples/own_motion_task.py
    >>> issubclass(own_motion_task.HeadHeightTask, fp.Task)
    True
    """

    def __init__(self, rows: int, weight: float, stiffness: float) -> None:
        self.rows = rows
        self.weight = weight
        self.stiffness = stiffness
        self.damping = 2 * np.sqrt(stiffness)

    @abstractmethod
    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """Write the task's Jacobian (rows, 45) and its target, desired - drift (rows,), in place."""


class PreferenceTask(Settings):
    """A task of a motion preference, as in an experiment file; every kind adds its own keys.

    >>> [task.kind for task in experiment.preferences["arm"].tasks]
    ['segment_upright']
    """

    kind: str
    weight: Positive = Field(
        description="Weight of the task, without unit; the hands' own is controller.weights.hand, 10 in the paper."
    )
    during: tuple[PhaseName, ...] = Field(default=PHASES, min_length=1, description="Phases in which the task acts.")
    stiffness_per_s2: Positive | None = Field(
        default=None,
        description="Gain of this task in 1/s^2; left out, that of its kind in controller.stiffness_per_s2.",
    )

    def build_stiffened(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """The task with its own stiffness where it has one, else with the controller's. Raises what `build` raises."""
        return self.build(human, state, stiffness.or_all(self.stiffness_per_s2))

    @abstractmethod
    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """The task for a human; `state` is evaluated in the natural stance.

        Raises DataFileError for names or angles the human does not have.
        """


TASKS = Registry("motion task", PreferenceTask)  # type: ignore[type-abstract]


class Coordinates(Settings):
    """World coordinates in m (x forward, y left, z up, from the centre between the soles); those left out are free."""

    x: float | None = Field(
        default=None,
        ge=-3,
        le=3,
        description="Distance in m forward from the centre between the soles; left out, free.",
    )
    y: float | None = Field(
        default=None,
        ge=-3,
        le=3,
        description="Distance in m to the left of the centre between the soles; left out, free.",
    )
    z: float | None = Field(default=None, ge=0, le=3, description="Height in m above the ground; left out, free.")

    @model_validator(mode="after")
    def _check_some(self) -> Self:
        if not self.axes():
            raise ValueError("give at least one of x, y and z")
        return self

    def axes(self) -> list[int]:
        """The indices of the given coordinates."""
        return [i for i, value in enumerate((self.x, self.y, self.z)) if value is not None]

    def values(self) -> Vector:
        """The given coordinates, (n,) m."""
        return np.array([value for value in (self.x, self.y, self.z) if value is not None])

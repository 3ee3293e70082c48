"""What a piece of physiology is: what it adds to the whole-body program of every tick.

A new piece is a file beside this one and a name in `registry.PIECES`: a `Piece`, which moves the body, or a `Bearer`,
which exerts torques. Whatever a piece does not define, it leaves as it is in the paper's human.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.minimum_jerk import Trajectory
from fatigue_planner.motion.motion import Phase
from fatigue_planner.motion.settings import Side
from fatigue_planner.motion.tasks.task import Task

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Scene:
    """The body and what it has to do. `state` is in the natural stance at first, later at the present tick.

    paths: the reference of every hand that has a goal, one row per tick.
    """

    human: Human
    state: BodyState
    phases: tuple[Phase, ...]
    time_step_s: float
    paths: dict[Side, Trajectory]

    @property
    def stance_rad(self) -> Vector:
        """The joint angles (39,) of the natural stance."""
        return self.human.stance[7:]

    def duration_s(self, phase: Phase) -> float:
        """How long a phase lasts."""
        return (phase.stop - phase.start) * self.time_step_s

    def times_s(self) -> Vector:
        """The time (T,) of every tick since the cycle began."""
        return np.arange(self.phases[-1].stop) * np.float64(self.time_step_s)


class TimedTask(NamedTuple):
    """A task, the fraction of its weight that it has at every tick (T,), and whether it aims at the work."""

    task: Task
    share: Vector
    aims: bool


class Piece:
    """A piece of physiology that moves the body."""

    # By how much the weight of the hands' tasks is multiplied.
    hand_weight_factor = 1.0
    # Whether hands that are turned far try both ways round.
    turns_either_way = False
    # How many limits of accelerations it has (see `limit`).
    limits = 0

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def tasks(self) -> list[TimedTask]:
        """Tasks added to those every motion has."""
        return []

    def aim(self) -> Vector | None:
        """The fraction (T,) of their weight that the tasks have which aim at the work: hands, gaze, preferences.

        None if they have all of it throughout.
        """
        return None

    def prepare(self, tick: int) -> None:
        """Take note of the tick; the state is evaluated."""

    def draw(self, weight: Vector, target: Vector) -> None:
        """Change what draws the joints: the weights and the accelerations wanted, each (39,), in place."""

    def limit(self, rows: Matrix, least: Vector) -> None:
        """Write its limits, rows (k, 45) a >= least (k,), in place: they hold as far as nothing else contradicts."""


class Bearer:
    """What bears a part of the joints' torques beside the muscles, and is not billed to them.

    It depends on the worker and the joint angles only, so that a stored motion can be checked against it.
    """

    def __init__(self, person: Anthropometry) -> None:
        self.person = person

    def bear(self, angles: Vector, moments: Vector) -> None:
        """Add what it exerts at joint angles (39,) rad to moments (39,) N.m."""

    def stiffen(self, angles: Vector, slopes: Matrix) -> None:
        """Add the derivatives of what `bear` adds, (39, 39) N.m/rad; a row is a moment, a column an angle."""

    def relieve(self, angles: Vector, torque_nm: Vector, moments: Vector) -> None:
        """Add what it exerts to moments (39,) N.m, where joints need `torque_nm` (39,) and tissue bears moments."""

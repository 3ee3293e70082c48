"""Ligaments, capsules and relaxed muscles bear a part of every joint's torque."""

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.passive_moments import add_passive_moments, add_passive_slopes, passive_table
from fatigue_planner.motion.physiology.piece import Bearer, Matrix, Vector


class PassiveTissue(Bearer):
    """The passive moments of `human.passive_moments`: in the equation of motion, not billed to the muscles."""

    def __init__(self, person: Anthropometry) -> None:
        super().__init__(person)
        self.table = passive_table(person)

    def bear(self, angles: Vector, moments: Vector) -> None:
        """See Bearer.bear."""
        add_passive_moments(self.table, angles, moments)

    def stiffen(self, angles: Vector, slopes: Matrix) -> None:
        """See Bearer.stiffen."""
        add_passive_slopes(self.table, angles, slopes)

"""Ligaments, capsules and relaxed muscles bear a part of every joint's torque."""

from fatigue_planner.human.passive_moments import passive_moments, passive_table
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, Vector


class PassiveTissue(Piece):
    """The passive moments of `human.passive_moments`: in the equation of motion, not billed to the muscles."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.table = passive_table()

    def bear(self, angles: Vector, moments: Vector, slopes: Matrix) -> None:
        """See Piece.bear."""
        passive_moments(self.table, angles, moments, slopes)

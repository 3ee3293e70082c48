"""An arm without work hangs by gravity."""

import numpy as np

from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.physiology.piece import Piece, TimedTask
from fatigue_planner.motion.tasks.segment_upright import SegmentUprightTask

WEIGHT = 2.0
STIFFNESS_PER_S2 = 10.0


class HangingArm(Piece):
    """Upper arm and forearm of a hand without a goal keep the direction that they have in the stance, in the world."""

    def tasks(self) -> list[TimedTask]:
        """See Piece.tasks."""
        state, always = self.scene.state, np.ones(self.scene.phases[-1].stop)
        frames = [
            state.frame(f"{side}_{part}")
            for side in SIDES
            for part in ("upper_arm", "forearm")
            if side not in self.scene.paths
        ]
        return [
            TimedTask(
                SegmentUprightTask(WEIGHT, STIFFNESS_PER_S2, frame, state.placement(frame).rotation[:, 2].copy()),
                always,
                aims=False,
            )
            for frame in frames
        ]

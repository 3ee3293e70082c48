"""Where a hand should be at every tick of the cycle."""

import numpy as np

from fatigue_planner.motion.action import HandGoal
from fatigue_planner.motion.minimum_jerk import Pose, Reach, Trajectory
from fatigue_planner.motion.motion import Phase


def hand_reference(home: Pose, goal: HandGoal, phases: tuple[Phase, ...], time_step_s: float) -> Trajectory:
    """From home to the first waypoint, along the waypoints, and home again: minimum jerk, from rest to rest.

    The last waypoint is held until the work is over.
    """
    reach, work, back = phases
    path = goal.path()
    poses = [home, *(waypoint.pose(home) for waypoint in path), home]
    begin_s = work.start * time_step_s
    arrivals = [begin_s + waypoint.work_time_s for waypoint in path]
    starts = [reach.start * time_step_s, *arrivals[:-1], back.start * time_step_s]
    ends = [*arrivals, back.stop * time_step_s]
    # the ticks of a leg: those from its beginning to that of the next one
    bounds = [round(start / time_step_s) for start in starts] + [back.stop]
    return Trajectory.joined(
        [
            Reach(poses[leg], poses[leg + 1], ends[leg] - starts[leg]).at(
                np.arange(bounds[leg], bounds[leg + 1]) * np.float64(time_step_s) - starts[leg]
            )
            for leg in range(len(starts))
        ]
    )

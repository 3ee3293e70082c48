"""Where a hand should be at every moment of the cycle."""

from bisect import bisect_right

from fatigue_planner.motion.action import HandGoal
from fatigue_planner.motion.minimum_jerk import MovingPose, Pose, Reach
from fatigue_planner.motion.motion import Phase


class HandReference:
    """From home to the first waypoint, along the waypoints, and home again: minimum jerk, from rest to rest."""

    def __init__(self, home: Pose, goal: HandGoal, phases: tuple[Phase, ...], time_step_s: float) -> None:
        reach, work, back = phases
        poses = [home, *(waypoint.pose(home) for waypoint in goal.path())]
        begin = work.start * time_step_s
        arrivals = [begin + waypoint.work_time_s for waypoint in goal.path()]
        self._starts = [reach.start * time_step_s, *arrivals[:-1], back.start * time_step_s]
        ends = [*arrivals, back.stop * time_step_s]
        legs = zip(self._starts, ends, poses, [*poses[1:], home], strict=True)
        self._legs = [Reach(start, end, stop - begin_s) for begin_s, stop, start, end in legs]

    def at(self, time_s: float) -> MovingPose:
        """The reference at a time since the beginning of the cycle; a waypoint is held until the next leg."""
        leg = bisect_right(self._starts, time_s) - 1
        return self._legs[leg].at(time_s - self._starts[leg])

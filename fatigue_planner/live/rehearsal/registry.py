"""The kinds of faults, by name."""

from fatigue_planner.live.rehearsal import outside_faults, robot_faults, tracker_faults
from fatigue_planner.live.rehearsal.fault import Fault

KINDS: tuple[type[Fault], ...] = (
    tracker_faults.TrackerSilent, tracker_faults.TrackerLate, tracker_faults.TrackerDouble,
    tracker_faults.TrackerContradictory, tracker_faults.TrackerAbsurd, robot_faults.RobotOtherPose,
    robot_faults.RobotNoPose, robot_faults.RobotSilent, outside_faults.ClientVanishes, outside_faults.ServerKilled,
    outside_faults.WorkerSwaps, outside_faults.Pause,
)  # fmt: skip
FAULTS: dict[str, Fault] = {kind.name: kind() for kind in KINDS}

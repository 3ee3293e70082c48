"""The robot does another pose, none, or does not say what it does."""

from fatigue_planner.live.rehearsal.cell import Cell
from fatigue_planner.live.rehearsal.fault import Fault, Reaction


class RobotOtherPose(Fault):
    """The robot does another pose than it was told."""

    name, rate = "robot_other_pose", 0.03

    def is_possible(self, cell: Cell) -> bool:
        """See Fault.is_possible."""
        return len(cell.scenario.model.actions) > 1

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        asked = cell.robot.decide(cell.cycle).action
        others = [name for name in cell.scenario.model.actions if name != asked]
        pose = cell.present(str(cell.rng.choice(others)))
        before = cell.state()["counts"]["other_actions"]
        seen = cell.work(pose)
        cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        counted = cell.state()["counts"]["other_actions"] == before + 1
        return Reaction("believed what was done", counted)  # which, the journal shows


class RobotNoPose(Fault):
    """The robot does nothing in a cycle."""

    name, rate = "robot_no_pose", 0.01

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        cell.robot.decide(cell.cycle)
        cell.worker.rest(cell.now_s + cell.cycle_s - cell.ended_s)
        cell.pass_time(cell.cycle_s)
        answer = cell.robot.call("skip", cycle=cell.cycle, duration_s=cell.cycle_s)
        cell.skip()
        return Reaction("the worker rested", answer is not None and answer.cycle == cell.cycle)


class RobotSilent(Fault):
    """For a cycle the robot does not say what it does, as when its controller is off while we write to it."""

    name, rate = "robot_silent", 0.01

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        cell.ordinary()
        pose = cell.robot.decide(cell.cycle).action
        spoke = cell.state()["robot"]
        seen = cell.work(pose)
        cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        missed = cell.state()["robot"]
        pose = cell.present()
        again = cell.state()["robot"]
        seen = cell.work(pose)
        cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        right = (spoke, missed, again) == ("answers", "unreachable", "answers")
        return Reaction("shown as unreachable until it spoke", right)

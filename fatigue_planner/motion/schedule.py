"""What a request means in ticks: phases, hand trajectories, masses in the hands, forces, switching of tasks."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.model import Human, Point, Tool, Worker, build_human
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.action import Action, HandGoal
from fatigue_planner.motion.minimum_jerk import Pose, Reach, Trajectory, minimum_jerk
from fatigue_planner.motion.motion import Phase
from fatigue_planner.motion.payload import CarriedMass, HandForce
from fatigue_planner.motion.settings import PHASES, Cycle, PhaseName, Side

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# A task that begins or ends with a phase comes and goes over this time, so that no torque jumps.
SWITCH_S = 0.5
# By how much of a tick a time may be off by rounding.
ROUNDING = 1e-6


class Run(NamedTuple):
    """Ticks [start, stop) with the same masses in the right and left hand, each at a point from the fist's centre."""

    start: int
    stop: int
    right_kg: float
    left_kg: float
    right_at_m: Point = (0.0, 0.0, 0.0)
    left_at_m: Point = (0.0, 0.0, 0.0)

    def human(self, worker: Worker) -> Human:
        """The worker with these masses."""
        return build_human(worker, *self[2:])


def phases_of(cycle: Cycle, time_step_s: float) -> tuple[Phase, ...]:
    """The phases in ticks, whole numbers of which an experiment has to give."""
    ends = np.cumsum([cycle.reach_s, cycle.work_s, cycle.return_s])
    ticks = [0, *(round(end / time_step_s) for end in ends)]
    return tuple(Phase(name, ticks[i], ticks[i + 1]) for i, name in enumerate(PHASES))


def runs_of(tool: Tool, action: Action, phases: tuple[Phase, ...]) -> tuple[Run, ...]:
    """The cycle in runs of constant masses; several in a hand are one at their centre."""
    masses = [load for load in action.loads if isinstance(load, CarriedMass)]
    if tool.mass_kg > 0:
        during: tuple[PhaseName, ...] = PHASES if tool.held == "cycle" else ("work",)
        masses.append(CarriedMass(kind="mass", hand=tool_hand(tool, action), mass_kg=tool.mass_kg, during=during))
    runs: list[Run] = []
    for phase in phases:
        held = [[m for m in masses if m.hand == side and phase.name in m.during] for side in SIDES]
        (right_kg, right_at), (left_kg, left_at) = map(_together, held)
        run = Run(phase.start, phase.stop, right_kg, left_kg, right_at, left_at)
        if runs and runs[-1][2:] == run[2:]:
            runs[-1] = runs[-1]._replace(stop=phase.stop)
        else:
            runs.append(run)
    return tuple(runs)


def _together(held: list[CarriedMass]) -> tuple[float, Point]:
    """The mass of all that a hand holds, and its centre."""
    mass_kg = sum((each.mass_kg for each in held), 0.0)
    moment = sum((each.mass_kg * each.centre_of_mass_m.vector() for each in held), np.zeros(3))
    x, y, z = (moment / mass_kg).tolist() if mass_kg > 0 else (0.0, 0.0, 0.0)
    return mass_kg, (x, y, z)


def tool_hand(tool: Tool, action: Action) -> Side:
    """The hand that holds the tool during an action: the one that is named, else the right one if it works."""
    first: Side = next(iter(action.goals()))
    return tool.hand or first


class PlannedForce(NamedTuple):
    """The forces (T, 3) N on a hand at every tick, in the world's axes or in the hand's."""

    hand: Side
    in_hand_axes: bool
    force_n: Matrix


def forces_of(action: Action, ticks: int, time_step_s: float) -> tuple[PlannedForce, ...]:
    """The forces an action brings, for every tick of the cycle."""
    times: Vector = np.arange(ticks) * np.float64(time_step_s)
    return tuple(
        PlannedForce(load.hand, load.frame == "hand", load.at(times))
        for load in action.loads
        if isinstance(load, HandForce)
    )


def weight_factor_of(during: tuple[PhaseName, ...], phases: tuple[Phase, ...], time_step_s: float) -> Vector | None:
    """The fraction of its weight a task has at every tick (T,), 0 to 1; None if it always has all of it.

    It rises with the first `SWITCH_S` of the phase it begins with and falls with those of the phase
    that follows its last, or with all of a phase that is shorter.
    """
    if set(during) == set(PHASES):
        return None
    share = np.concatenate([np.full(phase.stop - phase.start, float(phase.name in during)) for phase in phases])
    before = False
    for phase in phases:
        active = phase.name in during
        if active != before:
            rise = rise_of(phase, time_step_s)
            share[phase.start : phase.stop] = rise if active else 1 - rise
        before = active
    return share


def rise_of(phase: Phase, time_step_s: float) -> Vector:
    """From 0 to 1 over the first `SWITCH_S` of a phase, or all of a shorter one, at each of its ticks."""
    ticks = phase.stop - phase.start
    times: Vector = np.arange(1, ticks + 1) * np.float64(time_step_s)
    return minimum_jerk(times / min(SWITCH_S, ticks * time_step_s))[0]


def hand_reference(
    home: Pose, goal: HandGoal, phases: tuple[Phase, ...], time_step_s: float, other_way: bool = False
) -> Trajectory:
    """From home to the first waypoint, along the waypoints, and home again: minimum jerk, from rest to rest.

    The last waypoint is held until the work is over. other_way: whether the hand turns the longer way round on its way
    to the work and back.
    """
    reach, work, back = phases
    path = goal.path()
    poses = [home, *(waypoint.pose(home) for waypoint in path), home]
    begin_s = work.start * time_step_s
    arrivals = [begin_s + waypoint.work_time_s for waypoint in path]
    starts = [reach.start * time_step_s, *arrivals[:-1], back.start * time_step_s]
    ends = [*arrivals, back.stop * time_step_s]
    # the ticks of a leg: those from its beginning, at a tick or between two, to that of the next one
    bounds = [math.ceil(start / time_step_s - ROUNDING) for start in starts] + [back.stop]
    return Trajectory.joined(
        [
            Reach(poses[leg], poses[leg + 1], ends[leg] - starts[leg], other_way and leg in {0, len(starts) - 1}).at(
                np.arange(bounds[leg], bounds[leg + 1]) * np.float64(time_step_s) - starts[leg]
            )
            for leg in range(len(starts))
        ]
    )

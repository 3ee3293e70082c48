"""Where no hand can be: out of reach, below the floor, in the worker's own body, or where the other hand is."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import told_apart
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Human, Worker
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.schedule import hand_reference, phases_of

Vector = NDArray[np.float64]

# Parts of the body that are about where they are in the stance whatever the hands do.
_LEG = ("thigh", "shank", "foot")
ROOTED = ("pelvis", "abdomen", "thorax", "neck", "head", *(f"{side}_{part}" for side in SIDES for part in _LEG))
# How far a fist may reach into the standing body: as far as parts of the body may in a plausible motion.
ROOM_M = 0.005


def target_faults(experiment: Experiment, humans: dict[str, Human]) -> Iterator[str]:
    """Targets that some worker's hand cannot be at, each with its key."""
    for name, action in experiment.actions.items():
        for worker, human in humans.items():
            for side, goal in action.goals().items():
                key = f"actions.{name}.{side}_hand.{'position_m' if goal.position_m else 'waypoints'}"
                points = np.array([waypoint.position_m.vector() for waypoint in goal.path()])
                yield from _reach_faults(key, points, worker, experiment.workers[worker])
                yield from _body_faults(key, points, worker, human)
            yield from _meeting_faults(experiment, name, action, worker, human)


def _reach_faults(key: str, points: Vector, name: str, worker: Worker) -> Iterator[str]:
    distance, longest = float(np.linalg.norm(points, axis=1).max()), _longest_reach_m(worker)
    if distance > longest:
        away, reach = told_apart(distance, longest, ".2f")
        yield (f"{key}: {away} m from the feet; ankle, leg, trunk and arm of worker {name} together measure {reach} m.")


def _longest_reach_m(worker: Worker) -> float:
    """The length of the stretched chain from sole to fist: no posture reaches farther from the centre of the feet."""
    body = worker.anthropometry()
    arm = ["right_shoulder", "right_elbow", "right_wrist"]
    links = [
        body.joint_centre(joint) for joint in ["right_knee", "right_ankle", "right_hip", "lumbar", "thoracic", *arm]
    ]
    heel, toe, _, height = body.sole_rectangle()
    feet = np.array([(heel + toe) / 2, body.length("hip_half_width"), height])
    return float(sum(np.linalg.norm(link) for link in [feet, *links, body.grip_m()]))


def _body_faults(key: str, points: Vector, name: str, human: Human) -> Iterator[str]:
    """Points in a part of the standing body, where the worker has no room to make for a hand; and in the floor."""
    capsules = capsules_of(human.anthropometry)
    fist_m = capsules.radius_m[BODIES.index("right_hand")]
    lowest = float(points[:, 2].min())
    if lowest < fist_m:
        height, least = told_apart(100 * lowest, 100 * fist_m, ".1f")
        yield f"{key}: {height} cm above the floor; the centre of worker {name}'s fist is {least} cm above it at least."
    ends = capsules.world_ends(poses_of(tree_of(human.anthropometry), human.stance[None]))[0]
    radii = np.append(capsules.radius_m, fist_m)
    pairs = np.array([[BODIES.index(part), len(BODIES)] for part in ROOTED])
    for point in points:
        with_fist = np.concatenate([ends, np.broadcast_to(point, (1, 2, 3))])
        depth = -capsule_distances(with_fist, radii, pairs)[0]
        if depth.max() > ROOM_M:
            part = ROOTED[int(depth.argmax())].replace("_", " ")
            x, y, z = (f"{value:g}" for value in point)
            yield (
                f"{key}: a fist at ({x}, {y}, {z}) m is {100 * depth.max():.1f} cm inside the {part} of the standing "
                f"worker {name}."
            )


def _meeting_faults(experiment: Experiment, name: str, action: Action, worker: str, human: Human) -> Iterator[str]:
    """Both hands nearer to each other, at a time of the work, than two fists are thick."""
    late = any(goal.path()[-1].work_time_s > experiment.cycle.work_s for goal in action.goals().values())
    if late or len(action.goals()) < len(SIDES):
        return
    step = experiment.controller.time_step_s
    phases, home = phases_of(experiment.cycle, step), Pose(np.zeros(3), np.eye(3))
    work = slice(phases[1].start, phases[1].stop)
    right, left = (hand_reference(home, goal, phases, step).position_m[work] for goal in action.goals().values())
    apart = np.linalg.norm(right - left, axis=1)
    thick = 2 * float(capsules_of(human.anthropometry).radius_m[BODIES.index("right_hand")])
    if apart.min() < thick:
        near, least = told_apart(100 * float(apart.min()), 100 * thick, ".1f")
        yield (
            f"actions.{name}: right_hand and left_hand are {near} cm apart {int(apart.argmin()) * step:g} s after the "
            f"beginning of the work; two fists of worker {worker} need {least} cm."
        )

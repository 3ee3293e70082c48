"""Where no hand can be: out of reach, below the floor, in the worker's own body, or where the other hand is."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.errors import told_apart
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.capsules import capsules_of
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


class Standing(NamedTuple):
    """What is asked again and again of a worker: the farthest reach, the capsules of ROOTED in the stance, the fist."""

    longest_m: float
    ends_m: Vector
    radius_m: Vector
    fist_m: float

    def depths_m(self, point: Vector) -> Vector:
        """How deep a fist at a point (3,) m is in each of the capsules."""
        begin, along = self.ends_m[:, 0], self.ends_m[:, 1] - self.ends_m[:, 0]
        share = np.clip(np.sum((point - begin) * along, axis=1) / np.sum(along**2, axis=1), 0, 1)
        away = np.linalg.norm(point - begin - share[:, None] * along, axis=1)
        return np.asarray(self.radius_m + self.fist_m - away)


def target_faults(experiment: Experiment, humans: dict[str, Human]) -> Iterator[str]:
    """Targets that some worker's hand cannot be at, each with its key."""
    workers = {name: standing_of(experiment.workers[name], human) for name, human in humans.items()}
    for name, action in experiment.actions.items():
        for worker, standing in workers.items():
            for side, goal in action.goals().items():
                key = f"actions.{name}.{side}_hand.{'position_m' if goal.position_m else 'waypoints'}"
                points = np.array([waypoint.position_m.vector() for waypoint in goal.path()])
                distance = float(np.linalg.norm(points, axis=1).max())
                if distance > standing.longest_m:
                    away, reach = told_apart(distance, standing.longest_m, ".2f")
                    yield (
                        f"{key}: {away} m from the feet; ankle, leg, trunk and arm of worker {worker} together measure "
                        f"{reach} m."
                    )
                    continue
                yield from _body_faults(key, points, worker, standing)
            yield from _meeting_faults(experiment, name, action, worker, standing)


def standing_of(worker: Worker, human: Human) -> Standing:
    """What is asked again and again of a worker whose human this is."""
    capsules, data = capsules_of(human.anthropometry), human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    placements = [data.oMf[human.model.getFrameId(part)] for part in ROOTED]
    own = [BODIES.index(part) for part in ROOTED]
    ends = [ends @ at.rotation.T + at.translation for ends, at in zip(capsules.ends_m[own], placements, strict=True)]
    fist_m = float(capsules.radius_m[BODIES.index("right_hand")])
    return Standing(_longest_reach_m(worker), np.array(ends), capsules.radius_m[own], fist_m)


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


def _body_faults(key: str, points: Vector, name: str, standing: Standing) -> Iterator[str]:
    """Points in a part of the standing body, where the worker has no room to make for a hand; and in the floor."""
    fist_m, lowest = standing.fist_m, float(points[:, 2].min())
    if lowest < fist_m:
        height, least = told_apart(100 * lowest, 100 * fist_m, ".1f")
        yield f"{key}: {height} cm above the floor; the centre of worker {name}'s fist is {least} cm above it at least."
    for point in points:
        depth = standing.depths_m(point)
        if depth.max() > ROOM_M:
            part = ROOTED[int(depth.argmax())].replace("_", " ")
            x, y, z = (f"{value:g}" for value in point)
            yield (
                f"{key}: a fist at ({x}, {y}, {z}) m is {100 * depth.max():.1f} cm inside the {part} of the standing "
                f"worker {name}."
            )


def _meeting_faults(
    experiment: Experiment, name: str, action: Action, worker: str, standing: Standing
) -> Iterator[str]:
    """Both hands nearer to each other, at a time of the work, than two fists are thick."""
    late = any(goal.path()[-1].work_time_s > experiment.cycle.work_s for goal in action.goals().values())
    if late or len(action.goals()) < len(SIDES):
        return
    step = experiment.controller.time_step_s
    phases, home = phases_of(experiment.cycle, step), Pose(np.zeros(3), np.eye(3))
    work = slice(phases[1].start, phases[1].stop)
    right, left = (hand_reference(home, goal, phases, step).position_m[work] for goal in action.goals().values())
    apart = np.linalg.norm(right - left, axis=1)
    thick = 2 * standing.fist_m
    if apart.min() < thick:
        near, least = told_apart(100 * float(apart.min()), 100 * thick, ".1f")
        yield (
            f"actions.{name}: right_hand and left_hand are {near} cm apart {int(apart.argmin()) * step:g} s after the "
            f"beginning of the work; two fists of worker {worker} need {least} cm."
        )

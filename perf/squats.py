"""The natural human's squat beside recorded squats, joint by joint.

    FATPLAN_RECORDINGS=folder python perf/squats.py

Recorded: the five body-weight squats of squat_sit_plates/squats1. Simulated: the same person in pose_grid's preference
squat, whose hand goes to its lowest place and back. Both from standing to standing, over the way of the pelvis: 0 to 50 %
down, 50 to 100 % up, so that speed does not count. Angles, and torques of inverse dynamics over body mass, of the right
side. Printed: the RMS off the recorded mean, where the simulated one leaves the recorded band (the least and the most of
the five), and both at the deepest point.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import parse_experiment, read_content
from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.recordings import dynamics
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.kinematics.calibration import calibrate
from fatigue_planner.recordings.kinematics.markers import markers_of
from fatigue_planner.recordings.kinematics.tracking import track

Vector = NDArray[np.float64]

JOINTS = ("lumbar_flexion", "thoracic_flexion", "right_hip_flexion", "right_knee_flexion", "right_ankle_flexion")
PERSON = {"height_m": 1.75, "mass_kg": 60.05, "sex": "male"}  # stature and sex are not known
PHASE = np.linspace(0.05, 0.95, 19)  # of the way down, and of the way up


def recorded(folder: Path) -> tuple[Vector, Vector, Vector]:
    """Height of the pelvis (n,) m, angles (n, 39) rad and torques (n, 39) N.m of the recorded squats."""
    files = {name: [folder / f"{name}.trc", folder / f"{name}_grf.mot"] for name in ("squats1", "static1")}
    found, still = (read_recording(*files[name])[1] for name in ("squats1", "static1"))
    markers = markers_of(found.recording, found.mapping, PERSON["height_m"])
    markers, _ = markers.of(still.recording.labels)
    markers, moving = markers.of(found.recording.labels)
    standing = [still.recording.labels.index(label) for label in markers.labels]
    assert found.recording.points_m is not None and still.recording.points_m is not None
    points, stood = found.recording.points_m[:, moving], still.recording.points_m[:, standing]
    calibration = calibrate(Worker(**PERSON), markers, points, stood)

    def motion(person: object, seen: Vector) -> dynamics.Movement:
        own = track(calibration, calibration.markers, seen, found.recording.rate_hz)
        return dynamics.movement(calibration.person.model(), own.configuration, own.rate_hz, own.cutoff_hz)

    def plates(recording: object) -> list[object]:
        return dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)

    person = dynamics.balanced(calibration.person, motion(None, stood), plates(still.recording))
    squats = motion(None, points)
    torques = dynamics.inverse_dynamics(person.model(), squats, plates(found.recording))
    return squats.configuration[20:-20, 2], squats.configuration[20:-20, 7:], torques.torque_nm[20:-20]


def simulated() -> tuple[Vector, Vector, Vector]:
    """The same of the natural human's squat to the lowest place of pose_grid."""
    content = read_content(Path(__file__).parents[1] / "experiments" / "pose_grid.yaml")
    content["workers"] = {name: worker | PERSON for name, worker in content["workers"].items()}
    experiment = parse_experiment(content, "pose_grid")
    lowest = min(experiment.actions, key=lambda name: float(name.rsplit("z", 1)[1]))
    request = next(
        one for one in reaction_requests(experiment) if one.name.action == lowest and one.name.preference == "squat"
    )
    motion = simulate(request.key.motion_request())
    return motion.configuration[:, 2], motion.configuration[:, 7:], motion.torque_nm + motion.tissue_nm

"""The natural human's squat beside recorded squats, joint by joint.

    FATPLAN_RECORDINGS=folder python perf/squats.py

Recorded: the body-weight squats of squat_sit_plates/squats1. Simulated: a person as tall and heavy with pose_grid's
preference squat, whose right hand goes to a place that takes the pelvis as far down, and back, with nothing in it. Both
over the way of the pelvis, down and up, so that speed does not count. Angles, and torques of inverse dynamics over body
mass, of the right side. Printed: the RMS off the recorded mean, how often the simulated one leaves the recorded band
(the least and the most of all squats), both at the deepest point, and where they differ most. First, what the height of
the place decides: it stands for a task that nobody recorded.
"""

import os
from pathlib import Path
from typing import Any

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
from fatigue_planner.recordings.recording import GroundForce, Recording

Vector = NDArray[np.float64]

JOINTS = ("lumbar_flexion", "thoracic_flexion", "right_hip_flexion", "right_knee_flexion", "right_ankle_flexion")
ENDS = slice(20, -20)  # of filters
PERSON: dict[str, Any] = {"height_m": 1.75, "mass_kg": 60.05, "sex": "male"}  # stature and sex are not known
HEIGHTS_M = (0.44, 0.49, 0.54, 0.59, 0.64)  # of the simulated hand's place
HEIGHT_M = 0.54
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

    model = calibration.person.model()

    def motion(seen: Vector, rate_hz: float) -> dynamics.Movement:
        own = track(calibration, calibration.markers, seen, rate_hz)
        return dynamics.movement(model, own.configuration, own.rate_hz, own.cutoff_hz)

    def plates(recording: Recording) -> list[GroundForce]:
        return dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)

    standing_still = motion(stood, still.recording.rate_hz)
    person = dynamics.balanced(calibration.person, standing_still, plates(still.recording))
    squats = motion(points, found.recording.rate_hz)
    torques = dynamics.inverse_dynamics(person.model(), squats, plates(found.recording))
    return squats.configuration[ENDS, 2], squats.configuration[ENDS, 7:], torques.torque_nm[ENDS]


def simulated(height_m: float) -> tuple[Vector, Vector, Vector]:
    """The same of the natural human's squat to a place at this height, with nothing in the hand."""
    content = read_content(Path(__file__).parents[1] / "experiments" / "pose_grid.yaml")
    goal = {"position_m": {"x": 0.4, "y": -0.2, "z": height_m}, "orientation_deg": {"y": -90}}
    content |= {"tool": {"mass_kg": 0}, "actions": {"low": {"right_hand": goal}}, "workers": {"person": PERSON}}
    content["preferences"] = {"squat": content["preferences"]["squat"]}
    for condition in content["benchmark"]["conditions"].values():
        condition["worker"] = "person"
    (request,) = reaction_requests(parse_experiment(content, "pose_grid"))
    motion = simulate(request.motion)
    return motion.configuration[:, 2], motion.configuration[:, 7:], motion.torque_nm + motion.tissue_nm


def squats_of(height: Vector, values: Vector) -> list[Vector]:
    """Values (n, ...) of every squat over the phase: at shares of the pelvis' way down, then of its way up."""
    top, bottom = np.percentile(height, 95), height.min()
    down = 1 - (height - bottom) / (top - bottom)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (down > 0.02).astype(int), [0]])))
    found = []
    for start, end in edges.reshape(-1, 2):
        way = down[start:end]
        deepest = int(way.argmax())
        if start == 0 or end == len(height) or way[deepest] < 0.7:
            continue
        depth = way / way[deepest]
        there, back = np.maximum.accumulate(depth[: deepest + 1]), np.maximum.accumulate(depth[deepest:][::-1])
        first = [np.searchsorted(there, share) for share in PHASE]
        last = [len(way) - 1 - np.searchsorted(back, share) for share in PHASE[::-1]]
        found.append(values[start:end][np.minimum([*first, *last], len(way) - 1)])
    return found


def print_heights(seen: tuple[Vector, Vector, Vector], each: dict[float, tuple[Vector, Vector, Vector]]) -> None:
    """How far down the pelvis goes, and the RMS of each angle off the recorded mean, by the height of the place."""
    print(f"pelvis down by {np.ptp(seen[0]):.2f} m recorded")
    print("| height of the place, m | pelvis down by, m |", " | ".join(JOINTS).replace("right_", ""), "|")
    print("|---|---|" + "---|" * len(JOINTS))
    mean = np.mean(squats_of(seen[0], seen[1]), axis=0)
    for height_m, own in each.items():
        (one, *_) = squats_of(own[0], own[1])
        off = np.degrees(np.sqrt(((one - mean) ** 2).mean(axis=0)))
        cells = [f"{off[DEGREES_OF_FREEDOM.index(joint)]:.1f}°" for joint in JOINTS]
        print("|", " | ".join([f"{height_m:.2f}", f"{np.ptp(own[0]):.2f}", *cells]), "|")


def main() -> None:
    """Print both tables."""
    seen = recorded(Path(os.environ["FATPLAN_RECORDINGS"]) / "squat_sit_plates")
    each = {height_m: simulated(height_m) for height_m in HEIGHTS_M}
    print_heights(seen, each)
    own = each[HEIGHT_M]
    print("| joint | what | RMS | outside the band | recorded, deepest | simulated, deepest | farthest off at |")
    print("|---|---|---|---|---|---|---|")
    for what, index, scale in (("angle, deg", 1, 180 / np.pi), ("torque, N.m/kg", 2, 1 / PERSON["mass_kg"])):
        band = np.array(squats_of(seen[0], seen[index])) * scale
        (one, *_) = squats_of(own[0], own[index])
        for joint in JOINTS:
            at = DEGREES_OF_FREEDOM.index(joint)
            real, ours = band[..., at], one[:, at] * scale
            off = ours - real.mean(axis=0)
            outside = (ours < real.min(axis=0)) | (ours > real.max(axis=0))
            middle, worst = slice(len(PHASE) - 1, len(PHASE) + 1), int(abs(off).argmax())
            share = PHASE[worst] if worst < len(PHASE) else PHASE[::-1][worst - len(PHASE)]
            way = "down" if worst < len(PHASE) else "up"
            cells = [joint.removeprefix("right_"), what, f"{np.sqrt((off**2).mean()):.2f}"]
            cells += [f"{100 * outside.mean():.0f} %", f"{real[:, middle].mean():.2f}", f"{ours[middle].mean():.2f}"]
            print("|", " | ".join([*cells, f"{100 * share:.0f} % {way}: {off[worst]:+.2f}"]), "|")
    print(f"{len(band)} recorded squats")


if __name__ == "__main__":
    main()

"""What a laboratory would record of a simulated reaction: markers (TRC), force plates (MOT), a static trial.

    python examples/simulated_recording.py paper average_man/high/arm recordings [markers' noise in mm]

The truth behind such a recording is known: the reaction itself. The markers are those of Plug-in Gait; the person
stands still for half a second before and after.
"""

import sys
from pathlib import Path

import numpy as np
import yaml

import fatigue_planner as fp
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.recordings.mapping import landmark_table, load_mapping

MAPPING, STILL_S = "plug_in_gait", 0.5


def labels():
    """The labels of the mapping that stand for one place each."""
    mapping = load_mapping(MAPPING)
    templates = [first for first, *_ in mapping.landmarks.values() if "#" not in first]
    sides = [mapping.sides[side][0] for side in SIDES]
    named = (template.replace("{s}", side) for template in templates for side in sides)
    return list(dict.fromkeys(named))


def markers_m(worker, configuration):
    """Where the markers are (n, k, 3) m on a worker's body at configurations (n, 46)."""
    poses = poses_of(tree_of(worker.anthropometry()), configuration)
    places = [load_mapping(MAPPING).place(label) for label in labels()]
    scale = worker.height_m / landmark_table().stature_m
    return np.stack([poses.points(place.body, scale * place.at_m) for place in places], axis=1)


def plates(worker, motion):
    """Force, point and moment (n, 9), world axes, of the ground on each foot."""
    person = worker.anthropometry()
    heel, toe, _, height = person.sole_rectangle()
    poses = poses_of(tree_of(person), motion.configuration)
    for foot, side in enumerate(SIDES):
        centre = poses.points(f"{side}_foot", np.array([(heel + toe) / 2, 0, height]))
        turn = poses.rotation[:, BODIES.index(f"{side}_foot")]
        force, moment = (motion.wrench[:, 6 * foot + part : 6 * foot + part + 3] for part in (0, 3))
        yield np.concatenate(
            [np.einsum("nij,nj->ni", turn, force), centre, np.einsum("nij,nj->ni", turn, moment)], axis=1
        )


def trc(position, rate_hz):
    """A TRC file of markers (n, k, 3) m."""
    names, count = labels(), len(position)
    head = {
        "DataRate": rate_hz, "CameraRate": rate_hz, "NumFrames": count, "NumMarkers": len(names), "Units": "m",
        "OrigDataRate": rate_hz, "OrigDataStartFrame": 1, "OrigNumFrames": count,
    }  # fmt: skip
    lines = ["PathFileType\t4\t(X/Y/Z)\tsimulated.trc", "\t".join(head), "\t".join(map(str, head.values()))]
    lines += ["Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t"]
    lines += ["\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(names)) for axis in "XYZ")]
    for frame, row in enumerate(position.reshape(count, -1)):
        lines.append("\t".join([str(frame + 1), f"{frame / rate_hz:.6f}", *(f"{value:.7f}" for value in row)]))
    return "\n".join([*lines, ""])


def mot(columns, rate_hz):
    """A MOT file of the plates' columns."""
    names = [
        f"ground_force_{plate + 1}_{part}{axis}" for plate in range(len(columns)) for part in "vpm" for axis in "xyz"
    ]
    table = np.concatenate(columns, axis=1)
    lines = ["plates", "version=1", f"nRows={len(table)}", f"nColumns={len(names) + 1}", "endheader"]
    lines += ["\t".join(["time", *names])]
    lines += ["\t".join(f"{value:.7f}" for value in (i / rate_hz, *row)) for i, row in enumerate(table)]
    return "\n".join([*lines, ""])


def record(experiment, reaction, folder, noise_m=0.0, seed=0):
    """Write the recording of a reaction into a folder; its files: the markers, the plates, the subject."""
    worker, motion = experiment.workers[reaction.name.worker], reaction.motion
    rate = round(1 / motion.time_step_s)
    before, after = (np.repeat([row], round(STILL_S * rate), axis=0) for row in (0, len(motion.configuration) - 1))

    def with_stillness(values):
        return values[np.concatenate([before, np.arange(len(values)), after])]

    rng = np.random.default_rng(seed)
    shown = with_stillness(markers_m(worker, motion.configuration))
    still = np.repeat(shown[:1], rate, axis=0)
    stem = "-".join(reaction.name)
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{stem}.trc", folder / f"{stem}_plates.mot", folder / f"{reaction.name.worker}.yaml"]
    files[0].write_text(trc(shown + noise_m * rng.standard_normal(shown.shape), rate))
    files[1].write_text(mot([with_stillness(plate) for plate in plates(worker, motion)], rate))
    static = folder / f"{reaction.name.worker}_static.trc"
    static.write_text(trc(still + noise_m * rng.standard_normal(still.shape), rate))
    subject = {
        "height_m": worker.height_m,
        "mass_kg": worker.mass_kg,
        "sex": worker.sex,
        "static": [static.name],
    }
    files[2].write_text(yaml.safe_dump(subject | {"worker": reaction.name.worker}))
    return files


if __name__ == "__main__":
    experiment = fp.load(sys.argv[1])
    noise_m = float(sys.argv[4]) / 1000 if len(sys.argv) > 4 else 0.0
    reactions = fp.simulate(experiment)
    for file in record(experiment, reactions[sys.argv[2]], Path(sys.argv[3]), noise_m):
        print(file)

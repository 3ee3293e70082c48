"""Write what OpenSim finds for the torques of squats1: tests/recordings/opensim_squats1.csv.

    FATPLAN_RECORDINGS=folder python perf/opensim/torques.py

In an environment of its own, made when it is first needed. OpenSim's inverse dynamics with AddBiomechanics' scaled
model and angles, low-pass at 6 Hz, and the corrected external loads; ten rows a second, in fatplan's signs: flexion is
positive for lumbar, hip, knee and ankle. Different on both sides: the model (62.6 against 60.1 kg, one joint in the
trunk, 6 cm higher, a knee whose axis slides and turns), and so the angles. So that torques about the same axis can be
compared, the table has OpenSim's knee, too: how the shank turns (rad) and what shift (m) takes the laboratory's origin
along, per radian of the knee's flexion, in the laboratory's axes.
"""

import os
import subprocess
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))

from environments import environment_of

HERE = Path(__file__).parent
TARGET = HERE.parents[1] / "tests" / "recordings" / "opensim_squats1.csv"
INSIDE = r"""
import sys
from pathlib import Path
import opensim
source, target = Path(sys.argv[1]), Path(sys.argv[2])
model = opensim.Model(str(source / "subject4_scaled.osim"))
model.initSystem()
tool = opensim.InverseDynamicsTool()
tool.setModel(model)
tool.setCoordinatesFileName(str(source / "squats1_ik_addbiomechanics.mot"))
tool.setExternalLoadsFileName(str(source / "squats1_external_forces_corrected.xml"))
tool.setLowpassCutoffFrequency(6)
tool.setStartTime(0)
tool.setEndTime(13.45)
muscles = opensim.ArrayStr()
muscles.append("Muscles")
tool.setExcludedForces(muscles)
tool.setResultsDir(str(target.parent))
tool.setOutputGenForceFileName(target.name)
tool.run()

# the shank's velocity where nothing but the knee moves, at 1 rad/s
state = model.initSystem()
angles = opensim.Storage(str(source / "squats1_ik_addbiomechanics.mot"))
angles.pad(angles.getSize() // 2)
angles.lowpassIIR(6)
labels, coordinates = angles.getColumnLabels(), model.getCoordinateSet()
names = [labels.get(i) for i in range(1, labels.getSize())]
row = opensim.ArrayDouble()
row.setSize(len(names))
with target.with_suffix(".knees").open("w") as knees:
    for frame in range(0, 1346, 10):
        angles.getDataAtTime(frame / 100, len(names), row)
        for i, name in enumerate(names):
            coordinates.get(name).setValue(state, row.get(i), False)
        model.assemble(state)
        for side in "rl":
            for i in range(coordinates.getSize()):
                coordinates.get(i).setSpeedValue(state, 0)
            coordinates.get(f"knee_angle_{side}").setSpeedValue(state, 1)
            model.realizeVelocity(state)
            shank = model.getBodySet().get(f"tibia_{side}")
            velocity, place = shank.getVelocityInGround(state), shank.getPositionInGround(state)
            w, v, p = ([one.get(i) for i in range(3)] for one in (velocity.get(0), velocity.get(1), place))
            at_origin = [v[i] - w[i - 2] * p[i - 1] + w[i - 1] * p[i - 2] for i in range(3)]
            knees.write(",".join(f"{value:.5f}" for value in w + at_origin) + ("," if side == "r" else "\n"))
"""
COLUMNS = {"lumbar_flexion": ("lumbar_extension_moment", -1)} | {
    f"{side}_{joint}_flexion": (f"{name}_{side[0]}_moment", 1)
    for joint, name in (("hip", "hip_flexion"), ("knee", "knee_angle"), ("ankle", "ankle_angle"))
    for side in ("right", "left")
}

KNEES = [
    f"{side}_knee_{what}_{axis}" for side in ("right", "left") for what in ("turn_rad", "shift_m") for axis in "xyz"
]


def main() -> None:
    """Run OpenSim and write the table."""
    source = Path(os.environ["FATPLAN_RECORDINGS"]) / "squat_sit_plates"
    python = environment_of("opensim", "opensim", HERE / "requirements.txt")
    result = TARGET.with_suffix(".sto")
    subprocess.run([python, "-c", INSIDE, source, result], check=True, stdout=subprocess.DEVNULL)
    head, *rows = result.read_text().split("endheader\n")[1].splitlines()
    knees = result.with_suffix(".knees").read_text().splitlines()
    result.unlink()
    result.with_suffix(".knees").unlink()
    names = head.split("\t")
    table = [[float(cell) for cell in row.split("\t")] for row in rows][::10]
    lines = [",".join(["time_s", *COLUMNS, *KNEES])]
    for row, knee in zip(table, knees, strict=True):
        torques = [f"{sign * row[names.index(name)]:.2f}" for name, sign in COLUMNS.values()]
        lines.append(",".join([f"{row[0]:g}", *torques, knee]))
    TARGET.write_text("\n".join(lines) + "\n")
    print(f"{TARGET}: {len(table)} rows")


if __name__ == "__main__":
    main()

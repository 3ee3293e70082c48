"""Labelled recordings: a table, files with angles or markers, and what is trained with them."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from commands import fatplan, refused
from numpy.typing import NDArray
from recorded import LABELS, figure, real, trc

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.kinematics.measured import Measured
from fatigue_planner.recordings.mapping import landmark_table, load_mapping
from fatigue_planner.recordings.recognition.recorded import Label, read_labels, recorded
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, of_motion
from fatigue_planner.recordings.recognition.stored import load_recogniser

CYCLE = Cycle(reach_s=2, work_s=1, return_s=2)
WORKERS = {"man": Worker(height_m=1.75, mass_kg=75, sex="male")}
ELBOW = DEGREES_OF_FREEDOM.index("right_elbow_flexion")
HEAD = "file,person,action,preference"


def angles_file(path: Path, times_s: NDArray[np.float64], elbow_deg: NDArray[np.float64]) -> None:
    rows = (f"{at:.4f},{angle:.6f}" for at, angle in zip(times_s, elbow_deg, strict=True))
    path.write_text("time_s,right_elbow_flexion_deg\n" + "\n".join(rows) + "\n")


def table(folder: Path, *rows: str, head: str = HEAD) -> Path:
    path = folder / "labelled.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def read(path: Path) -> NDArray[np.float64]:
    labels = read_labels(path, ("low", "high"), ("arm", "back"), CYCLE)
    return recorded(path, labels, WORKERS, CYCLE)[0].angles_deg


def test_phases_are_stretched_to_those_of_the_cycle(tmp_path: Path) -> None:
    """Somebody who takes twice as long for the reach is the same as one who keeps to the cycle's time."""
    quick = np.arange(0, 5, 0.02)
    angles_file(tmp_path / "quick.csv", quick, 10 * np.interp(quick, [0, 2, 3, 5], [0, 1, 1, 0]))
    slow = np.arange(0, 9, 0.02)
    angles_file(tmp_path / "slow.csv", slow, 10 * np.interp(slow, [1, 5, 6, 8], [0, 1, 1, 0]))
    path = table(
        tmp_path, "quick.csv,p1,low,arm,,,,", "slow.csv,p1,low,arm,1,5,6,8",
        head=f"{HEAD},begins_s,reached_s,left_s,ends_s",
    )  # fmt: skip
    found = read(path)
    assert found.shape == (2, N_PARTS, len(DEGREES_OF_FREEDOM))
    np.testing.assert_allclose(found[0, :, ELBOW], found[1, :, ELBOW], atol=0.15)
    np.testing.assert_allclose(found[0, [0, 9, 12, 19], ELBOW], [0.5, 9.5, 10, 1.0], atol=0.12)
    assert np.isnan(np.delete(found, ELBOW, axis=2)).all()


@pytest.mark.parametrize(
    ("rows", "head", "message"),
    [
        (["a.csv,p,low"], "file,person,action", "line 1: the columns are file, person, action; required: file, person"),
        ([], HEAD, "has no rows"),
        (["a.csv,p,low,arm,x"], HEAD, "line 2: has 5 cells; the table has 4 columns"),
        (["a.csv,p,lo,arm"], HEAD, "line 2: action = 'lo': should be one of low, high"),
        (["a.csv,p,low,leg"], HEAD, "line 2: preference = 'leg': should be one of arm, back"),
        (["a.csv,,low,arm"], HEAD, "line 2: person is empty"),
        (["a.csv,p,low,arm,nan"], f"{HEAD},ends_s", "line 2: ends_s = 'nan': should be a time in s"),
        (["a.csv,p,low,arm,1"], f"{HEAD},ends_s", "are 0, 2, 3, 1; each should be later than the one before"),
        (["none.csv,p,low,arm"], HEAD, "line 2: .*none.csv: is not there"),
        (["a.csv,p,low,arm"], HEAD, "line 2: .*a.csv: lasts 2 s; the cycle is from 0 to 5 s"),
        (["knee.csv,p,low,arm"], HEAD, "its angles are knee; should be degrees of freedom"),
        (["walk.trc,p,low,arm"], HEAD, "person = 'p': .* the experiment's workers are man"),
        (["walk.trc,man,low,arm,none"], f"{HEAD},mapping", "none: neither a file nor a mapping"),
    ],
)
def test_what_cannot_be_is_refused_with_its_line(tmp_path: Path, rows: list[str], head: str, message: str) -> None:
    angles_file(tmp_path / "a.csv", np.arange(0, 2.01, 0.02), np.zeros(101))
    (tmp_path / "knee.csv").write_text("time_s,knee_deg\n0,1\n0.1,1\n")
    (tmp_path / "walk.trc").write_bytes(trc(figure()))
    with pytest.raises(RecordingError, match=message) as error:
        read(table(tmp_path, *rows, head=head))
    assert str(tmp_path / "labelled.csv") in str(error.value)


@pytest.mark.slow
def test_angles_are_found_from_markers(tmp_path: Path, reactions: tuple[Reaction, ...]) -> None:
    """A simulated reaction as markers of Plug-in Gait, without any on the hands: the arm's angles come back."""
    reaction = reactions[0]
    motion, request = reaction.motion, reaction.key.motion_request()
    worker = request.worker
    poses = poses_of(tree_of(Measured(worker.height_m, worker.mass_kg, worker.sex, worker.human)), motion.configuration)
    scale = worker.height_m / landmark_table().stature_m
    labels = (*LABELS, "RWRA", "RWRB", "LWRA", "LWRB")
    at = [load_mapping("plug_in_gait").place(label) for label in labels]
    shown = np.stack([poses.points(one.body, scale * np.array(one.at_m)) for one in at if one], axis=1)
    (tmp_path / "reach.trc").write_bytes(trc(shown[::10], labels, 0.1 / motion.time_step_s))
    path = table(tmp_path, f"reach.trc,man,{reaction.name.action},{reaction.name.preference}")
    rows = read_labels(path, ("low", "high"), ("arm", "back"), request.cycle)
    found = recorded(path, rows, {"man": worker}, request.cycle)[0].angles_deg[0]
    want = of_motion(motion, reaction.angles_rad().to_numpy())
    for name in ("right_shoulder_flexion", "right_elbow_flexion", "right_knee_flexion", "right_hip_flexion"):
        index = DEGREES_OF_FREEDOM.index(name)
        assert np.sqrt(((found - want)[:, index] ** 2).mean()) < 5, name
    unseen = [name for index, name in enumerate(DEGREES_OF_FREEDOM) if np.isnan(found[:, index]).all()]
    assert "right_wrist_flexion" in unseen and "head_flexion" in unseen and "right_elbow_flexion" not in unseen


@pytest.mark.slow
def test_real_squats_and_sit_to_stand() -> None:
    """Angles of a real person's markers, with his static trial: knees bend, and nothing is said of the wrists."""
    folder = real("squat_sit_plates/squats1.trc").parent
    instants = (0.5, 4.0, 8.0, 12.0)
    labels = [
        Label(2, folder / name, "man", "low", preference, instants, folder / "static1.trc", None)
        for name, preference in (("squats1.trc", "squat"), ("STS1.trc", "arm"))
    ]
    found, digests = recorded(folder, labels, {"man": Worker(height_m=1.75, mass_kg=60, sex="male")}, CYCLE)
    knee, wrist = (DEGREES_OF_FREEDOM.index(name) for name in ("right_knee_flexion", "right_wrist_flexion"))
    assert np.nanmax(found.angles_deg[:, :, knee], axis=1).min() > 45
    assert np.isnan(found.angles_deg[:, :, wrist]).all() and len(set(digests.values())) == 2


@pytest.mark.slow
def test_a_laboratory_that_has_only_recordings(tmp_path: Path) -> None:
    """Four people, two ways to reach: the command trains, and says that it were recordings."""
    (tmp_path / "lab.yaml").write_text(
        yaml.safe_dump(
            {
                "name": "lab",
                "cycle": {"reach_s": 2, "work_s": 1, "return_s": 2},
                "actions": {
                    "low": {
                        "right_hand": {"position_m": {"x": 0.4, "y": -0.15, "z": 0.7}, "orientation_deg": {"y": -90}}
                    }
                },
            }
        )
    )
    rng, rows, times = np.random.default_rng(0), [], np.arange(0, 5, 0.05)
    for person in range(4):
        offset = 5 * rng.standard_normal()
        for preference, most in (("arm", 60), ("back", 20)):
            for number in range(3):
                name = f"{person}-{preference}-{number}.csv"
                clean = most * np.interp(times, [0, 2, 3, 5], [0, 1, 1, 0])
                angles_file(tmp_path / name, times, clean + offset + rng.standard_normal(len(times)))
                rows.append(f"{name},p{person},low,{preference}")
    words = (
        "record",
        "recognise",
        tmp_path / "lab.yaml",
        "--recordings",
        table(tmp_path, *rows),
        "--results",
        tmp_path,
    )
    done = fatplan(*words)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "lab" / "recognition"
    stored = load_recogniser(folder / "recogniser.json")
    assert not stored.is_simulated and len(stored.reactions) == 24
    page = (folder / "report.html").read_text()
    assert "24, recorded" in page and "This is a floor" not in page and "--recordings" in page
    assert "give no --noise, --seed with it" in refused(2, *words, "--noise", 3, "--seed", 1)

"""From markers back to angles and torques: against what is known, since the motions are simulated or made."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from recorded import HIP_HEIGHT_M, LABELS, figure, places, real

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.experiment.build import worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Worker
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings import dynamics
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.formats.registry import read_content
from fatigue_planner.recordings.imports.contacts import carried, unmeasured_contacts
from fatigue_planner.recordings.kinematics.calibration import Calibration, calibrate
from fatigue_planner.recordings.kinematics.frame_fit import fit_frame, fit_problem
from fatigue_planner.recordings.kinematics.markers import Markers, markers_of, unmarked_joints
from fatigue_planner.recordings.kinematics.measured import SEGMENTS, Measured
from fatigue_planner.recordings.kinematics.tracking import Track, longest_run, track
from fatigue_planner.recordings.recording import GroundForce, Recording

pytestmark = pytest.mark.slow
Vector = NDArray[np.float64]

PERSON = Measured(1.75, 75.0, "male")
LOWER, UPPER = position_limits()
MIDDLE = (LOWER + UPPER) / 2


def four_on_each_body(rng: np.random.Generator) -> Markers:
    local = np.concatenate([rng.uniform(-0.1, 0.1, (4, 3)) for _ in BODIES])
    bodies = tuple(body for body in BODIES for _ in range(4))
    return Markers(tuple(f"{body}{i % 4}" for i, body in enumerate(bodies)), bodies, local, np.full(len(bodies), 0.01))


def seen(person: Measured, markers: Markers, configuration: Vector) -> Vector:
    """Where markers are (n, k, 3) m, by the project's forward kinematics."""
    poses = poses_of(tree_of(person), configuration)
    return np.stack([poses.points(body, at) for body, at in zip(markers.bodies, markers.local_m, strict=True)], axis=1)


def postures(rng: np.random.Generator, count: int, spread: float = 0.8) -> Vector:
    """Configurations anywhere within the ranges of motion."""
    angles = MIDDLE + spread / 2 * (UPPER - LOWER) * rng.uniform(-1, 1, (count, len(MIDDLE)))
    turn = rng.standard_normal((count, 4)) * [0.2, 0.2, 0.2, 0.0] + [0, 0, 0, 1.0]
    return np.concatenate(
        [rng.uniform(-1, 1, (count, 3)), turn / np.linalg.norm(turn, axis=1)[:, None], angles], axis=1
    )


def test_any_posture_is_found_again() -> None:
    rng = np.random.default_rng(1)
    markers = four_on_each_body(rng)
    problem = fit_problem(PERSON, list(markers.bodies), markers.local_m, markers.sigma_m, MIDDLE)
    for want in postures(rng, 20, 0.5):  # far from where two axes of a joint meet and angles are anybody's
        start = np.concatenate([want[:3] + 0.05, want[3:7], want[7:] + rng.uniform(-0.3, 0.3, len(MIDDLE))])
        found, distance = fit_frame(problem, start, seen(PERSON, markers, want[None])[0])
        assert np.degrees(abs(found[7:] - want[7:])).max() < 0.01
        assert distance.max() < 1e-4


def test_a_marker_that_has_gone_astray_hardly_counts_and_an_unseen_one_not_at_all() -> None:
    rng = np.random.default_rng(2)
    markers = four_on_each_body(rng)
    problem = fit_problem(PERSON, list(markers.bodies), markers.local_m, markers.sigma_m, MIDDLE)
    (want,) = postures(rng, 1, 0.5)
    target = seen(PERSON, markers, want[None])[0]
    target[17] += [0.3, 0.0, 0.0]
    target[30] = np.nan
    found, distance = fit_frame(problem, want, target)
    assert np.degrees(abs(found[7:] - want[7:])).max() < 0.5  # least squares without weights: several degrees
    assert distance[17] > 0.28 and np.isnan(distance[30])


def test_joints_that_no_marker_shows_stay_where_the_prior_has_them() -> None:
    rng = np.random.default_rng(3)
    all_markers = four_on_each_body(rng)
    markers, _ = all_markers.of(tuple(name for name in all_markers.labels if "hand" not in name and "head" not in name))
    problem = fit_problem(PERSON, list(markers.bodies), markers.local_m, markers.sigma_m, MIDDLE)
    (want,) = postures(rng, 1, 0.5)
    found, _ = fit_frame(problem, want, seen(PERSON, markers, want[None])[0])
    for index, name in enumerate(DEGREES_OF_FREEDOM):
        if "wrist" in name or "head" in name:
            assert found[7 + index] == pytest.approx(MIDDLE[index], abs=1e-6)
        else:
            assert found[7 + index] == pytest.approx(want[7 + index], abs=2e-4)


def test_lengths_and_places_are_found_from_the_motion() -> None:
    """A person with other lengths, markers a centimetre off: angles to 2 degrees (median), lengths to 2 %."""
    rng = np.random.default_rng(4)
    worker = Worker(height_m=1.75, mass_kg=75, sex="male")
    nominal = four_on_each_body(rng)
    person = Measured(1.75, 75.0, "male", "natural", tuple(1 + 0.05 * rng.uniform(-1, 1, len(SEGMENTS))))
    true = nominal.at(nominal.local_m + 0.01 * rng.standard_normal(nominal.local_m.shape))
    stance = np.concatenate([[0, 0, 0.94, 0, 0, 0, 1.0], calibration_stance(worker)])
    knots = np.concatenate([stance[None], postures(rng, 10, 0.5)])
    moved = np.array([np.interp(np.linspace(0, 10, 101), np.arange(11), angle) for angle in knots.T]).T
    moved[:, 3:7] = [0, 0, 0, 1]
    guess = Markers(nominal.labels, nominal.bodies, nominal.local_m, np.full(len(nominal.labels), 0.03))
    found = calibrate(worker, guess, seen(person, true, moved), seen(person, true, np.tile(stance, (5, 1))))
    assert found.rms_m < 0.004
    assert abs(np.array(found.person.factors) - person.factors).mean() < 0.02
    own = track(found, found.markers, seen(person, true, moved), 100.0)
    off = np.degrees(abs(own.configuration[:, 7:] - moved[:, 7:]))
    assert np.median(off) < 2


def calibration_stance(worker: Worker) -> Vector:
    from fatigue_planner.human.joint_data import posture

    return np.asarray(posture(worker.natural_posture_deg, "natural_posture_deg"))


def test_short_gaps_are_bridged_and_long_ones_told() -> None:
    position = figure(100)
    markers = markers_of(Recording(100.0, 100, LABELS, position), "plug_in_gait", 1.75)
    worker = Worker(height_m=1.75, mass_kg=75, sex="male")
    found = calibrate(worker, markers, position)
    whole = track(found, found.markers, position, 100.0)
    gone = position.copy()
    gone[20:38, LABELS.index("C7")] = np.nan  # 0.18 s
    bridged = track(found, found.markers, gone, 100.0)
    assert bridged.bridged == 18 and np.isnan(bridged.distance_m[25, 0])
    np.testing.assert_allclose(bridged.configuration, whole.configuration, atol=2e-3)
    for label in ("LKNE", "LASI"):  # all that shows the left thigh and half the pelvis
        gone[20:60, LABELS.index(label)] = np.nan
    told = track(found, found.markers, gone, 100.0)
    assert told.bridged == 18 and told.unseen_s["left_thigh"] == pytest.approx(0.4) and told.unseen_s["pelvis"] == 0
    assert longest_run(np.array([True, False, True, True])) == 2 and longest_run(np.zeros(3, bool)) == 0


def test_without_markers_on_a_body_there_is_no_posture() -> None:
    labels = tuple(label for label in LABELS if label not in ("LASI", "RASI", "LPSI", "RPSI"))
    with pytest.raises(RecordingError, match="no marker is on pelvis; there is no posture without"):
        markers_of(Recording(100.0, 4, labels, np.zeros((4, len(labels), 3))), "plug_in_gait", 1.75)
    with pytest.raises(RecordingError, match="no mapping knows its labels"):
        markers_of(Recording(100.0, 4, labels, np.zeros((4, len(labels), 3))), None, 1.75)
    assert len(places()) == len(LABELS) and HIP_HEIGHT_M > 0.9


@pytest.mark.parametrize(
    ("noise_m", "angle_deg", "rms_nm", "worst_nm"),
    [(0.0, 0.01, 0.1, 0.2), (0.001, 0.4, 0.4, 1.0), (0.003, 0.4, 0.5, 1.5)],
)
def test_simulated_reactions_come_back(
    paper: Experiment, reactions: tuple[Reaction, ...], noise_m: float, angle_deg: float, rms_nm: float, worst_nm: float
) -> None:
    """Simulated motion -> markers, with noise -> angles and torques above the pelvis, over the whole cycle.

    And what the cycle does to fatigue, from rest, as a share of the most that it does to any joint.
    """
    rng = np.random.default_rng(5)
    markers = four_on_each_body(rng)
    above = [not any(leg in name for leg in ("hip", "knee", "ankle")) for name in DEGREES_OF_FREEDOM]
    for reaction in (reactions[0], reactions[-1]):
        worker = reaction.key.motion_request().worker
        tool_kg = reaction.key.motion_request().tool.mass_kg
        person = Measured(worker.height_m, worker.mass_kg, worker.sex, worker.human)
        shown = seen(person, markers, reaction.motion.configuration)
        shown = shown + noise_m * rng.standard_normal(shown.shape)
        stance = reaction.motion.configuration[0, 7:]
        own = track(Calibration(person, markers, stance, 0.0), markers, shown, 1 / reaction.motion.time_step_s)
        assert own.cutoff_hz is None  # no skin moves over bones
        model = person.model(right_hand_kg=tool_kg)
        smooth = dynamics.movement(model, own.configuration, own.rate_hz, own.cutoff_hz)
        off = np.degrees(np.sqrt(((smooth.configuration - reaction.motion.configuration)[:, 7:] ** 2).mean(axis=0)))
        assert off.max() < angle_deg
        found = dynamics.inverse_dynamics(model, smooth, ())
        want = reaction.motion.torque_nm + reaction.motion.tissue_nm
        wrong = np.sqrt(((found.torque_nm - want)[:, above] ** 2).mean(axis=0))
        assert np.sqrt((wrong**2).mean()) < rms_nm and wrong.max() < worst_nm
        if noise_m == 0.003:
            parameters = worker_fatigue(paper)[reaction.name.worker]
            maps = [
                np.array(cycle_profile(replace(reaction.motion, torque_nm=torque), parameters).maps(1.0, 1.0))
                for torque in (found.torque_nm - reaction.motion.tissue_nm, reaction.motion.torque_nm)
            ]
            entries = np.concatenate([above, above])
            share = abs(maps[0] - maps[1])[:, entries].max(axis=1) / [
                (1 - maps[1][0][entries]).max(),
                maps[1][1][entries].max(),
            ]
            assert share.max() < 0.02


def test_without_plates_the_soles_carry_what_the_motion_needs(reactions: tuple[Reaction, ...]) -> None:
    """Against plates that show what the simulated ground did: all joints above the legs alike, the legs nearly."""
    reaction = reactions[0]
    request, rate = reaction.key.motion_request(), 1 / reaction.motion.time_step_s
    worker = request.worker
    model = Measured(worker.height_m, worker.mass_kg, worker.sex, worker.human).model(
        right_hand_kg=request.tool.mass_kg
    )
    motion = dynamics.Movement(
        rate, *(getattr(reaction.motion, n) for n in ("configuration", "velocity", "acceleration"))
    )
    found = dynamics.inverse_dynamics(model, motion, ())
    want = reaction.motion.torque_nm + reaction.motion.tissue_nm
    legs = np.array([any(leg in name for leg in ("hip", "knee", "ankle")) for name in DEGREES_OF_FREEDOM])
    np.testing.assert_allclose(found.torque_nm[:, ~legs], want[:, ~legs], atol=1e-6)
    assert np.isnan(found.residual_force_n).all()
    both = [sum(table[:, DEGREES_OF_FREEDOM.index(f"{side}_knee_flexion")] for side in ("right", "left")) for table in (found.torque_nm, want)]  # fmt: skip  # noqa: E501
    assert np.sqrt(((both[0] - both[1]) ** 2).mean()) < 0.1 * abs(both[1]).max()


def plates_under(model: pin.Model, configuration: Vector, frames: int) -> GroundForce:
    """One plate that carries somebody who stands still."""
    data = model.createData()
    weight = pin.computeTotalMass(model) * GRAVITY_MPS2 * np.array([0.0, 0.0, 1.0])
    moment = np.cross(pin.centerOfMass(model, data, configuration), weight)
    return GroundForce(np.tile(weight, (frames, 1)), np.tile(moment, (frames, 1)))


def test_a_static_trial_shows_how_far_forward_the_trunk_is() -> None:
    configuration = np.concatenate(
        [[0, 0, 0.94, 0, 0, 0, 1.0], calibration_stance(Worker(height_m=1.75, mass_kg=75, sex="male"))]
    )
    still = dynamics.Movement(100.0, np.tile(configuration, (3, 1)), np.zeros((3, 45)), np.zeros((3, 45)))
    true = replace(PERSON, trunk_forward_m=-0.03)
    plate = plates_under(true.model(), configuration, 3)
    assert dynamics.balanced(PERSON, still, [plate]).trunk_forward_m == pytest.approx(-0.03, abs=1e-6)
    with pytest.raises(RecordingError, match="the plates carry 736 N in the static trial, not the person's 589 N"):
        dynamics.balanced(replace(PERSON, mass_kg=60.0), still, [plate])


def test_the_trunk_weighs_where_the_seventh_cervical_vertebra_says() -> None:
    usual = PERSON.above_hip("thorax") + 0.295  # where the landmark is at this stature
    same, lower = (replace(PERSON, cervicale_m=height) for height in (usual, usual - 0.05))
    com = {body: lower.segment(body).com_m[2] - same.segment(body).com_m[2] for body in ("pelvis", "thorax", "head")}
    assert com["head"] == pytest.approx(-0.05) and -0.05 < com["thorax"] < -0.03 < com["pelvis"] < 0
    assert same.segment("head").com_m[2] == pytest.approx(PERSON.segment("head").com_m[2], abs=1e-9)


def test_an_unmarked_head_stays_upright_and_an_unmarked_abdomen_shares_the_bend() -> None:
    rng = np.random.default_rng(6)
    whole = four_on_each_body(rng)
    markers, _ = whole.of(tuple(name for name in whole.labels if not name.startswith(("head", "neck", "abdomen"))))
    worker = Worker(height_m=1.75, mass_kg=75, sex="male")
    bent = np.tile(np.concatenate([[0, 0, 0.94, 0, 0, 0, 1.0], calibration_stance(worker)]), (11, 1))
    bent[:, 7 + DEGREES_OF_FREEDOM.index("lumbar_flexion")] = np.linspace(0, 0.5, 11)
    calibration = Calibration(PERSON, markers, calibration_stance(worker), 0.0)
    own = track(calibration, markers, seen(PERSON, markers, bent), 100.0)
    turn = poses_of(tree_of(PERSON), own.configuration).rotation[-1]
    np.testing.assert_allclose(turn[BODIES.index("head")], np.eye(3), atol=0.01)
    assert np.arcsin(-turn[BODIES.index("thorax"), 2, 0]) == pytest.approx(0.5, abs=0.02)
    for name, low, high in (("lumbar_flexion", 0.3, 0.5), ("thoracic_flexion", 0.0, 0.2)):
        assert low <= own.configuration[-1, 7 + DEGREES_OF_FREEDOM.index(name)] <= high


def of_a_real(name: str, static: str) -> tuple[Calibration, Track, Recording]:
    """With the masses balanced by the static trial's plates."""
    files = [[real(f"squat_sit_plates/{one}.trc"), real(f"squat_sit_plates/{one}_grf.mot")] for one in (name, static)]
    found, still = read_recording(*files[0])[1], read_recording(*files[1])[1].recording
    markers = markers_of(found.recording, found.mapping, 1.75)
    assert found.recording.points_m is not None and still.points_m is not None
    markers, in_still = markers.of(still.labels)
    markers, in_motion = markers.of(found.recording.labels)
    targets = found.recording.points_m[:, in_motion]
    worker = Worker(height_m=1.75, mass_kg=60.05, sex="male")
    calibration = calibrate(worker, markers, targets, still.points_m[:, in_still])
    standing = track(calibration, calibration.markers, still.points_m[:, in_still], still.rate_hz)
    motion = dynamics.movement(calibration.person.model(), standing.configuration, still.rate_hz)
    ground = dynamics.ground_at(still.ground, still.ground_rate_hz, still.frames, still.rate_hz)
    balanced = dynamics.balanced(calibration.person, motion, ground)
    assert -0.06 < balanced.trunk_forward_m < -0.02  # nobody's masses are straight above the hips
    calibration = replace(calibration, person=balanced)
    return calibration, track(calibration, calibration.markers, targets, found.recording.rate_hz), found.recording


@pytest.fixture(scope="module")
def squats() -> tuple[Calibration, Track, Recording]:
    return of_a_real("squats1", "static1")


def test_real_squats(squats: tuple[Calibration, Track, Recording]) -> None:
    """Markers within 7.5 and 14 mm RMS, 13 N of vertical force and 20 N.m of pitch unexplained."""
    calibration, own, recording = squats
    assert np.sqrt(np.nanmean(own.distance_m**2)) < 0.0075
    assert max(own.marker_rms_m.values()) < 0.014
    model = calibration.person.model()
    ground = dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)
    found = dynamics.inverse_dynamics(model, dynamics.movement(model, own.configuration, own.rate_hz), ground)
    inner = slice(20, -20)  # ends of filters
    rms = np.sqrt((found.residual_force_n[inner] ** 2).mean(axis=0))
    assert rms[2] < 13 and np.sqrt((rms**2).sum()) < 20
    assert np.sqrt((found.residual_moment_nm[inner] ** 2).mean(axis=0)) == pytest.approx([2, 15, 2], abs=1.5)
    assert (found.foot[:, 0] == 0).all() and (found.foot[:, 1] == 1).all()  # whatever the shipped XML says


def test_real_chair() -> None:
    """Somebody stands up from a chair that nobody measured, five times, and sits down again."""
    calibration, own, recording = of_a_real("STS1", "static1")
    model = calibration.person.model()
    motion = dynamics.movement(model, own.configuration, own.rate_hz)
    ground = dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)
    found = dynamics.inverse_dynamics(model, motion, ground)
    contacts = unmeasured_contacts(model, motion, found)
    assert len(contacts) == 6 and all(contact.force_n[2] > 400 for contact in contacts)
    assert {contact.body for contact in contacts} == {"pelvis"}
    sat = carried(contacts, len(own.configuration))
    up = own.configuration[:, 2] > own.configuration[:, 2].max() - 0.05
    assert not (sat & up).any()
    assert unmarked_joints(calibration.markers.shown) == ("neck", "head", "right_wrist", "left_wrist")


@pytest.fixture(scope="module")
def opensim() -> NDArray[np.void]:
    """What perf/opensim/torques.py has stored, ten rows a second."""
    return np.genfromtxt(Path(__file__).parent / "opensim_squats1.csv", delimiter=",", names=True)


def rms(off: Vector) -> float:
    """Root mean square of a row each tenth of a second, without the ends of filters."""
    return float(np.sqrt((off[2:-2] ** 2).mean()))


def test_real_torques_beside_opensim(squats: tuple[Calibration, Track, Recording], opensim: NDArray[np.void]) -> None:
    """Where the model's trunk is OpenSim's, straight, lumbar torques, too.

    Knees are 8.7 N.m off (bar 8) where the moment about the hinge is compared with that about OpenSim's knee: see
    `test_real_knees_about_the_axis_of_opensim`.
    """
    calibration, own, recording = squats
    ground = dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)
    off = {}
    for straight in (True, False):
        person = replace(calibration.person, trunk_forward_m=0.0) if straight else calibration.person
        motion = dynamics.movement(person.model(), own.configuration, own.rate_hz)
        found = dynamics.inverse_dynamics(person.model(), motion, ground).torque_nm[::10]
        for name in (name for name in opensim.dtype.names[1:] if name in DEGREES_OF_FREEDOM):
            off[name, straight] = rms(found[:, DEGREES_OF_FREEDOM.index(name)] - opensim[name])
    for joint, most in (("hip", 2.0), ("knee", 9.0), ("ankle", 4.0)):
        assert max(off[f"{side}_{joint}_flexion", False] for side in ("right", "left")) < most
    assert off["lumbar_flexion", True] < 6 and off["lumbar_flexion", False] < 12


def test_real_knees_about_the_axis_of_opensim(
    squats: tuple[Calibration, Track, Recording], opensim: NDArray[np.void]
) -> None:
    """OpenSim's knee slides and turns as it bends: the same forces have another moment about it than about a hinge.

    What our thigh does to our shank, along OpenSim's motion of the knee, is its torque to 0.8 N.m RMS (bar 8).
    """
    calibration, own, recording = squats
    model = calibration.person.model()
    motion = dynamics.movement(model, own.configuration, own.rate_hz)
    ground = dynamics.ground_at(recording.ground, recording.ground_rate_hz, recording.frames, recording.rate_hz)
    foot = dynamics.inverse_dynamics(model, motion, ground).foot
    raw = read_content(real("squat_sit_plates/squats1.trc")).points
    assert raw is not None and recording.points_m is not None
    to_world = np.linalg.lstsq(raw.position[0], recording.points_m[0])[0].T  # both have their origin at the same place
    assert to_world @ to_world.T == pytest.approx(np.eye(3), abs=1e-9)
    data = model.createData()
    found = {"right": np.empty(len(opensim)), "left": np.empty(len(opensim))}
    for row, n in enumerate(range(0, recording.frames, 10)):
        outside = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
        pin.forwardKinematics(model, data, motion.configuration[n])
        for plate, side in zip(ground, foot[n], strict=True):
            if side < 0:  # nobody stands on it
                continue
            ankle = model.frames[model.getFrameId(f"{SIDES[side]}_sole")].parentJoint
            outside[ankle] += data.oMi[ankle].actInv(pin.Force(plate.force_n[n], plate.moment_nm[n]))
        pin.rnea(model, data, motion.configuration[n], motion.velocity[n], motion.acceleration[n], outside)
        for side, knees in found.items():
            knee = model.getJointId(f"{side}_knee_flexion")
            on_shank = data.oMi[knee].act(data.f[knee])
            turn, shift = (
                to_world @ [opensim[f"{side}_knee_{what}_{axis}"][row] for axis in "xyz"]
                for what in ("turn_rad", "shift_m")
            )
            knees[row] = turn @ on_shank.angular + shift @ on_shank.linear
    for side, knees in found.items():
        assert rms(knees - opensim[f"{side}_knee_flexion"]) < 2

"""From recordings to reactions: subjects, phases, contacts, verdicts; and simulated reactions, recorded, come back."""

import io
import itertools
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from recorded import mvnx, real
from scipy.spatial.transform import Rotation
from simulated_recording import record

from fatigue_planner.core.errors import DataFileError, MissingReactionsError, OtherVersionError, RecordingError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import load_reactions, reaction_requests
from fatigue_planner.experiment.loader import parse_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.model import Tool, Worker
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion.motion import Phase
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.hdf5_layout import entry_bytes, read_entry, with_checksum
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionName, ReactionRequest, Recorded
from fatigue_planner.reactions.recorded import PhaseQuality, RecordedQuality, RecordingAccuracy, largest_load
from fatigue_planner.reactions.verify import faults_of
from fatigue_planner.recordings.check import read_recording
from fatigue_planner.recordings.imports import contacts
from fatigue_planner.recordings.imports.imported import Imported, import_recording
from fatigue_planner.recordings.imports.phases import Bounds, bounds_of, given_bounds
from fatigue_planner.recordings.imports.subject import Subject, load_subject, static_files, worker_of
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import Interpreted
from fatigue_planner.recordings.mapping import landmark_table, load_mapping
from fatigue_planner.recordings.recognition.recorded import moved_by_angles_m
from fatigue_planner.recordings.recording import GroundForce

Vector = NDArray[np.float64]

KEY = "0123456789abcdef"
GOOD = PhaseQuality("reach", 0.5, 5.5, 0.006, 0.012, "C7", 0.0, "", 0.02, 30.0, 0.0, 0.0, 0.01, 1.0)
QUALITY = RecordedQuality(
    tuple(replace(GOOD, name=name) for name in ("reach", "work", "return")),
    0.02,
    (),
    0.0,
    0.3,
    "lumbar_flexion",
    (1.0,) * 7,
)


# --- who was recorded ------------------------------------------------------------------------------------------


def subject(tmp_path: Path, **changed: object) -> Path:
    path = tmp_path / "subject.yaml"
    path.write_text(yaml.safe_dump({"height_m": 1.75, "mass_kg": 75.0, "sex": "male"} | changed))
    return path


def test_a_subject_is_the_worker_who_has_this_body(paper: Experiment, tmp_path: Path) -> None:
    path = subject(tmp_path, static=["still.trc"])
    assert worker_of(paper, load_subject(path), path) == "average_man"
    assert static_files(path, load_subject(path)) == [tmp_path / "still.trc"]
    other = subject(tmp_path, mass_kg=60.0)
    with pytest.raises(RecordingError, match=r"no worker of the experiment has this body: 1\.75 m, 60 kg, male"):
        worker_of(paper, load_subject(other), other)
    with pytest.raises(RecordingError, match=r"average_man has another body: mass_kg = 75\.0, not 60\.0"):
        worker_of(paper, Subject(worker="average_man", height_m=1.75, mass_kg=60, sex="male"), other)
    with pytest.raises(RecordingError, match="worker = 'nobody': is not one of the experiment's average_man"):
        worker_of(paper, Subject(worker="nobody", height_m=1.75, mass_kg=75, sex="male"), other)


@pytest.mark.parametrize("key", ["name", "date_of_birth"])
def test_a_subject_file_has_no_place_for_who_it_is(tmp_path: Path, key: str) -> None:
    with pytest.raises(DataFileError, match=key):
        load_subject(subject(tmp_path, **{key: "x"}))


# --- phases ----------------------------------------------------------------------------------------------------


def way(*stops: tuple[float, float], rate_hz: float = 100.0) -> Vector:
    """A hand (n, 1, 3) m that goes along x from stop to stop (time in s, x in m) by minimum jerk."""
    times = np.arange(0, stops[-1][0], 1 / rate_hz)
    x = np.full(len(times), stops[0][1])
    for (begin, there), (end, then) in itertools.pairwise(stops):
        share = np.clip((times - begin) / (end - begin), 0, 1)
        x += (then - there) * share**3 * (10 - 15 * share + 6 * share**2)
    return np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)[:, None]


def test_phases_are_found_by_the_hand() -> None:
    found = bounds_of(way((0.5, 0.0), (1.5, 0.5), (4.0, 0.5), (5.0, 0.0), (6.0, 0.0)), 100.0)
    assert found == pytest.approx((0.5, 1.5, 4.0, 5.0), abs=0.12)  # 5 % of the speed: 6 % of the way's time
    # a short move within the work is part of it
    within = way((0.5, 0.0), (1.5, 0.5), (2.5, 0.5), (3.0, 0.55), (4.0, 0.55), (5.0, 0.0), (6.0, 0.0))
    assert bounds_of(within, 100.0) == pytest.approx((0.5, 1.5, 4.0, 5.0), abs=0.12)


def test_what_is_no_reach_and_return_is_refused() -> None:
    with pytest.raises(RecordingError, match="makes 1 movement with a pause before or after"):
        bounds_of(way((0.5, 0.0), (1.5, 0.5), (4.0, 0.5)), 100.0)
    with pytest.raises(RecordingError, match="does not return to where it began"):
        bounds_of(way((0.5, 0.0), (1.5, 0.5), (3.0, 0.5), (4.0, 1.0), (5.0, 1.0)), 100.0)


def test_phases_can_be_given() -> None:
    assert given_bounds([0.5, 1, 2, 3], 3.0) == Bounds(0.5, 1, 2, 3)
    for wrong in ([0.5, 1, 2], [0.5, 0.4, 2, 3], [0.5, 1, 2, 3.1], [-1, 1, 2, 3], [0.5, 1, math.nan, 3]):
        with pytest.raises(RecordingError, match="--phases"):
            given_bounds(wrong, 3.0)
    times = Bounds(1.0, 2.0, 2.5, 4.5).times_s((Phase("reach", 0, 4), Phase("work", 4, 6), Phase("return", 6, 10)))
    np.testing.assert_allclose(times, [1, 1.25, 1.5, 1.75, 2, 2.25, 2.5, 3, 3.5, 4])


# --- plates ----------------------------------------------------------------------------------------------------


def test_a_lag_of_the_plates_is_found_and_removed() -> None:
    times = np.arange(0, 6, 0.01)
    needed = 700 + 60 * np.sin(4 * times) + 30 * np.sin(9 * times)
    late = 700 + 60 * np.sin(4 * (times - 0.043)) + 30 * np.sin(9 * (times - 0.043))
    assert contacts.lag_s(late, needed, 100.0) == pytest.approx(0.043, abs=0.002)
    assert contacts.lag_s(needed, needed, 100.0) == pytest.approx(0.0, abs=1e-4)
    assert contacts.lag_s(late, np.full_like(needed, 700.0), 100.0) is None  # nothing to tell it by


# --- verdicts --------------------------------------------------------------------------------------------------


def test_a_good_recording_has_nothing_against_it() -> None:
    assert (QUALITY.verdict(RecordingAccuracy()), QUALITY.remarks()) == ("ok", [])
    reach, work, back = QUALITY.phases
    assert replace(QUALITY, phases=(reach, replace(work, stretch=0.3 / (1.5 - 1.3)), back)).remarks() == []


@pytest.mark.parametrize(
    ("changed", "verdict", "told"),
    [
        ({"marker_rms_m": 0.03}, "degraded", "work: markers are away from their places by 30 mm (good: 20)"),
        ({"marker_rms_m": 0.05}, "failed", "work: markers are away from their places by 50 mm (allowed: 40)"),
        ({"worst_marker_m": 0.05}, "degraded", "by 50 mm (C7) (good: 40)"),
        ({"unseen_s": 0.6, "unseen_body": "left_shank"}, "failed", "no marker for 0.60 s (left shank) (allowed: 0.50)"),
        ({"residual_force_share": 0.11}, "failed", "a force of 11.0 % of the weight (allowed: 10.0)"),
        ({"residual_moment_nm": 60.0}, "degraded", "a moment of 60.0 N·m (good: 50.0)"),
        ({"unmeasured_share": 0.05}, "degraded", "an unmeasured contact carries during 5 % of the time (good: 0)"),
        ({"unmeasured_share": 0.2}, "failed", "during 20 % of the time (allowed: 10)"),
        ({"one_plate_share": 0.2}, "failed", "both feet are on one plate during 20 % of the time (allowed: 10)"),
        ({"foot_slide_m": 0.03}, "degraded", "a foot slides by 3.0 cm (good: 2.0)"),
        ({"stretch": 3.5}, "failed", "by a factor of 3.50 (allowed: 3.00)"),
    ],
)
def test_a_phase_that_is_not_good_is_named(changed: dict[str, object], verdict: str, told: str) -> None:
    reach, work, back = QUALITY.phases
    found = replace(QUALITY, phases=(reach, replace(work, **changed), back))
    assert found.verdict(RecordingAccuracy()) == verdict
    assert told in "; ".join(found.faults(RecordingAccuracy()) or found.remarks())
    accepted = RecordingAccuracy(**{name: value for name, value in changed.items() if name != "unseen_body"})
    assert found.verdict(accepted) == "degraded"  # knowingly accepted, but still said


def test_without_hand_markers_no_wrist_torque_is_reported() -> None:
    found = replace(QUALITY, assumed_joints=("right_wrist",))
    assert found.verdict(RecordingAccuracy()) == "degraded"
    assert "no marker shows right wrist: no torque is reported there" in found.degradation()
    held = replace(found, wrist_load_kg=5.0)
    assert "a hand without markers holds 5 kg" in held.faults(RecordingAccuracy())[0]
    assert held.verdict(RecordingAccuracy(wrist_load_kg=5)) == "degraded"


def test_without_plates_legs_are_assumed() -> None:
    none = {"residual_force_share": None, "residual_moment_nm": None, "unmeasured_share": None, "one_plate_share": None}
    found = replace(QUALITY, phases=tuple(replace(phase, **none) for phase in QUALITY.phases))
    assert found.verdict(RecordingAccuracy()) == "degraded" and "no plate measured the ground" in found.degradation()


def test_a_hand_that_works_elsewhere_is_another_action() -> None:
    found = replace(QUALITY, work_hand_error_m=0.3)
    assert "the hand works 30 cm from the action's place (allowed: 15 cm)" in found.faults(RecordingAccuracy())


# --- the cache -------------------------------------------------------------------------------------------------


def as_recorded(reaction: Reaction, name: ReactionName | None = None) -> Reaction:
    """A simulated reaction as if it were one of a recording."""
    request = reaction.key.motion_request()
    share, joint = largest_load(request.maximum_torque, reaction.motion)
    key = ReactionKey.of_recorded(request, KEY)
    quality = replace(QUALITY, largest_load_share=share, largest_load_joint=joint)
    return Reaction(name or reaction.name, key, reaction.motion, quality)


def test_a_recorded_reaction_is_stored_and_read(reactions: tuple[Reaction, ...]) -> None:
    stored = as_recorded(reactions[0])
    found = read_entry(entry_bytes(stored), "memory")
    assert isinstance(found, Reaction) and found.quality == stored.quality and found.key == stored.key
    assert found.digest != reactions[0].digest and found.key.recorded == KEY and found.key.is_current
    np.testing.assert_array_equal(found.motion.torque_nm, stored.motion.torque_nm)
    assert faults_of(found) == [] and found.findings == []
    older = io.BytesIO(entry_bytes(stored))
    with h5py.File(older, "r+") as file:
        file["format_version"][()] = 5  # it named wrists only
    with pytest.raises(OtherVersionError, match="has format 5; this version reads 6"):
        read_entry(with_checksum(older.getvalue()), "memory")
    altered = replace(found, motion=replace(found.motion, torque_nm=2 * found.motion.torque_nm))
    assert "largest_load_share" in faults_of(altered)[0]


@pytest.mark.parametrize("change", [{"worst_marker": "a\nb"}, {"unseen_body": "tail"}, {"name": "rest"}])
def test_what_could_not_have_been_written_is_not_read(reactions: tuple[Reaction, ...], change: dict[str, str]) -> None:
    from fatigue_planner.core.errors import DamagedFileError

    stored = as_recorded(reactions[0])
    assert isinstance(stored.quality, RecordedQuality)
    phases = (replace(GOOD, **change), *stored.quality.phases[1:])
    with pytest.raises(DamagedFileError, match="its quality"):
        read_entry(entry_bytes(replace(stored, quality=replace(stored.quality, phases=phases))), "memory")


def test_an_experiment_names_a_recorded_reaction(
    paper: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path
) -> None:
    mixed = paper.model_copy(update={"recorded": {"average_man": {"low": {"arm": KEY}}}})
    requests = reaction_requests(mixed)
    (asked,) = [request for request in requests if request.recorded]
    assert asked.recorded == Recorded(KEY, RecordingAccuracy()) and asked.name == ("average_man", "low", "arm")
    cache = ReactionCache(tmp_path)
    for reaction in reactions:
        if reaction.name != asked.name:
            cache.store(reaction)
    with pytest.raises(MissingReactionsError, match=f"average_man/low/arm .{KEY}.*fatplan record import"):
        cache.complete(requests, LocalProcesses(1), lambda _: None)
    with pytest.raises(MissingReactionsError, match="Some are recorded: `fatplan record import`"):
        load_reactions(mixed, tmp_path, "fatplan simulate")
    (simulated,) = [reaction for reaction in reactions if reaction.name == asked.name]
    cache.store(as_recorded(simulated))
    outcomes = cache.complete(requests, LocalProcesses(1), lambda _: None)
    assert [outcome.found for outcome in outcomes] == [True] * 4
    assert [outcome.name for outcome in outcomes if outcome.is_recorded] == [asked.name]
    loaded = load_reactions(mixed, tmp_path, "fatplan simulate")
    assert [reaction.key.recorded for reaction in loaded if reaction.name == asked.name] == [KEY]
    strict = mixed.model_copy(update={"recording_accuracy": RecordingAccuracy(marker_rms_m=0.005)})
    (failed,) = [
        reaction
        for reaction in cache.stream(reaction_requests(strict), "fatplan simulate")
        if isinstance(reaction, FailedReaction)
    ]
    assert failed.name == asked.name and "by 6 mm (allowed: 5)" in failed.reason


# --- the whole import ------------------------------------------------------------------------------------------


class Trial(NamedTuple):
    """A simulated reaction, and the recording of it."""

    truth: Reaction
    request: ReactionRequest
    found: Interpreted
    static: Interpreted

    def imported(self, found: Interpreted | None = None, **more: Any) -> Imported:
        cycle = self.request.motion.cycle
        times = np.cumsum([0.5, cycle.reach_s, cycle.work_s, cycle.return_s]).tolist()
        given = {"phases_s": times} | more
        return import_recording(self.truth.name, self.request.motion, found or self.found, self.static, **given)

    def whole(self) -> Vector:
        """The configurations (n, 46) of the recording: he stands still for half a second before and after."""
        motion = self.truth.motion
        still = round(0.5 / motion.time_step_s)
        return np.pad(motion.configuration, ((still, still), (0, 0)), mode="edge")

    def under(self, *plates: GroundForce) -> Interpreted:
        """The recording with other plates."""
        return replace(self.found, recording=replace(self.found.recording, ground=plates))


@pytest.fixture(scope="module")
def trial(paper: Experiment, reactions: tuple[Reaction, ...], tmp_path_factory: pytest.TempPathFactory) -> Trial:
    """The paper's first reaction with plates, hand markers and a static trial, by Plug-in Gait, noise 1 mm."""
    *files, about = record(paper, reactions[0], tmp_path_factory.mktemp("trial"), noise_m=0.001)
    static = read_recording(*static_files(about, load_subject(about)))[1]
    request = next(one for one in reaction_requests(paper) if one.name == reactions[0].name)
    return Trial(reactions[0], request, read_recording(*files)[1], static)


def told(made: Imported, fault: int) -> str:
    return " ".join(remark.text for remark in made.remarks if remark.fault == fault)


@pytest.mark.slow
def test_a_simulated_reaction_that_is_recorded_comes_back(trial: Trial) -> None:
    made = trial.imported()
    assert made.quality.verdict(RecordingAccuracy()) == "ok", made.quality.remarks()
    assert made.remarks == ()
    assert made.track.cutoff_hz is None  # markers are noisy only; their smoother's postures are not filtered again
    np.testing.assert_allclose(made.movement.configuration[:, 7:], made.track.configuration[:, 7:], atol=1e-9)
    off = made.reaction.motion.torque_nm - trial.truth.motion.torque_nm
    rms = dict(zip(DEGREES_OF_FREEDOM, np.sqrt((off**2).mean(axis=0)), strict=True))
    assert max(rms.values()) < 5, rms
    assert made.quality.work_hand_error_m < 0.03
    # the same data, the same key; whatever the file is called and its header says
    assert trial.imported(replace(trial.found, remarks=(), findings=())).key == made.key
    slower = replace(trial.found, recording=replace(trial.found.recording, rate_hz=99.0, ground_rate_hz=99.0))
    assert trial.imported(slower).key != made.key


@pytest.mark.slow
def test_plates_find_their_feet(trial: Trial) -> None:
    """Fault 12: whatever a file says of plates and feet; and what is not plain is told."""
    right, left = trial.found.recording.ground
    made, other = trial.imported(), trial.imported(trial.under(left, right))
    np.testing.assert_allclose(other.reaction.motion.torque_nm, made.reaction.motion.torque_nm, atol=1e-9)
    shared = trial.imported(trial.under(GroundForce(right.force_n + left.force_n, right.moment_nm + left.moment_nm)))
    assert "both feet are on one plate 100 % of the time; it counts for the nearer one." in told(shared, 12)
    assert "both feet are on one plate during 100 %" in "; ".join(shared.quality.faults(RecordingAccuracy()))
    away = GroundForce(right.force_n, right.moment_nm + np.cross([0.0, 1.0, 0.0], right.force_n))
    nowhere = trial.imported(trial.under(away, left))
    assert "plate 1 is pressed where no foot is, 100 % of the time; left out." in told(nowhere, 12)
    half = trial.found.recording.frames // 2
    crossed = [
        GroundForce(
            np.concatenate([one.force_n[:half], two.force_n[half:]]),
            np.concatenate([one.moment_nm[:half], two.moment_nm[half:]]),
        )
        for one, two in ((right, left), (left, right))
    ]
    told_of = told(trial.imported(trial.under(*crossed)), 12)
    assert "plate 1 carries one foot, then the other (the right one 50 % of the time)" in told_of


@pytest.mark.slow
def test_what_nobody_measured_is_found_in_its_phase(trial: Trial) -> None:
    """Fault 13: a seat that carries a third of him while he works."""
    share = np.ones((trial.found.recording.frames, 1))
    share[550:1150] = 2 / 3
    plates = [GroundForce(one.force_n * share, one.moment_nm * share) for one in trial.found.recording.ground]
    made = trial.imported(trial.under(*plates))
    assert re.search(
        r"work: something unmeasured near [a-z ]+ carries 26\d N on average, (99|100) % of the time", told(made, 13)
    )
    assert "the phase counts as unmeasured" in told(made, 13)
    assert [(phase.unmeasured_share or 0.0) > 0.5 for phase in made.quality.phases] == [False, True, False]
    fault = made.quality.faults(RecordingAccuracy())[0]
    assert fault.startswith("work: an unmeasured contact carries during")


@pytest.mark.slow
def test_a_load_that_nobody_said_is_told(trial: Trial) -> None:
    """Fault 11: the recording is that of a tool of 5 kg, the experiment has none; or one of 15 kg (fault 13)."""
    empty = replace(trial.request.motion, tool=Tool(mass_kg=0.0))
    without = trial._replace(request=replace(trial.request, motion=empty))
    assert "work: the plates show +5.0 kg beside body, tool and loads." in told(without.imported(), 11)
    person, more_n = trial.request.motion.worker.anthropometry(), np.array([0.0, 0.0, 5 * GRAVITY_MPS2])
    hand = poses_of(tree_of(person), trial.whole()).points("right_hand", person.grip_m())
    heavier = [
        GroundForce(one.force_n + more_n, one.moment_nm + np.cross(hand, more_n))
        for one in trial.found.recording.ground
    ]
    said = told(without.imported(without.under(*heavier)), 13)
    assert re.search(
        r"work: the plates show \+15\.\d kg beside body, tool and loads, near right (hand|forearm), ", said
    )


@pytest.mark.slow
def test_plates_that_are_late_and_ends_are_told(trial: Trial) -> None:
    """Fault 15: how late, and the option that sets it right; and phases at the ends of a recording."""
    late = [
        GroundForce(np.roll(one.force_n, 4, axis=0), np.roll(one.moment_nm, 4, axis=0))
        for one in trial.found.recording.ground
    ]
    made = trial.imported(trial.under(*late))
    found = re.search(r"the plates are (\d+) ms late; --plate-lag (\S+) sets that right", told(made, 15))
    assert found and abs(int(found[1]) - 40) <= 4
    mended = trial.imported(trial.under(*late), plate_lag_s=float(found[2]))
    assert told(mended, 15) == "" and mended.key != made.key
    worst = [max(phase.residual_force_share or 0.0 for phase in one.quality.phases) for one in (made, mended)]
    assert worst[1] < worst[0]
    ends = trial.imported(phases_s=[0.1, 5.5, 11.5, 16.9])
    assert "a phase comes within 0.2 s of an end of the recording" in told(ends, 15)


# Segments of an Xsens suit, and the bodies they are; T8 is on the thorax.
SUIT = {"Pelvis": "pelvis", "L5": "abdomen", "T8": "thorax", "Neck": "neck", "Head": "head"} | {
    side.title() + segment: f"{side}_{body}"
    for side in SIDES
    for segment, body in {
        "UpperArm": "upper_arm", "ForeArm": "forearm", "Hand": "hand", "UpperLeg": "thigh", "LowerLeg": "shank",
        "Foot": "foot",
    }.items()
}  # fmt: skip


def suit(worker: Worker, configuration: Vector, rate_hz: float, points: bool = True) -> bytes:
    """The MVNX file of an Xsens suit, whose segments are not turned where the arms are held out sideways."""
    poses = poses_of(tree_of(worker.anthropometry()), configuration)
    scale = worker.height_m / landmark_table().stature_m
    places = load_mapping("xsens").places
    origins, turns, on = [], [], {}
    for segment, body in SUIT.items():
        sideways = Rotation.identity()
        if body.endswith(("arm", "hand")):
            sideways = Rotation.from_euler("x", 90 if body.startswith("right") else -90, degrees=True)
        at = scale * places["t8"].at_m if segment == "T8" else np.zeros(3)  # all others begin where their joint is
        origins.append(poses.points(body, at))
        turned = Rotation.from_matrix(poses.rotation[:, BODIES.index(body)]) * sideways
        turns.append(turned.as_quat(scalar_first=True))
        on |= {
            label: (segment, sideways.inv().apply(scale * place.at_m - at))
            for label, place in places.items()
            if place.body == body and label.startswith("p") and label != "pelvis"
        }
    return mvnx(
        np.stack(origins, axis=1), list(SUIT), rate_hz, turns=np.stack(turns, axis=1), points=on if points else None
    )


@pytest.mark.slow
def test_the_bony_points_of_a_suit_show_how_hands_and_head_turn(trial: Trial, tmp_path: Path) -> None:
    whole = trial.whole()

    def worn(points: bool) -> Imported:
        files = tmp_path / "motion.mvnx", tmp_path / "still.mvnx"
        for file, shown in zip(files, (whole, whole[:50]), strict=True):
            file.write_bytes(suit(trial.request.motion.worker, shown, 1 / trial.truth.motion.time_step_s, points))
        return trial._replace(static=read_recording(files[1])[1]).imported(read_recording(files[0])[1])

    def off_deg(made: Imported) -> dict[str, float]:
        off = np.degrees(made.track.configuration - whole)[:, 7:]
        return dict(zip(DEGREES_OF_FREEDOM, np.sqrt((off**2).mean(axis=0)), strict=True))

    made, without = worn(points=True), worn(points=False)
    assert max(off_deg(made).values()) < 0.1, off_deg(made)
    assert made.quality.assumed_joints == ()
    # the origin of a segment is at its joint: it does not show how the segment turns
    assumed = set(without.quality.assumed_joints)
    assert assumed == {"head", *(f"{side}_{joint}" for side in SIDES for joint in ("wrist", "ankle"))}
    bends = {name for name in DEGREES_OF_FREEDOM if name.endswith("_flexion")} - {
        f"{joint}_flexion" for joint in assumed
    }
    assert max(off_deg(without)[name] for name in bends) < 1
    # so it turns neither with the wrist nor with the forearm, on whose axis it is
    moved_m = moved_by_angles_m(without.calibration, without.track.configuration[::100])
    hand = dict(zip(DEGREES_OF_FREEDOM, moved_m[without.track.labels.index("RightHand")], strict=True))
    assert max(hand[f"right_{name}"] for name in ("wrist_flexion", "wrist_deviation", "forearm_pronation")) < 0.001
    assert min(hand[f"right_{name}"] for name in ("elbow_flexion", "shoulder_flexion", "shoulder_rotation")) > 0.1


def of_a_real(name: str, times_s: list[float]) -> Imported:
    """A real motion as if it were a reach; the hands, which show no marker, are where they are."""
    content = {
        "name": "real",
        "workers": {"s4": {"height_m": 1.75, "mass_kg": 60.05, "sex": "male"}},
        "cycle": {"reach_s": 1.0, "work_s": 1.0, "return_s": 1.0},
        "actions": {"squat": {"right_hand": {"position_m": {"x": 0.2, "y": -0.3, "z": 0.8}}}},
    }
    experiment = parse_experiment(content, "real.yaml")
    given = Given(mass_kg=60.05)
    files = [real(f"squat_sit_plates/{name}{end}") for end in (".trc", "_grf.mot")]
    found = read_recording(*files, given=given)[1]
    still = read_recording(*(real(f"squat_sit_plates/static1{end}") for end in (".trc", "_grf.mot")), given=given)[1]
    (request, _) = reaction_requests(experiment)
    return import_recording(request.name, request.motion, found, still, times_s)


@pytest.mark.slow
def test_a_real_squat_is_believed_but_for_its_wrists() -> None:
    made = of_a_real("squats1", [4.0, 5.0, 6.0, 7.0])
    quality = made.reaction.quality
    assert isinstance(quality, RecordedQuality) and "right_wrist" in quality.assumed_joints
    required = RecordingAccuracy(place_m=2.0)
    assert quality.verdict(required) == "degraded", quality.faults(required)
    assert quality.remarks() == [
        "no marker shows neck, head, right wrist and left wrist: no torque is reported there; planning uses those of "
        "an assumed posture"
    ]
    table = made.reaction.torques_nm()
    assert table[["right_wrist_flexion", "neck_flexion"]].isna().all(axis=None)
    assert table["right_knee_flexion"].notna().all()
    assert not any(remark.fault in (12, 13) for remark in made.remarks)
    assert made.track.cutoff_hz == 6 and made.calibration.person.trunk_forward_m < -0.02  # skin; the static's plates


@pytest.mark.slow
def test_a_chair_that_nobody_measured_is_found() -> None:
    made = of_a_real("STS1", [1.0, 2.0, 3.0, 4.0])
    assert "something unmeasured near pelvis carries" in told(made, 13)
    assert made.reaction.quality.verdict(RecordingAccuracy(place_m=2.0)) == "failed"

"""The file of a recogniser, read without trust; and simulated workers that it has never seen."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from test_recognition import CYCLE, JOINTS, repetitions

from fatigue_planner.core.errors import RecognitionError
from fatigue_planner.core.files import publish_with_checksum
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import parse_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.recognition.calibration import calibration_error
from fatigue_planner.recordings.recognition.confusion import told_apart
from fatigue_planner.recordings.recognition.recogniser import Recogniser, train
from fatigue_planner.recordings.recognition.repetitions import CaptureError, measured
from fatigue_planner.recordings.recognition.stored import StoredRecogniser, load_recogniser
from fatigue_planner.recordings.recognition.tables import KNOWN_FROM, early_table, known_from_s


@pytest.fixture(scope="module")
def recogniser() -> Recogniser:
    return train(repetitions(np.random.default_rng(0), 5, 3), CYCLE, 0.75)[0]


@pytest.fixture
def file(recogniser: Recogniser, tmp_path: Path) -> Path:
    path = tmp_path / "recogniser.json"
    StoredRecogniser.of(recogniser, "task", {"a": "0"}, CaptureError(), 0.75).publish(path)
    return path


def test_what_was_written_is_read(recogniser: Recogniser, file: Path) -> None:
    found = load_recogniser(file).recogniser()
    motion = np.random.default_rng(1).normal(0, 10, (12, JOINTS))
    assert found.probabilities("low", motion) == recogniser.probabilities("low", motion)
    before = recogniser.actions["low"].confusion
    assert found.actions["low"].confusion.plain() == before.plain()


def test_the_key_says_what_decided(recogniser: Recogniser) -> None:
    keys = {
        StoredRecogniser.of(recogniser, "task", reactions, CaptureError(seed=seed), told).key
        for reactions, seed, told in (
            ({"a": "0"}, 0, 0.75),
            ({"a": "1"}, 0, 0.75),
            ({"a": "0"}, 1, 0.75),
            ({"a": "0"}, 0, 0.8),
        )
    }
    assert len(keys) == 4


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("format",), 2, "format"),
        (("temperature",), [1.0], "temperature"),
        (("actions", "low", "people"), [1, 1, 1], "actions.low.people.0"),
        (("actions", "low", "people"), [3, 3], "people: has not the shape"),
        (("actions", "low", "mean_deg"), [[[0.0]]] * 3, "mean_deg: has not the shape"),
        (("actions", "low", "correlation"), [[0.0] * 20] * 20, "correlation: is no covariance"),
        (("actions", "low", "groups"), [0, 0, 0], "groups: are not those"),
        (("actions", "low", "degrees_of_freedom"), ["tail"] * JOINTS, "tail: the digital human has none"),
        (("actions", "low", "lapse"), 0.0, "lapse"),
        (("told_apart_from",), 0.9, "key: is not that of its content"),
        (("more",), 0, "more"),
    ],
)
def test_a_file_that_says_what_cannot_be_is_refused(
    file: Path, place: tuple[str, ...], value: object, message: str
) -> None:
    content = json.loads(file.read_text())
    del content["sha256"]
    part = content
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    publish_with_checksum(file, content)
    with pytest.raises(RecognitionError, match=message) as error:
        load_recogniser(file)
    assert str(file) in str(error.value) and "\n" not in str(error.value)


def test_a_changed_byte_is_seen_and_what_is_no_file_refused(file: Path, tmp_path: Path) -> None:
    file.write_text(file.read_text().replace('"low"', '"lov"', 1))
    with pytest.raises(RecognitionError, match="is not what was written"):
        load_recogniser(file)
    for path in (tmp_path, tmp_path / "none"):
        with pytest.raises(RecognitionError, match="is no file"):
            load_recogniser(path)


PEOPLE = """
name: people
tool: {mass_kg: 1}
cycle: {reach_s: 1.5, work_s: 1, return_s: 1.5}
workers:
  a: {height_m: 1.55, mass_kg: 52, sex: female}
  b: {height_m: 1.65, mass_kg: 60, sex: female}
  c: {height_m: 1.72, mass_kg: 75, sex: male}
  d: {height_m: 1.80, mass_kg: 80, sex: male}
  e: {height_m: 1.88, mass_kg: 92, sex: male}
  new_1: {height_m: 1.60, mass_kg: 64, sex: female}
  new_2: {height_m: 1.85, mass_kg: 78, sex: male}
actions:
  low: {right_hand: {position_m: {x: 0.4, y: -0.15, z: 0.6}, orientation_deg: {y: -90}}}
  high: {right_hand: {position_m: {x: 0.45, y: -0.25, z: 1.2}, orientation_deg: {y: -90}}}
"""


def made(experiment: Experiment) -> list[Reaction]:
    found = []
    for request in reaction_requests(experiment):
        motion = simulate(request.motion)
        assert isinstance(motion, Motion)
        found.append(Reaction(request.name, request.key, motion, None))  # type: ignore[arg-type]
    return found


@pytest.mark.slow
def test_simulated_workers_never_seen_are_recognised() -> None:
    """Offsets of 5 degrees and noise of 3; a floor, as simulated people of one preference do not vary otherwise."""
    experiment = parse_experiment(yaml.safe_load(PEOPLE), "people.yaml")
    reactions = made(experiment)
    known = [reaction for reaction in reactions if not reaction.name.worker.startswith("new")]
    new = [reaction for reaction in reactions if reaction.name.worker.startswith("new")]
    probabilities, truths = [], []
    for seed in range(5):
        recogniser, held_out = train(measured(known, experiment.cycle, CaptureError(seed=seed)), experiment.cycle, 0.75)
        for session in range(10):
            seen = measured(new, experiment.cycle, CaptureError(seed=1000 + 10 * seed + session, repetitions=4))
            for action, one in recogniser.actions.items():
                own = seen.where(seen.actions == action)
                truth = np.array([one.model.preferences.index(name) for name in own.preferences.tolist()])
                found = one.posterior(own.angles_deg, recogniser.temperature)
                probabilities.append(found)
                truths.append(truth)
                different = one.model.difference_deg() >= 5
                assert different.any()
                told = told_apart(np.log(found[:, :, -1]), truth)
                assert (told[different] >= 0.95).all()
                early = early_table(recogniser, held_out).query("action == @action")
                since = known_from_s(recogniser, held_out[action], action)
                assert since is not None and (early["recognised"][early["time_s"] >= since] >= KNOWN_FROM).all()
    probability, truth = np.concatenate(probabilities), np.concatenate(truths)
    for part in (4, 9, -1):
        assert calibration_error(probability[:, :, part], truth) <= 0.03

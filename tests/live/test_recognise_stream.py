"""A tracker's stream of joint angles on loopback, with real outlets and a real server: it comes, goes and errs."""

import json
import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pylsl
import pytest
from commands import process, refused
from conftest import PAPER
from test_lsl import WAIT_S, until

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.live.clients.angle_stream import AngleStream, Unit
from fatigue_planner.live.clients.connection import Connection
from fatigue_planner.live.clients.recogniser import Samples
from fatigue_planner.live.events import Observed
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.rehearsal.server import Server
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.recognition.recogniser import train
from fatigue_planner.recordings.recognition.repetitions import CaptureError, measured
from fatigue_planner.recordings.recognition.stored import StoredRecogniser

pytestmark = pytest.mark.slow
RATE_HZ = 25.0
ELBOW, KNEE = "right_elbow_flexion", "right_knee_flexion"
WANTED = (DEGREES_OF_FREEDOM.index(ELBOW), DEGREES_OF_FREEDOM.index(KNEE))


def outlet(
    name: str, labels: tuple[str, ...], unit: str, rate_hz: float = RATE_HZ, channels: int = 0, text: bool = False
) -> pylsl.StreamOutlet:
    """A tracker's stream."""
    form = pylsl.cf_string if text else pylsl.cf_double64
    info = pylsl.StreamInfo(name, "MoCap", channels or len(labels), rate_hz, form, f"test {time.time()}")
    described = info.desc().append_child("channels")
    for label in labels:
        channel = described.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", unit)
    return pylsl.StreamOutlet(info)


def read(stream: AngleStream, wants: str) -> Samples:
    """What is read as soon as there are samples, or a remark with these words."""
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        found = stream.read()
        if (wants and any(wants in one for one in found.remarks)) or (not wants and len(found.stamps_s)):
            return found
        time.sleep(0.05)
    raise AssertionError(wants)


def test_angles_of_the_channels_that_are_known_and_nothing_absurd() -> None:
    stream = AngleStream("known", None, WANTED, 4)
    first = outlet("known", ("confidence", KNEE, ELBOW), "radians")
    read(stream, "the stream known is there")
    first.push_sample([1.0, 0.5, math.pi / 2])
    found = read(stream, "")
    assert abs(found.stamps_s[0] - pylsl.local_clock()) < 1
    assert found.angles_deg[0, WANTED] == pytest.approx([90, math.degrees(0.5)])
    assert np.isfinite(found.angles_deg).sum() == 2
    for absurd in (math.nan, math.inf, 1e9):
        first.push_sample([1.0, absurd, 0.1], 0.0)
    found = read(stream, "")
    while len(found.stamps_s) < 3:
        more = read(stream, "")
        found = Samples(*(np.concatenate(both) for both in zip(
            (found.stamps_s, found.angles_deg), (more.stamps_s, more.angles_deg), strict=True
        )), (*found.remarks, *more.remarks))  # fmt: skip
    assert np.isnan(found.angles_deg[:, WANTED[1]]).all() and np.isfinite(found.angles_deg[:, WANTED[0]]).all()
    assert f"{KNEE} is beyond 360 degrees; such angles do not count" in found.remarks
    first.push_sample([1.0, 0.5, 0.5], pylsl.local_clock() + 1000)
    assert not len(read(stream, "in the future").stamps_s)
    del first
    read(stream, "the stream known has ended")
    time.sleep(3)  # until it is forgotten
    other = outlet("known", ("confidence",), "radians")
    read(stream, "not listened to: stream known: its channels are confidence")
    del other
    time.sleep(3)
    again = outlet("known", (KNEE,), "rad")
    read(stream, f"it has no {ELBOW}")
    again.push_sample([0.5])
    assert read(stream, "").angles_deg[0, WANTED[1]] == pytest.approx(math.degrees(0.5))
    stream.close()


@pytest.mark.parametrize(
    ("name", "labels", "unit", "rate_hz", "channels", "text", "given", "message"),
    [
        ("text", (KNEE,), "deg", RATE_HZ, 0, True, None, "is text; should be numbers"),
        ("slow", (KNEE,), "deg", 1.0, 0, False, None, "1 samples a second; should be 4 to 2000"),
        ("count", (KNEE, ELBOW), "deg", RATE_HZ, 5, False, None, "5 channels, of which 2 are described"),
        ("unit", (KNEE,), "", RATE_HZ, 0, False, None, "the unit of right_knee_flexion is ''; should be degrees or"),
        ("none", (), "", RATE_HZ, 3, False, "deg", "its channels are not labelled; should be"),
        ("twice", (KNEE, KNEE), "deg", RATE_HZ, 0, False, None, "each once"),
    ],
)
def test_a_stream_that_cannot_be_one_of_angles_is_refused(
    name: str, labels: tuple[str, ...], unit: str, rate_hz: float, channels: int, text: bool, given: Unit | None,
    message: str,
) -> None:  # fmt: skip
    stream = AngleStream(name, given, WANTED, 4)
    made = outlet(name, labels, unit, rate_hz, channels, text)
    with pytest.raises(SelectionError, match=message):
        read(stream, "never said")
    del made


@pytest.fixture(scope="module")
def server(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    options = [str(PAPER), "--condition", "multiple_novice", "--cache", str(cache_folder)]
    with Server(tmp_path_factory.mktemp("recognise") / "shift.fatplan", options, rehearsal=False) as running:
        yield running


@pytest.fixture(scope="module")
def file(paper: Experiment, reactions: tuple[Reaction, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recogniser of the paper's man as five people who differ by the tracker's errors."""
    people = [
        replace(reaction, name=reaction.name._replace(worker=f"person_{number}"))
        for reaction in reactions
        for number in range(5)
    ]
    capture = CaptureError()
    recogniser, _ = train(measured(people, paper.cycle, capture), paper.cycle, 0.75)
    path = tmp_path_factory.mktemp("recogniser") / "recogniser.json"
    StoredRecogniser.of(recogniser, paper.name, {}, capture, 0.75).publish(path)
    return path


class Worker(threading.Thread):
    """Shows a reaction to a tracker, with its errors, from now on until told to stop."""

    def __init__(self, reaction: Reaction, tracker: pylsl.StreamOutlet) -> None:
        super().__init__(daemon=True)
        table = np.degrees(reaction.angles_rad())
        self._times_s, self._angles_deg = table.index.to_numpy(), table.to_numpy()
        self._tracker, self._over = tracker, threading.Event()
        self.start()

    def run(self) -> None:
        began_s, rng = pylsl.local_clock(), np.random.default_rng(0)
        while not self._over.wait(1 / RATE_HZ):
            tick = int(np.searchsorted(self._times_s, pylsl.local_clock() - began_s))
            angles = self._angles_deg[min(tick, len(self._angles_deg) - 1)] + 3 * rng.standard_normal(39)
            angles[rng.integers(39)] = rng.choice([math.nan, math.inf, 1e300])
            self._tracker.push_sample(angles)

    def end(self) -> None:
        self._over.set()
        self.join()


def test_a_shift_with_a_tracker_that_vanishes_and_comes_again(
    server: Server, file: Path, reactions: tuple[Reaction, ...]
) -> None:
    """Two cycles of five seconds, cut short by the robot: each is told late, as what it was."""
    of = {str(reaction.name).removeprefix("average_man/"): reaction for reaction in reactions}
    words = ("live", "recognise", file, "--stream", "mocap", "--server", server.address.url, "--out", "growing")
    growing = pylsl.ContinuousResolver("name", "growing")
    with (
        closing(Connection(server.address)) as robot,
        process(*words, "--token-file", server.address.token_file) as client,
    ):
        doing = robot.decide()
        robot.call("executed", cycle=doing.cycle, action=doing.action)
        tracker = outlet("mocap", DEGREES_OF_FREEDOM, "degrees")
        assert tracker.wait_for_consumers(WAIT_S)
        until(lambda: bool(growing.results()))
        known = pylsl.StreamInlet(growing.results()[0])
        known.open_stream(WAIT_S)
        for shown in ("back", "arm"):
            doing = robot.decide(doing.cycle + 1)
            time.sleep(0.3)  # until the robot is there
            robot.call("executed", cycle=doing.cycle, action=doing.action)
            time.sleep(0.1)
            worker = Worker(of[f"{doing.action}/{shown}"], tracker)
            told = {"cycle": 0}
            while told["cycle"] < doing.cycle or told["seconds"] < 4:
                values, _ = known.pull_sample(WAIT_S)
                assert values
                told = json.loads(values[0])
            assert (told["cycle"], told["action"]) == (doing.cycle, doing.action)
            assert told["likelihood"][shown] > 0.5  # a busy machine may see the beginning late
            worker.end()
            if shown == "back":
                del worker, tracker
                time.sleep(3)  # until it is forgotten
                tracker = outlet("mocap", DEGREES_OF_FREEDOM, "degrees")
                assert tracker.wait_for_consumers(WAIT_S)
            robot.decide(doing.cycle + 1)

            def seen(cycle: int = doing.cycle) -> list[Observed]:
                events = [one.event for one in read_journal(server.journal)]
                return [one for one in events if isinstance(one, Observed) and one.cycle == cycle and one.late]

            until(lambda: bool(seen()))
            assert (seen()[0].likelihood or {})[shown] > 0.5
        client.send_signal(signal.SIGINT)
        assert client.wait(WAIT_S) == 130
        assert client.stderr is not None
        said = client.stderr.read()
        client.kill()
    assert "the stream mocap has ended" in said and "beyond 360 degrees" in said
    assert "Traceback" not in said


def test_a_file_that_is_no_recogniser_is_refused(tmp_path: Path) -> None:
    broken = tmp_path / "broken.json"
    broken.write_text("{}")
    words = ("live", "recognise", broken, "--stream", "none", "--token-file", tmp_path / "none")
    assert "is not what was written" in refused(2, *words)

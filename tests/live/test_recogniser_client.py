"""When a recogniser beside a shift says what: scripted states of the face, samples of a tracker, and a clock."""

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_clients import Recorder

from fatigue_planner.core.errors import FaceRefusedError, FaceUnreachableError, SelectionError
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.live.clients.connection import Address, Answer
from fatigue_planner.live.clients.recogniser import WAIT_S, RecogniserClient, Samples, Tracker
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.recordings.recognition.recogniser import Recogniser, train
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, Repetitions

CYCLE = Cycle()
RATE_HZ = 10
JOINTS = 5
# By how many degrees the first two joints are turned, from the middle of the reach on.
SHIFTS = {"arm": 0.0, "back": 40.0}
STATE = {
    "planned_s": CYCLE.duration_s, "preferences": ["arm", "back"], "worker": "w", "advised": True, "robot": "unknown",
    "executed": None,
}  # fmt: skip


def shown(reaction: str, action: str, times_s: np.ndarray) -> np.ndarray:
    """The angles (T, 39) of a reaction, without errors; to `high` they are mirrored."""
    found = np.full((len(times_s), len(DEGREES_OF_FREEDOM)), 10.0)
    sign = 1 if action == "low" else -1
    found[:, :2] += sign * SHIFTS[reaction] * np.clip((times_s - 2) / 3, 0, 1)[:, None]
    return found


@pytest.fixture(scope="module")
def recogniser() -> Recogniser:
    rng = np.random.default_rng(0)
    instants = np.linspace(0, CYCLE.duration_s, N_PARTS)
    angles, labels = [], []
    for person in range(4):
        offset = 5 * rng.standard_normal(JOINTS)
        for action in ("low", "high"):
            for reaction in SHIFTS:
                for _ in range(5):
                    clean = shown(reaction, action, instants)[:, :JOINTS]
                    angles.append(clean + offset + 3 * rng.standard_normal(clean.shape))
                    labels.append((f"p{person}", action, reaction))
    people, actions, preferences = np.array(labels).T
    return train(Repetitions(people, actions, preferences, np.array(angles)), CYCLE, 0.75)[0]


class Scripted(Tracker):
    """A tracker that has measured what the test says."""

    def __init__(self) -> None:
        self.samples: deque[Samples] = deque()

    def read(self) -> Samples:
        return self.samples.popleft() if self.samples else Samples.none()

    def close(self) -> None:
        pass


@dataclass
class Cell:
    """The client with everything around it; `at_s` is what the clock shows."""

    client: RecogniserClient
    tracker: Scripted
    recorder: Recorder
    published: list[dict[str, Any]]
    messages: list[str]
    state: dict[str, Any] = field(default_factory=lambda: dict(STATE))
    at_s: float = 100.0

    def look(self, cycle: int, action: str = "low", **news: Any) -> None:
        self.state |= news
        self.client.state = self.state
        self.client.look(cycle, action)

    def measure(self, cycle: int, reaction: str, seconds: float, action: str = "low", begun_s: float = 0.0) -> None:
        """Somebody shows a reaction for so long, of which `begun_s` have passed."""
        until = self.at_s + seconds
        began_s = self.at_s - begun_s
        while self.at_s < until - 1e-9:
            self.at_s += 1 / RATE_HZ
            stamps = np.array([self.at_s])
            self.tracker.samples.append(Samples(stamps, shown(reaction, action, stamps - began_s)))
            self.look(cycle, action)

    def joined(self) -> None:
        """The client comes, and the cycle after the first begins."""
        self.look(1)
        self.look(2)

    @property
    def said(self) -> list[tuple[str, dict[str, Any]]]:
        return self.recorder.said

    def last(self) -> dict[str, float]:
        assert self.said
        return self.said[-1][1]["likelihood"]


@pytest.fixture
def cell(recogniser: Recogniser, tmp_path: Path) -> Cell:
    tracker, recorder = Scripted(), Recorder()
    published: list[dict[str, Any]] = []
    messages: list[str] = []
    client = RecogniserClient(
        Address("http://127.0.0.1:1", tmp_path), recogniser, tracker, lambda: made.at_s, published.append,
        messages.append,
    )  # fmt: skip
    client.connection = recorder  # type: ignore[assignment]
    made = Cell(client, tracker, recorder, published, messages)
    return made


def test_a_cycle_is_said_at_its_end_and_published_as_it_grows(cell: Cell) -> None:
    cell.joined()
    cell.measure(2, "back", CYCLE.duration_s - 0.2)
    assert cell.said == []
    assert [one["seconds"] for one in cell.published[:3]] == [0.5, 1.0, 1.5]
    early, later = (cell.published[part]["likelihood"]["back"] for part in (2, 9))
    assert early < 0.6 and later > 0.95
    cell.measure(2, "back", 0.4, begun_s=CYCLE.duration_s - 0.2)
    assert [(name, told["cycle"]) for name, told in cell.said] == [("observe", 2)]
    assert cell.last()["back"] > 0.95 and sum(cell.last().values()) == pytest.approx(1)
    cell.look(3)
    cell.measure(3, "arm", CYCLE.duration_s + 0.1)
    assert cell.said[-1][1]["cycle"] == 3 and cell.last()["arm"] > 0.95 and len(cell.said) == 2


def test_a_cycle_begins_when_the_robot_says_so_and_may_be_cut_short(cell: Cell) -> None:
    cell.look(1, robot="answers", executed="low")
    cell.look(2, executed=None)
    cell.measure(2, "arm", 3)  # the robot is not there yet
    cell.look(2, executed="low")
    cell.measure(2, "back", 6)
    cell.at_s += 0.05
    cell.look(3, executed=None)
    assert cell.said == []  # what was measured before may still come
    cell.at_s += WAIT_S
    cell.look(3)
    assert [told["cycle"] for _, told in cell.said] == [2] and cell.last()["back"] > 0.95


def test_what_the_robot_does_decides_what_is_expected(cell: Cell) -> None:
    cell.look(1, robot="answers", executed="low")
    cell.look(2, executed=None)
    cell.look(2, executed="high")
    cell.measure(2, "back", CYCLE.duration_s + 0.1, action="high")
    assert cell.last()["back"] > 0.95
    assert cell.published[-1]["action"] == "high"


def test_a_cycle_whose_beginning_was_not_seen_is_ended_but_not_judged(cell: Cell) -> None:
    cell.look(1)
    cell.measure(1, "back", CYCLE.duration_s + 0.1, begun_s=9)
    assert cell.said == [("observe", {"cycle": 1})] and not cell.published
    cell.look(2)
    cell.measure(2, "back", CYCLE.duration_s + 0.1)
    assert cell.said[-1][1]["cycle"] == 2 and cell.last()["back"] > 0.95


def test_where_a_robot_ends_cycles_what_was_not_seen_is_not_said(cell: Cell) -> None:
    cell.look(1, robot="answers", executed="low")
    cell.measure(1, "back", CYCLE.duration_s + 2)
    cell.look(2)
    cell.at_s += WAIT_S
    cell.look(2)
    assert cell.said == []


def test_of_a_worker_who_wants_no_belief_only_the_end_of_the_cycle_is_said(cell: Cell) -> None:
    cell.state["advised"] = False
    cell.joined()
    cell.measure(2, "back", CYCLE.duration_s + 0.1)
    assert cell.said == [("observe", {"cycle": 2})] and not cell.published


def test_a_tracker_that_vanishes(cell: Cell) -> None:
    cell.joined()
    cell.measure(2, "back", 7)
    cell.at_s += CYCLE.duration_s - 7
    cell.look(2)
    assert cell.said == []
    cell.at_s += WAIT_S + 0.01
    cell.look(2)
    assert cell.last()["back"] > 0.95
    # nobody is seen: the cycle does not end until somebody was there for as long
    cell.look(3)
    cell.at_s += 100
    cell.look(3)
    cell.look(3)
    assert len(cell.said) == 1
    cell.measure(3, "back", CYCLE.duration_s + 0.2)
    assert cell.said[1:] == [("observe", {"cycle": 3})]
    assert any("nothing was measured of its beginning" in one for one in cell.messages)


def test_gaps_and_numbers_that_are_none(cell: Cell) -> None:
    cell.joined()
    began_s = cell.at_s
    times = np.arange(0, CYCLE.duration_s + 0.2, 0.1)
    angles = shown("back", "low", times)
    angles[(times > 0.95) & (times < 1.55)] = np.nan
    cell.at_s += CYCLE.duration_s + 0.1
    cell.tracker.samples.append(Samples(began_s + times, angles, ("odd", "odd")))
    cell.look(2)
    assert cell.last()["back"] == pytest.approx(0.5, abs=0.2)  # only the beginning says something
    assert cell.messages == ["odd", "cycle 2: parts were not measured; what came after the first does not count"]
    cell.look(3)
    began_s = cell.at_s
    cell.at_s += CYCLE.duration_s + 0.1
    cell.tracker.samples.append(Samples(began_s + times, np.radians(shown("back", "low", times))))
    cell.look(3)
    assert cell.said[-1] == ("observe", {"cycle": 3})
    assert "radians or nobody moved" in cell.messages[-1]


def test_what_another_worker_did_is_not_his(cell: Cell) -> None:
    cell.joined()
    cell.measure(2, "back", CYCLE.duration_s - 1)
    cell.look(2, worker="other")
    cell.measure(2, "arm", CYCLE.duration_s + 0.1)
    assert cell.said == [("observe", {"cycle": 2})]


class Away(Recorder):
    """A face that fails once in each way."""

    def __init__(self) -> None:
        super().__init__()
        self.errors: list[Exception] = [FaceUnreachableError("away"), FaceRefusedError(409, "said before")]

    def call(self, name: str, **said: Any) -> Answer | None:
        super().call(name, **said)
        if self.errors:
            raise self.errors.pop(0)
        return None


def test_what_the_face_did_not_hear_is_said_again_and_what_it_refused_is_not(cell: Cell) -> None:
    cell.recorder = Away()
    cell.client.connection = cell.recorder  # type: ignore[assignment]
    cell.joined()
    cell.measure(2, "back", CYCLE.duration_s + 0.5)
    assert [told["cycle"] for _, told in cell.said] == [2, 2]
    assert cell.messages == ["away", "refused with 409: said before"]


@pytest.mark.parametrize(
    ("actions", "state", "message"),
    [
        (("low", "middle"), {}, "the recogniser knows low, high; the shift has middle, too"),
        (("low",), {"preferences": ["arm", "back", "squat"]}, "action low: the recogniser knows arm, back; the pref"),
        (("low",), {"preferences": None}, "the preferences of the shift are"),
        (("low",), {"planned_s": 12.0}, "the recogniser's cycle lasts 16 s; the shift's 12.0 s"),
    ],
)
def test_another_task_is_refused(cell: Cell, actions: tuple[str, ...], state: dict[str, Any], message: str) -> None:
    cell.client.state = STATE
    cell.client.check(("low", "high"), ("arm", "back"))
    cell.client.state = STATE | state
    with pytest.raises(SelectionError, match=message):
        cell.client.check(actions, ())

"""A rehearsed shift: cycles and faults drawn from a seed, and at the end whether the journal says what happened."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.live.events import Input, Observed, Opened, Rested, Skipped, WorkerChanged
from fatigue_planner.live.journal_file import Stored, pseudonyms, read_journal
from fatigue_planner.live.rehearsal.cell import PSEUDONYMS, Cell, Expected
from fatigue_planner.live.rehearsal.outside_faults import swap
from fatigue_planner.live.rehearsal.registry import FAULTS
from fatigue_planner.live.rehearsal.server import Server
from fatigue_planner.live.shift import Shift
from fatigue_planner.live.state import joint_fatigue
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.pomdp.scenario import Scenario

# Two sums of the same durations, in other orders.
ROUNDING_S = 1e-6


@dataclass(frozen=True)
class FaultRow:
    """A row of a rehearsal's table: how often a fault came, what the server did, how often that was wrong."""

    fault: str
    times: int
    did: dict[str, int]
    wrong: int


@dataclass(frozen=True)
class Rehearsal:
    """What came of a rehearsal.

    seconds: of the shift, simulated. inputs: how many the journal holds; wrong_inputs: where these are not what was
    said, in words. belief_is_right: the last belief is that of a shift without faults that was told the same.
    """

    cycles: int
    seconds: float
    rows: tuple[FaultRow, ...]
    inputs: int
    wrong_inputs: tuple[str, ...]
    belief_is_right: bool

    @property
    def is_right(self) -> bool:
        """Whether the server did everything as it should."""
        return not self.wrong_inputs and self.belief_is_right and not any(row.wrong for row in self.rows)


def rehearse(
    journal: Path,
    scenario: Scenario,
    policy: PolicySettings,
    options: Sequence[str],
    cycles: int,
    rates: Mapping[str, float],
    seed: int,
    speed: float = 0.0,
    started: Callable[[str], None] = lambda _: None,
    advance: Callable[[int], None] = lambda _: None,
) -> Rehearsal:
    """Rehearse a shift of so many cycles with faults at these rates per cycle.

    options: of `fatplan live serve`, which must make the same scenario and policy. started: is told the address of the
    page; advance: how many cycles have gone by. Raises WorkerError if the server does not start,
    FaceUnreachableError, FaceRefusedError if it cannot be worked with.
    """
    rng = random_stream(seed, "rehearsal")
    reactions: dict[str, Counter[tuple[str, bool]]] = {name: Counter() for name in rates}
    with Server(journal, options) as server, ExitStack() as held:
        started(server.page)
        cell = held.enter_context(closing(Cell(server, scenario, seed, rng, speed)))
        swap(cell, PSEUDONYMS[0])
        cell.ordinary()
        possible = {name: rate for name, rate in rates.items() if FAULTS[name].is_possible(cell)}
        while cell.cycle <= cycles:
            before = cell.cycle
            cell.fault = _drawn(possible, rng.random())
            if cell.fault:
                reaction = FAULTS[cell.fault].happen(cell)
                reactions[cell.fault][reaction.did, reaction.right] += 1
            else:
                cell.ordinary()
            advance(cell.cycle - before)
        shown = cell.state()["joints"]
    events = read_journal(journal)
    told = [one.event for one in events if isinstance(one.event, Input)]
    return Rehearsal(
        cycles=cell.cycle - 1,
        seconds=cell.now_s,
        rows=tuple(_row(name, counted) for name, counted in reactions.items()),
        inputs=len(told),
        wrong_inputs=_differences(told, cell.inputs, pseudonyms(journal)),
        belief_is_right=shown == _undisturbed(scenario, policy, events, told),
    )


def _drawn(rates: Mapping[str, float], uniform: float) -> str:
    """The fault of a cycle; "" for none."""
    for name, rate in rates.items():
        if uniform < rate:
            return name
        uniform -= rate
    return ""


def _row(name: str, counted: Counter[tuple[str, bool]]) -> FaultRow:
    did: Counter[str] = Counter()
    for (what, _), times in sorted(counted.items()):
        did[what] += times
    wrong = sum(times for (_, right), times in counted.items() if not right)
    return FaultRow(name, did.total(), dict(did), wrong)


def _differences(told: Sequence[Input], expected: Sequence[Expected], names: Mapping[str, str]) -> tuple[str, ...]:
    """Where the journal's inputs are not the expected ones."""
    found = []
    for number in range(max(len(told), len(expected))):
        one = told[number] if number < len(told) else None
        other = expected[number] if number < len(expected) else None
        if one is None or other is None or not _is_same(one, other.event, names):
            during = other.fault if other is not None and other.fault else "no fault"
            found.append(f"input {number} ({during}): recorded {one!r}, said {other.event if other else None!r}")
    return tuple(found)


def _is_same(one: Input, other: Input, names: Mapping[str, str]) -> bool:
    """Whether an input is another, but for rounding of what passed."""
    if isinstance(one, WorkerChanged) and isinstance(other, WorkerChanged):
        if one.away_s is None or other.away_s is None:
            return one.away_s is other.away_s and names.get(one.worker) == other.worker
        return names.get(one.worker) == other.worker and abs(one.away_s - other.away_s) < ROUNDING_S
    if isinstance(one, Observed) and isinstance(other, Observed):
        return one.model_copy(update={"idle_s": other.idle_s}) == other and abs(one.idle_s - other.idle_s) < ROUNDING_S
    return isinstance(one, Skipped | Rested) and one == other


def _undisturbed(
    scenario: Scenario, policy: PolicySettings, events: Sequence[Stored], told: Sequence[Input]
) -> list[dict[str, object]]:
    """The joints' fatigue after a shift without faults that is told the same."""
    opened = events[0].event
    assert isinstance(opened, Opened)
    shift = Shift(scenario, policy, opened.session)
    for event in told:
        shift.take(event)
    return [vars(joint) for joint in joint_fatigue(shift.belief)]

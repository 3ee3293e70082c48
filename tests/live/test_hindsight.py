"""A shift that is over: what its journal says in order, what was believed, and what other plans would have come to."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from journals import MORNING, opening, stored
from small_problems import SEVERAL, hidden, known

from fatigue_planner.fatigue.model import Rest
from fatigue_planner.live.course import intervals, replayed
from fatigue_planner.live.events import (
    Advice,
    Closed,
    Contradicted,
    Decided,
    Event,
    Observed,
    Rested,
    Resumed,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.hindsight import SAMPLES, Hindsight, Plan, hindsight, usual_plans
from fatigue_planner.live.journal_file import Stored
from fatigue_planner.live.record import Record, record_of
from fatigue_planner.live.shift import Shift
from fatigue_planner.live.state import interval
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.pomdp.timing import Timing

CYCLE_S = 16.0
NOISY = np.array([[0.8, 0.2], [0.3, 0.7]])


def timed(scenario: Scenario) -> Scenario:
    rest = Rest(np.zeros(3), np.zeros(3), np.full(3, 0.04))
    return replace(scenario, model=replace(scenario.model, timing=Timing(CYCLE_S, rest)))


def decided(cycle: int, action: str = "a") -> Decided:
    return Decided(
        cycle=cycle, action=action, reason="r", fallback="none", prepared=True, late=False, duration_s=0.001
    )  # fmt: skip


def seen(cycle: int, executed: str = "a", observation: str | None = "x", **other: object) -> Observed:
    return Observed.model_validate({"cycle": cycle, "executed": executed, "observation": observation} | other)


def record(events: Sequence[Stored]) -> Record:
    found = record_of(events)
    assert found is not None
    return found


def in_hindsight(scenario: Scenario, events: Sequence[Event], plans: Sequence[Plan]) -> Hindsight:
    segment = record(stored(enumerate([opening(scenario), *events]))).segments[0]
    shift = Shift(scenario, policy(segment.opened.policy), segment.opened.session)
    return hindsight(replayed(segment, scenario).stretches, shift, plans)


def test_the_record_is_in_order_whatever_the_clocks_did() -> None:
    """The clock is set, the machine starts anew, a cycle is told late, a worker goes and comes."""
    scenario = timed(known(0.0, SEVERAL[:1]))
    before = stored(
        [
            (0, opening(scenario)), (0, WorkerChanged(worker="1")), (0, decided(1)), (16, seen(1)),
            (16, decided(2, "b")), (32, seen(2, "b", None)), (32, decided(3)),
        ]
    )  # fmt: skip
    after = stored(
        [
            (40, seen(2, "b", late=True)), (50, seen(3, duration_s=10, idle_s=8)), (350, Rested(seconds=300)),
            (350, WorkerChanged(worker="2")), (366, Skipped(cycle=4, duration_s=16)),
            (366, WorkerChanged(worker="1", away_s=16)), (366, Advice(on=False)),
            (382, Observed(cycle=5, executed="a", off=True)),
        ],
        wall_off_s=-3600,
    )  # fmt: skip
    restarted = stored(
        [(20, Resumed(origin="boot 2")), (36, Contradicted(cycle=5, said="")), (36, Closed())], 400 - 3600
    )
    found = record([*before, *after, *restarted])
    segment = found.segments[0]
    assert found.is_closed and [(one.at_s, one.worker) for one in segment.asides[:1]] == [(420, "1")]
    assert found.lasted_s == 436.0 and found.began == MORNING.replace(hour=5)
    worked = segment.worked()
    assert [(one.cycle, one.worker, one.ended_s, one.told_late) for one in worked] == [
        (1, "1", 16, False), (2, "1", 32, True), (3, "1", 50, False), (4, "2", 366, False), (5, "1", 382, False),
    ]  # fmt: skip
    assert worked[1].end == seen(2, "b") and worked[1].decided == decided(2, "b") and worked[4].decided is None
    assert [(one.worker, one.ended_s, one.seconds, one.kind) for one in segment.pauses(16.0)] == [
        ("1", 40, 8, "clock"), ("1", 350, 300, "said"), ("1", 366, 16, "away"),
    ]  # fmt: skip
    assert segment.switches() == [(366, "1", False)]
    assert record_of([]) is None


def test_a_pause_ends_where_the_cycle_after_it_began() -> None:
    """Also where nobody said how long that cycle took: as long as planned."""
    found = record(stored([(0, opening(timed(known(0.0, SEVERAL[:1])))), (100, seen(1, idle_s=84))])).segments[0]
    assert [(one.ended_s, one.seconds, one.kind) for one in found.pauses(16.0)] == [(84, 84, "clock")]


def shift_of(scenario: Scenario, seed: int, cycles: int = 40) -> list[Event]:
    """Reactions seen well, badly and not at all; pauses, other durations, another worker, off for a while."""
    rng = np.random.default_rng(seed)
    events: list[Event] = []
    for cycle in range(1, cycles + 1):
        kind = rng.integers(5)
        what: dict[str, object] = {}
        if kind < 2:
            what = {"observation": str(rng.choice(["x", "y"]))}
        elif kind == 2:
            what = {"observation": None, "likelihood": {"x": 0.9, "y": 0.4}}
        elif kind == 3:
            what = {"observation": None}
        else:
            what = {"duration_s": float(rng.integers(8, 30)), "idle_s": 20.0}
        events.append(seen(cycle, str(rng.choice(["a", "b"])), **({"observation": "x"} | what)))
        if cycle == 10:
            events.append(Rested(seconds=30))
        if cycle == 20:
            events += [WorkerChanged(worker="2"), WorkerChanged(worker="", away_s=100.0)]
        if cycle == 25:
            events.append(Advice(on=False))
        if cycle == 26:
            events[-1] = Observed(cycle=26, executed="b", off=True)
            events.append(Advice(on=True))
    return events


@pytest.mark.parametrize("expertise", [0.0, 30.0])
def test_the_replay_ends_where_the_shift_did(expertise: float) -> None:
    """Also if a cycle became known late, which is in its place then."""
    scenario = timed(known(expertise, SEVERAL))
    events = shift_of(scenario, 1)
    late = next(one for one in events if isinstance(one, Observed) and one.is_blind and one.cycle > 30)
    told = late.model_copy(update={"observation": "y", "late": True})
    events.insert(events.index(late) + 2, told)
    segment = record(stored(enumerate([opening(scenario), *events]))).segments[0]
    shift = Shift(scenario, policy(segment.opened.policy), segment.opened.session)
    for event in events:
        shift.take(event)  # type: ignore[arg-type]
    found = replayed(segment, scenario)
    assert found.digest == shift.digest()
    assert [stretch.worker for stretch in found.stretches] == ["", "2", ""]
    assert {one.cycle for one in found.believed} == {*range(1, 41)} - {26}
    last = found.believed[-1]
    fatigue = shift.belief.states[:, :3]
    np.testing.assert_allclose(last.mean, shift.belief.weights @ fatigue)
    assert [interval(fatigue[:, entry], shift.belief.weights) for entry in range(3)] == list(
        zip(last.low, last.high, strict=True)
    )


def test_intervals_of_many_are_those_of_each() -> None:
    rng = np.random.default_rng(0)
    values, weights = rng.random((50, 4)), rng.dirichlet(np.ones(50))
    low, high = intervals(values, weights)
    assert [interval(values[:, column], weights) for column in range(4)] == list(zip(low, high, strict=True))


@pytest.mark.parametrize(
    "scenario", [known(0.0, SEVERAL), known(30.0, SEVERAL, NOISY), known(np.inf, SEVERAL[:1]), hidden()]
)
def test_what_was_done_comes_to_itself(scenario: Scenario) -> None:
    """Every worker drawn reacts as he did if the robot does what it did."""
    scenario = timed(scenario)
    events = [one for one in shift_of(scenario, 2) if not isinstance(one, Advice)]
    events = [one for one in events if not (isinstance(one, Observed) and one.off)]
    done = tuple(scenario.model.actions.index(one.executed) for one in events if isinstance(one, Observed))
    cycles = [one.cycle for one in events if isinstance(one, Observed)]
    actions = tuple(done[cycles.index(cycle)] if cycle in cycles else 0 for cycle in range(1, 41))
    other = tuple(1 - action for action in actions)
    found = in_hindsight(scenario, events, [Plan("same", actions), Plan("other", other)])
    assert found.cycles == len(cycles)
    np.testing.assert_array_equal(found.others["same"], found.followed)
    assert found.saving("same") == (0.0, 0.0, 0.0)
    assert (found.others["other"] != found.followed).all()


def test_a_novice_would_have_reacted_as_he_did() -> None:
    """All is seen, the start is known: costs of both plans are sums written out."""
    scenario = timed(known(0.0, SEVERAL[:1]))
    reactions, actions = [0, 1, 1, 0, 1], [0, 0, 1, 0, 1]
    events = [
        seen(cycle, "ab"[action], "xy"[reaction])
        for cycle, (action, reaction) in enumerate(zip(actions, reactions, strict=True), 1)
    ]
    found = in_hindsight(scenario, events, [Plan("schedule", (1, 0))])
    for costs, plan in ((found.followed, actions), (found.others["schedule"], [1, 0, 1, 0, 1])):
        fatigue, total = SEVERAL[0], 0.0
        for action, reaction in zip(plan, reactions, strict=True):
            fatigue = scenario.model.profiles[action][reaction].cycle_map().apply(fatigue)
            total += float(np.mean(fatigue**2))
        np.testing.assert_allclose(costs, np.full(SAMPLES, total), rtol=1e-12)


def test_an_expert_chooses_what_costs_least() -> None:
    """Under another plan he chooses anew, after pauses and a cycle of half the time as he was."""
    scenario = timed(known(np.inf, SEVERAL[:1]))
    events = [seen(1), Rested(seconds=20), seen(2, idle_s=5.0), seen(3, duration_s=8.0), seen(4)]
    found = in_hindsight(scenario, events, [Plan("b", (1,))])
    model = scenario.model
    half = model.for_workers(model.workers, 0.5)
    state, total = model.state(SEVERAL[0]), 0.0
    for event in events:
        if isinstance(event, Rested):
            state = model.rested(state[None], event.seconds)[0]
            continue
        state = model.rested(state[None], event.idle_s)[0]
        costs = [-model.transition(state, 1, reaction)[1] for reaction in (0, 1)]
        state, reward = (half if event.cycle == 3 else model).transition(state, 1, int(np.argmin(costs)))
        total -= reward
    np.testing.assert_allclose(found.others["b"], np.full(SAMPLES, total), rtol=1e-12)


def test_unseen_reactions_are_drawn_by_bayes_rule() -> None:
    """Of one cycle: the mean cost over the workers drawn is that of the posterior."""
    scenario = timed(known(30.0, SEVERAL[2:]))
    event = seen(1, observation=None, likelihood={"x": 0.9, "y": 0.3})
    found = in_hindsight(scenario, [event], [])
    model, state = scenario.model, scenario.states[0]
    chances = model.probabilities(state, 0) * [0.9, 0.3]
    costs = np.array([-model.transition(state, 0, reaction)[1] for reaction in (0, 1)])
    share = (found.followed == costs[0]).mean()
    assert set(np.round(found.followed, 12)) <= set(np.round(costs, 12))
    assert abs(share - chances[0] / chances.sum()) < 4 * 0.5 / np.sqrt(SAMPLES)


def test_the_usual_plans_are_chosen_before_the_shift() -> None:
    plans = {plan.name: plan.actions for plan in usual_plans(timed(known(0.0, SEVERAL)), "prior")}
    assert len(plans["the best fixed action"]) == 1 and set(plans["the best schedule"]) <= {0, 1}
    free = known(0.0, SEVERAL)
    assert usual_plans(replace(free, model=replace(free.model, discount=1.0)), "prior") == []

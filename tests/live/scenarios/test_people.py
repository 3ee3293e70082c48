"""Workers who take turns, and situations and settings that change."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from planting import fails_with
from shifts import CYCLE_S, FakeClock, World, cycles, standing

import fatigue_planner as fp
from fatigue_planner.core.errors import OtherSituationError, SelectionError
from fatigue_planner.live import opening
from fatigue_planner.live.events import Configured, Decided, Opened, Resumed
from fatigue_planner.live.rules import DEFAULT_POLICY

SESSION = "fatigue_planner.live.session:Session"
GREEDY = {"kind": "periodic", "sequence": ("low", "high")}


@fails_with("fatigue_planner.live.shift:Shift._change", "belief.rest(event.away_s)", "belief.rest(0)")
def test_10_workers_take_turns(world: World) -> None:
    """Each has the belief of a shift alone in which the other's turn was a pause; a newcomer has the prior's."""
    turns = [("w-a", ["arm", "back"]), ("w-b", ["back"]), ("w-a", ["back", "arm"]), ("w-b", ["arm", "arm"])]
    with world.open() as session:
        for name, seen in turns:
            decision = session.worker(name)
            for one in seen:
                world.clock.pass_(CYCLE_S)
                decision = session.observe(decision.cycle, executed="low", observation=one)
            world.clock.pass_(60)
        digest = session.digest()
        beliefs = {"w-b": standing(session).belief}
        session.worker("w-a")
        beliefs["w-a"] = standing(session).belief
    # how long each was away before his second turn, and until now
    for name, away_s in (("w-a", (60 + CYCLE_S + 60, 60 + 2 * CYCLE_S + 60)), ("w-b", (60 + 2 * CYCLE_S + 60, 0))):
        with world.open(name, clock := FakeClock()) as alone:
            own = [seen for who, seen in turns if who == name]
            for seen, pause_s in zip(own, away_s, strict=True):
                for one in seen:
                    alone.decide()
                    clock.pass_(CYCLE_S)
                    alone.observe(alone.cycle, executed="low", observation=one)
                alone.rest(pause_s)
            mine = standing(alone).belief
            np.testing.assert_allclose(beliefs[name].states, mine.states, rtol=1e-12)
            assert np.array_equal(beliefs[name].weights, mine.weights)
    with world.open() as resumed:
        assert resumed.digest() != digest  # w-a is back
        assert np.array_equal(standing(resumed).belief.states, beliefs["w-a"].states)


@fails_with("fatigue_planner.live.opening:changes", "if old != new]", "if False]")
def test_21_it_is_started_again_with_something_else(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused, naming what has changed; accepted, a new segment begins that knows nothing of the one before."""
    with world.open(safe_action="low") as session:
        cycles(session, world.clock, ["arm", "back"])
    count = len(world.events())
    stronger = replace(world.scenario.model, arrays=world.scenario.model.arrays._replace(
        offset=0.9 * world.scenario.model.arrays.offset))  # fmt: skip
    others = {
        r"what a cycle does .* changed": replace(world.scenario, model=stronger),
        r"the worker's initial fatigue changed": replace(world.scenario, weights=np.array([0.3, 0.4, 0.3])),
    }
    for message, other in others.items():
        with pytest.raises(OtherSituationError, match=message):
            fp.Session.open(world.path, pickle.loads(pickle.dumps(other)), safe_action="low", clock=world.clock)
    with pytest.raises(OtherSituationError, match="the policy, the safe action changed"):
        world.open(policy="greedy", safe_action="high")
    with monkeypatch.context() as patch:
        patch.setattr(opening, "digest_of_package", lambda name: f"other {name}")
        with pytest.raises(OtherSituationError, match=r"the program's sources \(planners\)"):
            world.open(safe_action="low")
    assert len(world.events()) == count
    with world.open(policy="greedy", safe_action="low", accept=True) as session:
        assert session.decide().cycle == 1
    opened = world.events(Opened)
    assert [one.accepted for one in opened] == [(), ("the policy",)]
    assert opened[0].session != opened[1].session
    with world.open(policy="greedy", safe_action="low") as session:
        assert session.cycle == 1
    assert len(world.events(Resumed)) == 1


@fails_with(f"{SESSION}.configure", "cycle=self._shift.cycle + 1", "cycle=self._shift.cycle")
def test_22_settings_change_in_mid_shift(world: World) -> None:
    """Checked before, journalled, valid from the next cycle; a restart goes on with them."""
    with world.open() as session:
        cycles(session, world.clock, ["arm"])
        pending = session.decide()
        for wrong in ({}, {"deadline_s": -1}, {"deadline_s": True}, {"unseen_limit": 0}, {"policy": "random"},
                      {"policy": DEFAULT_POLICY | {"knows": "average"}}, {"deadline_s": 1e-7}):  # fmt: skip
            with pytest.raises(SelectionError):
                session.configure(**wrong)  # type: ignore[arg-type]
        assert world.events(Configured) == []
        told = session.configure(deadline_s=9.0, policy=GREEDY)
        assert (told.cycle, told.action, told.reason) == (2, pending.action, pending.reason)
        session.rest(1)
        again = session.decide()
        assert (again.action, again.reason) == (pending.action, pending.reason)
        reasons = []
        for _ in range(2):
            world.clock.pass_(CYCLE_S)
            reasons.append(session.observe(session.cycle, observation="arm").reason)
        assert reasons == ["the schedule"] * 2
    assert [(one.cycle, one.deadline_s, one.unseen_limit) for one in world.events(Configured)] == [(3, 9.0, 20)]
    with world.open() as session:
        world.clock.pass_(CYCLE_S)
        assert session.observe(4, observation="arm").action == "low"
    with world.open(deadline_s=2.0) as session:
        assert session.decide().reason == "the schedule"
    assert world.events(Configured)[-1].deadline_s == 2.0
    assert world.events(Decided)[-1].cycle == 5


@pytest.mark.parametrize("name", ["w-1", "ä", "w 3"])
def test_pseudonyms_are_texts(world: World, name: str) -> None:
    with world.open() as session:
        session.worker(name)
        with pytest.raises(SelectionError):
            session.worker("\ud800")
    assert len(world.events()) == 4

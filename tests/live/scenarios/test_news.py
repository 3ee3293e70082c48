"""What is seen of a worker, or not; said late, twice, otherwise, of another cycle, of another action."""

from itertools import product

import numpy as np
from conftest import PAPER
from planting import fails_with
from shifts import CYCLE_S, FakeClock, World, cycles, standing

import fatigue_planner as fp
from fatigue_planner.live.events import Observed
from fatigue_planner.live.fit import MOST, WINDOW
from fatigue_planner.pomdp.beliefs.bounded import MAX_STATES

SESSION = "fatigue_planner.live.session:Session"


def enumerated(task: fp.Scenario, actions: list[str], seen: list[str | None]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and mean square of the fatigue after cycles, over every start and all reactions that may have been."""
    arrays, names = task.model.arrays, task.model.outcomes
    found = []
    for path in product(range(len(names)), repeat=len(actions)):
        if all(one is None or names[reaction] == one for one, reaction in zip(seen, path, strict=True)):
            fatigue = task.states[:, :-1].copy()
            for action, reaction in zip(actions, path, strict=True):
                row = task.model.actions.index(action) * len(names) + reaction
                fatigue = arrays.gain[row] * fatigue + arrays.offset[row]
            found.append(fatigue)  # a novice's reactions are all as likely
    return task.weights @ np.mean(found, axis=0), task.weights @ np.mean(np.square(found), axis=0)


@fails_with("fatigue_planner.live.shift:Shift.after", "self.likelihood(event), rng", "np.arange(1.0, 3.0), rng")
def test_01_the_tracker_is_silent_for_three_cycles(world: World) -> None:
    """The belief is Bayes' rule over all that may have happened; the lookahead goes on deciding."""
    seen = ["arm", None, None, None]
    with world.open() as session:
        actions = cycles(session, world.clock, seen)
        decision = session.decide()
        mean, square = enumerated(world.scenario, actions, seen)
        belief = standing(session).belief
        fatigue = belief.states[:, :-1]
        np.testing.assert_allclose(belief.weights @ fatigue, mean, rtol=1e-12)
        np.testing.assert_allclose(belief.weights @ fatigue**2, square, rtol=1e-12)
        state = session.state()
    assert (decision.fallback, state.counts.unseen, state.counts.unseen_in_a_row) == ("none", 3, 3)
    assert state.degraded


@fails_with(f"{SESSION}._decided", "standing.counts.unseen_in_a_row >= rules.unseen_limit", "False")
def test_02_the_tracker_is_silent_for_200_cycles(world: World) -> None:
    """Memory is bounded; from the limit on, which can be chosen, the schedule decides."""
    with world.open(unseen_limit=30) as session:
        fallbacks = []
        for _ in range(200):
            fallbacks.append(session.decide().fallback)
            world.clock.pass_(CYCLE_S)
            session.observe(session.cycle)
        assert fallbacks == ["none"] * 30 + ["schedule"] * 170
        assert len(standing(session).belief.weights) <= MAX_STATES
        digest = session.digest()
        world.clock.pass_(CYCLE_S)
        assert session.observe(session.cycle, observation="arm").fallback == "none"
    with world.open() as resumed:
        assert resumed.digest() != digest
        assert resumed.counts == session.counts


@fails_with(
    "fatigue_planner.live.shift:Shift._correct",
    "belief, surprised = past[first].belief",
    "belief, surprised = self.belief",
)
def test_07_an_observation_comes_after_the_next_decision(world: World) -> None:
    """It is taken in its place, as if it had come in time; what was decided in the meantime stands."""
    with world.open() as session:
        actions = cycles(session, world.clock, ["arm", "back"])
        third = session.decide()
        world.clock.pass_(CYCLE_S)
        fourth = session.decide(cycle=4)  # nothing was seen of the third
        assert session.counts.unseen == 1
        late = session.observe(3, observation="back")
        assert (late.cycle, late.action) == (4, fourth.action)
        assert session.counts.unseen == 0
        belief, digest = standing(session).belief, session.digest()
    assert [one.late for one in world.events(Observed)] == [False, False, False, True]
    with world.open("in time", clock := type(world.clock)()) as other:
        assert cycles(other, clock, ["arm", "back", "back"]) == [*actions, third.action]
        assert np.array_equal(standing(other).belief.states, belief.states)
        assert standing(other).belief.weights.tolist() == belief.weights.tolist()
    with world.open() as resumed:
        assert resumed.digest() == digest
        assert resumed.counts == session.counts


@fails_with(
    "fatigue_planner.live.shift:Shift.after",
    "belief.model.actions.index(event.executed)",
    "1 - belief.model.actions.index(event.executed)",
)
def test_09_the_robot_did_something_else_or_nothing(world: World) -> None:
    """What was done decides the belief; of nothing, only rest is left."""
    with world.open() as session:
        asked = session.decide().action
        other = next(name for name in world.scenario.model.actions if name != asked)
        world.clock.pass_(CYCLE_S)
        session.observe(1, executed=other, observation="arm")
        mean, _ = enumerated(world.scenario, [other], ["arm"])
        np.testing.assert_allclose(standing(session).belief.weights @ standing(session).belief.states[:, :-1], mean)
        assert session.counts.other_actions == 1
        before = standing(session).belief
        world.clock.pass_(9)
        assert session.skip().cycle == 3
        assert np.array_equal(standing(session).belief.states, before.rest(9).states)


@fails_with("fatigue_planner.live.fit:Fit.add", ".append(surprised)", ".append(False)")
def test_12_the_worker_does_what_nobody_knows(world: World) -> None:
    """Flat evidence, a surprise; too many of them, and the model is said not to fit this worker, and only him."""
    with world.open() as session:
        session.worker("w-a")
        actions = cycles(session, world.clock, ["unclear"] * 4)
        mean, _ = enumerated(world.scenario, actions, [None] * 4)
        np.testing.assert_allclose(standing(session).belief.weights @ standing(session).belief.states[:, :-1], mean)
        cycles(session, world.clock, ["unclear"] * (MOST - 4))
        assert (session.state().surprises, session.state().fits) == (MOST, True)
        cycles(session, world.clock, ["unclear"])
        assert (session.state().surprises, session.state().fits) == (MOST + 1, False)
        assert session.counts.surprised == MOST + 1 and session.counts.unseen == 0
        session.worker("w-b")
        assert session.state().fits
        session.worker("w-a")
        assert not session.state().fits
    with world.open() as resumed:
        assert not resumed.state().fits
        cycles(resumed, world.clock, ["arm"] * (WINDOW - MOST))
        assert resumed.state().fits


def test_a_surprise_that_is_told_late_counts(world: World) -> None:
    """As in time: what no reaction is, and what an expert would never do."""
    experiment = fp.load(PAPER)
    expert = fp.scenario(experiment, fp.simulate(experiment, world.cache), "single_expert")
    found = []
    for seen in ("unclear", "arm", "back"):
        for late in (False, True):
            name = f"{seen} {late}"
            with fp.Session.open(world.folder / name, expert, clock=FakeClock()) as session:
                session.decide()
                if late:
                    session.observe(1, executed="low")
                session.observe(1, executed="low", observation=seen)
                state = session.state()
                assert state.judged == 1 and state.surprises == session.counts.surprised
                found.append(state.surprises)
            with fp.Session.open(world.folder / name, expert, clock=FakeClock()) as resumed:
                assert resumed.state().surprises == state.surprises
    assert found[:2] == [1, 1]
    assert found[2:] in ([0, 0, 1, 1], [1, 1, 0, 0])

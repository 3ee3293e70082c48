"""A limit of fatigue is passed."""

from planting import fails_with
from shifts import CYCLE_S, World

import fatigue_planner as fp
from fatigue_planner.live.events import Acknowledged, Alarmed, Cleared

LIMIT = fp.AlarmSettings(limit=0.25, limit_source="a test", repeat_s=300)
ABOVE = "lumbar_flexion:negative"


def bend(session: fp.Session, world: World, cycles: int) -> None:
    """Cycles in which the worker bends his back; each is looked at."""
    for _ in range(cycles):
        decision = session.decide()
        world.clock.pass_(CYCLE_S)
        session.observe(decision.cycle, executed="low", observation="back")
        session.state()


@fails_with("fatigue_planner.live.watch:Alarms._is_forgotten", ">= self.settings.repeat_s", ">= 0")
def test_27_a_limit_is_passed(world: World) -> None:
    """One alarm; acknowledged, still above: silence, also after a restart; then again; a pause clears it."""
    with world.open(alarms=LIMIT) as session:
        session.decide()
        assert session.state().pauses.alarms == ()
        bend(session, world, 20)
        state = session.state().pauses
        alarms = {one.entry: one for one in state.alarms}
        assert alarms[ABOVE].probability == 1
        assert not alarms[ABOVE].acknowledged
        assert state.wanted_s == max(one.pause_s or 0 for one in alarms.values()) > 1
        assert [one.entry for one in state.work_design] == ["right_wrist_deviation:positive"]
        assert not {one.entry for one in state.work_design} & set(alarms)
        session.acknowledge()
        session.acknowledge()
        bend(session, world, 10)
        assert all(one.acknowledged for one in session.state().pauses.alarms)
    with world.open(alarms=LIMIT) as session:
        assert {one.entry: one.acknowledged for one in session.state().pauses.alarms} == dict.fromkeys(alarms, True)
        bend(session, world, 10)  # 320 s after it was acknowledged
        state = session.state().pauses
        assert {one.entry: one.acknowledged for one in state.alarms} == dict.fromkeys(alarms, False)
        assert state.alarms[0].since_cycle <= 21
        assert state.wanted_s is not None
        session.rest(state.wanted_s)
        state = session.state().pauses
        assert (state.alarms, state.wanted_s) == ((), 0)
        assert session.state().counts.late == 0
    told = [one for one in world.events() if isinstance(one, Alarmed | Acknowledged | Cleared)]
    of_one = [one for one in told if isinstance(one, Acknowledged) or one.entry == ABOVE]
    assert [one.kind for one in of_one] == ["alarmed", "acknowledged", "alarmed", "cleared"]
    assert [one.repeated for one in of_one if isinstance(one, Alarmed)] == [False, True]
    assert sum(isinstance(one, Alarmed) for one in told) == 2 * len(alarms)

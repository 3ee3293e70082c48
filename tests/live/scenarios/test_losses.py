"""Programs that are killed, logs that are cut, bytes that flip, disks that are full, and a program started twice."""

import os
import resource
import shutil
import sqlite3
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest
from commands import finished
from lives import lived
from planting import fails_with
from servers import SERVE
from shifts import CYCLE_S, FakeClock, World, cycles

import fatigue_planner as fp
from fatigue_planner.core.errors import CycleError, DamagedJournalError, OutputFolderError
from fatigue_planner.live.events import Observed, Recovered, Resumed
from fatigue_planner.live.journal_file import pseudonyms, read_journal
from fatigue_planner.live.recovery import recover

SEEN = ["arm", "back", None, "arm", "arm"]
# `FATPLAN_KILLS=1000 pytest -m '' tests/live/scenarios/test_losses.py -k 14` is the whole of it.
KILLS = int(os.environ.get("FATPLAN_KILLS", "40"))
# `FATPLAN_CUT_EVERY=1` cuts at every byte.
CUT_EVERY = int(os.environ.get("FATPLAN_CUT_EVERY", "97"))


@pytest.mark.slow
@fails_with("fatigue_planner.live.journal:Journal.wait", "return self._durable.wait_for(", "return True or (")
def test_14_it_is_killed_at_any_moment(world: World) -> None:
    """Nothing that was said to be durable is lost; the next life believes and decides the same."""
    found = lived(world, KILLS)
    assert found.kills == KILLS
    assert found.durable > KILLS // 2


@pytest.mark.slow
@fails_with("fatigue_planner.live.replay:time_of", "max(ago_s, 0.0)", "0.0")
def test_15_the_power_fails(world: World) -> None:
    """Whatever is left of the log, a prefix of the shift is; the time since then was rest, by the time of day."""
    copy = world.folder / "cut"
    with world.open() as session:
        cycles(session, world.clock, SEEN)
        session.decide()
        digest = session.digest()
        assert session._journal.wait(session._recorded, 30)
        for suffix in ("", "-wal"):
            shutil.copy(f"{world.path}{suffix}", f"{copy}{suffix}")
    whole, log = copy.read_bytes(), Path(f"{copy}-wal").read_bytes()
    said = [one.event for one in read_journal(world.path)]
    kept = []
    for length in [*range(max(0, len(log) - 65_536), len(log), CUT_EVERY), len(log)]:
        Path(f"{copy}-shm").unlink(missing_ok=True)
        copy.write_bytes(whole)
        Path(f"{copy}-wal").write_bytes(log[:length])
        try:
            events = [one.event for one in read_journal(copy)]
        except OutputFolderError:  # cut before it was a journal at all
            events = []
        assert events == said[: len(events)]
        kept.append(len(events))
    assert kept == sorted(kept)
    assert kept[-1] >= len(said) - 1  # all but that it was closed
    after = FakeClock("boot 2")
    after.now_s, after.wall = 40.0, world.clock.wall + timedelta(minutes=7)
    with world.open("cut", after) as resumed:
        assert resumed.digest() == digest
        after.pass_(CYCLE_S)
        resumed.observe(6, observation="arm")
    assert world.events(Resumed, "cut")[-1].away_s == 7 * 60
    assert world.events(Observed, "cut")[-1].idle_s == 7 * 60


@fails_with("fatigue_planner.live.journal_file:intact", "digest != right", "False")
def test_16_a_byte_flips_in_the_middle(world: World) -> None:
    """Found, refused, and gone on with from a cycle before, openly."""
    digests = []
    with world.open() as session:
        session.worker("w-7f3a")
        for one in SEEN:
            cycles(session, world.clock, [one])
            session.decide()
            digests.append(session.digest())
    with closing(sqlite3.connect(world.path, isolation_level=None)) as connection:
        connection.execute("""UPDATE event SET body = replace(body, '"arm"', '"back"') WHERE body LIKE '%"cycle":4%'""")
    with pytest.raises(DamagedJournalError, match="up to cycle 3") as refusal:
        world.open()
    assert refusal.value.exit_code == 4
    for cycle in (None, 3):
        name = f"from {cycle}"
        recover(world.path, world.folder / name, cycle)
        note = world.events(Recovered, name)[-1]
        assert note.cycle == (cycle or 4)
        assert note.kept <= note.intact
        assert list(pseudonyms(world.folder / name).values()) == ["w-7f3a"]
        with world.open(name, FakeClock()) as session:
            assert session.cycle == note.cycle
            session.decide()
            assert session.digest() == digests[note.cycle - 2]
    for wrong in (0, 5):
        with pytest.raises(CycleError, match="intact up to cycle 3"):
            recover(world.path, world.folder / "wrong", wrong)


@fails_with("fatigue_planner.live.journal:Journal._deliver", "if self.fault:", "if False:")
def test_17_the_disk_is_full(world: World) -> None:
    """It goes on deciding from memory, says so, and tries nothing again; when it ends, it says what was lost."""
    session = world.open()
    cycles(session, world.clock, ["arm"])
    assert session._journal.wait(session.decide().recorded, 30)
    durable = session._journal.durable_up_to
    resource.prlimit(session._journal._process.pid, resource.RLIMIT_FSIZE, (4096, 4096))
    actions = cycles(session, world.clock, SEEN)
    session._journal.wait(10**6, 30)
    state = session.state()
    assert "disk" in state.fault or "full" in state.fault or "I/O" in state.fault
    assert state.durable_up_to == durable
    restarts = session._journal._restarts
    actions += cycles(session, world.clock, SEEN)
    assert restarts == session._journal._restarts == 0
    with pytest.raises(OutputFolderError, match=r"events could not be recorded"):
        session.close()
    with world.open("healthy", clock := FakeClock()) as other:
        assert cycles(other, clock, ["arm", *SEEN, *SEEN])[1:] == actions
    with world.open() as resumed:
        assert resumed.cycle == 2  # the cycle after the last that was recorded
    assert len(world.events(Observed)) == 1


@pytest.mark.slow
@fails_with("fatigue_planner.live.journal_file:lock", "os.getpid()", "os.getppid()")
def test_18_it_is_started_twice(world: World) -> None:
    """The second ends with exit code 2 and names the first; a lock of a program that was killed is none."""
    with world.serving() as server:
        second = finished(*SERVE, "--journal", world.path, "--cache", world.cache)
        assert second.returncode == 2
        assert f"is being written by process {server.process.pid} since 20" in second.stderr
        other = world.folder / "other.fatplan"
        port = [*SERVE[:-1], server.port]
        same_port = finished(*port, "--journal", other, "--cache", world.cache)
        assert same_port.returncode == 2
        assert f"port {server.port}: cannot be used" in same_port.stderr
        assert not other.exists()
        server.process.kill()
        server.process.wait(30)
    with fp.Session.open(world.path, world.scenario) as session:
        assert session.cycle == 1

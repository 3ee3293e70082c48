"""`fatplan live watch`: a running shift in a terminal."""

import math
import time
from contextlib import nullcontext
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import clients
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    from fatigue_planner.live.state import SessionState

REFRESH_S = 0.5
# Older news are told as old; the server sends its state once a second.
STALE_S = 5.0


def watch(
    token_file: Annotated[
        Path, typer.Option("--token-file", help="File with the token to look: JOURNAL.view-token.")
    ] = Path("shift.fatplan.view-token"),
    server: clients.Server = "http://127.0.0.1:8765",
    authority: clients.Authority = None,
) -> None:
    """Watch a shift in a terminal: the next pose, alarms, joints and what did not go as planned. Ctrl-C ends.

    A server that goes away is waited for. Where the output is no terminal, there is a line for every change.
    """
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    from fatigue_planner.live.clients.connection import Address, Watch

    address = Address(server, token_file, authority)
    address.token()
    watching, console = Watch(address), Console(highlight=False, soft_wrap=True)
    watching.start()
    number, news_s, newest, said = 0, time.monotonic(), None, ""
    with Live(console=console, auto_refresh=False) if console.is_terminal else nullcontext() as shown:
        while True:
            before = number
            number, state = watching.newest(number, REFRESH_S)
            if number > before and state is not None:
                newest, news_s = read(state), time.monotonic()
            old_s = time.monotonic() - news_s
            if shown is not None:
                shown.update(Text("\n".join(lines(newest, old_s))), refresh=True)
            elif (line := essence(newest, old_s)) != said:
                said = line
                typer.echo(f"{datetime.now():%H:%M:%S} {line}")


def read(state: dict[str, Any]) -> "SessionState | None":
    """The state in an event; None if it is none of this version."""
    from pydantic import TypeAdapter, ValidationError

    from fatigue_planner.live.state import SessionState

    try:
        return TypeAdapter(SessionState).validate_python(state)
    except ValidationError:
        return None


def essence(state: "SessionState | None", old_s: float) -> str:
    """What counts, in a line."""
    if state is None or old_s > STALE_S:
        return "no news"
    said = [f"cycle {state.cycle}: {state.action or '-'}", *troubles(state), *alarms(state)]
    return "; ".join(said)


def lines(state: "SessionState | None", old_s: float) -> list[str]:
    """All that a terminal shows."""
    if state is None:
        return [f"No news for {old_s:.0f} s."]
    counts, pauses = state.counts, state.pauses
    doses = {one.entry: f"{one.mean_s:.0f} s" for one in pauses.doses}
    shown = [f"No news for {old_s:.0f} s: what is shown is old"] if old_s > STALE_S else []
    shown += [*troubles(state), *alarms(state), "", f"Cycle {state.cycle}    next pose: {state.action or '-'}", ""]
    shown += [
        f"not seen {counts.unseen} ({counts.unseen_in_a_row} in a row)   late {counts.late}, came late "
        f"{counts.came_late}   fallback {counts.fallback}   other pose {counts.other_actions}   "
        f"last cycle ended {state.since_s:.0f} s ago",
        f"model: {'fits' if state.fits else 'does not fit'}, {surprises(state)}" if state.advised else "model: off",
        "",
        f"{'joint and direction':34}{'fatigue, 90 % interval':26}load dose, last hour",
    ]
    for one in state.joints:
        interval = f"{one.mean:.2f} ({one.low:.2f}-{one.high:.2f})"
        shown.append(f"{named(one.entry):34}{interval:26}{doses.get(one.entry, '')}")
    shown += [
        f"in {counted(one.in_cycles, 'cycle')} {named(one.entry)} passes {pauses.limit:g} with probability "
        f"{one.probability:.0%}"
        for one in pauses.coming
    ]
    shown += [f"work design: no pose keeps {named(one.entry)} below {pauses.limit:g}" for one in pauses.work_design]
    return [*shown, "", "Model estimates of fatigue that fades within minutes. No safety function."]


def alarms(state: "SessionState") -> list[str]:
    """The pause that is wanted, and why."""
    pauses = state.pauses
    if not pauses.alarms:
        return []
    wanted = "no pause helps" if pauses.wanted_s is None else f"take a pause of {math.ceil(pauses.wanted_s)} s"
    why = (f"{named(one.entry)} above {pauses.limit:g} ({one.probability:.0%})" for one in pauses.alarms)
    return [f"{wanted}: {', '.join(why)}"]


def troubles(state: "SessionState") -> list[str]:
    """What does not go as it should."""
    found = {
        "rehearsal: the worker and the time are simulated": state.rehearsal,
        "the robot does not say what it does": state.robot == "unreachable",
        f"not recorded: {state.fault}": state.fault,
        f"degraded: not seen for {counted(state.counts.unseen_in_a_row, 'cycle')}": state.degraded,
        f"fallback: {state.fallback}": state.fallback != "none",
        f"the model does not fit this worker: {surprises(state)}": not state.fits,
    }
    return [text for text, is_so in found.items() if is_so]


def surprises(state: "SessionState") -> str:
    """How well the model explains what is seen of this worker."""
    return f"{counted(state.surprises, 'surprise')} in the last {counted(state.judged, 'cycle')} that were seen"


def named(entry: str) -> str:
    """An entry in words."""
    return entry.replace("_", " ").replace(":", ", ")

"""What clients send: a strict model per call."""

from typing import Any

from pydantic import Field, ValidationError

from fatigue_planner.core.errors import EvidenceError, shortened
from fatigue_planner.core.settings import Settings

MAX_TEXT_LENGTH = 500


class Request(Settings):
    """The body of a call."""

    waited_s: float | None = Field(
        default=None,
        description="How long you waited for the answer before this one, in s by your own clock, from before you "
        "asked. Beyond the deadline it is counted.",
    )


class Decide(Request):
    """What to do in a cycle."""

    cycle: int | None = Field(
        default=None,
        description="Number of the cycle. Default: the one to decide. The one after that: nothing was seen of this.",
    )


class Observe(Request):
    """A cycle has ended; the answer is the decision for the next."""

    cycle: int = Field(description="Number of the cycle that has ended.")
    executed: str | None = Field(default=None, description="The action that the robot did. Default: the one decided.")
    observation: str | None = Field(default=None, description="The reaction that was recognised.")
    likelihood: dict[str, float] | None = Field(
        default=None,
        description="By reaction, how likely what was measured is under it, from 0 to 1. Without this and "
        "`observation` nothing was seen.",
    )
    duration_s: float | None = Field(default=None, description="Duration of the cycle in s. Default: as planned.")


class Executed(Request):
    """What the robot does in a cycle, as it says itself; the decision stands."""

    cycle: int = Field(description="Number of the cycle.")
    action: str | None = Field(default=None, description="The action that it does. Without it: it does not answer.")


class Skip(Request):
    """The worker did nothing in this cycle."""

    duration_s: float | None = Field(default=None, description="For how long, in s. Default: since the last cycle.")
    cycle: int | None = Field(default=None, description="Number of the cycle; with it, what is said again is known.")


class Rest(Request):
    """A pause before this cycle."""

    seconds: float = Field(description="Length of the pause in s.")
    key: str | None = Field(
        default=None,
        description="Names this pause and nobody, in up to 40 letters, digits and ._-; with it, what is said again is "
        "known.",
    )


class Worker(Request):
    """Another worker."""

    pseudonym: str = Field(description="The worker's pseudonym, never a name.")


class Advise(Request):
    """Whether the belief decides for this worker."""

    on: bool = Field(description="Whether the belief decides (true), or the schedule (false).")


class Acknowledge(Request):
    """Somebody has seen the alarms that are on."""


class Configure(Request):
    """Decide otherwise from the next cycle on."""

    deadline_s: float | None = Field(default=None, description="Seconds after which an answer is late.")
    unseen_limit: int | None = Field(
        default=None, description="Cycles in a row of which nothing is known, after which the schedule decides."
    )
    policy: str | dict[str, Any] | None = Field(
        default=None, description="Policy, by its kind or its settings as in an experiment file."
    )


class Note(Request):
    """A remark for the journal."""

    text: str = Field(max_length=MAX_TEXT_LENGTH, description="The remark.")


class MoveClock(Request):
    """Move on the clock of a rehearsal; in a real shift this is refused."""

    seconds: float = Field(description="What the clock shows from now on, in s since the rehearsal began.")


# By path, what is done there.
CALLS: dict[str, type[Request]] = {
    "decide": Decide, "executed": Executed, "observe": Observe, "skip": Skip, "rest": Rest, "worker": Worker,
    "advise": Advise, "acknowledge": Acknowledge, "configure": Configure, "note": Note, "clock": MoveClock,
}  # fmt: skip


def parse(kind: type[Request], body: bytes) -> Request:
    """The request in a body. Raises EvidenceError naming every field that is wrong."""
    try:
        return kind.model_validate_json(body or b"{}", strict=True)
    except ValidationError as error:
        faults = [
            f"{'.'.join(map(str, one['loc'])) or 'body'}: {one['msg']} (given: {shortened(one['input'])})"
            for one in error.errors(include_url=False, include_context=False)[:10]
        ]
        raise EvidenceError("; ".join(faults)) from error

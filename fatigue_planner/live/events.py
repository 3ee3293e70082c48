"""What happens in a shift, as the journal keeps it: a frozen model per kind, and nothing that names a person.

The inputs (`Opened`, `Observed`, `Skipped`, `Rested`, `WorkerChanged`) decide everything; replaying them gives the same
belief, bit for bit. `Decided` says what was answered; the rest is for the report.
"""

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from fatigue_planner.core.settings import Settings
from fatigue_planner.live.limits import MAX_SECONDS

FORMAT = 1
# Names are those of the experiment, notes are a person's.
MAX_NOTE_LENGTH = 500
MAX_SOURCE_LENGTH = 200

Seconds = Annotated[float, Field(ge=0, le=MAX_SECONDS)]
Cycle = Annotated[int, Field(ge=1)]
# "policy": where a search should have improved its decision.
Fallback = Literal["none", "policy", "schedule", "safe_action"]
# What a recogniser says that saw the worker do none of the reactions; where the recognition does not know it.
UNCLEAR = "unclear"
Probability = Annotated[float, Field(ge=0, le=1)]


class AlarmSettings(Settings):
    """When a pause is wanted: the limit of fatigue, where it comes from, and when an acknowledged alarm is repeated.

    The defaults are assumptions. No standard limits fatigue by Ma's law; a limit is the employer's to set.

    >>> fp.AlarmSettings(limit=0.4, limit_source="risk assessment of cell 7").repeat_s
    600.0
    """

    limit: Annotated[float, Field(gt=0, lt=1)] = 0.5
    limit_source: Annotated[str, Field(max_length=MAX_SOURCE_LENGTH)] = "an assumption: half of the strength is gone"
    repeat_s: Annotated[float, Field(ge=1, le=MAX_SECONDS)] = 600.0


class Opened(Settings):
    """A session began: with what. Everything before belongs to another situation, see `shift.Shift`.

    experiment, cache: where they lie, from the journal's folder, for the report; "" where it is not known.
    """

    kind: Literal["opened"] = "opened"
    format: int
    session: str  # random, of this journal
    scenario: str  # digest
    scenario_name: str
    actions: tuple[str, ...]
    policy: dict[str, Any]
    policy_sources: dict[str, str]
    safe_action: str
    deadline_s: float
    versions: dict[str, str]
    origin: str  # of the clock
    alarms: AlarmSettings | None = None  # None in journals that are older
    rehearsal: bool = False  # the clock was not the machine's
    unseen_limit: int = 20  # cycles in a row of which nothing is known, after which the schedule decides
    parts: dict[str, str] = Field(default_factory=dict)  # digests of the scenario's parts; none in older journals
    sources: dict[str, str] = Field(default_factory=dict)  # digests of the program's sources; none in older journals
    search: dict[str, Any] | None = None  # that improves decisions
    accepted: tuple[str, ...] = ()  # what has changed since the segment before, as somebody has confirmed
    off: tuple[str, ...] = ()  # workers who wanted no belief about them in the segments before
    experiment: str = ""
    cache: str = ""
    planned_s: float | None = None  # duration of a cycle; None in older journals


class Resumed(Settings):
    """The program started again and went on from what is before this event.

    away_s: seconds since then, by the clock; by the time of day if the machine was started anew.
    """

    kind: Literal["resumed"] = "resumed"
    origin: str  # of the clock from now on
    away_s: float = 0.0
    alarms: AlarmSettings | None = None  # from now on


class Recovered(Settings):
    """What is before this event was copied from a damaged journal, and what came after it was left out.

    intact: events that were not damaged; kept: those of them that were copied; cycle: the first that is to be done.
    """

    kind: Literal["recovered"] = "recovered"
    intact: int
    kept: int
    cycle: int


class Configured(Settings):
    """From this cycle on decisions are made so."""

    kind: Literal["config"] = "config"
    cycle: Cycle
    policy: dict[str, Any]
    policy_sources: dict[str, str]
    deadline_s: float
    unseen_limit: int


class ClockSet(Settings):
    """The time of day was set by so many seconds beyond what has passed. No duration is measured by it."""

    kind: Literal["clock"] = "clock"
    difference_s: float


class Slept(Settings):
    """The machine was suspended for so long."""

    kind: Literal["slept"] = "slept"
    seconds: float


class SearchFailed(Settings):
    """The search that improves decisions gave no answer; without it the policy decides."""

    kind: Literal["search_failed"] = "search_failed"
    why: str


class Decided(Settings):
    """What the robot was told."""

    kind: Literal["decided"] = "decided"
    cycle: Cycle
    action: str
    reason: str
    fallback: Fallback
    prepared: bool
    late: bool
    duration_s: float


class Executed(Settings):
    """What the robot does in a cycle, as it said itself; None: it does not answer."""

    kind: Literal["executed"] = "executed"
    cycle: Cycle
    action: str | None


class Observed(Settings):
    """A cycle ended. What the robot did counts (`executed`), not what it was asked.

    observation: as what the reaction was recognised; likelihood: of every reaction, by its name, where a recogniser
    gives that; neither: nothing was seen. idle_s: rest between the end of the cycle before and the beginning of this.
    late: told after the next cycle's decision, in which the cycle counted as not seen. off: the worker wants no belief
    about him, so that only what the robot did is kept.
    """

    kind: Literal["observed"] = "observed"
    cycle: Cycle
    executed: str
    observation: str | None = None
    likelihood: dict[str, float] | None = None
    duration_s: Seconds | None = None
    idle_s: Seconds = 0.0
    late: bool = False
    off: bool = False

    @property
    def is_blind(self) -> bool:
        """Whether something could have been seen, but was not."""
        return self.observation is None and self.likelihood is None and not self.off

    @property
    def is_unclear(self) -> bool:
        """Whether the worker was seen to do none of the reactions."""
        return self.observation == UNCLEAR

    def without_worker(self) -> "Observed":
        """What is kept of it where the belief is off: cycle and action."""
        return Observed(cycle=self.cycle, executed=self.executed, off=True)


class Skipped(Settings):
    """A cycle in which the worker did nothing, of so many seconds; off: see `Observed`, and how long is not kept."""

    kind: Literal["skipped"] = "skipped"
    cycle: Cycle
    duration_s: Seconds
    off: bool = False


class Rested(Settings):
    """A pause between two cycles. key: names it, so that it can be said again."""

    kind: Literal["rested"] = "rested"
    seconds: Seconds
    key: str | None = None


class WorkerChanged(Settings):
    """Another worker, by a random number that the erasable table joins to a pseudonym.

    away_s: how long a worker who was here before has been away; None for a new one, or one who wants no belief.
    """

    kind: Literal["worker_changed"] = "worker_changed"
    worker: str
    away_s: Seconds | None = None


class Advice(Settings):
    """Whether a belief is kept of this worker and decides, from the next cycle on; else the schedule does."""

    kind: Literal["advice"] = "advice"
    on: bool


class Contradicted(Settings):
    """Something else was said of a cycle that had been observed; the first stands."""

    kind: Literal["contradicted"] = "contradicted"
    cycle: Cycle
    said: str


class Noted(Settings):
    """A remark."""

    kind: Literal["noted"] = "noted"
    text: Annotated[str, Field(max_length=MAX_NOTE_LENGTH)]


class Alarmed(Settings):
    """An alarm was raised, or repeated after it had been acknowledged: an entry is above the limit, and pauses help.

    probability: that it is above. pause_s: after which it is relieved; None: no pause is long enough.
    """

    kind: Literal["alarmed"] = "alarmed"
    cycle: Cycle
    entry: str
    probability: Probability
    pause_s: float | None
    repeated: bool = False


class Acknowledged(Settings):
    """Somebody has seen these alarms."""

    kind: Literal["acknowledged"] = "acknowledged"
    entries: tuple[str, ...]


class Cleared(Settings):
    """An entry is clearly below the limit again."""

    kind: Literal["cleared"] = "cleared"
    cycle: Cycle
    entry: str


class CameLate(Settings):
    """An answer came later than the deadline to the client that had asked, by its own clock; decided late or not."""

    kind: Literal["came_late"] = "came_late"
    seconds: Seconds


class Refused(Settings):
    """Requests that may not pass, by their HTTP status, since this was told last; at most once a second."""

    kind: Literal["refused"] = "refused"
    counts: dict[str, int]


class Closed(Settings):
    """The session was closed in good order."""

    kind: Literal["closed"] = "closed"


Input = Observed | Skipped | Rested | WorkerChanged | Advice
Event = (
    Opened
    | Resumed
    | Recovered
    | Configured
    | ClockSet
    | Slept
    | SearchFailed
    | Decided
    | Executed
    | Observed
    | Skipped
    | Rested
    | WorkerChanged
    | Advice
    | Contradicted
    | Noted
    | Alarmed
    | Acknowledged
    | Cleared
    | CameLate
    | Refused
    | Closed
)
ANY_EVENT: TypeAdapter[Event] = TypeAdapter(Annotated[Event, Field(discriminator="kind")])

"""What the report of a shift is written from: the journal, replayed, and tables of it for one worker."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

import numpy as np
import pandas as pd

from fatigue_planner.core.errors import OtherSituationError
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.live.course import Replayed, replayed
from fatigue_planner.live.doses import HOUR_S, doses
from fatigue_planner.live.events import Observed, Skipped
from fatigue_planner.live.hindsight import Hindsight, hindsight, usual_plans
from fatigue_planner.live.record import Pause, Record, Segment, Worked
from fatigue_planner.live.rules import from_json
from fatigue_planner.live.shift import Shift
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.scenario import Scenario

# Entries whose fatigue stays below this are left out.
TRACE = 0.005


@dataclass(frozen=True)
class Part:
    """A segment of the journal and, where the scenario is that it was begun with, what follows from both."""

    segment: Segment
    scenario: Scenario | None

    @cached_property
    def replayed(self) -> Replayed | None:
        """What was believed."""
        return None if self.scenario is None else replayed(self.segment, self.scenario)


@dataclass(frozen=True)
class ShiftData:
    """A shift that is over, or as far as it has come. name: the journal's."""

    name: str
    record: Record
    parts: tuple[Part, ...]

    @classmethod
    def of(cls, name: str, record: Record, scenario: Scenario) -> "ShiftData":
        """The shift, whose last segment must have been begun with this scenario. Raises OtherSituationError."""
        parts = [Part(one, scenario if one.opened.scenario == scenario.digest else None) for one in record.segments]
        if parts[-1].scenario is None:
            raise OtherSituationError(
                f"{name}: was written with another scenario than the one that was found; the experiment, its reactions "
                "or the program have changed since. Give the experiment as it was with --experiment."
            )
        return cls(name, record, tuple(parts))

    @property
    def is_rehearsal(self) -> bool:
        """Whether nobody worked: the worker was a program."""
        return all(part.segment.opened.rehearsal for part in self.parts)

    @cached_property
    def worked(self) -> list[Worked]:
        """All cycles, in order."""
        return [one for part in self.parts for one in part.segment.worked()]

    @cached_property
    def pauses(self) -> list[Pause]:
        """All rests, in order."""
        return [one for part in self.parts for one in part.segment.pauses(self.planned_s(part))]

    @property
    def first_hour_s(self) -> float:
        """When the local hour began in which the journal begins, in s since that; not positive."""
        began = self.record.local(0)
        return -(60.0 * began.minute + began.second + began.microsecond / 1e6)

    def hour_of(self, at_s: float) -> int:
        """The number of the local hour of a moment."""
        return int((at_s - self.first_hour_s) // HOUR_S)

    def hour_begins(self, hour: int) -> datetime:
        """When an hour begins, in local time."""
        return self.record.local(self.first_hour_s + hour * HOUR_S)

    def planned_s(self, part: Part) -> float:
        """The planned duration of a part's cycles; where an older journal does not say it, that of the last part."""
        if part.segment.opened.planned_s is not None:
            return part.segment.opened.planned_s
        scenario = part.scenario or self.parts[-1].scenario
        assert scenario is not None and scenario.model.timing is not None
        return scenario.model.timing.cycle_s

    def worked_s(self, part: Part, one: Worked) -> float:
        """How long a cycle of a part took, or was planned to take."""
        return self.planned_s(part) if one.end.duration_s is None else one.end.duration_s

    def cycles_table(self, worker: str) -> pd.DataFrame:
        """Every cycle of a worker: when it ended, what was decided and why, what was done and seen."""
        surprised = {
            (number, one.cycle)
            for number, part in enumerate(self.parts)
            for one in (part.replayed.believed if part.replayed else [])
            if one.surprised
        }
        rows = []
        for number, part in enumerate(self.parts):
            for one in part.segment.worked():
                if one.worker != worker:
                    continue
                end, decided = one.end, one.decided
                seen = isinstance(end, Observed) and end.likelihood
                rows.append(
                    {
                        "part": number + 1, "cycle": one.cycle, "ended": stamp(self.record.local(one.ended_s)),
                        "decided": decided.action if decided else None,
                        "reason": decided.reason if decided else None,
                        "fallback": decided.fallback if decided else None,
                        "late": decided.late if decided else None,
                        "answer_ms": 1000 * decided.duration_s if decided else None,
                        "done": end.executed if isinstance(end, Observed) else None,
                        "observation": end.observation if isinstance(end, Observed) else None,
                        "likelihood": json.dumps(seen) if seen else None,
                        "duration_s": end.duration_s,
                        "seen": sight_of(end), "told_late": one.told_late,
                        "surprised": (number, one.cycle) in surprised,
                    }
                )  # fmt: skip
        return pd.DataFrame(rows)

    def fatigue_table(self, worker: str) -> pd.DataFrame:
        """What was believed of a worker's fatigue after every cycle and pause, by entry."""
        frames = []
        for number, part in enumerate(self.parts):
            mine = [one for one in part.replayed.believed if one.worker == worker] if part.replayed else []
            if not mine or part.scenario is None:
                continue
            names = [ENTRIES[entry] for entry in part.scenario.model.active_entries]
            values = {name: np.concatenate([getattr(one, name) for one in mine]) for name in ("mean", "low", "high")}
            repeated = {
                "part": number + 1,
                "cycle": np.repeat([one.cycle for one in mine], len(names)),
                "at_s": np.repeat([one.at_s for one in mine], len(names)),
                "time": np.repeat([stamp(self.record.local(one.at_s)) for one in mine], len(names)),
            }
            table = pd.DataFrame(repeated | {"entry": names * len(mine)} | values)
            frames.append(table[table["entry"].map(table.groupby("entry")["high"].max()) >= TRACE].round(6))
        columns = ["part", "cycle", "at_s", "time", "entry", "mean", "low", "high"]
        return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=columns)

    def doses_table(self, worker: str) -> pd.DataFrame:
        """Load doses of a worker by hour and entry, in s, with the standard deviation of what was not seen surely."""
        rows: dict[tuple[int, str], list[float]] = {}
        mine = [one for one in self.worked if one.worker == worker and sight_of(one.end) != "off"]
        hours = {self.hour_of(one.ended_s) for one in mine}
        for part in self.parts:
            for stretch in part.replayed.stretches if part.replayed else []:
                if stretch.worker != worker or part.scenario is None:
                    continue
                found = doses(part.scenario.model, stretch.lived(part.scenario.model, self.first_hour_s))
                for hour, (means, deviations) in enumerate(zip(found.mean_s, found.deviation_s, strict=True)):
                    for entry, mean, deviation in zip(found.entries, means, deviations, strict=True):
                        total = rows.setdefault((hour, entry), [0.0, 0.0])
                        total[0] += mean
                        total[1] += deviation**2
        return pd.DataFrame(
            [
                {
                    "hour": hour, "begins": stamp(self.hour_begins(hour)), "entry": entry,
                    "dose_s": mean, "deviation_s": variance**0.5,
                }
                for (hour, entry), (mean, variance) in sorted(rows.items(), key=lambda row: row[0][0])
                if hour in hours
            ],
            columns=["hour", "begins", "entry", "dose_s", "deviation_s"],
        )  # fmt: skip

    def worth(self, worker: str) -> list[Hindsight]:
        """By part of the shift, what the plan cost the worker, and what others would have."""
        found = []
        for part in self.parts:
            if part.scenario is None or part.replayed is None:
                continue
            own = [one for one in part.replayed.stretches if one.worker == worker]
            settings = policy(from_json(part.segment.opened.policy))
            shift = Shift(part.scenario, settings, part.segment.opened.session)
            result = hindsight(own, shift, usual_plans(part.scenario, settings.knows))
            if result.cycles and result.others:
                found.append(result)
        return found


def sight_of(end: object) -> str:
    """What was known of a cycle that has ended so."""
    if isinstance(end, Observed | Skipped) and end.off:
        return "off"
    if not isinstance(end, Observed):
        return "skipped"
    if end.is_unclear:
        return "unclear"
    return "nothing" if end.is_blind else "likelihood" if end.likelihood is not None else "recognised"


def stamp(moment: datetime) -> str:
    """A local time with its offset, to the second."""
    return moment.isoformat(sep=" ", timespec="seconds")


def offset(moment: datetime) -> str:
    """How far local time is from UTC, as `UTC+01:00`."""
    return f"UTC{moment.isoformat()[-6:]}"


def together(results: Sequence[Hindsight]) -> Hindsight | None:
    """The parts of a shift as one; None where there are none."""
    if not results:
        return None
    names = [name for name in results[0].others if all(name in one.others for one in results)]
    return Hindsight(
        sum(one.cycles for one in results),
        np.sum([one.followed for one in results], axis=0),
        {name: np.sum([one.others[name] for one in results], axis=0) for name in names},
    )

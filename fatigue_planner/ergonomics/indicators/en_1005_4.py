"""EN 1005-4:2005+A1:2008, working postures and movements at machinery: what is held, and how often one moves."""

from collections import defaultdict
from collections.abc import Sequence
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.held_posture import HeldPosture, Judged, holds, working
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Level, Origin, Phrase
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.human.skeleton import SIDES

OK, CONDITIONAL, NOT = Level.ACCEPTABLE, Level.INVESTIGATE, Level.NOT_ACCEPTABLE
# Movements per minute from which they are frequent, and from which an upper arm may not be raised by 20 to 60 degrees.
FREQUENT, VERY_FREQUENT = 2.0, 10.0


class Rule(NamedTuple):
    """What a zone is, held for more than 4 s, entered less than twice a minute, more often, and 10 times or more."""

    held: Level
    seldom: Level
    frequent: Level
    very_frequent: Level = NOT


BETWEEN = Rule(CONDITIONAL, OK, NOT)
BETWEEN_SUPPORTED = Rule(OK, OK, NOT)
BEYOND = Rule(NOT, CONDITIONAL, NOT)
ARM_BETWEEN = Rule(CONDITIONAL, OK, CONDITIONAL)
ARM_BETWEEN_SUPPORTED = Rule(OK, OK, CONDITIONAL)
SHRUGGED = Rule(NOT, NOT, NOT)


class Zone(NamedTuple):
    """Where a part of the body is in a zone, (n,), the rule on it, and what a movement enters if it is more than that.

    counted (n,): who goes through a zone and back has moved once, so entries into it and what is beyond are counted.
    """

    part: str
    side: str
    inside: NDArray[np.bool_]
    rule: Rule
    counted: NDArray[np.bool_] | None = None

    @property
    def entries(self) -> int:
        """How often the zone is entered in a cycle that is repeated: never if it is not left."""
        counted = self.inside if self.counted is None else self.counted
        return int(np.count_nonzero(counted & ~np.roll(counted, 1)))


class En10054(HeldPosture):
    """EN 1005-4: seconds per cycle in zones that are not acceptable as they are held or entered so often.

    How often is counted over the cycle: a movement is an entry into the zone; what is held and entered so often is
    judged by the worse of both, and what lasts through the whole cycle is never entered, only held. If the length of
    the cycle is not stated, the operations follow each other without a pause.
    """

    title: ClassVar[str] = "EN 1005-4"
    edition: ClassVar[str] = "EN 1005-4:2005+A1:2008; zones as in the help of DELMIA's fault monitor"
    origin: ClassVar[Origin] = Origin.RECALLED
    words: ClassVar[tuple[str, str, str]] = ("acceptable", "conditionally acceptable", "not acceptable")

    kind: Literal["en_1005_4"] = Field(default="en_1005_4", description="EN 1005-4, working postures and movements.")

    def zones(self, operation: Operation, stated: Circumstances) -> list[Zone]:
        """All zones of an operation."""
        seen = operation.posture
        trunk, arm = seen.trunk_deg, seen.arm_raised_deg
        between = BETWEEN_SUPPORTED if stated.trunk_supported else BETWEEN
        found = [
            Zone("trunk inclined", "", (trunk > 20) & (trunk <= 60), between, trunk > 20),
            Zone("trunk inclined far", "", trunk > 60, BEYOND),
            Zone("trunk leaning back", "", trunk < 0, BETWEEN_SUPPORTED if stated.trunk_supported else BEYOND),
            Zone("trunk twisted", "", np.abs(seen.trunk_twist_deg) > self.visible_deg, BEYOND),
            Zone("trunk bent sideways", "", np.abs(seen.trunk_side_deg) > self.visible_deg, BEYOND),
            Zone("head inclined", "", (seen.head_deg > 40) | (seen.head_deg < 0), BEYOND),
            Zone("neck twisted", "", np.abs(seen.neck_twist_deg) > self.head_turned_deg, BEYOND),
            Zone("neck bent sideways", "", np.abs(seen.neck_side_deg) > self.visible_deg, BEYOND),
        ]
        for index, side in enumerate(SIDES):
            raised = arm[:, index]
            works = bool(operation.works[index])
            arm_between = ARM_BETWEEN_SUPPORTED if stated.arm_supported and works else ARM_BETWEEN
            found += [
                Zone("upper arm raised", side, (raised > 20) & (raised <= 60), arm_between, raised > 20),
                Zone("upper arm raised far", side, raised > 60, BEYOND),
                Zone("upper arm behind the body", side, seen.arm_forward_deg[:, index] < -self.visible_deg, BEYOND),
                Zone("shoulder raised", side, working(operation) & works & bool(stated.shoulder_raised), SHRUGGED),
            ]
        return found

    def judged(self, job: Job, stated: Sequence[Circumstances]) -> list[list[Judged]]:
        """See HeldPosture.judged."""
        zones = [self.zones(operation, one) for operation, one in zip(job.operations, stated, strict=True)]
        entries: defaultdict[tuple[str, str], float] = defaultdict(float)
        for operation, found in zip(job.operations, zones, strict=True):
            for zone in found:
                entries[zone.part, zone.side] += zone.entries * operation.stated.times_per_cycle
        per_minute = {name: 60 * count / job.cycle_s for name, count in entries.items()}
        return [
            [Judged(zone.part, zone.side, _level(zone, per_minute[zone.part, zone.side], operation)) for zone in found]
            for operation, found in zip(job.operations, zones, strict=True)
        ]

    def remarks(self) -> tuple[Phrase, ...]:
        """See HeldPosture.remarks."""
        return (
            Phrase(
                "Twist, side bend and arms behind the body count from {visible:g}°, a turned head from {head:g}°.",
                {"visible": self.visible_deg, "head": self.head_turned_deg},
            ),
            Phrase("A movement is an entry into a zone, counted over the cycle; what is never left is only held."),
        )


def _level(zone: Zone, per_minute: float, operation: Operation) -> NDArray[np.int64]:
    moved = zone.rule.seldom
    if per_minute >= FREQUENT:
        moved = zone.rule.frequent if per_minute < VERY_FREQUENT else zone.rule.very_frequent
    level = np.where(zone.inside, int(moved), 0)
    for hold in holds(zone.inside, operation):
        level[hold] = max(zone.rule.held, moved)
    return level

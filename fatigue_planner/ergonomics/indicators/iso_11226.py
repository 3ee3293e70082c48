"""ISO 11226:2000, static working postures: what may be held, and for how long."""

from collections.abc import Sequence
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.held_posture import HELD_S, HeldPosture, Judged, holds, working
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.posture import BACKWARD_DEG, PostureCourse, runs
from fatigue_planner.ergonomics.result import Level, Origin, Phrase
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.human.joint_data import ranges_of_motion
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]


class Line(NamedTuple):
    """A part of the body that may be inclined up to an angle, and up to a larger one for a while.

    The maximum holding time falls on a straight line from `longest_s` at `free_deg` to `shortest_s` at `most_deg`.
    """

    free_deg: float
    most_deg: float
    longest_s: float
    shortest_s: float

    def holding_s(self, angle_deg: Vector) -> Vector:
        """How long angles may be held: infinite up to the free one, 0 beyond the largest."""
        share = (angle_deg - self.free_deg) / (self.most_deg - self.free_deg)
        time = self.longest_s + share * (self.shortest_s - self.longest_s)
        return np.where(angle_deg <= self.free_deg, np.inf, np.where(angle_deg > self.most_deg, 0.0, time))


# All lines end here, in s.
SHORTEST_S = 60.0
TRUNK = Line(20, 60, 240, SHORTEST_S)
HEAD = Line(25, 85, 480, SHORTEST_S)
UPPER_ARM = Line(20, 60, 180, SHORTEST_S)
# Flexion of the neck: head less trunk.
NECK_DEG = (0.0, 25.0)


class Zone(NamedTuple):
    """A rule at each instant: of which part and side it is, what is not acceptable, and how long the rest may be held.

    beyond (n,), holding_s (n,), infinite where nothing limits it.
    """

    part: str
    side: str
    beyond: Booleans
    holding_s: Vector


class ArmHold(NamedTuple):
    """The longest time for which an upper arm is above 60 degrees without a break, and how high it comes."""

    longest_s: float
    highest_deg: float

    @property
    def overhead(self) -> bool:
        """Whether the arm is held there."""
        return self.longest_s > HELD_S


def arm_hold(reaction: Reaction) -> ArmHold:
    """The hold of a reaction, at every tick: the arm that is held longest, the one that comes highest."""
    seen, ticks = PostureCourse.of(reaction.key.motion_request().worker.anthropometry(), reaction.motion), 0
    for raised_deg in seen.arm_raised_deg.T:
        first, last = runs(raised_deg > UPPER_ARM.most_deg)
        ticks = max(ticks, int((last - first).max(initial=0)))
    return ArmHold(ticks * seen.step_s, float(seen.arm_raised_deg.max()))


class Iso11226(HeldPosture):
    """ISO 11226: seconds per cycle in held postures that are not acceptable. Recovery after a hold is not judged."""

    title: ClassVar[str] = "ISO 11226"
    edition: ClassVar[str] = "ISO 11226:2000; holding times as straight lines between the printed corners"
    origin: ClassVar[Origin] = Origin.RECALLED
    words: ClassVar[tuple[str, str, str]] = ("acceptable", "acceptable for a limited time", "not acceptable")

    kind: Literal["iso_11226"] = Field(default="iso_11226", description="ISO 11226:2000, static working postures.")
    extreme_share: float = Field(
        default=0.75,
        gt=0,
        le=1,
        description="From which fraction of its range on a wrist or forearm is in an extreme position; the standard "
        "gives no number.",
    )
    bent_knee_deg: float = Field(
        default=30,
        gt=0,
        lt=90,
        description="From where on a standing worker's knee counts as bent, in degrees; the standard gives no number.",
    )

    def zones(self, operation: Operation, stated: Circumstances) -> list[Zone]:
        """All rules of an operation."""
        seen = operation.posture
        free = np.full(len(seen.time_s), np.inf)
        trunk_s = free if stated.trunk_supported else TRUNK.holding_s(seen.trunk_deg)
        head_s = free if stated.trunk_supported else HEAD.holding_s(seen.head_deg)
        neck = seen.head_deg - seen.trunk_deg
        found = [
            Zone("trunk inclined", "", seen.trunk_deg > TRUNK.most_deg, trunk_s),
            Zone("trunk leaning back", "", (seen.trunk_deg < 0) & (not stated.trunk_supported), free),
            Zone("trunk twisted", "", np.abs(seen.trunk_twist_deg) > self.visible_deg, free),
            Zone("trunk bent sideways", "", np.abs(seen.trunk_side_deg) > self.visible_deg, free),
            Zone("head inclined", "", seen.head_deg > HEAD.most_deg, head_s),
            Zone("head leaning back", "", (seen.head_deg < 0) & (not stated.head_supported), free),
            Zone("neck flexed", "", neck > NECK_DEG[1], free),
            Zone("neck extended", "", (neck < NECK_DEG[0] - BACKWARD_DEG) & (not stated.head_supported), free),
            Zone("neck twisted", "", np.abs(seen.neck_twist_deg) > self.head_turned_deg, free),
            Zone("neck bent sideways", "", np.abs(seen.neck_side_deg) > self.visible_deg, free),
        ]
        for index, side in enumerate(SIDES):
            raised, wrist = seen.arm_raised_deg[:, index], seen.wrist_deg[:, index]
            arm_s = free if stated.arm_supported and operation.works[index] else UPPER_ARM.holding_s(raised)
            shoulder = np.full(len(free), bool(stated.shoulder_raised) and bool(operation.works[index]))
            found += [
                Zone("upper arm raised", side, raised > UPPER_ARM.most_deg, arm_s),
                Zone("upper arm behind the body", side, seen.arm_forward_deg[:, index] < -self.visible_deg, free),
                Zone("upper arm across the body", side, seen.arm_abducted_deg[:, index] < -self.visible_deg, free),
                Zone("shoulder raised", side, shoulder & working(operation), free),
                Zone("forearm turned", side, self._extreme("forearm_pronation", seen.pronation_deg[:, index]), free),
                Zone("wrist bent", side, self._extreme("wrist_flexion", wrist), free),
                Zone("wrist deviated", side, self._extreme("wrist_deviation", seen.deviation_deg[:, index]), free),
                Zone("knee bent", side, seen.knee_deg[:, index] > self.bent_knee_deg, free),
            ]
        return found

    def _extreme(self, name: str, angle_deg: Vector) -> Booleans:
        allowed = ranges_of_motion()[name]
        return np.asarray(
            (angle_deg > self.extreme_share * allowed.max) | (angle_deg < self.extreme_share * allowed.min)
        )

    def judged(self, job: Job, stated: Sequence[Circumstances]) -> list[list[Judged]]:
        """See HeldPosture.judged."""
        return [
            [Judged(zone.part, zone.side, held(zone, operation)) for zone in self.zones(operation, circumstances)]
            for operation, circumstances in zip(job.operations, stated, strict=True)
        ]

    def remarks(self) -> tuple[Phrase, ...]:
        """See HeldPosture.remarks."""
        return (
            Phrase("A posture is held if it lasts for more than {held:g} s.", {"held": HELD_S}),
            Phrase(
                "Twist, side bend and arms behind or across the body count from {visible:g}°, a turned head from "
                "{head:g}°, wrist and forearm from {extreme:g} % of their range, knees from {knee:g}°: the standard "
                "gives no numbers.",
                {
                    "visible": self.visible_deg,
                    "head": self.head_turned_deg,
                    "extreme": 100 * self.extreme_share,
                    "knee": self.bent_knee_deg,
                },
            ),
            Phrase("Recovery between holds is not judged."),
        )


def held(zone: Zone, operation: Operation) -> Integers:
    """The level of a zone at every instant, (n,): see `holds`.

    Where the angle changes during a hold, each instant uses up its share of the holding time at its angle (assumed; of
    an angle that stays it is the standard's rule), beyond the largest angle that of the shortest time. A hold that
    uses up more than all is not acceptable.
    """
    level = np.zeros(len(zone.beyond), dtype=np.int64)
    for hold in holds(np.isfinite(zone.holding_s), operation):
        used = float((operation.posture.step_s / np.maximum(zone.holding_s[hold], SHORTEST_S)).sum())
        level[hold] = Level.NOT_ACCEPTABLE if used > 1 else Level.INVESTIGATE
    for hold in holds(zone.beyond, operation):
        level[hold] = Level.NOT_ACCEPTABLE
    return level

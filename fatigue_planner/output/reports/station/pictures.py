"""Pictures of postures as small SVG: the worker from the right, the place of the hand, the robot, and a scale."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.posture import PostureCourse
from fatigue_planner.human.model import Human, build_human
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.settings import Side
from fatigue_planner.output.figures.postures import CAPSULES, SIDE, landmarks
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.robot.shape import RobotShape
from fatigue_planner.station.assessment import Doing, Judged, StationAssessment
from fatigue_planner.station.judging import stated
from fatigue_planner.station.outcomes import Task, tasks_of
from fatigue_planner.station.robot_reach import StationRobot

Vector = NDArray[np.float64]

_BODY, _WORKING, _FAR = "#c3ccd5", "#5b7083", "#dfe4e9"
_PLACE, _ROBOT = "#0b5394", "#8b7a63"
# A letter of the scale is so high, in cm of the picture; a picture 150 cm wide is 160 px wide on a phone.
_LETTER_CM = 11
_HEAD = 0.06


@dataclass(frozen=True)
class Posture:
    """A posture of a motion: who does what, at which instant, what is seen of the whole motion, and of the robot."""

    judged: Judged
    reaction: Reaction
    hands: tuple[Side, ...]
    target_m: tuple[Vector, ...]
    tick: int
    time_s: float
    seen: PostureCourse
    robot: RobotShape | None = None

    @property
    def angles_deg(self) -> tuple[float, float]:
        """Trunk and the higher working upper arm against the vertical."""
        row = int(np.abs(self.seen.time_s - self.time_s).argmin())
        sides = [SIDES.index(side) for side in self.hands]
        return float(self.seen.trunk_deg[row]), float(self.seen.arm_raised_deg[row, sides].max())


def worst_moment(judged: Judged) -> float | None:
    """When the rule with the most seconds that are not acceptable finds it worst, in s; None if no rule says so."""
    by = sorted(judged.by, key=lambda rule: -(rule.not_acceptable_s or 0.0))
    moments = (judged.judgements[rule.kind].worst for rule in by)
    return next((moment.time_s for moment in moments if moment is not None), None)


def postures_of(
    assessment: StationAssessment, doings: Sequence[Doing], cache: ReactionCache, command: str
) -> dict[Doing, Posture]:
    """The postures of some motions that may be used, each where it is worst, or else in the middle of the work.

    Raises what `ReactionCache.stream` raises.
    """
    judged = {each.doing: each for each in assessment.judged}
    tasks = [task for task in tasks_of(assessment.station) if task.doing in set(doings)]
    stored = cache.stream([task.request for task in tasks], command)
    station = assessment.station
    robot = None if station.robot is None else StationRobot(station, station.robot)
    return {
        task.doing: _posture(assessment, task, reaction, judged[task.doing], robot)
        for task, reaction in zip(tasks, stored, strict=True)
        if isinstance(reaction, Reaction)
    }


def _posture(
    assessment: StationAssessment, task: Task, reaction: Reaction, judged: Judged, robot: StationRobot | None
) -> Posture:
    motion = reaction.motion
    moment = worst_moment(judged)
    tick = (
        motion.middle("work") if moment is None else min(round(moment / motion.time_step_s), len(motion.torque_nm) - 1)
    )
    name = task.doing.operation
    seen = Operation(name, task.request.motion, motion, stated(assessment.station, name)).posture
    goals = task.request.motion.action.goals().values()
    return Posture(
        judged,
        reaction,
        task.hands,
        tuple(goal.path()[0].position_m.vector() for goal in goals),
        tick,
        tick * motion.time_step_s,
        seen,
        None if robot is None else robot.shape(task),
    )


def figure_of(posture: Posture, wording: Wording, title: str) -> Markup:
    """A posture with its caption: where, who, the level in words, by which rule first, and the angles."""
    doing, judged = posture.judged.doing, posture.judged
    who = wording.say("{worker} at {place}", worker=wording.worker(doing.worker), place=wording.name(doing.place))
    trunk, arm = posture.angles_deg
    text = "At {time:.0f} s: trunk {trunk:.0f}°, upper arm {arm:.0f}° from the vertical."
    angles = wording.say(text, time=posture.time_s, trunk=trunk, arm=arm)
    first = sorted(judged.by, key=lambda rule: -(rule.not_acceptable_s or 0.0))[:1]
    rules = wording.say("by {rules}", rules=wording.catalogue.term(first[0].title)) if first else ""
    words = wording.say("Side view: {who}. {angles}", who=who, angles=angles)
    caption = "<figure>{}<figcaption><b>{}:</b> {}: {} {}. {}</figcaption></figure>"
    light = wording.marked(wording.light(judged.level))
    return Markup(caption).format(drawing(posture, words), title, who, light, rules, angles).replace(" . ", ". ")


def drawing(posture: Posture, words: str) -> Markup:
    """The SVG of a posture; `words` say what it shows."""
    worker = posture.reaction.key.motion_request().worker
    human = build_human(worker)
    points = landmarks(human, posture.reaction.motion.configuration[posture.tick])
    parts = [*_robot(posture.robot), *_body(human, points, posture.hands)]
    drawn = [*points.values(), *posture.target_m]
    if posture.robot is not None:
        drawn += list(posture.robot.parts(0)[0].reshape(-1, 3))
    flat = np.array([_flat(point) for point in drawn])
    left, right = min(flat[:, 0].min() - 22, -75.0), max(flat[:, 0].max() + 18, 75.0)
    top = min(flat[:, 1].min() - 16, -205.0)
    scale = "".join(
        f'<path d="M{left + 1:.0f} {-height:.0f}h7" stroke="#555"/>'
        f'<text x="{left + 10:.0f}" y="{-height + 4:.0f}" font-size="{_LETTER_CM}" fill="#444">{height // 100} m</text>'
        for height in (100, 200)
    )
    ground = f'<path d="M{left:.0f} 0H{right:.0f}" stroke="#555" stroke-width="1.5"/>'
    marks = "".join(
        f'<path d="M{x - 5:.1f} {y - 5:.1f}h10v10h-10z" fill="none" stroke="{_PLACE}" stroke-width="2.5"/>'
        for x, y in map(_flat, posture.target_m)
    )
    box = f"{left:.0f} {top:.0f} {right - left:.0f} {5 - top:.0f}"
    svg = f'<svg role="img" aria-label="{escape(words)}" viewBox="{box}">{scale}{ground}{"".join(parts)}{marks}</svg>'
    return Markup(svg)


def _flat(point: Vector) -> tuple[float, float]:
    """A point of the world in the picture, in cm, y downwards."""
    return 100 * float(point @ SIDE.across), -100 * float(point[2])


def _robot(robot: RobotShape | None) -> list[str]:
    """The robot as lines with round ends, behind the body, far ones first."""
    if robot is None:
        return []
    ends, radii = robot.parts(0)
    drawn = []
    for i in np.argsort(ends.sum(axis=1) @ SIDE.towards):
        (x, y), (to_x, to_y) = map(_flat, ends[i])
        path = f'd="M{x:.1f} {y:.1f}L{to_x:.1f} {to_y + 0.01:.2f}" stroke-linecap="round"'
        drawn.append(f'<path {path} stroke="#fff" stroke-width="{200 * radii[i] + 1.6:.1f}"/>')
        drawn.append(f'<path {path} stroke="{_ROBOT}" stroke-width="{200 * radii[i]:.1f}"/>')
    return drawn


def _body(human: Human, points: dict[str, Vector], working: Sequence[str]) -> list[str]:
    """The parts of the body as lines with round ends, far ones first, the working arms last and darkest."""
    stature = human.anthropometry.stature_m

    def place(part: tuple[str, str, float]) -> tuple[bool, float]:
        return _is_working(part, working), float((points[part[0]] + points[part[1]]) @ SIDE.towards)

    drawn = []
    for start, end, radius in sorted([*CAPSULES, ("head_centre", "head_centre", _HEAD)], key=place):
        (x, y), (to_x, to_y) = _flat(points[start]), _flat(points[end])
        far = start.startswith("left") and end.startswith("left")
        colour = _WORKING if _is_working((start, end, radius), working) else _FAR if far else _BODY
        width = 200 * radius * stature
        path = f'd="M{x:.1f} {y:.1f}L{to_x:.1f} {to_y + 0.01:.2f}" stroke-linecap="round"'
        drawn.append(f'<path {path} stroke="#fff" stroke-width="{width + 1.6:.1f}"/>')
        drawn.append(f'<path {path} stroke="{colour}" stroke-width="{width:.1f}"/>')
    return drawn


def _is_working(part: tuple[str, str, float], working: Sequence[str]) -> bool:
    return part[0].endswith(("upper_arm", "forearm", "hand")) and any(
        part[0].startswith(side) and part[1].startswith(side) for side in working
    )

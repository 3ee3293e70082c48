"""What a station's page says of its robot: every place, margins and clearance, and where else it could stand."""

from collections.abc import Iterator

from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.output.reports.page import Points, Table, Text
from fatigue_planner.output.reports.station.blocks import AnyBlock, table
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station import statements
from fatigue_planner.station.assessment import RobotFinding, RobotPlace, StationAssessment


def robot_blocks(assessment: StationAssessment, robot: RobotFinding, wording: Wording) -> Iterator[AnyBlock]:
    """Sentences, a table of all places, and a table of other places of the base."""
    say, settings = wording.say, assessment.station.robot
    assert settings is not None
    base = settings.base_m
    yield Text(
        say(
            "{arm}, its base {x:g} m ahead, {y:g} m to the {side} and {z:g} m high, holds {mass:g} kg {distance:g} m "
            "before its flange.",
            arm=robot.arm, x=base.x, y=abs(base.y), side=wording.catalogue.term(base.side), z=base.z,
            mass=settings.hold.mass_kg, distance=settings.hold.distance_m,
        )
    )  # fmt: skip
    if robot.payload_kg is None:
        yield Text(say("What the arm carries is not known: its file does not say it."))
    else:
        yield Text(say("It carries up to {payload:g} kg.", payload=robot.payload_kg))
    yield Points([wording.sentence(each) for each in statements.of_robot(assessment.station, robot)])
    yield table(
        wording,
        "What the robot makes of every place: the nearest that its arm comes to any worker in any way, over the whole "
        "cycle, the working hands left out. Manipulability is 0 where the arm cannot move in some direction.",
        ["Operation", "Place", "Result", "From a joint's limit, degrees", "Manipulability", "Nearest, cm", "Where"],
        [_row(each, wording) for each in robot.places],
    )
    yield _scan(robot, wording)
    yield Text(wording.sentence(Phrase(statements.NOT_FOR_SAFETY)))


def _row(each: RobotPlace, wording: Wording) -> list[str]:
    """A place: presented or why not, the margins, and where the arm is nearest to whom."""
    term, near = wording.catalogue.term, each.meeting
    result = f"✕ {term(each.reason)}" if each.reason else wording.say("presented")
    if each.left_out is not None and not each.reason:
        result = f"✕ {wording.say('too near to a worker')}"
    where = "–" if near is None else wording.say(
        "{part} of {worker}, {way}, at {time:.1f} s",
        part=term(near.part), worker=wording.worker(near.worker), way=term(near.way), time=near.time_s,
    )  # fmt: skip
    return [
        wording.name(each.operation),
        wording.name(each.place),
        result,
        "–" if each.reason else f"{wording.number(each.joint_margin_deg)} ({each.tightest})",
        "–" if each.reason else wording.number(each.manipulability, 2),
        "–" if near is None else wording.number(100 * near.distance_m),
        where,
    ]


def _scan(robot: RobotFinding, wording: Wording) -> Table:
    """How many places are reached, by height and distance of the base."""
    forward = sorted({each.x_m for each in robot.scan})
    reached = {(each.x_m, each.height_m): each.reached for each in robot.scan}
    heights = sorted({each.height_m for each in robot.scan}, reverse=True)
    rows = [
        [wording.number(100 * height), *(wording.number(reached[x, height]) for x in forward)] for height in heights
    ]
    header = [wording.say("Height of the base, cm")]
    header += [wording.say("{ahead:.0f} cm ahead", ahead=100 * x) for x in forward]
    caption = "How many of {count} places the robot reaches from elsewhere; how near it comes is not looked at."
    return Table(wording.say(caption, count=len({each.place for each in robot.places})), header, rows)

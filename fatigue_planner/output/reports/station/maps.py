"""Maps of places as SVG: each point with its level, the rule that decides, fatigue, a score, and who or what cannot."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from markupsafe import Markup, escape

from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.experiment.pose_grid import AXES
from fatigue_planner.output.reports.station.blocks import Map
from fatigue_planner.output.reports.station.wording import SIGNS, Wording
from fatigue_planner.station.assessment import PlaceSummary, StationAssessment
from fatigue_planner.station.robot_reach import ruled_out

# Fill and ink of a point by its level, as the page's `look.css` has them.
INKS = {
    Level.ACCEPTABLE: ("#e7f5ec", "#0b5d2a"), Level.INVESTIGATE: ("#fff4d6", "#6b4700"),
    Level.NOT_ACCEPTABLE: ("#fdeaec", "#8d0f1c"), None: ("#f3f3f3", "#444444"),
}  # fmt: skip
CANNOT, RECOMMENDED, NO_ROBOT = "✕", "★", "⊘"
# The indicator whose score is written into every point.
SCORE = "rula"
# Width and height of a point, of a line of letters, and the room for the numbers on both axes, in px.
_WIDE, _HIGH, _LINE, _LEFT, _BELOW, _ABOVE = 46, 60, 13, 44, 34, 18
# What is drawn across a point that is not acceptable, so that colour alone does not say so: lines so far apart, in px.
_HATCH, _HATCH_INK = 11, "#efc3c8"
LEFT_OUT = "left out for all: out of reach, too weak, implausible, or beyond a limit"
AXIS_NAMES = {"x": "ahead, cm", "y": "to the left, cm", "z": "height, cm"}
LAYERS = {
    "x": "{operation} at {map}, {value:.0f} cm ahead", "y": "{operation} at {map}, {value:.0f} cm to the left",
    "z": "{operation} at {map}, {value:.0f} cm high",
}  # fmt: skip


def maps(assessment: StationAssessment, wording: Wording) -> Iterator[Map]:
    """A picture of every map of every operation; of places in a room, one of every layer."""
    places = assessment.station.places

    def name_of(each: PlaceSummary) -> tuple[str, str]:
        return each.operation, places[each.place].map or ""

    for (operation, name), group in groupby(sorted(assessment.summaries, key=name_of), name_of):
        if name:
            found = list(group)
            across, up, layer = axes_of(assessment, found)
            for depth in sorted({getattr(places[each.place], layer) for each in found}):
                own = [each for each in found if getattr(places[each.place], layer) == depth]
                names = {"operation": wording.name(operation), "map": wording.name(name)}
                title = wording.say(LAYERS[layer], **names, value=100 * depth)
                yield _map(assessment, wording, title, own, (across, up))


def axes_of(assessment: StationAssessment, found: Sequence[PlaceSummary]) -> tuple[str, str, str]:
    """Which coordinate goes to the right, which upwards, and which parts layers: that with the fewest values."""
    at = [assessment.station.places[each.place] for each in found]
    counts = {axis: len({getattr(place, axis) for place in at}) for axis in AXES}
    layer = min(("y", "x", "z"), key=counts.__getitem__)
    across, up = {"y": ("x", "z"), "x": ("y", "z"), "z": ("y", "x")}[layer]
    return across, up, layer


def _map(
    assessment: StationAssessment, wording: Wording, title: str, own: Sequence[PlaceSummary], axes: tuple[str, str]
) -> Map:
    """One picture with the words that explain it."""
    at = {each.place: assessment.station.places[each.place] for each in own}
    columns, rows = (sorted({getattr(place, axis) for place in at.values()}) for axis in axes)
    if axes[0] == "y":
        columns = columns[::-1]  # what is to the left is at the left
    rules = list(dict.fromkeys(filter(None, map(_decides, own))))
    without_robot = ruled_out(assessment.robot.places if assessment.robot else ())
    out = {each.place: why for each in own if (why := without_robot.get((each.operation, each.place)))}
    drawn = [
        _point(assessment, wording, each, rules, out.get(each.place),
               _LEFT + _WIDE * columns.index(getattr(at[each.place], axes[0])),
               _ABOVE + _HIGH * (len(rows) - 1 - rows.index(getattr(at[each.place], axes[1]))))
        for each in own
    ]  # fmt: skip
    width, height = _LEFT + _WIDE * len(columns) + 4, _ABOVE + _HIGH * len(rows) + _BELOW
    words = _in_words(wording, title, own, len(out))
    svg = Markup('<svg role="img" aria-label="{}" width="{}" height="{}" viewBox="0 0 {} {}">{}{}</svg>').format(
        words, width, height, width, height, _scales(wording, columns, rows, axes), Markup("").join(drawn)
    )
    return Map(words, svg, list(_legend(assessment, wording, own, rules, bool(out))))


def _in_words(wording: Wording, title: str, own: Sequence[PlaceSummary], without_robot: int) -> str:
    """What the picture shows, for who does not see it: how many places of every level."""
    counts = [(wording.catalogue.term(level.words), sum(each.level == level for each in own)) for level in Level]
    counts.append((wording.say("left out for all"), sum(each.level is None for each in own)))
    counts.append((wording.say("left out because of the robot"), without_robot))
    levels = ", ".join(f"{count} {words}" for words, count in counts if count)
    return wording.say("Map: {title}. {count} places: {levels}.", title=title, count=len(own), levels=levels)


def _decides(each: PlaceSummary) -> str:
    """The rule with the most seconds that are not acceptable."""
    return max(each.by, key=lambda rule: rule.not_acceptable_s or 0.0).title if each.by else ""


def _point(
    assessment: StationAssessment,
    wording: Wording,
    each: PlaceSummary,
    rules: Sequence[str],
    out: Phrase | None,
    x: int,
    y: int,
) -> Markup:
    fill, ink = INKS[each.level]
    sign = CANNOT if each.level is None else SIGNS[each.level]
    decides = _decides(each)
    lines = [f"{sign} {rules.index(decides) + 1}" if decides else sign]
    if each.peak is not None:
        lines.append(wording.percent(each.peak))
    if (score := score_of(assessment, each)) is not None:
        lines.append(f"R {wording.number(score)}")
    if each.missed_by and each.reached_by:
        lines.append(f"{CANNOT} {len(each.missed_by)}")
    best = assessment.best.places.get(each.operation) == each.place
    if best:
        lines[0] = f"{RECOMMENDED} {lines[0]}"
    if out is not None:
        lines[0] = f"{NO_ROBOT} {lines[0]}"
    hatch = "".join(_hatch(x, y)) if each.level == Level.NOT_ACCEPTABLE else ""
    letters = "".join(
        f'<text x="{x + _WIDE / 2:g}" y="{y + (number + 1) * _LINE:g}" text-anchor="middle" font-size="12" '
        f'fill="{ink}"{" font-weight=" + chr(34) + "bold" + chr(34) if number == 0 else ""}>{escape(line)}</text>'
        for number, line in enumerate(lines)
    )
    dashes = ' stroke-dasharray="4 3"' if each.missed_by else ""
    frame = (
        f'<rect x="{x + 1.5}" y="{y + 1.5}" width="{_WIDE - 3}" height="{_HIGH - 3}" fill="none" stroke="{ink}" '
        f'stroke-width="{3 if best else 1}"{dashes}/>'
    )
    ground = f'<rect x="{x + 1}" y="{y + 1}" width="{_WIDE - 2}" height="{_HIGH - 2}" fill="{fill}"/>'
    return Markup(
        f"<g><title>{escape(_told(assessment, wording, each, out))}</title>{ground}{hatch}{frame}{letters}</g>"
    )


def _hatch(x: int, y: int) -> Iterator[str]:
    wide, high = _WIDE - 3, _HIGH - 3
    lines = "".join(
        f"M{x + 1.5 + max(0, d - high):g} {y + 1.5 + min(d, high):g}L{x + 1.5 + min(d, wide):g} "
        f"{y + 1.5 + max(0, d - wide):g}"
        for d in range(_HATCH, wide + high, _HATCH)
    )
    yield f'<path d="{lines}" stroke="{_HATCH_INK}" fill="none"/>'


def _told(assessment: StationAssessment, wording: Wording, each: PlaceSummary, out: Phrase | None) -> str:
    """A point in words, as the table of all places has it."""
    parts = [wording.name(each.place), wording.light(each.level, wording.say("left out for all"))[2:]]
    parts.append(wording.rules(each.by, assessment.station.cycle.duration_s))
    if each.missed_by:
        parts.append(wording.say("cannot: {workers}", workers=wording.workers(each.missed_by)))
    if out is not None:
        parts.append(wording.sentence(out))
    return "; ".join(filter(None, parts))


def score_of(assessment: StationAssessment, each: PlaceSummary) -> float | None:
    """The score that is certain, of the worker for whom it is worst in the way that is best there."""
    here = {
        place.outcome.doing for place in assessment.places
        if (place.operation, place.place) == (each.operation, each.place) and place.way is not None
    }  # fmt: skip
    found = [judged.judgements.get(SCORE) for judged in assessment.judged if judged.doing in here]
    return max((one.value.low for one in found if one is not None and one.value is not None), default=None)


def _scales(wording: Wording, columns: Sequence[float], rows: Sequence[float], axes: tuple[str, str]) -> Markup:
    """The numbers on both axes, in cm, and what they are."""

    def letters(x: float, y: float, anchor: str, text: str) -> str:
        return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="12" fill="#333">{escape(text)}</text>'

    below, middle = _ABOVE + _HIGH * len(rows) + 14, _HIGH / 2 + 4
    drawn = [letters(2, 12, "start", wording.say(AXIS_NAMES[axes[1]]))]
    drawn += [
        letters(_LEFT - 6, _ABOVE + _HIGH * (len(rows) - 1 - i) + middle, "end", wording.number(100 * value))
        for i, value in enumerate(rows)
    ]
    drawn += [
        letters(_LEFT + _WIDE * (i + 0.5), below, "middle", wording.number(100 * value))
        for i, value in enumerate(columns)
    ]
    drawn.append(letters(2, below + 15, "start", wording.say(AXIS_NAMES[axes[0]])))
    return Markup("".join(drawn))


def _legend(
    assessment: StationAssessment,
    wording: Wording,
    own: Sequence[PlaceSummary],
    rules: Sequence[str],
    has_left_out: bool,
) -> Iterator[str]:
    """What the signs mean that the map has, and the rules by their numbers."""
    levels = [f"{SIGNS[level]} {wording.catalogue.term(level.words)}" for level in Level]
    yield ", ".join([*levels, f"{CANNOT} {wording.say(LEFT_OUT)}"])
    if any(each.missed_by and each.reached_by for each in own):
        yield wording.say(
            "Dashed frame, {sign} and a number: so many workers cannot work there; the rest is said of the others.",
            sign=CANNOT,
        )
    if rules:
        numbers = ", ".join(f"{i} {wording.catalogue.term(title)}" for i, title in enumerate(rules, start=1))
        yield wording.say("Number beside a sign: the rule that decides: {numbers}.", numbers=numbers)
    yield wording.say("Per cent: the highest fatigue; R: the RULA score of the worst of the workers.")
    if has_left_out:
        yield wording.say("{sign}: left out, as the robot cannot present it or comes too near.", sign=NO_ROBOT)
    if any(assessment.best.places.get(each.operation) == each.place for each in own):
        yield wording.say("{sign}: recommended.", sign=RECOMMENDED)

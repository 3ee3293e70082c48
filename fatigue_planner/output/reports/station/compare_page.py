"""Two assessments of a station side by side, as a page and as lines of text."""

from collections.abc import Iterator, Sequence

from fatigue_planner.output.reports.page import Table, Text
from fatigue_planner.output.reports.station.blocks import Group, Groups, Part, table
from fatigue_planner.output.reports.station.compare import BETTER, WORSE, Row, StationComparison
from fatigue_planner.output.reports.station.page import render
from fatigue_planner.output.reports.station.stored import StoredAssessment


def parts_of(found: StationComparison) -> list[Part]:
    """What got better and worse, then all rows, then what was changed."""
    say = found.wording.say
    return [
        Part(say("In short"), [Groups([Group(title, items) for title, items in _short(found)])]),
        Part(
            say("Places"),
            [_table(found, "Every place, for the worst of the workers.", ["Operation", "Place"], found.places)],
        ),
        Part(say("Who can do what"), [_cannot(found)]),
        Part(
            say("Who of the population can"),
            [_table(found, "Shares of the population.", ["Operation", "Place", "Sex"], found.shares)],
        ),
        Part(say("The cycle as a whole"), [_table(found, "The cycle of every worker.", ["Worker"], found.cycles)]),
        Part(say("What was changed"), [_settings(found)]),
    ]


def _short(found: StationComparison) -> Iterator[tuple[str, list[str]]]:
    say = found.wording.say
    for verdict, title in ((BETTER, say("What got better")), (WORSE, say("What got worse"))):
        mine = [each for each in found.rows if each.verdict == verdict]
        items = [f"{', '.join(each.what)}: {_plain(each.before)} → {_plain(each.after)}" for each in mine]
        yield title, items or [say("Nothing.")]
    old, new = (_recommended(found, each) for each in (found.before, found.after))
    yield say("Recommended"), [f"{say('Before')}: {old}", f"{say('After')}: {new}"]


def _plain(text: str) -> str:
    """Words without the sign before them."""
    return text[2:] if text[1:2] == " " else text


def _recommended(found: StationComparison, assessment: StoredAssessment) -> str:
    places = assessment.best.places
    if not places:
        return found.wording.say("No cycle is recommended.")
    return ", ".join(f"{found.wording.name(key)} – {found.wording.name(place)}" for key, place in places.items())


def _table(found: StationComparison, caption: str, what: Sequence[str], rows: Sequence[Row]) -> Table:
    say = found.wording.say
    content = [[*each.what, each.before, each.after, say(each.verdict)] for each in rows]
    return table(found.wording, caption, [*what, "Before", "After", "Verdict"], content)


def _cannot(found: StationComparison) -> Table | Text:
    if not found.cannot:
        return Text(found.wording.say("Every worker reaches every place."))
    caption = "Who cannot before or after: why, or the level."
    return _table(found, caption, ["Worker", "Operation", "Place"], found.cannot)


def _settings(found: StationComparison) -> Table | Text:
    if not found.settings:
        return Text(found.wording.say("The stations are the same."))
    rows = [[f"`{name}`", *values] for name, values in found.settings.items()]
    return table(found.wording, "Keys of the station file that differ.", ["Key", "Before", "After"], rows)


def comparison_page(found: StationComparison) -> str:
    """The comparison as a page."""
    wording, (before, after) = found.wording, (found.before, found.after)
    text = "Workstation {name}: before and after"
    title = wording.say(text, name=wording.name(str(after.station.get("name", ""))))
    footer = wording.say(
        "Station files {before} (before) and {after} (after); fatplan {old} and {new}.",
        before=f"`{before.station_digest[:16]}`", after=f"`{after.station_digest[:16]}`",
        old=before.version, new=after.version,
    )  # fmt: skip
    better, worse = (sum(each.verdict == which for each in found.rows) for which in (BETTER, WORSE))
    verdict = wording.say("{better} better, {worse} worse.", better=better, worse=worse)
    return render(wording, title, footer, ("", verdict), parts_of(found), [])


def comparison_text(found: StationComparison) -> str:
    """The comparison as lines of text."""
    lines = []
    for title, items in _short(found):
        lines += [f"{title}:", *(f"  {item}" for item in items)]
    return "\n".join(lines) + "\n"

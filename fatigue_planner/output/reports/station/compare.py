"""Two assessments of a station side by side: what got better and what got worse, in the words of its page."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from fatigue_planner.ergonomics.result import Level, ShownSeconds
from fatigue_planner.output.reports.results.compare import differences, flat
from fatigue_planner.output.reports.station.catalogue import Catalogue
from fatigue_planner.output.reports.station.details import why_left_out
from fatigue_planner.output.reports.station.stored import (
    StoredAssessment,
    StoredCycle,
    StoredPlace,
    StoredPlaceForWorker,
    StoredShare,
)
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station.recommendation import nearness
from fatigue_planner.station.statements import joint_name

# Fatigue that differs by less than half of the last digit that is shown is the same.
SAME_PEAK = 0.005
BETTER, SAME, WORSE, ONLY = "better", "the same", "worse", "in one of them only"
# The words for before and for after: who is called the same may be another worker.
Both = tuple[Wording, Wording]
Key = TypeVar("Key")
Found = TypeVar("Found")
# Beyond any level: a place that nobody reaches, or a cycle that a worker cannot do.
_NOBODY = max(Level) + 1


class Row(NamedTuple):
    """Something before and after: what it is, in words, and whether it got better."""

    what: tuple[str, ...]
    before: str
    after: str
    verdict: str


@dataclass(frozen=True)
class StationComparison:
    """Two assessments side by side, and the settings that differ.

    places       a row for every (operation, place)
    cannot       for every (worker, operation, place) where the worker cannot work before or after
    shares       for every (operation, place, sex): who of the population can
    cycles       for the whole cycle of every (worker)
    """

    before: StoredAssessment
    after: StoredAssessment
    wording: Wording
    places: tuple[Row, ...]
    cannot: tuple[Row, ...]
    shares: tuple[Row, ...]
    cycles: tuple[Row, ...]
    settings: dict[str, tuple[str, str]]

    @property
    def rows(self) -> tuple[Row, ...]:
        """All of them."""
        return (*self.places, *self.cannot, *self.shares, *self.cycles)


def compare_stations(before: StoredAssessment, after: StoredAssessment, texts: Catalogue) -> StationComparison:
    """What tells two assessments apart. Workers and places are the same if their names are."""
    names = list(dict.fromkeys(each.name for each in (*before.workers, *after.workers)))
    both = (Wording(texts, before.workers), Wording(texts, after.workers))
    labels = {name: _label(name, before, after, *both) for name in names}
    places = _pairs(before.summaries, after.summaries, lambda each: (each.operation, each.place))
    was, now = ({each.worker: each for each in found.cycles} for found in (before, after))
    return StationComparison(
        before,
        after,
        both[1],
        tuple(_place_row(both, *pair) for pair in places),
        tuple(_cannot_rows(both, labels, before, after)),
        tuple(_share_rows(both, before, after)),
        tuple(_cycle_row(both, labels[name], was.get(name), now.get(name)) for name in names),
        differences(*(flat(_settings_of(found, labels)) for found in (before, after))),
    )


def _label(name: str, before: StoredAssessment, after: StoredAssessment, old: Wording, new: Wording) -> str:
    """What a worker is called: as before and as after, where the worker of this name is another one now."""
    found = [
        wording.worker(name)
        for wording, assessment in ((old, before), (new, after))
        if name in {each.name for each in assessment.workers}
    ]
    return " → ".join(dict.fromkeys(found))


def _settings_of(found: StoredAssessment, labels: Mapping[str, str]) -> dict[str, Any]:
    """What decides of a station file; workers are called as on the page."""
    settings = {key: value for key, value in found.station.items() if key not in ("name", "about")}
    return settings | {"workers": {labels[name]: each for name, each in settings.get("workers", {}).items()}}


def _pairs(
    before: Sequence[Found], after: Sequence[Found], key: Callable[[Found], Key]
) -> Iterator[tuple[Key, Found | None, Found | None]]:
    """What is called the same, before and after; None where it is not there."""
    old, new = ({key(each): each for each in found} for found in (before, after))
    for name in dict.fromkeys([*old, *new]):
        yield name, old.get(name), new.get(name)


def _words(
    both: Both, said: Callable[[Wording, Found | None], str], before: Found | None, after: Found | None
) -> list[str]:
    """Something before and after, each in its own words."""
    return [said(wording, each) for wording, each in zip(both, (before, after), strict=True)]


def _place_row(both: Both, key: tuple[str, str], before: StoredPlace | None, after: StoredPlace | None) -> Row:
    words = _words(both, _place_words, before, after)
    return Row(tuple(map(both[1].name, key)), words[0], words[1], _place_verdict(before, after))


def _cannot_rows(
    both: Both, labels: Mapping[str, str], before: StoredAssessment, after: StoredAssessment
) -> Iterator[Row]:
    pairs = _pairs(before.places, after.places, lambda each: (each.worker, each.operation, each.place))
    for key, was, now in pairs:
        if any(each is not None and each.way is None for each in (was, now)):
            words = _words(both, _worker_words, was, now)
            what = (labels[key[0]], *map(both[1].name, key[1:]))
            yield Row(what, words[0], words[1], _worker_verdict(was, now, words))


def _share_rows(both: Both, before: StoredAssessment, after: StoredAssessment) -> Iterator[Row]:
    for key, was, now in _pairs(before.shares, after.shares, lambda each: (each.operation, each.place, each.sex)):
        words = _words(both, _share_words, was, now)
        what = (*map(both[1].name, key[:2]), both[1].catalogue.term(key[2]))
        yield Row(what, words[0], words[1], _share_verdict(was, now, words))


def _cycle_row(both: Both, label: str, before: StoredCycle | None, after: StoredCycle | None) -> Row:
    words = _words(both, _cycle_words, before, after)
    return Row((label,), words[0], words[1], _cycle_verdict(before, after))


def _place_words(wording: Wording, found: StoredPlace | None) -> str:
    if found is None:
        return "–"
    parts = []
    if found.seconds:
        parts.append(wording.say("{seconds:.0f} s above the rule", seconds=ShownSeconds(found.seconds)))
    if found.missed_by:
        parts.append(wording.say("cannot: {workers}", workers=wording.workers(found.missed_by)))
    parts += _fatigue_words(wording, found.peak, found.entry)
    return ": ".join(filter(None, [wording.light(found.grade(), wording.say("left out for all")), "; ".join(parts)]))


def _worker_words(wording: Wording, found: StoredPlaceForWorker | None) -> str:
    if found is None:
        return "–"
    return why_left_out(found.outcome, wording) if found.way is None else wording.light(found.grade())


def _share_words(wording: Wording, found: StoredShare | None) -> str:
    if found is None:
        return "–"
    if found.strong_share is None:
        return wording.say("reached by {reach:.0%}", reach=found.share)
    text = "reached by {reach:.0%}, strong enough: {strong:.0%}"
    return wording.say(text, reach=found.share, strong=found.strong_share)


def _cycle_words(wording: Wording, found: StoredCycle | None) -> str:
    if found is None:
        return wording.light(None, wording.say("cannot do all operations"))
    fatigue = _fatigue_words(wording, found.fatigue.peak, found.fatigue.entry)
    return ": ".join([wording.light(found.grade()), *fatigue])


def _fatigue_words(wording: Wording, peak: float | None, entry: str) -> list[str]:
    if peak is None or not entry:
        return []
    return [wording.say("{joint} loses {peak:.0%}", joint=wording.catalogue.term(joint_name(entry)), peak=peak)]


def _place_verdict(before: StoredPlace | None, after: StoredPlace | None) -> str:
    if before is None or after is None:
        return ONLY
    old, new = ((len(each.missed_by), _grade(each.grade()), round(each.seconds)) for each in (before, after))
    return _verdict(old, new, before.peak, after.peak)


def _worker_verdict(
    before: StoredPlaceForWorker | None, after: StoredPlaceForWorker | None, words: Sequence[str]
) -> str:
    """Who can is better off than who cannot; of those who cannot, who is nearer to it."""
    if before is None or after is None:
        return ONLY
    if words[0] == words[1]:
        return SAME
    old, new = ((each.way is None, nearness(each.outcome)) for each in (before, after))
    return SAME if old == new else BETTER if new < old else WORSE


def _share_verdict(before: StoredShare | None, after: StoredShare | None, words: Sequence[str]) -> str:
    """More who reach it count first, then more who are strong enough."""
    if before is None or after is None:
        return ONLY
    if words[0] == words[1]:
        return SAME
    old, new = ((round(each.share, 2), each.strong_share or 0.0) for each in (before, after))
    return BETTER if new > old else WORSE


def _cycle_verdict(before: StoredCycle | None, after: StoredCycle | None) -> str:
    old, new = ((_NOBODY if each is None else _grade(each.grade()),) for each in (before, after))
    peaks = [None if each is None else each.fatigue.peak for each in (before, after)]
    return _verdict(old, new, *peaks)


def _grade(level: Level | None) -> int:
    return _NOBODY if level is None else int(level)


def _verdict(before: Sequence[int], after: Sequence[int], peak: float | None, peak_after: float | None) -> str:
    """Who cannot counts first, then the level, the seconds above the rule, and the fatigue."""
    if tuple(before) != tuple(after):
        return BETTER if tuple(after) < tuple(before) else WORSE
    if peak is None or peak_after is None or abs(peak - peak_after) < SAME_PEAK:
        return SAME
    return BETTER if peak_after < peak else WORSE

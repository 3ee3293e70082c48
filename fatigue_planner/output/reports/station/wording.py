"""How an assessment is put into words: workers by percentile and not by name, levels with a sign, values as ranges."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from markupsafe import Markup

from fatigue_planner.core.text import format_label
from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Level, Phrase, ShownSeconds
from fatigue_planner.output.reports.page import prose
from fatigue_planner.output.reports.station.catalogue import Catalogue
from fatigue_planner.station.assessment import Rule
from fatigue_planner.station.workers import WorkerFacts

# A sign beside the words of a level, so that neither colour nor reading alone carries it.
SIGNS = {Level.ACCEPTABLE: "●", Level.INVESTIGATE: "▲", Level.NOT_ACCEPTABLE: "■"}
NO_LEVEL = "○"
_CLASSES = {sign: level.name.lower() for level, sign in SIGNS.items()} | {NO_LEVEL: "none"}
# Values of sentences that are names of the file: of workers, and of anything else; and names that are as they are.
_AS_THEY_ARE = ("arm",)
_WORKERS, _NAMES = ("worker", "workers"), ("place", "operation", "others", "tool", "sequence", "station", "stations")


class Wording:
    """The words for an assessment in a language.

    Workers are called by sex and percentile; those whose pseudonyms are given, by these.
    """

    def __init__(self, catalogue: Catalogue, workers: Sequence[WorkerFacts], pseudonyms: Iterable[str] = ()) -> None:
        self.catalogue = catalogue
        self._labels = {**self._labelled(workers), **{name: format_label(name) for name in pseudonyms}}

    def say(self, template: str, /, **values: str | float) -> str:
        """A text of the page with its values, which are put into words already."""
        return self.catalogue.text(template, **values)

    def phrase(self, phrase: Phrase) -> str:
        """A part of a sentence of the assessment: workers are named by percentile, names of parts translated."""
        values = {name: self._value(name, each) for name, each in phrase.values.items()}
        return self.catalogue.text(phrase.template, **values)

    def sentence(self, phrase: Phrase) -> str:
        """A sentence of the assessment."""
        text = self.phrase(phrase)
        return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"

    def worker(self, name: str) -> str:
        """A worker by sex and percentile of stature, and what tells him or her apart."""
        return self._labels[name]

    def workers(self, names: Iterable[str]) -> str:
        """Some workers."""
        return ", ".join(map(self.worker, names))

    def light(self, level: Level | None, otherwise: str = "") -> str:
        """A level in words behind its sign; `otherwise` where there is none."""
        return f"{NO_LEVEL} {otherwise}" if level is None else f"{SIGNS[level]} {self.catalogue.term(level.words)}"

    def marked(self, text: str) -> Markup:
        """A text as HTML; a level, which ends at a colon, has its colour, and its sign is not read aloud."""
        if text[:1] not in _CLASSES:
            return prose(text)
        level, colon, rest = text[2:].partition(": ")
        light = '<span class="light {}"><span aria-hidden="true">{}</span> {}</span>{}'
        return Markup(light).format(_CLASSES[text[0]], text[0], prose(level), prose(colon + rest))

    def name(self, name: str) -> str:
        """A name of the file as it is read."""
        return format_label(name)

    def names(self, names: Iterable[str]) -> str:
        """Some names of the file."""
        return ", ".join(map(format_label, names))

    def rules(self, by: Sequence[Rule], cycle_s: float, most: int | None = None) -> str:
        """So many of the rules that give a level, that with the most seconds first, each with the part it is about."""
        ordered = sorted(by, key=lambda rule: -(rule.not_acceptable_s or 0.0))
        texts = [self._rule(rule, cycle_s) for rule in ordered[:most]]
        if len(texts) < len(ordered):
            texts.append(self.say("{more} more", more=len(ordered) - len(texts)))
        return "; ".join(texts)

    def _rule(self, rule: Rule, cycle_s: float) -> str:
        title = self.catalogue.term(f"{rule.title} ({rule.part})" if rule.part else rule.title)
        if not rule.not_acceptable_s:
            return title
        return self.say(
            "{rule} for {seconds:.0f} of {cycle_s:.0f} s",
            rule=title,
            seconds=ShownSeconds(rule.not_acceptable_s),
            cycle_s=cycle_s,
        )

    def levels(self, low: Level, high: Level) -> str:
        """A level, or the range of it; a range has the sign of what is to be investigated, or of the level for sure."""
        if low == high:
            return self.light(low)
        words = self.say("{low} to {high}", low=self.catalogue.term(low.words), high=self.catalogue.term(high.words))
        return f"{SIGNS[max(low, Level.INVESTIGATE)]} {words}"

    def number(self, value: float, digits: int = 0) -> str:
        """A number with so many decimals."""
        return self.catalogue.number(value, f".{digits}f")

    def percent(self, share: float) -> str:
        """A share in whole per cent."""
        return self.catalogue.number(share, ".0%")

    def value(self, judgement: Judgement) -> str:
        """What an indicator finds, as `Assessment.text` has it: `3 (4 if repeated more than 4 times a minute)`."""
        if judgement.value is None:
            reason = self.phrase(judgement.reason) if judgement.reason else ""
            return self.say("does not apply: {reason}", reason=reason)
        low, high = (self._finite(end, judgement.digits) for end in judgement.value)
        unit = f"\u00a0{judgement.unit}" if judgement.unit else ""
        if not judgement.decides:
            return f"{low}{unit}" if low == high else self.say("{low} to {high}", low=low, high=high) + unit
        more = [
            f"{self._finite(one.value, judgement.digits)} {self.phrase(one.condition)}" for one in judgement.decides
        ]
        if len(more) > 1:
            more.append(self.say("{most} if all", most=high))
        return f"{low}{unit} ({'; '.join(more)})"

    def part(self, judgement: Judgement) -> str:
        """Where a value is worst."""
        worst = judgement.worst
        return self.catalogue.term(f"{worst.side} {worst.part}".strip()) if worst else ""

    def _finite(self, value: float, digits: int) -> str:
        return self.catalogue.number(value, f".{digits}f")

    def _value(self, name: str, value: str | float) -> str | float:
        if not isinstance(value, str):
            return value
        if name in _WORKERS:
            return ", ".join(self._labels.get(each, each) for each in value.split(", "))
        if name in _NAMES:
            return format_label(value)
        if name in _AS_THEY_ARE:
            return value
        return self.catalogue.term(format_label(value) if name == "joint" else value)

    def _labelled(self, workers: Sequence[WorkerFacts]) -> Mapping[str, str]:
        labels = {facts.name: self._label(facts) for facts in workers}
        often, seen = Counter(labels.values()), Counter[str]()
        for name, label in labels.items():
            if often[label] > 1:
                seen[label] += 1
                labels[name] = f"{label} ({seen[label]})"
        return labels

    def _label(self, facts: WorkerFacts) -> str:
        text = self.catalogue.text("woman P{percentile:.0f}" if facts.sex == "female" else "man P{percentile:.0f}",
                                   percentile=facts.stature_percentile)  # fmt: skip
        if facts.handedness == "left":
            text += self.catalogue.text(", left-handed")
        if round(facts.strength_percentile) != 50:
            text += self.catalogue.text(", strength P{percentile:.0f}", percentile=facts.strength_percentile)
        return text

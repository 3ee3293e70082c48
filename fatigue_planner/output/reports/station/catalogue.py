"""Texts in another language: one file per language in `texts`, keyed by the English text.

English has no file: a text is its own key. What a file lacks stays English, and `missing` remembers it.
"""

import math
import re
from pathlib import Path
from typing import Any

from pydantic import Field

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.core.settings import Settings, load_data

TEXTS = Path(__file__).parent / "texts"
ENGLISH = "en"
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
# A word with seconds behind it, and seconds alone, which are the same in all languages.
_TIMED, _SECONDS = re.compile(r"([^,()]+), ([\d.]+ s)"), re.compile(r"[\d.]+ s")
_FIELD = re.compile(r"\\{(\w+)\\}")


class Texts(Settings):
    """The content of a file of texts."""

    decimal: str = Field(default=".", min_length=1, max_length=1, description="The sign before decimals.")
    texts: dict[str, str] = Field(default_factory=dict, description="Sentences and words by their English text.")
    patterns: dict[str, str] = Field(
        default_factory=dict,
        description="Texts that come with their values in them, by the English text with names in braces.",
    )


class Catalogue:
    """The texts of a language."""

    def __init__(self, language: str, texts: Texts) -> None:
        self.language, self._texts = language, texts
        self._patterns = [(_pattern(key), text) for key, text in texts.patterns.items()]
        self.missing: set[str] = set()

    def text(self, template: str, /, **values: Any) -> str:
        """A text with its values; numbers as the language writes them."""
        found = self._texts.texts.get(template)
        if found is None:
            if self.language != ENGLISH:
                self.missing.add(template)
            found = template
        return found.format(**{name: _Value(self, value) for name, value in values.items()})

    def term(self, text: str) -> str:
        """A word, a name of a part, or a list of them, which is not a template."""
        if self.language == ENGLISH or not text:
            return text
        if _SECONDS.fullmatch(text):
            return self._signs(text)
        if (found := self._texts.texts.get(text)) is not None:
            return found
        if timed := _TIMED.fullmatch(text):
            return f"{self.term(timed[1])}, {self._signs(timed[2])}"
        for pattern, template in self._patterns:
            if match := pattern.fullmatch(text):
                return template.format(**{name: self._part(part) for name, part in match.groupdict().items()})
        if match := re.fullmatch(r"(.+?) \(([^()]+)\)", text):
            return f"{self.term(match[1])} ({self.term(match[2])})"
        if len(parts := re.split(r", (?![^(]*\))", text)) > 1:
            return ", ".join(map(self.term, parts))
        self.missing.add(text)
        return text

    def number(self, value: float, spec: str) -> str:
        """A number in a format, as the language writes it; a per cent sign has a space before it."""
        text = format(value, spec) if math.isfinite(value) else "∞"
        return self._signs(text).replace("%", "\u00a0%").replace("-", "−")

    def _part(self, text: str) -> str:
        return self._signs(text) if _NUMBER.fullmatch(text) else self.term(text)

    def _signs(self, text: str) -> str:
        return text.replace(".", self._texts.decimal)


class _Value:
    """A value in a text: a number is written as its language does."""

    def __init__(self, catalogue: Catalogue, value: Any) -> None:
        self._catalogue, self._value = catalogue, value

    def __format__(self, spec: str) -> str:
        if isinstance(self._value, int | float) and not isinstance(self._value, bool):
            return self._catalogue.number(self._value, spec)
        return format(self._value, spec)


def languages() -> list[str]:
    """The languages that there are texts of."""
    return sorted({ENGLISH, *(file.stem for file in TEXTS.glob("*.yaml"))})


def catalogue_of(language: str) -> Catalogue:
    """The texts of a language. Raises SelectionError if there are none."""
    if language not in languages():
        raise SelectionError(f"--language {language}: give one of {', '.join(languages())}.")
    return Catalogue(language, Texts() if language == ENGLISH else load_data(TEXTS / f"{language}.yaml", Texts))


def _pattern(key: str) -> re.Pattern[str]:
    return re.compile(_FIELD.sub(r"(?P<\1>.+?)", re.escape(key)))

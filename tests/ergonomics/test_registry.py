"""All indicators on one job: what they say is plain data, every key is described, a plug-in adds one."""

import ast
import json
from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np
import pytest
from conftest import ROOT
from forgotten_plugins import forgotten_plugins

import fatigue_planner as fp
from fatigue_planner.core.errors import PluginError
from fatigue_planner.core.settings import Settings
from fatigue_planner.ergonomics.indicator import INDICATORS, Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.registry import KINDS, evaluate
from fatigue_planner.ergonomics.result import Assessment, Level, Origin, Phrase, Span, Unknown, spanned
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.reactions.reaction import Reaction


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    """No plug-in outlives its test."""
    with forgotten_plugins():
        yield


@pytest.mark.parametrize("known", [True, False])
def test_every_indicator_says_plain_data(reactions: tuple[Reaction, ...], known: bool) -> None:
    """Of two operations; levels are those of both ends of the range, and a range has what decides it or two methods."""
    stated = Circumstances(
        actions_per_minute=3, effort_share=0.3, omni_effort=3, coupling="good", shock=False, rapid_changes=False,
        shoulder_raised=False, placed_carefully=False,
    )  # fmt: skip
    operations = [Operation.of(reaction, stated if known else None) for reaction in reactions[:2]]
    found = evaluate(operations, Shift(cycle_s=60, hours=4) if known else None)
    assert [one.indicator for one in found] == list(INDICATORS.kinds())
    for one in found:
        plain = json.loads(json.dumps(one.plain(), allow_nan=False))
        assert plain["title"] and plain["edition"] and plain["origin"]
        assert one.text()
        if not one.applies:
            assert plain["reason"]
            continue
        assert one.value is not None
        assert one.value.low <= one.value.high
        assert one.levels is not None and one.words is not None
        assert not (known and one.decides), one.indicator
        if one.value.low < one.value.high:
            assert one.decides or one.indicator in {"holding_time", "l5s1_compression"}, one.indicator
        for times in (one.times, one.times_most):
            assert times is None or sum(times) == pytest.approx(32)


def test_seconds_are_those_of_the_operation(reactions: tuple[Reaction, ...]) -> None:
    """Judged every 0.3 s, 16 s are 54 instants, but not 16.2 s."""
    operation = Operation.of(reactions[0], Circumstances(times_per_cycle=2), step_s=0.3)
    assert len(operation.posture.time_s) == 54
    times = [one.times for one in evaluate([operation]) if one.times is not None]
    assert len(times) == 5
    np.testing.assert_allclose(np.sum(times, axis=1), 32)


def test_every_key_is_described() -> None:
    kinds: list[type[Settings]] = [Circumstances, Shift, *KINDS]
    for kind in kinds:
        for name, key in kind.model_json_schema()["properties"].items():
            assert key.get("description", "").endswith("."), f"{kind.__name__}.{name}"


def test_templates_can_be_collected_from_the_sources() -> None:
    found = []
    for file in (ROOT / "fatigue_planner" / "ergonomics").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Phrase":
                assert isinstance(node.args[0], ast.Constant), f"{file.name}: line {node.lineno}"
                found.append(node.args[0].value)
    assert len(found) > 40


def test_titles_and_kinds_are_not_taken_twice() -> None:
    for names in ([kind.title for kind in KINDS], [kind.model_fields["kind"].default for kind in KINDS]):
        assert len(set(names)) == len(names) == 15
    assert all(kind.edition and isinstance(kind.origin, Origin) for kind in KINDS)


def test_a_plug_in_adds_an_indicator(reactions: tuple[Reaction, ...]) -> None:
    @fp.register
    class Long(Indicator):
        """How long the operations are."""

        title: ClassVar[str] = "length"
        edition: ClassVar[str] = "own"
        origin: ClassVar[Origin] = Origin.READ
        kind: Literal["long"] = "long"

        def assess(self, job: Job) -> Assessment:
            return self.answer(value=Span(job.busy_s, job.busy_s), unit="s", levels=(Level.ACCEPTABLE,) * 2)

    found = evaluate([Operation.of(reactions[0])])
    assert (found[-1].indicator, found[-1].text()) == ("long", "16 s")

    class Taken(Long):
        kind: Literal["rula"] = "rula"  # type: ignore[assignment]

    with pytest.raises(PluginError, match="'rula' is already defined"):
        fp.register(Taken)


def test_a_range_spans_all_that_may_be() -> None:
    """Every input alone from the first values, and all of them together, in any order of what they make worse."""
    unknown = [
        Unknown("a", 1.0, ((3.0, Phrase("if three")), (2.0, Phrase("if two")))),
        Unknown("b", 1.0, ((-5.0, Phrase("if negative")), (4.0, Phrase("if four")))),
        Unknown("c", 0.0, ((7.0, Phrase("which does not matter")),)),
    ]
    value, base, decides = spanned(lambda chosen: float(chosen["a"] * chosen["b"]), unknown)
    assert (value, base) == ((-15, 12), 1)
    assert [(one.key, str(one.condition), one.value) for one in decides] == [
        ("a", "if three", 3), ("a", "if two", 2), ("b", "if negative", -5), ("b", "if four", 4),
    ]  # fmt: skip
    assert spanned(lambda _: 2.0, []) == ((2, 2), 2, ())


def test_words_of_a_result() -> None:
    assert str(Phrase("up to {most:g} m", {"most": 0.5})) == "up to 0.5 m"
    assert [Span(1, 1).text(0), Span(1, 2.25).text(1), Span(1, float("inf")).text(0)] == ["1", "1.0 to 2.2", "1 to ∞"]
    assert [level.words for level in Level] == ["acceptable", "investigate", "not acceptable"]
    assert [origin.words.split()[0] for origin in Origin] == ["read", "read", "recalled,"]

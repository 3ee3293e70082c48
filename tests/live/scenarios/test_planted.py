"""The scenarios: every one has a test, and every test sees a fault that is planted for it."""

import re
from collections.abc import Callable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest
from planting import Planted, function_at, planted
from shifts import World

HERE = Path(__file__).parent
NUMBERS = range(1, 29)


def scenarios() -> dict[int, Callable[[World], None]]:
    """By number, the tests of this folder."""
    found: dict[int, Callable[[World], None]] = {}
    for file in sorted(HERE.glob("test_*.py")):
        if file.name == Path(__file__).name:
            continue
        spec = spec_from_file_location(f"scenarios_{file.stem}", file)
        assert spec is not None and spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        for name, test in vars(module).items():
            if number := re.match(r"test_(\d\d)_", name):
                assert int(number[1]) not in found, name
                found[int(number[1])] = test
    return found


SCENARIOS = scenarios()
# By number, a scenario whose test needs an extra.
ELSEWHERE = {28: ("test_ur.py", "test_scenario_28_only_an_echo_is_delivery")}


def test_every_scenario_has_a_test_and_a_fault() -> None:
    assert sorted([*ELSEWHERE, *SCENARIOS]) == list(NUMBERS)
    for file, name in ELSEWHERE.values():
        assert f"def {name}(" in (HERE.parent / file).read_text(encoding="utf-8")
    for test in SCENARIOS.values():
        fault: Planted = test.fault  # type: ignore[attr-defined]
        function_at(fault.where)


@pytest.mark.slow
@pytest.mark.parametrize("number", SCENARIOS)
def test_a_planted_fault_is_seen(number: int, world: World, request: pytest.FixtureRequest) -> None:
    test: Any = SCENARIOS[number]
    world.fault = test.fault
    names = test.__code__.co_varnames[: test.__code__.co_argcount]
    given = {name: world if name == "world" else request.getfixturevalue(name) for name in names}
    with planted(test.fault), pytest.raises((AssertionError, pytest.fail.Exception)):
        test(**given)

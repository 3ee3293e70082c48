"""Compiled kernels: never stale, equal to plain Python bit for bit, and draws that respect impossibility."""

import importlib
import inspect
import json
import os
import pickle
import pkgutil
import stat
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tiger
from numba.core.dispatcher import Dispatcher as CPUDispatcher
from small_problems import (
    EXPERTISES,
    NOISY,
    lookahead,
    pomcp,
    small_model,
    table_belief,
    tiger_with_an_end,
    tree_of,
    two_starts,
    two_workers,
)

import fatigue_planner
from fatigue_planner.core.jit import PRIVATE_FOLDER, _meaning, cache_folder
from fatigue_planner.planners.pomcp.backups import expect_nothing
from fatigue_planner.planners.pomcp.leaf_values import no_value
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.choices.inertia import InertiaChoice
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import draw

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def python(script: str, *arguments: str | Path, path: Path = HERE, **environment: str) -> str:
    """What a script prints in a process of its own that finds modules in `path`."""
    paths = os.pathsep.join(
        [
            str(path),
            str(ROOT),
            str(ROOT / "tests"),
            str(ROOT / "tests" / "support"),
            str(ROOT / "examples"),
            os.environ.get("PYTHONPATH", ""),
        ]
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": paths} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


MINE = """
from typing import NamedTuple

import constants
import helper
import numpy as np
from fatigue_planner.core.jit import compiled, specialised
from fatigue_planner.planners.pomcp.leaf_values import problem_bound
from helper import helped

NUMBER = 1.0
PAIR = (0.0, 1.0)
TABLE = np.array([1.0, 0.0])


@compiled
def own_constant(_, x):
    return x + 1.0


@compiled
def global_number(_, x):
    return x + NUMBER


@compiled
def global_pair(_, x):
    return x + PAIR[1]


@compiled
def global_array(_, x):
    return x + TABLE[0]


@compiled
def function_of_another_module(_, x):
    return helped(0, x)


def adding(value):
    @compiled
    def closure(_, x):
        return x + value

    return closure


@compiled
def number_of_another_module(_, x):
    return x + constants.VALUE


@compiled
def function_found_in_a_module(_, x):
    return helper.more(0, x)


@compiled
def member_of_a_class(_, x):
    return x + constants.Kind.USUAL.value


closure = adding(1.0)
PARTS = (
    member_of_a_class, own_constant, global_number, global_pair, global_array, closure,
    function_of_another_module, number_of_another_module, function_found_in_a_module,
)


class Fields(NamedTuple):
    first: float
    second: float


class Workspace(NamedTuple):
    state: float


@compiled
def first_field(fields, _):
    return fields.first


def results():
    fields = Fields(first=7.0, second=8.0)
    kernels = [specialised(problem_bound, bound=part) for part in (first_field, *PARTS)]
    return [kernel(0, fields, Workspace(0.0), 0, 0, 0) for kernel in kernels] + [part(fields, 0.0) for part in PARTS]
"""
HELPER = """
import constants
from fatigue_planner.core.jit import compiled


@compiled
def helped(_, x):
    return x + 1.0


@compiled
def more(_, x):
    return x + constants.VALUE
"""
CONSTANTS = """
from enum import Enum

VALUE = 1.0


class Kind(Enum):
    USUAL = 1.0
"""


@pytest.mark.slow
def test_changed_sources_never_run_stale_code(tmp_path: Path) -> None:
    """A problem of one's own, changed without a change of size or time of its files: in kernels and by itself.

    The last change also swaps the fields of a NamedTuple that the function gets.
    """
    sources = {"mine.py": MINE, "helper.py": HELPER, "constants.py": CONSTANTS}
    for values in (("1.0", "1.0", "1.0"), ("1.0", "2.0", "3.0"), ("4.0", "2.0", "3.0")):
        for value, (name, text) in zip(values, sources.items(), strict=True):
            source = text.replace("1.0", value)
            if value == "4.0":
                source = source.replace("first: float\n    second: float", "second: float\n    first: float")
            (tmp_path / name).write_text(source)
            os.utime(tmp_path / name, (1e9, 1e9))
        printed = python(
            "import json, mine; print(json.dumps(mine.results()))",
            path=tmp_path,
            XDG_CACHE_HOME=str(tmp_path / "cache"),
            PYTHONDONTWRITEBYTECODE="1",
        )
        own, helper, constant = map(float, values)
        expected = [constant] + [own] * 5 + [helper, constant, constant]
        assert json.loads(printed) == [7.0, *expected, *expected]


def test_compiled_kernels_lie_in_a_folder_that_is_ours_and_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Numba runs what it finds there: at home, else in the temporary folder, else in a private one for this run."""
    folder = cache_folder.__wrapped__
    home, temporary = tmp_path / "home", tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv(PRIVATE_FOLDER, raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setenv("HOME", str(home))
    at_home, fallback = home / ".cache" / "fatplan", temporary / f"fatplan-{os.getuid()}"
    assert folder().parent == at_home
    assert [stat.S_IMODE(path.stat().st_mode) for path in (at_home, folder())] == [0o700] * 2
    at_home.chmod(0o770)
    assert folder().parent == fallback
    at_home.chmod(0o700)
    monkeypatch.setattr(os, "getuid", lambda: 54321)  # all these are somebody else's now
    monkeypatch.setattr(Path, "home", no_home)
    (temporary / "fatplan-54321").symlink_to(fallback)
    assert capsys.readouterr().err == ""
    private = folder()
    assert private.parent == temporary and stat.S_IMODE(private.stat().st_mode) == 0o700
    assert capsys.readouterr().err == (
        f"Compiled kernels are kept in {private} only until this program ends: there is no home folder; "
        f"{temporary}/fatplan-54321 is somebody else's.\n"
    )
    monkeypatch.undo()
    monkeypatch.setenv(PRIVATE_FOLDER, str(private))
    assert folder() == private  # in the processes that work


def no_home() -> Path:
    raise RuntimeError("Could not determine home directory.")


ALONE = """
import sys
sys.path.insert(0, sys.argv[1])
from small_problems import pomcp, small_model, tree_of, two_starts
if sys.argv[2] == "own":
    from own_problem import BELIEF
else:
    BELIEF = two_starts(small_model(0.0))
print(tree_of(BELIEF, pomcp(9, leaf_value="none")).tried[0].sum())
"""
OWN_PROBLEM = """
from small_problems import *
class Own(NamedTuple):
    move: np.ndarray
    reward: np.ndarray
    see: np.ndarray
    horizon: int
problem = tiger_with_an_end(3)
BELIEF = table_belief(replace(problem, arrays=Own(*problem.arrays)), [0.5, 0.5])
"""


@pytest.mark.slow
def test_one_programs_problem_does_not_disturb_another_program(tmp_path: Path) -> None:
    """What is kept for a problem whose types are defined elsewhere is of no account where these are not known."""
    (tmp_path / "own_problem.py").write_text(OWN_PROBLEM)
    for which, folder in (("own", tmp_path), ("fatigue", HERE), ("own", tmp_path)):
        assert python(ALONE, folder, which, XDG_CACHE_HOME=str(tmp_path / "cache")) == "9\n"


def test_functions_that_get_a_problems_own_types_are_not_kept() -> None:
    """Else the file that lists what is kept could not be read by programs that do not know these types."""
    found = [no_value, expect_nothing, tiger.advance]
    for module in pkgutil.walk_packages(fatigue_planner.__path__, "fatigue_planner."):
        if module.name.startswith(("fatigue_planner.pomdp.", "fatigue_planner.planners.")):
            found += [value for value in vars(importlib.import_module(module.name)).values() if _gets_any_arrays(value)]
    assert len({function.py_func for function in found}) >= 7
    assert [function.py_func for function in found if function.stats.cache_path is not None] == []


def _gets_any_arrays(value: object) -> bool:
    """Whether it is a compiled function that gets the arrays of any problem."""
    if not isinstance(value, CPUDispatcher):
        return False
    parameters = inspect.signature(value.py_func).parameters
    return any(
        name.strip("_") in {"arrays", "bound_arrays"} and parameters[name].annotation is Any for name in parameters
    )


def test_modules_without_a_file_are_no_obstacle() -> None:
    """`math` is built into some Pythons and a file in others."""
    assert _meaning(sys) == ["sys", {}]


def beliefs() -> dict[str, ExactBelief]:
    """Fatigue: every kind of expertise, both kinds of recognition, two hidden workers; and the tiger."""
    cases: dict[str, ExactBelief] = {}
    for kind, recognition in (("sharp", None), ("noisy", NOISY)):
        cases |= {f"{kind} {beta}": two_starts(small_model(beta, recognition)) for beta in EXPERTISES}
        cases[f"{kind} hidden"] = two_workers(recognition)
    habit = InertiaChoice(kind="inertia", inertia=1.0, offsets={"x": 0.5})
    cases["habit by action"] = two_starts(small_model(25.0, np.array([NOISY, NOISY[::-1]]), habit))
    return cases | {"tiger": table_belief(tiger_with_an_end(4), [0.5, 0.5])}


ALL = list(
    product(("mean", "max", "exact"), ("fixed", "scaled"), ("none", "random_rollout", "greedy_rollout", "bound"))
)


def searched() -> dict[tuple[str, ...], Any]:
    """Trees and lookahead values of all cases: 120 descents of each combination of parts."""
    found: dict[tuple[str, ...], Any] = {}
    for name, belief in beliefs().items():
        fatigue = isinstance(belief.model, FatiguePomdp)
        for parts in ALL:
            c = 0.01 if fatigue else 50.0
            others = {"exploration": parts[1], "leaf_value": parts[2], "rollout_cycles": 3}
            tree = tree_of(belief, pomcp(120, c, parts[0], **others))
            found[name, *parts] = {field: tree[field].tobytes() for field in tree.dtype.names}
        for leaf in dict.fromkeys(parts[2] for parts in ALL):
            found[name, leaf] = lookahead(belief, 3, leaf_value=leaf, rollout_cycles=3).tobytes()
    return found


SEARCHED = """
import pickle, sys
from pathlib import Path
from test_jit import searched
Path(sys.argv[1]).write_bytes(pickle.dumps(searched()))
"""


@pytest.mark.slow
def test_compiled_search_equals_plain_python_bit_for_bit(tmp_path: Path) -> None:
    """The same trees and values, to the last bit, with the compiler switched off."""
    python(SEARCHED, tmp_path / "plain", NUMBA_DISABLE_JIT="1")
    plain = pickle.loads((tmp_path / "plain").read_bytes())
    ours = searched()
    assert len(ours) == len(plain) > 100
    for case, expected in plain.items():
        assert ours[case] == expected, case


def test_a_draw_is_never_impossible() -> None:
    """At the ends of [0, 1), on the borders, and where rounding leaves a rest: no index of probability 0."""
    rng = np.random.default_rng(1)
    edge = np.nextafter(1.0, 0.0)
    for _ in range(300):
        probabilities = rng.dirichlet(np.ones(5)) * rng.integers(0, 2, 5)
        if not probabilities.any():
            continue
        probabilities /= probabilities.sum()
        borders = np.cumsum(probabilities)
        near = np.concatenate([borders, np.nextafter(borders, 0), np.nextafter(borders, 1)])
        for uniform in (0.0, edge, *near[near < 1], *rng.random(3)):
            index = draw(probabilities, uniform)
            assert probabilities[index] > 0
            assert abs(np.clip(uniform, borders[index] - probabilities[index], borders[index]) - uniform) < 1e-12
    assert draw(np.array([0.0, 0.0, 1.0 - 1e-9, 0.0]), edge) == 2  # a rest of rounding goes to the last that may be

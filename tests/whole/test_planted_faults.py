"""Do the tests see anything? A fault planted in a copy of the sources must make one of the tests named for it fail.

`pytest -m '' --dist load tests/whole/test_planted_faults.py` spreads the faults over the cores; with `--junitxml FILE`
the file says which test has seen each.
"""

import os
import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import pytest
from conftest import KEPT_REACTIONS, ROOT
from numba.core.caching import UserProvidedCacheLocator
from planted_faults import FAULTS, Fault
from planting import run_pytest
from test_layers import PACKAGE, dotted, imports

from fatigue_planner.core.jit import PRIVATE_FOLDER, cache_folder

PARTS = (
    "fatigue_planner", "tests", "experiments", "examples", "docs", "perf", "pyproject.toml", "README.md", "LICENSE",
)  # fmt: skip
MAX_SECONDS = 600
# Processes that run tests begin as copies of one that has imported these: nothing of the project.
LIBRARIES = [
    "pytest", "pydantic", "cloudpickle", "numba", "pandas", "scipy.stats", "scipy.optimize", "pinocchio", "casadi",
    "h5py", "typer",
]  # fmt: skip
# How a message begins where a test found another result than it expects; anything else is a broken program.
FOUND = re.compile(r"assert |AssertionError|Failed: DID NOT RAISE")


class Ran(NamedTuple):
    """A test that was run: its name, and the first words of its failure, empty if it passed."""

    name: str
    failure: str


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the project, removed afterwards."""
    folder = tmp_path_factory.mktemp("copy")
    for part in PARTS:
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / part)
    take_over_kernels(folder)
    yield folder
    shutil.rmtree(folder)


def take_over_kernels(folder: Path) -> None:
    """Give a copy what is compiled of the sources: numba looks for it by the folder they are in, and by their times."""
    sources = {path.parent for path in PACKAGE.rglob("*.py")}
    name_there = {kept_as(source): kept_as(folder / source.relative_to(ROOT)) for source in sources}
    for path in cache_folder().rglob("*.nb?"):
        if name := name_there.get(path.parent.name):
            there = folder / "kernels" / path.parent.parent.relative_to(cache_folder()) / name
            there.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, there)


def kept_as(source: Path) -> str:
    """The name of the folder in which numba keeps what is compiled of the files in a folder."""
    return UserProvidedCacheLocator.get_suitable_cache_subpath(str(source / "any.py"))


def importing(file: str) -> set[str]:
    """The modules of the package, that of `file` among them, in whose code a change of `file` can be seen."""
    changed = {dotted(PACKAGE / file)}
    while more := {name for name, below in imports().items() if below & changed} - changed:
        changed |= more
    return changed


@contextmanager
def kernels_without(folder: Path, file: str) -> Iterator[Path]:
    """A folder with the code that the copy's tests have compiled, less what a change of `file` may have changed.

    What is compiled there of other files is kept. Were anything stale left, it could hide a fault; but then no test
    fails, which is told.
    """
    kept, used = folder / "kernels", folder / "changed"
    kept.mkdir(exist_ok=True)
    stale = {tuple(name.split(".")[-2:]) for name in importing(file)}

    def drop_stale() -> None:
        """What is compiled of a function lies in "folder_hash/file.function-line.*" of where that is written."""
        for path in used.rglob("*.nb?"):
            if (path.parent.name.rpartition("_")[0], path.name.partition(".")[0]) in stale:
                path.unlink()

    try:
        shutil.copytree(kept, used, copy_function=os.link)  # numba replaces files, it does not write into them
        drop_stale()
        yield used
        drop_stale()
        shutil.copytree(used, kept, dirs_exist_ok=True, copy_function=os.replace)
    finally:
        shutil.rmtree(used)


def run_tests(folder: Path, tests: list[str], kernels: Path) -> list[Ran]:
    """Run some of the copy's tests until one fails, with the copy's package and the code compiled in `kernels`.

    The paper's reactions are those that an earlier run has made of the same sources.
    """
    kept = {PRIVATE_FOLDER: str(kernels), KEPT_REACTIONS: str(folder / "reactions")}
    outside = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    environment = outside | {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")} | kept
    report, said = folder / "report.xml", folder / "said.txt"
    options = ["-n", "0", "-x", "-p", "no:cacheprovider", f"--basetemp={folder / 'temporary'}", f"--junitxml={report}"]
    context = get_context("forkserver")
    context.set_forkserver_preload(LIBRARIES)
    process = context.Process(
        target=run_pytest, args=([*options, *(f"tests/{test}" for test in tests)], folder, ROOT, environment, said)
    )
    process.start()
    process.join(MAX_SECONDS)
    process.kill()  # in vain if it has ended
    assert process.exitcode in {0, 1}, said.read_text(encoding="utf-8")
    ran = []
    for case in ET.parse(report).iter("testcase"):
        assert case.find("skipped") is None, case.get("name")
        failure = case.find("failure")
        broken = case.find("error") if failure is None else failure
        ran.append(Ran(str(case.get("name")), "" if broken is None else str(broken.get("message"))))
    return ran


def test_every_fault_can_still_be_planted() -> None:
    """The old text is found once, the new one is Python, and the tests exist."""
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 26
    for fault in FAULTS:
        text = (ROOT / "fatigue_planner" / fault.file).read_text(encoding="utf-8")
        assert text.count(fault.old) == 1, fault.name
        compile(text.replace(fault.old, fault.new), fault.file, "exec")
        assert fault.old != fault.new and fault.tests, fault.name
        for test in fault.tests:
            file, function = test.split("[")[0].split("::")
            assert f"def {function}(" in (ROOT / "tests" / file).read_text(encoding="utf-8"), test


NAMED = sorted({test for fault in FAULTS for test in fault.tests})


@pytest.mark.slow
@pytest.mark.parametrize("room", sorted({test.partition("/")[0] for test in NAMED}))
def test_without_a_fault_the_tests_pass(room: str, copy: Path) -> None:
    named = [test for test in NAMED if test.startswith(f"{room}/")]
    ran = run_tests(copy, named, copy / "kernels")
    assert not [test for test in ran if test.failure]
    assert {test.name.partition("[")[0] for test in ran} == {test.partition("[")[0].split("::")[1] for test in named}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name.replace(" ", "_"))
def test_a_planted_fault_is_seen(copy: Path, fault: Fault, record_property: Callable[[str, object], None]) -> None:
    path = copy / "fatigue_planner" / fault.file
    text = path.read_text(encoding="utf-8")
    assert text.count(fault.old) == 1
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    try:
        with kernels_without(copy, fault.file) as kernels:
            ran = run_tests(copy, list(fault.tests), kernels)
    finally:
        path.write_text(text, encoding="utf-8")
    failures = [test for test in ran if test.failure]
    assert failures, f"{fault.name}: no test fails"
    assert all(FOUND.match(test.failure) for test in failures), failures
    record_property("seen by", failures[0].name)

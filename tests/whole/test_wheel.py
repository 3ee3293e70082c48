"""The wheel, used in an empty folder: what ships is found by name, and nothing is written beside the code.

The environment of the test lends its libraries; `tests/versions.py` installs everything anew.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from conftest import ROOT

COMMANDS = (
    "simulate paper --jobs 2",
    "benchmark paper --cycles 5 --trials 2 --policies greedy --policies random --conditions single_novice",
    "report paper --cycles 5 --trials 2 --policies greedy --policies random --conditions single_novice",
    "claims --help",
    "validate paper_claims",
    "validate sensitivity",
    "view paper --save page.html --reaction average_man/high/arm",
    "init mine",
    "validate mine.yaml",
    "doctor",
)


SOURCES = ("fatigue_planner", "experiments", "pyproject.toml", "setup.py", "README.md", "LICENSE")
# Nothing of the repository is found but through the wheel.
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of an environment with the wheel, and the other libraries of this one."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"  # setuptools leaves a folder `build` beside what it builds
    source.mkdir()
    for part in SOURCES:
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
        copy(ROOT / part, source / part)
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(source)]
    subprocess.run(build, check=True, cwd=folder, env=ENVIRONMENT)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    python = folder / "venv" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-deps", wheel], check=True, env=ENVIRONMENT)
    site = Path(sysconfig.get_path("purelib", vars={"base": str(folder / "venv")}))
    libraries = sysconfig.get_path("purelib")  # after the wheel, and with what their own .pth files add (pin)
    (site / "libraries.pth").write_text(f"import site; site.addsitedir({libraries!r})\n")
    return python


def files(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if "__pycache__" not in path.parts}


@pytest.mark.slow
def test_the_commands_work_from_the_wheel_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    environment = ENVIRONMENT | {"PYTHONDONTWRITEBYTECODE": "1", "XDG_CACHE_HOME": str(tmp_path / "xdg")}
    package = next((installed.parents[1] / "lib").glob("python*/site-packages/fatigue_planner"))
    before = files(package)
    assert {path.stem for path in (package / "shipped").glob("*.yaml")} >= {"paper", "paper_claims", "sensitivity"}
    ours = {file.relative_to(ROOT / "fatigue_planner") for file in files(ROOT / "fatigue_planner") if file.is_file()}
    assert ours <= {file.relative_to(package) for file in before}
    work = tmp_path / "work"
    work.mkdir()
    for command in COMMANDS:
        done = subprocess.run(
            [installed, "-m", "fatigue_planner", *command.split()],
            cwd=work, env=environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        assert str(ROOT) not in done.stdout + done.stderr
    assert files(package) == before

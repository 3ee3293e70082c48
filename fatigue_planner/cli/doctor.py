"""`fatplan doctor`: whether everything that the program needs works on this machine."""

import io
import subprocess
import sys
import tempfile
import time
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import typer

from fatigue_planner import __version__
from fatigue_planner.cli import options
from fatigue_planner.cli.validate import summary
from fatigue_planner.core.errors import ExitCode, ExperimentError, OutputFolderError, listed
from fatigue_planner.core.executors.processes import available_cores
from fatigue_planner.core.file_kinds import kind_of

SOLVERS = ("daqp", "qpoases")
REINSTALL = "Install fatplan again: `make install`, or `pip install --force-reinstall` of this package."
# A small container lacks what the wheels of others take from the system.
SYSTEM = "Install the system's package with this library (libgomp.so.1 on Debian: `apt-get install libgomp1`)."


@dataclass(frozen=True)
class Finding:
    """What a check found; remedy: None if all is well; vital: nothing works without it."""

    what: str
    found: str
    remedy: str | None = None
    vital: bool = True


def doctor(
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    as_json: options.Json = False,
) -> None:
    """Check this installation by using every part: libraries, data, experiments that ship, folders, viewer, browser.

    Whatever is missing is named, with what to do about it; the exit code is 3 if nothing can work without it.
    """
    checks: list[Callable[[], Finding]] = [
        _versions, _module, _data_files, _files_that_ship, _solvers, _compiler, _hdf5,
        lambda: _folder("cache", cache), lambda: _folder("results", results),
        _viewer, _browser, _cores,
    ]  # fmt: skip
    findings = [_careful(check) for check in checks]
    healthy = not any(one.remedy and one.vital for one in findings)
    options.present({"healthy": healthy, "findings": findings}, "\n".join(map(_words, findings)), as_json)
    if not healthy:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _words(one: Finding) -> str:
    mark = "ok     " if one.remedy is None else "MISSING" if one.vital else "absent "
    return f"{mark} {one.what}: {one.found}" + (f"\n        {one.remedy}" if one.remedy else "")


def _careful(check: Callable[[], Finding]) -> Finding:
    """A broken library may raise anything when it is first used."""
    try:
        return check()
    except Exception as error:
        name = getattr(check, "__name__", "check").strip("_<>").replace("_", " ")
        remedy = SYSTEM if isinstance(error, ImportError) and ".so" in str(error) else REINSTALL
        return Finding(name, f"{type(error).__name__}: {error}", remedy)


def _versions() -> Finding:
    from fatigue_planner.core.provenance import versions

    return Finding("versions", ", ".join(f"{name} {number}" for name, number in versions().items()))


def _module() -> Finding:
    """Whether the command that needs no script on the path starts this program, and no other of its name."""
    command = [sys.executable, "-m", "fatigue_planner", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    said = (done.stdout or done.stderr).strip() or "nothing"
    what, found = "python -m fatigue_planner", said.splitlines()[-1]
    if done.returncode == 0 and found == f"fatplan {__version__}":
        return Finding(what, found)
    remedy = f"Look for another package of this name in {Path.cwd()} or in PYTHONPATH; else install fatplan again."
    return Finding(what, f"does not start fatplan {__version__}; it says: {found}", remedy)


def _data_files() -> Finding:
    """Whether all that is read from the package's folder is in it: data of the human, strengths, templates."""
    from fatigue_planner.fatigue.parameters import FatigueSettings
    from fatigue_planner.human.model import Worker
    from fatigue_planner.human.strength_sets import load_strengths, shipped_sets
    from fatigue_planner.output.reports.human.page import human_page
    from fatigue_planner.output.reports.page import page

    for name in shipped_sets():
        load_strengths(name)
    human_page(Worker(height_m=1.75, mass_kg=73.0, sex="male"), FatigueSettings(), (), "fatplan doctor")
    page("", "", (), ())
    return Finding("data files", f"digital human, {len(shipped_sets())} strength sets, pages of reports")


def _files_that_ship() -> Finding:
    """Whether all that ships is found by its name and valid."""
    from fatigue_planner.core.files import find_shipped, shipped_folder
    from fatigue_planner.core.yaml_reader import read_yaml

    what, names = "files that ship", sorted(file.stem for file in shipped_folder().glob("*.yaml"))
    if "paper" not in names:
        return Finding(what, f"no paper.yaml in {shipped_folder()}", REINSTALL)
    files = [find_shipped(Path(name)) for name in names]
    hidden = [file for file in files if file.parent != shipped_folder()]
    for file in files:
        if file not in hidden:
            summary(file, kind_of(read_yaml(file, ExperimentError)))
    remedy = f"In this folder these names mean your own files: {listed(map(str, hidden))}." if hidden else None
    return Finding(what, ", ".join(names), remedy, vital=False)


def _solvers() -> Finding:
    import casadi

    missing = [name for name in SOLVERS if not casadi.has_conic(name)]
    return Finding(
        "solvers", ", ".join(SOLVERS), f"CasADi lacks {', '.join(missing)}. {REINSTALL}" if missing else None
    )


def _compiler() -> Finding:
    from fatigue_planner.core.jit import cache_folder, compiled

    begin = time.perf_counter()
    three = compiled(_successor)(2)
    folder, seconds = cache_folder(), time.perf_counter() - begin
    kept = len(list(folder.rglob("*.nbi")))
    remedy = None if three == 3 else "numba computes wrongly; install its pinned version."
    return Finding("compiler", f"numba works ({seconds:.1f} s); {kept} kernels kept in {folder}", remedy)


def _successor(number: int) -> int:
    return number + 1


def _hdf5() -> Finding:
    import h5py
    import numpy as np

    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file.create_dataset("x", data=np.arange(3.0), fletcher32=True)
    with h5py.File(content, "r") as file:
        intact = file["x"][:].tolist() == [0.0, 1.0, 2.0]
    return Finding("HDF5", f"{h5py.version.hdf5_version}, with checksums", None if intact else REINSTALL)


def _folder(what: str, folder: Path) -> Finding:
    from fatigue_planner.core.files import writable_folder

    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    try:
        with tempfile.TemporaryDirectory(dir=there) as inside:
            writable_folder(Path(inside))
    except (OSError, OutputFolderError) as error:
        reason = getattr(error, "strerror", None) or error
        return Finding(
            f"folder of the {what}", f"{folder}: cannot be written ({reason})", f"Choose another one: --{what} FOLDER."
        )
    made = "" if folder.exists() else ", to be made"
    return Finding(f"folder of the {what}", f"{folder}: can be written{made}")


def _viewer() -> Finding:
    try:
        return Finding("viewer", f"viser {version('viser')}")
    except PackageNotFoundError:
        return Finding("viewer", "viser is not installed", f"`fatplan view` cannot work. {REINSTALL}", vital=False)


def _browser() -> Finding:
    try:
        return Finding("browser", webbrowser.get().__class__.__name__)
    except webbrowser.Error:
        remedy = "Pages are written all the same: open them on another machine, or set BROWSER."
        return Finding("browser", "none found", remedy, vital=False)


def _cores() -> Finding:
    return Finding("cores", f"{available_cores()} for --jobs")

"""`fatplan doctor`: whether everything that the program needs works on this machine."""

import io
import tempfile
import time
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import ExitCode, OutputFolderError
from fatigue_planner.core.executors.processes import available_cores

SOLVERS = ("daqp", "qpoases")
REINSTALL = "Install fatplan again: `make install`, or `pip install --force-reinstall` of this package."


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
    """Check this installation (versions, solvers, compiler, HDF5, folders, viewer, browser) by using every part.

    Whatever is missing is named, with what to do about it; the exit code is 3 if nothing can work without it.
    """
    checks: list[Callable[[], Finding]] = [
        _versions, _solvers, _compiler, _hdf5, lambda: _folder("cache", cache), lambda: _folder("results", results),
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
        name = getattr(check, "__name__", "check").strip("_<>")
        return Finding(name, f"{type(error).__name__}: {error}", REINSTALL)


def _versions() -> Finding:
    from fatigue_planner.core.provenance import versions

    return Finding("versions", ", ".join(f"{name} {number}" for name, number in versions().items()))


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

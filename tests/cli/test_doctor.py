"""fatplan doctor finds what is wrong by using it, and says what to do."""

import shutil
from pathlib import Path

import pytest
from commands import fatplan
from conftest import ROOT

from fatigue_planner.human.strength_sets import shipped_sets


def test_a_healthy_machine_is_told_so(tmp_path: Path) -> None:
    done = fatplan("doctor", "--cache", tmp_path / "cache", "--results", tmp_path)
    assert done.returncode == 0, done.stdout
    for what in (
        "versions",
        "solvers: daqp, qpoases",
        "compiler: numba works",
        "HDF5",
        "can be written, to be made",
        "python -m fatigue_planner: fatplan ",
        f"{len(shipped_sets())} strength sets",
        "paper_claims, planners",
    ):
        assert what in done.stdout
    assert "MISSING" not in done.stdout and not (tmp_path / "cache").exists()


def test_what_is_missing_is_named_with_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import casadi
    import h5py

    blocked = tmp_path / "blocked"
    blocked.write_text("a file, not a folder")
    monkeypatch.setattr(casadi, "has_conic", lambda name: name != "daqp")

    def broken(*_: object, **__: object) -> None:
        raise OSError("libhdf5 is gone")

    monkeypatch.setattr(h5py, "File", broken)
    done = fatplan("doctor", "--cache", blocked / "inside", "--results", tmp_path)
    assert done.returncode == 3
    lines = done.stdout.splitlines()
    missing = [line for line in lines if line.startswith("MISSING")]
    assert len(missing) == 3 and "libhdf5 is gone" in done.stdout and "CasADi lacks daqp" in done.stdout
    assert any("folder of the cache" in line for line in missing) and "--cache FOLDER" in done.stdout


def test_what_the_package_lacks_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wheel without experiments, a lost data file, another package of this name, an own file of a shipped name."""
    from fatigue_planner.core import files
    from fatigue_planner.human import strength_sets

    copied = shutil.copytree(strength_sets.STRENGTHS, tmp_path / "strengths")
    (copied / "average_man.yaml").write_text("entries: none")
    monkeypatch.setattr(strength_sets, "STRENGTHS", copied)
    monkeypatch.setattr(files, "PACKAGE", tmp_path / "fatigue_planner")
    other = tmp_path / "other" / "fatigue_planner"
    other.mkdir(parents=True)
    (other / "__init__.py").touch()
    monkeypatch.setenv("PYTHONPATH", str(other.parent))
    done = fatplan("doctor", cwd=tmp_path)
    assert done.returncode == 3
    missing = {line.split(":")[0].removeprefix("MISSING ") for line in done.stdout.splitlines() if "MISSING" in line}
    assert missing == {"python -m fatigue_planner", "data files", "files that ship"}, done.stdout
    assert "average_man.yaml" in done.stdout and "no paper.yaml" in done.stdout and "PYTHONPATH" in done.stdout


def test_a_file_of_the_users_may_hide_one_that_ships(tmp_path: Path) -> None:
    (tmp_path / "workers").write_text("mine")
    done = fatplan("doctor", cwd=tmp_path)
    assert done.returncode == 0 and "own files: workers" in done.stdout


def test_a_broken_file_that_ships_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from fatigue_planner.core import files

    shutil.copytree(ROOT / "experiments", tmp_path / "shipped")
    (tmp_path / "shipped" / "planners.yaml").write_text("name: planners")
    monkeypatch.setattr(files, "PACKAGE", tmp_path)
    done = fatplan("doctor", cwd=tmp_path)
    assert (
        done.returncode == 3
        and "MISSING files that ship" in done.stdout
        and "planners.yaml" in done.stdout
        and "Install fatplan again" in done.stdout
    )


def test_a_library_that_the_system_lacks_is_asked_of_the_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fatigue_planner.human import strength_sets

    def broken() -> tuple[str, ...]:
        raise ImportError("libgomp.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr(strength_sets, "shipped_sets", broken)
    done = fatplan("doctor", cwd=tmp_path)
    assert done.returncode == 3 and "libgomp.so.1: cannot open" in done.stdout and "libgomp1" in done.stdout

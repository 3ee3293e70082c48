"""fatplan doctor finds what is wrong by using it, and says what to do."""

from pathlib import Path

import pytest
from commands import fatplan


def test_a_healthy_machine_is_told_so(tmp_path: Path) -> None:
    done = fatplan("doctor", "--cache", tmp_path / "cache", "--results", tmp_path)
    assert done.returncode == 0, done.stdout
    for what in ("versions", "solvers: daqp, qpoases", "compiler: numba works", "HDF5", "can be written, to be made"):
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

"""With --json a command prints one strict JSON document, whose keys are documented."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import fatplan
from conftest import PAPER, ROOT
from pydantic_core import PydanticSerializationError

from fatigue_planner.cli.options import json_text


def strict(text: str) -> dict[str, Any]:
    """One document and nothing else; NaN and Infinity are no JSON."""
    found: dict[str, Any] = json.loads(text, parse_constant=pytest.fail)
    return found


def documented_keys(command: str) -> list[str]:
    """The keys of a command's document as docs/command-line.md lists them; what is in brackets explains."""
    lines = (ROOT / "docs" / "command-line.md").read_text().splitlines()
    (row,) = [line for line in lines if line.startswith(f"| `{command}` |")]
    while row != (shorter := re.sub(r"\([^()]*\)", "", row)):
        row = shorter
    return re.findall(r"`(\w+)`", row.split("|")[2])


def document(command: str, *arguments: object, code: int = 0) -> dict[str, Any]:
    """What a command prints, with just the documented keys."""
    done = fatplan(*command.split(), *arguments, "--json")
    assert done.returncode == code, done.stderr
    found = strict(done.stdout)
    assert list(found) == documented_keys(command)
    return found


def test_numbers_and_paths_become_strict_json() -> None:
    value = {"a": math.nan, "b": [math.inf, -math.inf], "c": np.float64(0.1), "d": np.int64(3), "e": Path("x")}
    found = strict(json_text(value | {"f": np.bool_(True), "g": None, "h": ("ä", 1, False), "i": np.float64("nan")}))
    assert found == {
        "a": None, "b": ["Infinity", "-Infinity"], "c": 0.1, "d": 3, "e": "x", "f": True, "g": None,
        "h": ["ä", 1, False], "i": None,
    }  # fmt: skip
    with pytest.raises(PydanticSerializationError):
        json_text({"a": object()})


@pytest.mark.slow
def test_simulate(cache_folder: Path, tmp_path: Path) -> None:
    found = document("simulate", PAPER, "--cache", cache_folder)
    assert found["folder"] == str(cache_folder) and (found["found"], found["simulated"], found["failed"]) == (4, 0, 0)
    first = found["reactions"][0]
    assert list(first) == documented_keys("simulate: reactions")
    assert first["name"] == "average_man/high/arm" and len(first["digest"]) == 64 and first["verdict"] == "implausible"
    assert 0 < first["hand_error_m"] < 0.02 and 0.3 < first["largest_load_share"] < 0.8
    far = tmp_path / "far.yaml"
    text = PAPER.read_text().replace("x: 0.5, y: -0.25, z: 1.2", "x: 1.3, y: -0.25, z: 1.2")
    far.write_text(text.replace("time_step_s: 0.01", "time_step_s: 0.02"))
    found = document("simulate", far, "--cache", tmp_path, code=3)
    assert found["failed"] >= 2
    failed = [one for one in found["reactions"] if one["verdict"] == "failed"]
    assert len(failed) == found["failed"] and all(one["failure"] for one in failed)


def test_a_dry_run(cache_folder: Path, tmp_path: Path) -> None:
    grid = ["--cycles", 5, "--conditions", "single_novice", "--trials", 4, "--policies", "greedy"]
    where = ["--cache", cache_folder, "--results", tmp_path]
    found = document("benchmark --dry-run", PAPER, *where, *grid)
    assert (found["cells"], found["runs"], found["decisions_left"]) == (1, 4, 20) and found["n_cycles"] == [5]
    assert found["estimated_s"] > 0


def test_validate(tmp_path: Path) -> None:
    found = document("validate", PAPER)
    assert found["valid"] and found["kind"] == "experiment" and "4 reactions" in found["about"]
    assert document("validate", PAPER.parent / "paper_claims.yaml")["kind"] == "claims"
    bad = tmp_path / "bad.yaml"
    bad.write_text(PAPER.read_text().replace("mass_kg: 75 ", "mass_kg: heavy ").replace("discount:", "discont:"))
    found = document("validate", bad, code=2)
    assert not found["valid"] and len(found["faults"]) == 2
    assert found["faults"][0]["message"].startswith("workers.average_man.mass_kg = 'heavy'")
    assert len(fatplan("validate", bad, "--json").stderr.splitlines()) == 2
    bad.write_text("name: [1")
    found = document("validate", bad, code=2)
    assert found["kind"] is None and "line 1" in found["faults"][0]["message"]


@pytest.mark.slow
def test_cache(cache_folder: Path, tmp_path: Path) -> None:
    where = ["--cache", cache_folder]
    found = document("cache list", *where)
    assert [one["current"] for one in found["reactions"]] == [True] * 4 and found["unreadable"] == []
    assert document("cache verify", *where)["counts"] == {"implausible": 4}
    mine = tmp_path / "mine.yaml"
    mine.write_text(PAPER.read_text().replace("solver: daqp", "solver: qpoases"))
    found = document("cache why", mine, *where)
    assert (found["wanted"], found["found"]) == (4, 0)
    (difference,) = found["missing"][0]["differences"]
    assert difference == {"part": "controller.solver", "wanted": "qpoases", "stored": "daqp"}
    assert document("cache gc", *where)["files"] == []
    bundle = tmp_path / "bundle.zip"
    assert document("cache export", PAPER, bundle, *where)["reactions"] == 4
    found = document("cache import", bundle, "--cache", tmp_path / "c")
    assert (found["taken"], found["refused"]) == (4, 0)


@pytest.mark.slow
def test_doctor_and_human(cache_folder: Path, tmp_path: Path) -> None:
    found = document("doctor", "--cache", tmp_path, "--results", tmp_path)
    assert found["healthy"] and {"solvers", "HDF5"} <= {one["what"] for one in found["findings"]}
    urdf, page = tmp_path / "a.urdf", tmp_path / "a.md"
    found = document("human export", PAPER, "--output", urdf)
    assert found["joints"] == 39 and found["mass_kg"] == pytest.approx(75) and urdf.exists()
    found = document("human report", PAPER, "--cache", cache_folder, "--output", page)
    assert found["outside"] == 8 and Path(found["file"]) == page


@pytest.mark.parametrize(
    ("words", "kind", "code"),
    [
        (["simulate", "none.yaml"], "ExperimentError", 2),
        (["benchmark", PAPER, "--cache", "none"], "MissingReactionsError", 2),
        (["simulate", "--nonsense"], "UsageError", 2),
        (["benchmark", "--trials", "0"], "UsageError", 2),
        (["nonsense"], "UsageError", 2),
    ],
)
def test_an_error_is_a_document_and_a_message(words: list[object], kind: str, code: int, tmp_path: Path) -> None:
    done = fatplan(*words, "--json", cwd=tmp_path)
    assert done.returncode == code
    (error,) = strict(done.stdout).values()
    assert list(error) == ["type", "message", "exit_code"]
    assert (error["type"], error["exit_code"]) == (kind, code) and done.stderr == f"Error: {error['message']}\n"
    assert fatplan(*words, cwd=tmp_path).stdout == ""

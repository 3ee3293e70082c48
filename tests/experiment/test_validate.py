"""Files are checked completely before anything is done, and editors can check them, too."""

import json
from pathlib import Path

import pytest
import yaml
from commands import fatplan, refused
from conftest import PAPER, ROOT

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.file_kinds import FileKind
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.loader import editor_schema, load_experiment
from fatigue_planner.experiment.schema import Experiment


def output_of(*arguments: object) -> str:
    """What a valid command prints."""
    done = fatplan(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", ["paper", "pose_grid", "paper_claims", "sensitivity"])
def test_the_shipped_files_are_valid(name: str) -> None:
    assert ": ok; " in output_of("validate", ROOT / "experiments" / f"{name}.yaml")


def test_all_faults_of_form_are_reported_at_once(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        PAPER.read_text().replace("mass_kg: 75 ", "mass_kg: heavy ").replace("discount: 0.95", "discont: 2")
    )
    lines = refused(2, "validate", file).splitlines()  # with its exit code
    assert len(lines) == 2 and "workers.average_man.mass_kg = 'heavy'" in lines[0] and "did you mean" in lines[1]


def test_all_faults_of_meaning_are_reported_at_once(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    text = PAPER.read_text().replace("lumbar_flexion: 0.5", "lumbago: 0.5").replace("z: 1.2}", "z: 2.9}")
    file.write_text(
        text.replace("right_hip_flexion: 0.5", "right_hop: 0.5").replace("segment: thorax", "segment: neck")
    )
    with pytest.raises(ExperimentError) as caught:
        load_experiment(file)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"{file}: ") for line in lines) and len(lines) == 3
    for piece in ("initial_beliefs.multiple.1", "'lumbago'", "initial_beliefs.multiple.2", "actions.high.right_hand"):
        assert piece in str(caught.value)


def test_claims_and_studies_are_distinguished(tmp_path: Path) -> None:
    claims = tmp_path / "claims.yaml"
    claims.write_text("experiment: paper.yaml\nclaims: {one: {place: here}}\n")
    assert "claims.one.quote: is missing" in refused(2, "validate", claims)
    study = tmp_path / "study.yaml"
    study.write_text("name: mine\nfactors: {}\n")
    assert "base: is missing" in refused(2, "validate", study)
    assert "No such file" in refused(2, "validate", tmp_path / "none.yaml")


def _objects(schema: object) -> list[dict[str, object]]:
    """Every object schema inside a schema."""
    if isinstance(schema, dict):
        own = [schema] if schema.get("type") == "object" and "properties" in schema else []
        return own + [found for value in schema.values() for found in _objects(value)]
    return [found for value in schema for found in _objects(value)] if isinstance(schema, list) else []


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("claims paper", "paper.yaml: is an experiment, not a file of claims; it is for `fatplan simulate`"),
        ("claims sensitivity", "sensitivity.yaml: is a study, not a file of claims; it is for `fatplan sensitivity`"),
        (
            "simulate paper_claims",
            "paper_claims.yaml: is a file of claims, not an experiment; it is for `fatplan claims`",
        ),
        ("benchmark sensitivity", "is a study, not an experiment"),
        ("rotate car_line", "car_line.yaml: is a station, not a line; it is for `fatplan assess` and `schedule`"),
        ("assess trim_line", "trim_line.yaml: is a line, not a station; it is for `fatplan rotate`"),
        ("sensitivity paper", "is an experiment, not a study"),
        ("sensitivity paper_claims", "is a file of claims, not a study"),
    ],
)
def test_a_file_of_another_kind_is_told_in_one_line(command: str, words: str) -> None:
    said = refused(2, *command.split())
    assert words in said and said.count("\n") == 1


def test_keys_of_another_kind_in_an_experiment_are_named(tmp_path: Path) -> None:
    for key in ("factors", "claims", "experiment"):
        (tmp_path / "mine.yaml").write_text(f"{PAPER.read_text()}\n{key}: {{}}\n")
        assert f"{key}: unknown key" in refused(2, "simulate", tmp_path / "mine.yaml")


def test_the_schema_knows_every_key_of_the_shipped_experiments() -> None:
    found = editor_schema(Experiment)
    assert all(kind["additionalProperties"] is False for kind in _objects(found))
    known = {key for kind in _objects(found) for key in kind["properties"]}  # type: ignore[attr-defined]
    content = read_yaml(PAPER, ExperimentError)
    assert set(content) <= set(found["properties"]) and set(found["required"]) <= set(content)
    assert set(content["controller"]) | set(content["cycle"]) | set(content["fatigue"]) <= known
    axis = found["$defs"]["Position"]["properties"]["z"]["anyOf"]
    assert axis[0]["maximum"] == 3 and axis[1] == {"$ref": "#/$defs/Range"}
    assert set(found["$defs"]["Range"]["properties"]) == {"from", "to", "count"}


@pytest.mark.parametrize("kind", list(FileKind))
def test_schemas_are_printed_as_json(kind: str) -> None:
    printed = json.loads(output_of("schema", kind))
    assert printed["$schema"].endswith("2020-12/schema") and printed["type"] == "object"


@pytest.mark.slow
def test_a_dry_run_counts_and_writes_nothing(cache_folder: Path, tmp_path: Path) -> None:
    grid = ["--cycles", 5, "--conditions", "single_novice", "--trials", 4, "--policies", "greedy"]
    where = ["--cache", cache_folder, "--results", tmp_path / "r"]
    first = output_of("benchmark", PAPER, *where, *grid, "--dry-run")
    assert "1 cell, 4 runs, 20 decisions, 20 of them not in" in " ".join(first.split())
    assert not (tmp_path / "r").exists()
    assert fatplan("benchmark", PAPER, *where, *grid).returncode == 0
    again = output_of("benchmark", PAPER, *where, *grid, "--dry-run")
    assert "20 decisions, 0 of them not in" in " ".join(again.split())


def test_a_range_of_a_grid_is_valid_where_the_schema_says_so(tmp_path: Path) -> None:
    content = yaml.safe_load(PAPER.read_text())
    content["actions"]["high"]["right_hand"]["position_m"]["z"] = {"from": 1.0, "to": 1.2, "count": 3}
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(content))
    assert "8 reactions" in output_of("validate", file)

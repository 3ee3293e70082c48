"""Loading a study file, with one clear message if it is wrong."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fatigue_planner.core.errors import ExperimentError, listed, shortened
from fatigue_planner.core.file_kinds import FileKind, mapping_of_kind
from fatigue_planner.core.files import find_shipped
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import error_message
from fatigue_planner.experiment.loader import complete_content, parse_experiment, read_content
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.study.claims.loader import Claims, load_claims
from fatigue_planner.study.sensitivity.factors import Level
from fatigue_planner.study.sensitivity.keys import KeyPath, find, overlap, value_at, with_value
from fatigue_planner.study.sensitivity.settings import StudySettings

# Keys that must be the same at all points, so that their results can be compared, or that are not part of a point.
FIXED = ("name", "figures", "statistics", "benchmark.n_cycles", "benchmark.trials", "benchmark.seed")
MIN_TRIALS = 2
MAX_REACTIONS = 500


@dataclass(frozen=True)
class Study:
    """A study whose factors are known to fit its base experiment.

    content: the base experiment's file with the grid of the study; base: the experiment it describes; paths: of the
    keys that factors change; base_values: the base experiment's values of these keys; claims: about the base
    experiment.
    """

    settings: StudySettings
    base_file: Path
    content: Mapping[str, Any]
    base: Experiment
    claims: Claims | None
    paths: Mapping[str, KeyPath]
    base_values: Mapping[str, Any]

    def base_levels(self) -> dict[str, Level]:
        """The base experiment's own level of every factor."""
        return {name: factor.base_level(self.base_values) for name, factor in self.settings.factors.items()}

    def changed(self, levels: Mapping[str, Level]) -> dict[str, Any]:
        """The content with some factors at other levels."""
        content = dict(self.content)
        for name, level in levels.items():
            for key, value in self.settings.factors[name].changes(level, self.base_values).items():
                content = with_value(content, self.paths[key], value)
        return content


def load_study(path: Path) -> Study:
    """The study of a file, checked completely.

    Raises ExperimentError naming file, factor, key, value and what is allowed; a level outside the limits of the
    experiment's schema is found here, before anything is run.
    """
    path = find_shipped(path)
    settings = _read_settings(path)
    base_file = path.parent / settings.base
    try:
        base_content = complete_content(parse_experiment(read_content(base_file), str(base_file)))
        content = _with_grid(base_content, settings)
    except ExperimentError as error:
        raise ExperimentError(f"{path}: {error}") from error
    base = parse_experiment(content, f"{path}: the grid on {base_file}")
    if (reactions := len(base.workers) * len(base.actions) * len(base.preferences)) > MAX_REACTIONS:
        raise ExperimentError(
            f"{path}: base = {settings.base!r}: has {reactions} reactions, which may all change from point to point; "
            f"at most {MAX_REACTIONS} are allowed."
        )
    _check_names(path, settings, base)
    plain = base.plain()
    paths: dict[str, KeyPath] = {}
    owners: dict[KeyPath, str] = {}
    for name, factor in settings.factors.items():
        for key in factor.changed_keys():
            where = f"{path}: factors.{name}"
            try:
                found = find(plain, key)
            except ExperimentError as error:
                raise ExperimentError(f"{where}: {error}") from error
            if any(overlap(found, find(plain, fixed)) for fixed in FIXED):
                raise ExperimentError(f"{where}: {key}: must be the same at all points.")
            for other, owner in owners.items():
                if overlap(found, other):
                    raise ExperimentError(f"{where}: {key}: is already changed by factor {owner!r}.")
            owners[found] = name
            paths[key] = found
    values = {key: value_at(plain, at) for key, at in paths.items()}
    study = Study(settings, base_file, content, base, _read_claims(path, settings), paths, values)
    _check_levels(path, study)
    return study


def _read_claims(path: Path, settings: StudySettings) -> Claims | None:
    if settings.claims is None:
        return None
    claims = load_claims(path.parent / settings.claims)
    if claims.experiment_file.resolve() != (path.parent / settings.base).resolve():
        raise ExperimentError(
            f"{path}: claims = {settings.claims!r}: are about {claims.experiment_file}, not the base."
        )
    return claims


def _read_settings(path: Path) -> StudySettings:
    content = mapping_of_kind(path, read_yaml(path, ExperimentError), FileKind.STUDY, ExperimentError)
    try:
        return StudySettings.model_validate(content, strict=True)
    except ValidationError as error:
        raise ExperimentError(error_message(error, StudySettings, str(path))) from error


def _with_grid(content: Mapping[str, Any], settings: StudySettings) -> dict[str, Any]:
    """The base experiment's content with the study's name and grid, without figures and families of the old grid."""
    grid = settings.grid
    if content["name"] == settings.name:
        raise ExperimentError(f"name = {settings.name!r}: is the base experiment's; their results would be mixed.")
    benchmark = content["benchmark"]
    changes: dict[str, Any] = {}
    for key in ("conditions", "policies"):
        named, known = getattr(grid, key), benchmark[key]
        if named is not None:
            _check_known(f"grid.{key}", named, known)
            changes[key] = {name: known[name] for name in known if name in named}
    policies = changes.get("policies", benchmark["policies"])
    if grid.further_policies:
        further = {name: policy.model_dump() for name, policy in grid.further_policies.items()}
        if taken := [name for name in further if name in benchmark["policies"]]:
            raise ExperimentError(f"grid.further_policies.{taken[0]}: the base experiment has a policy of this name.")
        changes["policies"] = {**policies, **further}
    changes |= {key: getattr(grid, key) for key in ("n_cycles", "trials") if getattr(grid, key) is not None}
    return {
        **content,
        "name": settings.name,
        "benchmark": {**benchmark, **changes},
        "statistics": {key: value for key, value in content["statistics"].items() if key != "families"},
        "figures": {},
    }


def _check_names(path: Path, settings: StudySettings, base: Experiment) -> None:
    grid = base.benchmark
    headline = settings.headline
    try:
        _check_known("planners", settings.planners, grid.policies)
        _check_known("baselines", settings.baselines, grid.policies)
        _check_known("headline.planner", [headline.planner], settings.planners)
        _check_known("headline.condition", [headline.condition], grid.conditions)
        _check_known("headline.n_cycles", [headline.n_cycles], grid.n_cycles)
        if grid.trials < MIN_TRIALS:
            raise ExperimentError(f"grid.trials = {grid.trials}: intervals need at least {MIN_TRIALS}.")
        if both := [name for name in settings.planners if name in settings.baselines]:
            raise ExperimentError(f"baselines: {both[0]!r} is also among the planners.")
    except ExperimentError as error:
        raise ExperimentError(f"{path}: {error}") from error


def _check_known(key: str, named: Any, known: Any) -> None:
    unknown = [name for name in named if name not in known]
    if unknown:
        raise ExperimentError(f"{key}: {listed(unknown)}; known are {listed(known)}.")
    if len(set(named)) < len(named):
        raise ExperimentError(f"{key}: {listed(named)}: a name is given twice.")


def _check_levels(path: Path, study: Study) -> None:
    """Check that the schema allows every level of every factor, and that the levels differ."""
    for name, factor in study.settings.factors.items():
        where = f"{path}: factors.{name}"
        try:
            factor.base_level(study.base_values)
        except ExperimentError as error:
            raise ExperimentError(f"{where}.{error}") from error
        contents = {level: study.changed({name: level}) for level in factor.all_levels()}
        if len(contents) < len(factor.all_levels()):
            raise ExperimentError(f"{where}: its levels {listed(factor.all_levels())} are not all different.")
        for (level, content), (other, other_content) in itertools.combinations(contents.items(), 2):
            if content == other_content:
                raise ExperimentError(f"{where}: its levels {shortened(level)} and {shortened(other)} are the same.")
        for level, content in contents.items():
            parse_experiment(content, f"{where} at {shortened(level)}")

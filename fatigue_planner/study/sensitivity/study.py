"""Loading a study file, with one clear message if it is wrong."""

import difflib
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import ExperimentError, listed, shortened
from fatigue_planner.core.file_kinds import FileKind
from fatigue_planner.core.files import file_named_in, find_shipped
from fatigue_planner.experiment.loader import (
    complete_content,
    parse_experiment,
    parse_settings,
    read_content,
    read_mapping,
)
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.study.claims.loader import Claims, load_claims
from fatigue_planner.study.sensitivity.factors import Level
from fatigue_planner.study.sensitivity.settings import StudySettings

# Names along a dotted path into the settings of an experiment, e.g. `benchmark.policies.pomcp_0.1.descents`.
KeyPath = tuple[str, ...]
# Keys that must be the same at all points, so that their results can be compared, or that are not part of a point.
FIXED = ("name", "figures", "statistics", "benchmark.n_cycles", "benchmark.trials", "benchmark.seed")
# Keys of the base experiment's statistics that are about its own grid.
OF_ITS_GRID = ("policies", "families")
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
    settings = parse_settings(
        StudySettings, read_mapping(path, FileKind.STUDY, ExperimentError), str(path), ExperimentError
    )
    base_file = file_named_in(path, "base", settings.base)
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
    claims = load_claims(file_named_in(path, "claims", settings.claims))
    if claims.experiment_file.resolve() != file_named_in(path, "base", settings.base).resolve():
        raise ExperimentError(
            f"{path}: claims = {settings.claims!r}: are about {claims.experiment_file}, not the base."
        )
    return claims


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
        "statistics": {key: value for key, value in content["statistics"].items() if key not in OF_ITS_GRID},
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


def find(settings: Mapping[str, Any], key: str) -> KeyPath:
    """The names along a dotted path; names may contain dots, so they are matched with the known ones.

    Raises ExperimentError, with a suggestion, if there is no such setting.
    """
    node: Any = settings
    path: KeyPath = ()
    rest = key
    while rest:
        known = [name for name in node if rest == name or rest.startswith(f"{name}.")] if isinstance(node, dict) else []
        if not known:
            raise ExperimentError(f"{key}: unknown key{_suggestion(node, path, rest)}")
        name = max(known, key=len)
        path, node, rest = (*path, name), node[name], rest[len(name) + 1 :]
    return path


def value_at(settings: Mapping[str, Any], path: KeyPath) -> Any:
    """The setting at a path."""
    node: Any = settings
    for name in path:
        node = node[name]
    return node


def with_value(content: Mapping[str, Any], path: KeyPath, value: Any) -> dict[str, Any]:
    """A copy of the content with another value at a path; mappings that it lacks are added."""
    name, *rest = path
    return {**content, name: with_value(content.get(name) or {}, tuple(rest), value) if rest else value}


def overlap(first: KeyPath, second: KeyPath) -> bool:
    """Whether the paths are equal or one is above the other."""
    shorter = min(len(first), len(second))
    return first[:shorter] == second[:shorter]


def _suggestion(node: Any, path: KeyPath, rest: str) -> str:
    where = ".".join(path) or "the experiment"
    if not isinstance(node, dict):
        return f"; {where} has no settings of its own."
    close = difflib.get_close_matches(rest.split(".", maxsplit=1)[0], node, n=1)
    if close:
        return f"; did you mean {'.'.join([*path, close[0]])!r}?"
    return f"; {where} has {listed(node)}."

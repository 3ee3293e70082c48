"""What is kept is found again exactly as long as nothing that decides it has changed: settings, sources, libraries."""

import ast
import copy
import fnmatch
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import PAPER, ROOT
from deciding_settings import EXPERIMENT, LEAVES, RULES, Content, Rule, changed, parsed
from forgotten_plugins import forgotten_plugins
from numpy.typing import NDArray
from settings_leaves import Leaf, leaves, schema_leaves

from fatigue_planner.core import files
from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.core.files import PACKAGE, digest_of, digests_of_package
from fatigue_planner.core.plugins import load_plugin
from fatigue_planner.experiment import build
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile, TickProfile
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.reactions import key as reaction_key
from fatigue_planner.reactions.reaction import Reaction, ReactionName, ReactionRequest
from fatigue_planner.robot.reach import Cell, PoseReach
from fatigue_planner.station import kept_shares
from fatigue_planner.study.benchmark import bounds, cell, regret
from fatigue_planner.study.benchmark.bounds import bound_jobs
from fatigue_planner.study.benchmark.regret import RegretJob
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.selection import cells, references

SECTIONS = list(Experiment.model_fields)
LONG = (  # with many settings, or with settings that are long to try
    "benchmark", "preferences", "actions", "fatigue", "controller", "workers", "cost", "hidden_workers", "robot",
    "statistics", "recording_accuracy",
)  # fmt: skip


@dataclass(frozen=True)
class Keys:
    """The keys of all that is kept, by what it is of."""

    reactions: dict[tuple[str, ...], str]
    cells: dict[tuple[str, int, str], str]
    regrets: dict[tuple[str, int, str], str]
    bounds: dict[tuple[str, int], str]


@pytest.fixture(scope="module")
def moved(reactions: tuple[Reaction, ...]) -> tuple[Reaction, ...]:
    """A motion for every name of the experiment: the paper's four in turn."""
    names = [request.name for request in reaction_requests(parsed(EXPERIMENT))]
    return tuple(replace(reactions[index % len(reactions)], name=name) for index, name in enumerate(names))


@pytest.fixture(scope="module")
def keys_of(moved: tuple[Reaction, ...]) -> Iterator[Callable[[Content], Keys]]:
    """The keys of an experiment's content, were its motions still the same; what equals is computed once."""
    known: dict[str, dict[ReactionName, CycleProfile]] = {}
    poses: dict[tuple[str, bytes, bytes, bytes], PoseReach] = {}
    maps: dict[tuple[int | bytes, ...], tuple[CycleProfile, tuple[NDArray[np.float64], NDArray[np.float64]]]] = {}
    reach, cycle_maps = Cell.reach, TickProfile.maps

    def reach_once(cell: Cell, target: NDArray[np.float64], worker: tuple[NDArray[np.float64], ...]) -> PoseReach:
        key = (cell.settings.model_dump_json(), target.tobytes(), worker[0].tobytes(), worker[1].tobytes())
        if key not in poses:
            poses[key] = reach(cell, target, (worker[0], worker[1]))
        return poses[key]

    def maps_once(profile: TickProfile, *rates: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        key = (id(profile), *(np.asarray(factor).tobytes() for factor in rates))
        if key not in maps:
            maps[key] = (profile, cycle_maps(profile, *rates))  # with the profile, whose number no other gets so
        return maps[key][1]

    def keys(content: Content) -> Keys:
        experiment = parsed(content)
        what_tires = digest_of(
            [
                experiment.fatigue.plain(),
                experiment.cost.plain(),
                experiment.robot and experiment.robot.plain(),
                [worker.strength for worker in experiment.workers.values()],
            ]
        )
        if what_tires not in known:
            known[what_tires] = cycle_profiles(experiment, moved)
        all_cells = cells(experiment, known[what_tires])
        judges = references(experiment, all_cells)
        named = {(cell.condition, cell.n_cycles, cell.policy): cell for cell in all_cells}
        return Keys(
            {tuple(request.name): request.digest for request in reaction_requests(experiment)},
            {name: cell.digest() for name, cell in named.items()},
            {name: RegretJob(cell, judges[name[0]], {}).digest() for name, cell in named.items()},
            {(job.condition, job.n_cycles): job.digest() for job in bound_jobs(all_cells)},
        )

    with pytest.MonkeyPatch.context() as patch, forgotten_plugins():
        load_plugin(ROOT / "tests" / "support" / "agents.py")
        patch.setattr(build, "maximum_torque", cache(build.maximum_torque))
        patch.setattr(Cell, "reach", reach_once)
        patch.setattr(TickProfile, "maps", maps_once)
        yield keys


@pytest.fixture(scope="module")
def base(keys_of: Callable[[Content], Keys]) -> Keys:
    """The keys of the experiment as it is."""
    return keys_of(EXPERIMENT)


def rule_of(leaf: Leaf) -> Rule:
    found = [rule for rule in RULES for name in rule.names if fnmatch.fnmatchcase(leaf.name, _pattern(name))]
    assert len(found) == 1, f"{leaf.name}: {len(found)} rules"
    return found[0]


def _pattern(name: str) -> str:
    return name.replace("[", "[[]")


def _leaves() -> list[Leaf]:
    """All that the paper's experiment has, and of what it has not the last of every name."""
    papers = {leaf.path for leaf in leaves(load_experiment(PAPER), Experiment)}
    last = {leaf.name: leaf for leaf in LEAVES}.values()
    return [leaf for leaf in LEAVES if leaf.path in papers or leaf in last]


EVERY_LEAF = _leaves()


@cache
def change_of(leaf: Leaf) -> Content | None:
    return changed(leaf)


def test_every_setting_there_is_has_a_rule_and_is_changed() -> None:
    # the other kinds of belief and law are what these kinds are changed to
    others = {"belief.<exact>.kind", "fatigue.law.<ma>.kind"}
    assert {leaf.name for leaf in EVERY_LEAF} | others == schema_leaves(Experiment)
    assert {rule_of(leaf).why for leaf in EVERY_LEAF} == {rule.why for rule in RULES}
    unchanged = {leaf.path for leaf in EVERY_LEAF if change_of(leaf) is None}
    assert unchanged == {("initial_beliefs", "single", 0, "probability"), ("benchmark", "reference", "kind")}
    paper = load_experiment(PAPER)
    missing = {leaf.path for leaf in leaves(paper, Experiment)} - {leaf.path for leaf in EVERY_LEAF}
    too = set(paper.benchmark.policies) - set(paper.statistics.policies or ())  # kinds that are there with more keys
    missing = {path for path in missing if not too & set(path) and path[:2] != ("statistics", "policies")}
    assert missing == {("benchmark", "n_cycles", 2)}  # one length of three, which would be as the others


@pytest.mark.parametrize("section", [pytest.param(s, marks=pytest.mark.slow) if s in LONG else s for s in SECTIONS])
def test_a_setting_changes_the_keys_of_what_it_decides_and_no_other(
    section: str, base: Keys, keys_of: Callable[[Content], Keys]
) -> None:
    for leaf in EVERY_LEAF:
        content = change_of(leaf) if leaf.path[0] == section else None
        if content is None:
            continue
        rule, now = rule_of(leaf), keys_of(content)
        expected = (
            {name for name in base.reactions if rule.reactions(leaf, name)},
            {name for name in base.cells if rule.cells(leaf, name[0], name[2])},
            {name for name in base.regrets if rule.regret or rule.cells(leaf, name[0], name[2])},
            {name for name in base.bounds if rule.bounds(leaf, name[0])},
        )
        found = tuple(
            {name for name, key in before.items() if name in after and after[name] != key}
            for before, after in zip(vars(base).values(), vars(now).values(), strict=True)
        )
        assert found == expected, leaf.path


def test_names_order_and_spelling_decide_only_where_they_are_used(
    base: Keys, keys_of: Callable[[Content], Keys]
) -> None:
    """Streams of chance go by the names of conditions and policies; all other names are for people."""
    renamed = json.loads(json.dumps(EXPERIMENT).replace("tired_woman", "t_w"))
    now = keys_of(renamed)
    assert {name for name in base.cells if name not in now.cells} == {n for n in base.cells if n[0] == "tired_woman"}
    assert now.reactions == base.reactions and not set(base.cells.values()) & {
        key for name, key in now.cells.items() if name[0] == "t_w"
    }
    assert now.bounds["t_w", 5] == base.bounds["tired_woman", 5]
    for old in ("unknown_0", "multiple"):
        other = keys_of(json.loads(json.dumps(EXPERIMENT).replace(f'"{old}"', '"renamed"')))
        assert list(other.reactions.values()) == list(base.reactions.values())
        assert (other.cells == base.cells) is (old == "multiple")  # a condition is called unknown_0, too
    spelt = copy.deepcopy(EXPERIMENT)
    spelt["tool"] = dict(reversed(spelt["tool"].items()))
    spelt["cycle"]["return_hand"] = "free"  # what it is when left out
    assert keys_of(spelt) == base


def test_a_strength_set_counts_by_its_values_not_by_its_name(
    base: Keys, keys_of: Callable[[Content], Keys], tmp_path: Path
) -> None:
    content = copy.deepcopy(EXPERIMENT)
    for values, same in (("", True), ("  neck_flexion: {positive: 1.0, source: none}\n", False)):
        rows = f"degrees_of_freedom:\n{values}" if values else "degrees_of_freedom: {}\n"
        path = tmp_path / f"{same}.yaml"
        path.write_text(f"population: mine\nbased_on: average_man\n{rows}")
        content["workers"]["average_man"]["strength"] = str(path)
        now = keys_of(content)
        assert (now.reactions == base.reactions) is same


def test_keys_know_nothing_of_folder_time_and_environment(tmp_path: Path) -> None:
    program = (
        "import sys\n"
        f"sys.path[:0] = {[str(ROOT / 'tests' / part) for part in ('', 'support')]!r}\n"
        "from deciding_settings import parsed, EXPERIMENT\n"
        "from fatigue_planner.experiment.build import reaction_requests\n"
        "experiment = parsed(EXPERIMENT)\n"
        "print([request.digest for request in reaction_requests(experiment)])\n"
        "from fatigue_planner.core.files import digest_of_package\n"
        "from fatigue_planner.study.benchmark.cell import SOURCES, NUMERICAL_LIBRARIES\n"
        "from fatigue_planner.core.provenance import versions_of\n"
        "print(digest_of_package(*SOURCES), versions_of(*NUMERICAL_LIBRARIES))\n"
    )
    printed = set()
    for number, (zone, seed, language) in enumerate((("UTC", "1", "C"), ("Asia/Tokyo", "2", "C.UTF-8"))):
        folder = tmp_path / str(number)
        folder.mkdir()
        environment = os.environ | {
            "TZ": zone, "PYTHONHASHSEED": seed, "LC_ALL": language, "USER": f"u{number}", "HOSTNAME": f"h{number}",
        }  # fmt: skip
        command = [sys.executable, "-c", program]
        printed.add(subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True).stdout)
    assert len(printed) == 1


# --- sources ---------------------------------------------------------------------------------------------------

# What a key needs not know of: in reach of the code that makes the numbers, but without a part in them.
WITHOUT_A_PART = {
    "core/errors.py": "messages",
    "core/files.py": "makes files and keys; were its JSON another one, so would be every key",
    "core/plugins.py": "what a plug-in decides is in the keys by its own source",
    "core/provenance.py": "looks up the versions that are in the keys",
}
# The same where no body data are read: only names of joints and types of settings, whose values are in the key.
ONLY_NAMES = {
    "study/benchmark/job.py": "what a job is, no number",
    "core/settings.py": "the settings' values are in the key",
    "core/yaml_reader.py": "nothing is read there",
}  # fmt: skip
# In the folders of what matters, out of reach: a new file there is one file too many rather than one too few.
TOO_MUCH = {
    "human/urdf.py", "human/worker_tables.py", "human/population.py", "human/data/populations.yaml",
    "human/data/strength_spread.yaml",  # what a set's percentile is; the torques are in the key
    "pomdp/cycles.py", "pomdp/beliefs/moments.py",
    *(path.relative_to(PACKAGE).as_posix() for path in (PACKAGE / "planners/bounds").glob("[a-z]*.py")),
    # a choice model's log-odds are in the key
    *(path.relative_to(PACKAGE).as_posix() for path in (PACKAGE / "pomdp/choices").glob("[a-z]*.py")),
    *(f"human/{path.relative_to(PACKAGE / 'human')}" for path in (PACKAGE / "human/data/strengths").glob("*.yaml")),
    # laws, rates and loads make profiles, which are in the key; a profile brings the code of its law with it
    *(
        path.relative_to(PACKAGE).as_posix()
        for path in (PACKAGE / "fatigue").rglob("*.*")
        if path.suffix in (".py", ".yaml") and path.name not in ("model.py", "__init__.py")
    ),
}  # fmt: skip
# What the code reads besides modules.
BODY_DATA = {
    f"human/data/{name}.yaml"
    for name in ("capsules", "geometry/natural", "geometry/paper", "passive_moments", "ranges_of_motion", "segments")
}


def imported(path: Path) -> set[str]:
    """The modules that a file imports, anywhere but for the type checker."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            node.body = []
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


def in_reach(*modules: str) -> tuple[set[str], set[str]]:
    """Files of the package, and libraries, that modules import, and what those import."""
    seen: set[Path] = set()
    libraries: set[str] = set()
    ahead = [f"fatigue_planner.{module}" for module in modules]
    while ahead:
        name = ahead.pop()
        if name.split(".")[0] != "fatigue_planner":
            libraries.add(name.split(".")[0])
            continue
        parts = name.split(".")[1:]
        found = [PACKAGE.joinpath(*parts[:count], "__init__.py") for count in range(len(parts) + 1)]
        found += [PACKAGE.joinpath(*parts).with_suffix(".py")] if parts else []
        for path in found:
            if path.is_file() and path not in seen:
                seen.add(path)
                ahead += imported(path)
    files = {path.relative_to(PACKAGE).as_posix() for path in seen if path.name != "__init__.py"}
    return files, libraries - sys.stdlib_module_names


# What is kept -> the modules that make it, the sources in its key, what of the reach has no part in it.
MAKERS = {
    "reactions": (
        ("motion.simulator", "motion.verification", "motion.causes"), reaction_key.SOURCES, WITHOUT_A_PART, BODY_DATA,
    ),
    "cells": (("study.benchmark.cell", "planners.registry"), cell.SOURCES, WITHOUT_A_PART | ONLY_NAMES, set()),
    "regret": (
        ("study.benchmark.regret", "planners.registry"), (*cell.SOURCES, *regret.REGRET_SOURCES),
        WITHOUT_A_PART | ONLY_NAMES, set(),
    ),
    "bounds": (("planners.bounds.cost_bound",), bounds.SOURCES, WITHOUT_A_PART | ONLY_NAMES, set()),
}  # fmt: skip


@pytest.mark.parametrize("kind", MAKERS)
def test_a_file_is_in_the_key_if_what_makes_the_numbers_can_reach_it(kind: str) -> None:
    modules, sources, without, data = MAKERS[kind]
    reached, _ = in_reach(*modules)
    keyed = set(digests_of_package(*sources))
    assert reached - keyed <= set(without), "in reach, not in the key"
    assert data <= keyed
    assert keyed - reached - data <= TOO_MUCH


def test_what_finds_who_of_a_population_reaches_a_place_is_in_its_key() -> None:
    """But for what an experiment's file may say of planning, of which a station says nothing."""
    reached, _ = in_reach("station.population_reach")
    without = reached - set(digests_of_package(*kept_shares.SOURCES))
    assert {file.partition("/")[0] for file in without} == {"planners", "pomdp", "robot"}


def test_a_room_says_what_it_is_and_no_more() -> None:
    """So that no key needs to know of `__init__.py`; the package's own has the public names and the version.

    Matplotlib has to be imported before any figure, whatever it finds around it; figures decide no number.
    """
    for path in PACKAGE.rglob("*/__init__.py"):
        if path.parent not in (PACKAGE, PACKAGE / "output"):
            assert [type(node) for node in ast.parse(path.read_text()).body] == [ast.Expr], path
            assert 1 <= len(path.read_text().splitlines()) <= 3, path


def test_nothing_is_excused_that_needs_no_excuse() -> None:
    gaps, surplus = set(), set()
    for modules, sources, _, data in MAKERS.values():
        reached, _ = in_reach(*modules)
        keyed = set(digests_of_package(*sources))
        gaps |= reached - keyed
        surplus |= keyed - reached - data
    assert gaps == {*WITHOUT_A_PART, *ONLY_NAMES} and surplus >= TOO_MUCH


def test_every_change_of_a_source_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in [*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.yaml")]:
        copied = tmp_path / path.relative_to(PACKAGE)
        copied.parent.mkdir(parents=True, exist_ok=True)
        copied.write_bytes(path.read_bytes() + b"\n# changed\n")
    before = {kind: digests_of_package(*sources) for kind, (_, sources, _, _) in MAKERS.items()}
    with monkeypatch.context() as patched:
        patched.setattr(files, "PACKAGE", tmp_path)
        digests_of_package.cache_clear()
        after = {kind: digests_of_package(*sources) for kind, (_, sources, _, _) in MAKERS.items()}
    digests_of_package.cache_clear()
    for kind, now in after.items():
        assert now.keys() == before[kind].keys() and len(now) > 5
        assert not set(now.values()) & set(before[kind].values())


# Names under which libraries are imported and those under which they are installed.
DISTRIBUTIONS = {"pinocchio": "pin"}
# Libraries that read and check, and decide no number.
NO_NUMBERS = {"pydantic", "pydantic_core", "yaml", "pandas"}


@pytest.mark.parametrize(
    ("kind", "named"),
    [
        ("reactions", reaction_key.NUMERICAL_LIBRARIES), ("cells", cell.NUMERICAL_LIBRARIES),
        ("regret", cell.NUMERICAL_LIBRARIES), ("bounds", bounds.NUMERICAL_LIBRARIES),
    ],
)  # fmt: skip
def test_the_numerical_libraries_in_reach_are_in_the_key(kind: str, named: tuple[str, ...]) -> None:
    _, libraries = in_reach(*MAKERS[kind][0])
    assert {DISTRIBUTIONS.get(name, name) for name in libraries - NO_NUMBERS} == set(named)


# --- does it matter indeed? --------------------------------------------------------------------------------------

# Settings that decide a motion in general, but not this one, which comes near none of these limits.
OFTEN_WITHOUT_EFFECT = (
    "controller.torque_limit_factor", "controller.friction_coefficient",
    "controller.velocity_limit_radps", "controller.acceleration_limit_radps2",
)  # fmt: skip


TORQUES: dict[str, NDArray[np.float64] | None] = {}


def torques(request: ReactionRequest) -> NDArray[np.float64] | None:
    """The joint torques of a motion, None where it cannot be performed."""
    if request.digest not in TORQUES:
        try:
            TORQUES[request.digest] = simulate(request.motion).torque_nm
        except FailedMotionError:
            TORQUES[request.digest] = None
    return TORQUES[request.digest]


@pytest.mark.slow
@pytest.mark.parametrize("section", SECTIONS)
def test_a_setting_of_the_motion_changes_a_motion_indeed(section: str) -> None:
    first = {request.name: request for request in reaction_requests(parsed(EXPERIMENT))}
    tried = 0
    for leaf in EVERY_LEAF:
        content = change_of(leaf) if leaf.path[0] == section else None
        if content is None:
            continue
        rule = rule_of(leaf)
        free = any(fnmatch.fnmatchcase(leaf.name, name) for name in OFTEN_WITHOUT_EFFECT)
        requests = {request.name: request for request in reaction_requests(parsed(content))}
        simulated = [name for name in first if not (first[name].recorded or requests[name].recorded)]
        decided = [name for name in simulated if rule.reactions(leaf, name)]
        for name in decided[:2] if free else decided:
            before = torques(first[name])
            if before is None:  # cannot be performed
                continue
            tried += 1
            after = torques(requests[name])
            if after is None or after.shape != before.shape or not np.array_equal(after, before):
                break
        else:
            assert free or not decided, leaf.path
    assert tried or section not in ("workers", "tool", "cycle", "actions", "preferences", "controller")


@pytest.mark.slow
def test_what_decides_nothing_changes_nothing(moved: tuple[Reaction, ...], tmp_path: Path) -> None:
    """The same runs, in the same files, to the byte but for times, whatever is said of names, statistics, accuracy."""
    content = copy.deepcopy(EXPERIMENT)
    content["benchmark"]["policies"] = {name: content["benchmark"]["policies"][name] for name in ("random", "greedy")}
    content["benchmark"] |= {"trials": 3, "n_cycles": [5]}
    del content["statistics"]["families"]
    other = copy.deepcopy(content)
    other["name"] = "other"
    other["accuracy"]["hand_error_m"] = 0.5
    other["statistics"]["significance_level"] = 0.01
    other["figures"] = {}
    found = []
    for number, settings in enumerate((content, other)):
        experiment = parsed(settings)
        grid_cells = cells(experiment, cycle_profiles(experiment, moved))
        results, _ = run_grid(grid_cells, tmp_path / str(number), LocalProcesses(1), lambda job, n: None)
        outcomes = [result for done in results for result in done.values()]
        found.append((outcomes, sorted(path.parent.name for path in (tmp_path / str(number)).rglob("*.json"))))
    assert found[0] == found[1]

"""The reaction cache: published whole, checked on reading, found again, made anew only where it matters."""

import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import PAPER, Machine
from foreign import keep

from fatigue_planner.core.errors import DamagedFileError, MissingReactionsError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import load_reactions, reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.motion import Phase
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions.archive import export_archive, import_archive
from fatigue_planner.reactions.cache import Outcome, ReactionCache
from fatigue_planner.reactions.hdf5_layout import ARRAYS, entry_bytes, read_entry, with_checksum
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import FailedReaction, Reaction
from fatigue_planner.reactions.verify import verify_entry


@pytest.fixture
def brief(paper: Experiment) -> Experiment:
    """The paper's experiment with one quick action and preference."""
    return paper.model_copy(
        update={
            "cycle": Cycle(reach_s=1.0, work_s=0.2, return_s=1.0),
            "actions": {"high": paper.actions["high"]},
            "preferences": {"arm": paper.preferences["arm"]},
            "accuracy": paper.accuracy.model_copy(update={"hand_error_m": 0.05}),
        }
    )


def complete(experiment: Experiment, folder: Path) -> tuple[ReactionCache, list[Outcome]]:
    cache = ReactionCache(folder)
    return cache, cache.complete(reaction_requests(experiment), LocalProcesses(1), lambda _: None)


def other_key(reaction: Reaction, **settings: object) -> ReactionKey:
    return replace(reaction.key, settings={**reaction.key.settings, **settings})


def test_an_entry_describes_itself(cache_folder: Path) -> None:
    assert len(list(cache_folder.glob("*.h5"))) == 4
    with h5py.File(next(cache_folder.glob("average_man-high-arm-*.h5"))) as file:
        assert file["format"][()] == b"fatplan reaction" and file["format_version"][()] == 5
        assert file["name"][()].tolist() == [b"average_man", b"high", b"arm"]
        assert [name.decode() for name in file["phases"]] == ["reach", "work", "return"]
        assert file["torque_nm"].attrs["columns"].split(", ") == list(DEGREES_OF_FREEDOM)
        for name in ARRAYS:
            assert file[name].attrs["units"] and file[name].attrs["columns"] and file[name].fletcher32


def test_a_reaction_comes_back_as_it_was(reactions: tuple[Reaction, ...]) -> None:
    written = reactions[0]
    read = read_entry(entry_bytes(written), "here")
    assert (written.name, written.key, written.quality) == (read.name, read.key, read.quality)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(written.motion, name), getattr(read.motion, name))
    assert entry_bytes(read) == entry_bytes(written)


def test_a_second_run_finds_everything(brief: Experiment, tmp_path: Path) -> None:
    cache, first = complete(brief, tmp_path)
    (path,) = cache.files()
    before = path.read_bytes(), path.stat().st_mtime_ns
    _, second = complete(brief, tmp_path)
    assert [outcome.found for outcome in first] == [False] and [outcome.found for outcome in second] == [True]
    assert cache.files() == [path] and (path.read_bytes(), path.stat().st_mtime_ns) == before


@pytest.mark.slow
def test_a_second_simulation_gives_the_same_bytes(brief: Experiment, tmp_path: Path) -> None:
    (one,), (other,) = (complete(brief, tmp_path / name)[0].files() for name in "ab")
    assert one.read_bytes() == other.read_bytes() and one.name == other.name


@pytest.mark.slow
def test_an_experiment_finds_what_another_has_simulated(paper: Experiment, brief: Experiment, tmp_path: Path) -> None:
    complete(brief, tmp_path)
    two = brief.model_copy(update={"name": "other", "preferences": paper.preferences})
    _, outcomes = complete(two, tmp_path)
    assert [outcome.found for outcome in outcomes] == [True, False]


def test_the_key_of_a_reaction_knows_sources_and_libraries(paper: Experiment, machine: Machine) -> None:
    def key() -> str:
        return reaction_requests(paper)[0].digest

    files = (
        "human/anthropometry.py", "human/data/segments.yaml", "human/data/strengths/average_man.yaml",
        "motion/simulator.py", "motion/tasks/hand.py", "core/settings.py", "core/yaml_reader.py", "core/jit.py",
    )  # fmt: skip
    same = key()
    keys = [machine.with_another_file(file, key) for file in files]
    libraries = ("pin", "casadi", "numpy", "numba", "scipy")
    keys += [machine.with_another_version(name, key) for name in libraries]
    assert len({same, *keys}) == len(keys) + 1
    for file in ("fatigue/model.py", "planners/pomcp/policy.py", "cli/simulate.py"):
        assert machine.with_another_file(file, key) == same


def test_accuracy_decides_when_a_motion_is_read_and_nothing_is_simulated_again(
    brief: Experiment, tmp_path: Path
) -> None:
    strict = brief.model_copy(update={"accuracy": brief.accuracy.model_copy(update={"hand_error_m": 1e-7})})
    told = [outcome for experiment in (strict, brief, strict) for outcome in complete(experiment, tmp_path)[1]]
    assert [outcome.verdict for outcome in told] == ["failed", "implausible", "failed"]
    assert [outcome.found for outcome in told] == [False, True, True]
    assert told[0].failure == told[2].failure and "the hand stays" in told[0].failure and told[1].failure == ""
    assert len(ReactionCache(tmp_path).files()) == 1
    assert load_reactions(strict, tmp_path, "fatplan simulate") == ()
    assert len(load_reactions(brief, tmp_path, "fatplan simulate")) == 1
    both = [*reaction_requests(strict), *reaction_requests(brief)]
    outcomes = ReactionCache(tmp_path).complete(both, LocalProcesses(1), lambda _: None)
    assert [outcome.verdict for outcome in outcomes] == ["failed", "implausible"]


@pytest.mark.slow
def test_a_reaction_that_cannot_be_performed_is_kept_with_its_reason(brief: Experiment, tmp_path: Path) -> None:
    weak = brief.model_copy(update={"controller": brief.controller.model_copy(update={"torque_limit_factor": 0.02})})
    cache, first = complete(weak, tmp_path / "a")
    _, again = complete(weak, tmp_path / "a")
    assert [outcome.found for outcome in (*first, *again)] == [False, True]
    assert first[0].failure == again[0].failure and "no admissible movement" in first[0].failure
    assert first[0].failure.endswith("with a free orientation and half-way to the hanging hand.")
    assert load_reactions(weak, tmp_path / "a", "fatplan simulate") == ()
    (path,) = cache.files()
    assert verify_entry(path).verdict == "ok" and first[0].failure in verify_entry(path).reason
    assert export_archive(cache, reaction_requests(weak), tmp_path / "b.zip", "fatplan simulate") == 1
    (taken,) = import_archive(tmp_path / "b.zip", ReactionCache(tmp_path / "b"))
    assert taken.new and not taken.refused
    stored = cache.read(path)
    assert isinstance(stored, FailedReaction) and entry_bytes(stored) == path.read_bytes()
    path.write_bytes(entry_bytes(replace(stored, reason="it is Monday")))
    export_archive(cache, reaction_requests(weak), tmp_path / "b.zip", "fatplan simulate")
    (taken,) = import_archive(tmp_path / "b.zip", ReactionCache(tmp_path / "c"))
    assert "for another reason" in taken.refused and verify_entry(path).verdict == "failed"
    path.write_bytes(with_checksum(path.read_bytes()[:-9] + b"forgotten"))
    with pytest.raises(DamagedFileError):
        cache.read(path)


def test_files_of_others_are_left_alone(brief: Experiment, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "my_measurements.h5", "w") as file:
        file["x"] = 1
    cache, _ = complete(brief, tmp_path)
    assert cache.damaged == [] and len(cache.files()) == 1 and (tmp_path / "my_measurements.h5").exists()


@pytest.mark.parametrize("damage", [b"", "flip"])
def test_a_damaged_entry_is_refused_and_set_aside_and_made_again(
    brief: Experiment, tmp_path: Path, damage: bytes | str
) -> None:
    cache, _ = complete(brief, tmp_path)
    (path,) = cache.files()
    whole = path.read_bytes()
    changed = whole[:5000] + bytes([whole[5000] ^ 4]) + whole[5001:]
    path.write_bytes(changed if damage == "flip" else damage)
    with pytest.raises(DamagedFileError, match=r"does not match its hash.*Run `fatplan simulate somewhere\.yaml`"):
        load_reactions(brief, tmp_path, "fatplan simulate somewhere.yaml")
    cache, outcomes = complete(brief, tmp_path)
    assert len(cache.damaged) == 1 and "set aside" in cache.damaged[0] and not outcomes[0].found
    assert path.read_bytes() == whole and path.with_suffix(".damaged-1").exists()


def test_a_damaged_entry_is_replaced_by_a_sound_twin(brief: Experiment, tmp_path: Path) -> None:
    cache, _ = complete(brief, tmp_path)
    (path,) = cache.files()
    twin = tmp_path / f"z-{path.name}"
    shutil.copy(path, twin)
    path.write_bytes(b"")
    cache, outcomes = complete(brief, tmp_path)
    assert len(cache.damaged) == 1 and outcomes[0].found and cache.files() == [twin]


def test_an_entry_under_a_wrong_name_is_refused(
    paper: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path
) -> None:
    for request, reaction in zip(reaction_requests(paper), (*reactions[1:], reactions[0]), strict=True):
        ReactionCache(tmp_path).path(request).write_bytes(entry_bytes(reaction))
    with pytest.raises(DamagedFileError, match="holds another reaction than its name says, average_man-high-back-"):
        load_reactions(paper, tmp_path, "fatplan simulate p.yaml")
    one = {"actions": {"low": paper.actions["low"]}, "preferences": {"arm": paper.preferences["arm"]}}
    cache, (outcome,) = complete(paper.model_copy(update=one), tmp_path)
    assert len(cache.damaged) == 1 and not outcome.found


def test_missing_reactions_are_named_with_the_command(paper: Experiment, cache_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(MissingReactionsError, match=r"4 of 4 .*Run `fatplan simulate p\.yaml` first"):
        load_reactions(paper, tmp_path, "fatplan simulate p.yaml")
    for path in cache_folder.glob("*-low-*.h5"):
        shutil.copy(path, tmp_path)
    with pytest.raises(MissingReactionsError, match=r"2 of 4 reactions are not there: average_man/high/arm, average"):
        load_reactions(paper, tmp_path, "fatplan simulate p.yaml")
    requests = reaction_requests(paper)
    (there,) = ReactionCache(tmp_path).stream(requests, "fatplan simulate", [requests[2].name])
    assert there.name == requests[2].name


def test_a_degraded_motion_is_kept_and_says_so(brief: Experiment, tmp_path: Path) -> None:
    """A stoop from bent elbows, with hardly any braking allowed."""
    (worker, man), (task,) = *brief.workers.items(), brief.preferences["arm"].tasks
    bent = man.model_copy(update={"natural_posture_deg": {**man.natural_posture_deg, "elbow_flexion": 15.0}})
    stoop = brief.preferences["arm"].model_copy(update={"tasks": (task.model_copy(update={"stiffness_per_s2": None}),)})
    slow = brief.model_copy(
        update={
            "workers": {worker: bent},
            "preferences": {"arm": stoop},
            "cycle": Cycle(reach_s=2.5, work_s=1.0, return_s=2.5, return_hand="pose"),
            "actions": {"low": load_experiment(PAPER).actions["low"]},
            "controller": brief.controller.model_copy(update={"acceleration_limit_radps2": 1.0}),
            "accuracy": brief.accuracy.model_copy(update={"hand_error_m": 0.02, "eased_position_rad": 0.02}),
        }
    )
    _, first = complete(slow, tmp_path)
    _, again = complete(slow, tmp_path)
    assert [outcome.verdict for outcome in (*first, *again)] == ["implausible", "implausible"]
    assert again[0].found and again[0].quality == first[0].quality
    (file,) = ReactionCache(tmp_path).files()
    assert verify_entry(file).verdict == "implausible" and "ticks" in verify_entry(file).reason


def test_two_names_of_the_same_reaction_are_simulated_once(brief: Experiment, tmp_path: Path) -> None:
    twice = brief.model_copy(update={"actions": {"high": brief.actions["high"], "top": brief.actions["high"]}})
    cache, outcomes = complete(twice, tmp_path)
    assert [str(outcome.name) for outcome in outcomes] == ["average_man/high/arm", "average_man/top/arm"]
    assert len(cache.files()) == 1
    first, second = load_reactions(twice, tmp_path, "fatplan simulate")
    assert first.digest == second.digest and first.name != second.name
    np.testing.assert_array_equal(first.motion.torque_nm, second.motion.torque_nm)


def test_audit_recomputes_every_invariant(cache_folder: Path, reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    """A stored motion that does not keep its bars is found, even behind a valid hash."""
    good = verify_entry(ReactionCache(cache_folder).files()[0])
    assert (good.verdict, good.damaged) == ("implausible", False) and "face turned away" in good.reason
    torque = reactions[0].motion.torque_nm.copy()
    torque[100, 3] += 1e-3
    forged = replace(reactions[0], motion=replace(reactions[0].motion, torque_nm=torque))
    found = verify_entry(keep(tmp_path, forged))
    assert found.verdict == "failed" and not found.damaged
    assert "equation_of_motion_nm = 0.00" in found.reason and "stored as" in found.reason
    strange = replace(reactions[0], key=other_key(reactions[0], action={"position": 1}))
    assert "not those of this version" in verify_entry(keep(tmp_path, strange)).reason


def test_a_motion_longer_than_its_settings_say_is_noticed(
    paper: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path
) -> None:
    motion = reactions[0].motion
    rows = {name: np.concatenate([getattr(motion, name)] * 2) for name in ARRAYS}
    phases = tuple(Phase(name, 2 * start, 2 * stop) for name, start, stop in motion.phases)
    path = keep(tmp_path, replace(reactions[0], motion=replace(motion, phases=phases, **rows)))
    assert verify_entry(path).verdict == "failed" and "another length" in verify_entry(path).reason
    request = next(request for request in reaction_requests(paper) if request.digest == reactions[0].digest)
    with pytest.raises(DamagedFileError, match="another length"):
        list(ReactionCache(tmp_path).stream([request], "fatplan simulate"))


def test_a_complete_cache_needs_no_writable_folder(brief: Experiment, tmp_path: Path) -> None:
    complete(brief, tmp_path)
    before = tmp_path.stat().st_mtime_ns
    _, outcomes = complete(brief, tmp_path)
    assert outcomes[0].found and tmp_path.stat().st_mtime_ns == before

"""The reaction cache: published whole, checked on reading, found again, made anew only where it matters."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import PAPER, Machine

from fatigue_planner.errors import DamagedFileError, MissingLibraryError, OutputFolderError
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_reactions, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.reactions import reaction as reaction_module
from fatigue_planner.reactions.audit import audit
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.library import ARRAYS, Source, assemble_library, names_in, read_reaction, write_reaction
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.statistics.settings import StatisticsSettings


@pytest.fixture
def brief(paper: Experiment) -> Experiment:
    """The paper's experiment with one quick action and preference."""
    return paper.model_copy(
        update={
            "cycle": Cycle(reach_s=1.0, work_s=0.2, return_s=1.0),
            "actions": {"high": paper.actions["high"]},
            "preferences": {"arm": paper.preferences["arm"]},
            "controller": paper.controller.model_copy(update={"time_step_s": 0.01}),
            "accuracy": paper.accuracy.model_copy(update={"hand_error_m": 0.05}),
        }
    )


def read_library(path: Path) -> Iterator[Reaction]:
    return (read_reaction(path, name) for name in names_in(path))


def complete(experiment: Experiment, folder: Path):
    cache = ReactionCache(folder)
    path, outcomes = cache.complete(experiment.name, reaction_requests(experiment), 1, lambda _: None)
    return cache, path, outcomes


def test_library_describes_itself(cache_folder: Path) -> None:
    (path,) = cache_folder.glob("*.h5")
    with h5py.File(path) as file:
        assert [name.decode() for name in file["degrees_of_freedom"]] == list(DEGREES_OF_FREEDOM)
        assert {"format", "format_version", "digest", "versions"} <= set(file.attrs)
        group = file["reactions/average_man/high/arm"]
        assert {"digest", "settings", "quality", "time_step_s", "content_sha256"} <= set(group.attrs)
        assert [name.decode() for name in group["phases"]] == ["reach", "work", "return"]
        for name in ARRAYS:
            assert group[name].attrs["units"] and group[name].attrs["columns"] and group[name].fletcher32


def test_library_comes_back_as_it_was(reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    sources = []
    for reaction in reactions[:2]:
        path = tmp_path / f"{reaction.name.preference}.h5"
        write_reaction(path, reaction)
        sources.append(Source(reaction.name, reaction.digest, path, reaction.name))
    assemble_library(tmp_path / "both.h5", sources)
    for written, read in zip(reactions[:2], read_library(tmp_path / "both.h5"), strict=True):
        assert (written.name, written.digest, written.settings) == (read.name, read.digest, read.settings)
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(written.motion, name), getattr(read.motion, name))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.h5", "back.h5", "both.h5"]


def test_second_run_finds_everything(brief: Experiment, tmp_path: Path) -> None:
    _, path, first = complete(brief, tmp_path)
    before = path.read_bytes()
    _, again, second = complete(brief, tmp_path)
    assert [outcome.found for outcome in first] == [False] and [outcome.found for outcome in second] == [True]
    assert again == path and path.read_bytes() == before


def test_unfinished_work_is_taken_up(brief: Experiment, tmp_path: Path) -> None:
    """A reaction that an interrupted run left in partial/ is found, not simulated again."""
    _, path, outcomes = complete(brief, tmp_path)
    (tmp_path / "partial").mkdir(exist_ok=True)
    path.rename(tmp_path / "partial" / f"{outcomes[0].digest[:16]}.h5")
    _, path, outcomes = complete(brief, tmp_path)
    assert outcomes[0].found and path.exists()


def test_settings_that_matter_make_a_new_entry_and_others_do_not(paper: Experiment) -> None:
    def digest(experiment: Experiment) -> str:
        return reaction_requests(experiment)[0].digest

    def changed(**update: object) -> Experiment:
        return paper.model_copy(update=update)

    same = digest(paper)
    settings, man = paper.controller, paper.workers["average_man"]
    different = [
        changed(workers={"average_man": man.model_copy(update={"height_m": 1.76})}),
        changed(workers={"average_man": man.model_copy(update={"strength": "average_woman"})}),
        changed(tool=paper.tool.model_copy(update={"mass_kg": 4.0})),
        changed(tool=paper.tool.model_copy(update={"held": "work"})),
        changed(cycle=Cycle(reach_s=4.0, work_s=6.0, return_s=5.0)),
        changed(controller=settings.model_copy(update={"time_step_s": 0.005})),
        changed(controller=settings.model_copy(update={"solver": "qpoases"})),
        changed(controller=settings.model_copy(update={"centre_of_mass_shift_m": 0.01})),
        changed(accuracy=paper.accuracy.model_copy(update={"hand_error_m": 0.02})),
        changed(actions={"high": paper.actions["low"]}),
        changed(preferences={"arm": paper.preferences["back"]}),
    ]
    assert len({same, *map(digest, different)}) == len(different) + 1
    unimportant = [
        changed(discount=0.5),
        changed(name="other"),
        changed(statistics=StatisticsSettings(significance_level=0.01)),
        changed(fatigue=paper.fatigue.model_copy(update={"threshold": 0.2})),
    ]
    assert {digest(experiment) for experiment in unimportant} == {same}


def test_the_key_of_a_reaction_knows_sources_and_libraries(paper: Experiment, machine: Machine) -> None:
    def key() -> str:
        return reaction_requests(paper)[0].digest

    files = (
        "human/anthropometry.py", "human/data/segments.yaml", "human/data/strengths/average_man.yaml",
        "motion/simulator.py", "motion/tasks/hand.py", "settings.py", "yaml_reader.py", "compiled.py",
    )  # fmt: skip
    same = key()
    keys = [machine.with_another_file(file, key) for file in files]
    keys += [machine.with_another_version(reaction_module, name, key) for name in ("pin", "casadi", "numpy", "numba")]
    assert len({same, *keys}) == len(keys) + 1
    for file in ("fatigue/cycle_map.py", "planners/pomcp.py", "cli/simulate.py"):
        assert machine.with_another_file(file, key) == same


def test_inaccurate_motion_is_reported_and_never_kept(brief: Experiment, tmp_path: Path) -> None:
    strict = brief.model_copy(update={"accuracy": brief.accuracy.model_copy(update={"hand_error_m": 1e-7})})
    _, path, outcomes = complete(strict, tmp_path)
    assert outcomes[0].verdict == "failed" and "out of reach" in outcomes[0].failure
    assert not path.exists() and not list(tmp_path.rglob("*.h5"))


@pytest.mark.parametrize("position", [0.02, 0.3, 0.6, 0.95])
def test_flipped_bit_is_noticed_set_aside_and_mended(brief: Experiment, tmp_path: Path, position: float) -> None:
    _, path, _ = complete(brief, tmp_path)
    intact = tuple(read_library(path))
    data = bytearray(path.read_bytes())
    # a byte that is used: HDF5 leaves gaps between its structures
    place = next(i for i in range(int(position * len(data)), len(data)) if data[i])
    data[place] ^= 0x10
    path.write_bytes(bytes(data))
    try:
        (read,) = read_library(path)
    except DamagedFileError:
        cache, again, outcomes = complete(brief, tmp_path)
        assert len(cache.damaged) == 1 and "set aside" in cache.damaged[0]
        assert not outcomes[0].found
        (read,) = read_library(again)
    # whether noticed and mended or in a byte that says nothing: what is read is what was written
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(read.motion, name), getattr(intact[0].motion, name))
    assert (read.name, read.digest, read.settings, read.quality) == (
        intact[0].name, intact[0].digest, intact[0].settings, intact[0].quality,
    )  # fmt: skip


def test_every_flip_in_the_numbers_is_noticed(brief: Experiment, tmp_path: Path) -> None:
    """200 bit flips inside the arrays' compressed data: every one raises."""
    _, path, _ = complete(brief, tmp_path)
    whole = path.read_bytes()
    with h5py.File(path) as file:
        chunks = [
            data.id.get_chunk_info(i)
            for data in (file[f"reactions/average_man/high/arm/{name}"] for name in ARRAYS)
            for i in range(data.id.get_num_chunks())
        ]
    rng = np.random.default_rng(0)
    for _ in range(200):
        chunk = chunks[rng.integers(len(chunks))]
        data = bytearray(whole)
        data[chunk.byte_offset + rng.integers(chunk.size)] ^= 1 << rng.integers(8)
        path.write_bytes(bytes(data))
        with pytest.raises(DamagedFileError):
            tuple(read_library(path))


def test_files_of_others_are_left_alone(brief: Experiment, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "my_measurements.h5", "w") as file:
        file["x"] = 1
    cache, _, _ = complete(brief, tmp_path)
    assert cache.damaged == [] and (tmp_path / "my_measurements.h5").exists()


def test_library_with_a_reaction_missing_is_completed(brief: Experiment, tmp_path: Path) -> None:
    _, path, _ = complete(brief, tmp_path)
    with h5py.File(path, "r+") as file:
        del file["reactions/average_man/high/arm"]
    with pytest.raises(DamagedFileError, match="does not hold the reactions it was written with"):
        load_reactions(brief, tmp_path, "fatplan simulate")
    complete(brief, tmp_path)
    assert len(load_reactions(brief, tmp_path, "fatplan simulate")) == 1


def test_damaged_library_is_mended_from_a_sound_twin(brief: Experiment, tmp_path: Path) -> None:
    """Another library holds the same reactions: the damaged one is still noticed and made anew."""
    _, path, _ = complete(brief, tmp_path)
    shutil.copy(path, tmp_path / f"a-{'0' * 16}.h5")
    path.write_bytes(path.read_bytes()[:5000])
    cache, again, outcomes = complete(brief, tmp_path)
    assert len(cache.damaged) == 1 and outcomes[0].found and again == path
    assert len(tuple(read_library(path))) == 1


@pytest.mark.parametrize("damage", [b"", b"no HDF5", None])
def test_truncated_or_foreign_file_is_one_clear_error(
    paper: Experiment, cache_folder: Path, tmp_path: Path, damage: bytes | None
) -> None:
    (source,) = cache_folder.glob("*.h5")
    path = tmp_path / source.name
    shutil.copy(source, path)
    path.write_bytes(path.read_bytes()[:100_000] if damage is None else damage)
    with pytest.raises(DamagedFileError, match=r"fatplan simulate somewhere\.yaml"):
        load_reactions(paper, tmp_path, "fatplan simulate somewhere.yaml")


def test_altered_data_behind_a_valid_checksum_are_noticed(cache_folder: Path, tmp_path: Path) -> None:
    (source,) = cache_folder.glob("*.h5")
    path = tmp_path / source.name
    shutil.copy(source, path)
    with h5py.File(path, "r+") as file:
        file["reactions/average_man/low/back/torque_nm"][5, 5] += 1e-9
    with pytest.raises(DamagedFileError, match="average_man/low/back does not match its hash"):
        tuple(read_library(path))


def test_reactions_of_other_settings_under_this_name_are_refused(
    paper: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path
) -> None:
    path = ReactionCache(tmp_path).path(paper.name, reaction_requests(paper))
    write_reaction(path, replace(reactions[0], digest="0" * 64))
    with pytest.raises(DamagedFileError, match="holds other reactions than its name says"):
        load_reactions(paper, tmp_path, "fatplan simulate p.yaml")


def test_missing_library_names_the_command(paper: Experiment, tmp_path: Path) -> None:
    with pytest.raises(MissingLibraryError, match=r"Run `fatplan simulate p\.yaml` first"):
        load_reactions(paper, tmp_path, "fatplan simulate p.yaml")


def test_a_degraded_motion_is_kept_and_says_so(brief: Experiment, tmp_path: Path) -> None:
    slow = brief.model_copy(
        update={
            "cycle": Cycle(reach_s=2.5, work_s=1.0, return_s=2.5),
            "actions": {"low": load_experiment(PAPER).actions["low"]},
            "controller": brief.controller.model_copy(update={"acceleration_limit_radps2": 1.0}),
            "accuracy": brief.accuracy.model_copy(update={"hand_error_m": 0.02, "eased_position_rad": 0.02}),
        }
    )
    _, _, first = complete(slow, tmp_path)
    _, _, again = complete(slow, tmp_path)
    assert [outcome.verdict for outcome in (*first, *again)] == ["degraded", "degraded"]
    assert again[0].found and again[0].quality == first[0].quality
    (file,) = ReactionCache(tmp_path).files()
    (name,) = names_in(file)
    assert audit((file, name)).verdict == "degraded" and "ticks" in audit((file, name)).reason


def test_two_names_of_the_same_reaction_are_simulated_once(brief: Experiment, tmp_path: Path) -> None:
    twice = brief.model_copy(update={"actions": {"high": brief.actions["high"], "top": brief.actions["high"]}})
    _, path, outcomes = complete(twice, tmp_path)
    assert [str(outcome.name) for outcome in outcomes] == ["average_man/high/arm", "average_man/top/arm"]
    before = path.stat().st_mtime_ns
    complete(twice, tmp_path)
    assert path.stat().st_mtime_ns == before  # nothing to do, nothing written
    first, second = read_library(path)
    assert first.digest == second.digest and first.name != second.name
    np.testing.assert_array_equal(first.motion.torque_nm, second.motion.torque_nm)


def test_a_library_of_another_format_is_left_alone(brief: Experiment, tmp_path: Path) -> None:
    _, path, _ = complete(brief, tmp_path)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 1
    old = path.with_name(f"old-{'0' * 16}.h5")
    path.rename(old)
    cache, again, outcomes = complete(brief, tmp_path)
    assert cache.damaged == [] and old.exists() and again.exists() and not outcomes[0].found


def test_no_room_is_said_before_anything_is_written(
    brief: Experiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(OutputFolderError, match="no room for"):
        complete(brief, tmp_path)
    assert not list(tmp_path.glob("*.h5")) and len(list((tmp_path / "partial").glob("*.h5"))) == 1


def test_audit_recomputes_every_invariant(cache_folder: Path, reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    """A stored motion that does not keep its bars is found, even behind a valid hash."""
    good = audit((next(iter(ReactionCache(cache_folder).files())), reactions[0].name))
    assert (good.verdict, good.reason, good.damaged) == ("ok", "", False)
    torque = reactions[0].motion.torque_nm.copy()
    torque[100, 3] += 1e-3
    forged = replace(reactions[0], motion=replace(reactions[0].motion, torque_nm=torque))
    path = tmp_path / f"{'0' * 16}.h5"
    write_reaction(path, forged)
    found = audit((path, forged.name))
    assert found.verdict == "failed" and not found.damaged
    assert "equation_of_motion_nm = 1.00e-03 (allowed: 1e-08)" in found.reason and "stored as" in found.reason
    strange = replace(reactions[0], settings={**reactions[0].settings, "action": {"position": 1}})
    write_reaction(path, strange)
    assert "not those of this version" in audit((path, forged.name)).reason


def test_two_runs_at_once_end_well(brief: Experiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While one run assembles its library, another has published the same and taken the parts away."""
    import fatigue_planner.reactions.cache as module

    real = module.assemble_library

    def overtaken(path: Path, sources: list[Source]) -> None:
        real(path, sources)
        for source in sources:
            source.path.unlink()
        real(path, sources)

    monkeypatch.setattr(module, "assemble_library", overtaken)
    _, path, outcomes = complete(brief, tmp_path)
    assert outcomes[0].verdict == "ok" and len(tuple(read_library(path))) == 1


def test_settings_that_do_not_fit_the_digest_are_refused(brief: Experiment, tmp_path: Path) -> None:
    _, path, _ = complete(brief, tmp_path)
    (reaction,) = read_library(path)
    settings = dict(reaction.settings) | {"accuracy": {**reaction.settings["accuracy"], "hand_error_m": 9.0}}
    write_reaction(path, replace(reaction, settings=settings))
    with pytest.raises(DamagedFileError, match="has other settings than its digest says"):
        load_reactions(brief, tmp_path, "fatplan simulate")


def test_audit_finds_a_motion_longer_than_its_settings_say(reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    motion = reactions[0].motion
    rows = {name: np.concatenate([getattr(motion, name)] * 2) for name in ARRAYS}
    write_reaction(tmp_path / f"{'1' * 16}.h5", replace(reactions[0], motion=replace(motion, **rows)))
    found = audit((tmp_path / f"{'1' * 16}.h5", reactions[0].name))
    assert found.verdict == "failed" and "another length" in found.reason


def test_what_is_kept_of_an_unfinished_library_can_be_looked_at(brief: Experiment, tmp_path: Path) -> None:
    """One of two reactions fails: no library, but the other one is there for who asks for it by name."""
    far = brief.actions["high"].model_copy(
        update={"right_hand": brief.actions["high"].right_hand.model_copy(
            update={"position_m": brief.actions["high"].right_hand.position_m.model_copy(update={"x": 0.9})})}
    )  # fmt: skip
    two = brief.model_copy(update={"actions": {"high": brief.actions["high"], "far": far}})
    cache, path, outcomes = complete(two, tmp_path)
    assert [outcome.verdict for outcome in outcomes] == ["ok", "failed"] and not path.exists()
    requests = reaction_requests(two)
    (kept,) = cache.stream(two.name, requests, "fatplan simulate", [requests[0].name])
    assert kept.name == requests[0].name
    with pytest.raises(MissingLibraryError, match=r"only 1 of 2 reactions are there: average_man/high/arm\. `fat"):
        load_reactions(two, tmp_path, "fatplan simulate")


def test_a_complete_library_needs_no_writable_folder(brief: Experiment, tmp_path: Path) -> None:
    complete(brief, tmp_path)
    shutil.rmtree(tmp_path / "partial")
    _, _, outcomes = complete(brief, tmp_path)
    assert outcomes[0].found and not (tmp_path / "partial").exists()

"""`fatplan cache`: list, verify, why, gc, export and import, as a user types them."""

import os
import shutil
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from commands import fatplan
from conftest import PAPER
from foreign import keep

from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.hdf5_layout import entry_bytes
from fatigue_planner.reactions.reaction import Reaction, file_name


def told(code: int, *arguments: object) -> str:
    """What a command says; it must end with an exit code. If it is refused, why."""
    done = fatplan("cache", *arguments)
    assert done.returncode == code, done.stderr
    return " ".join((done.stdout or done.stderr).split())


def outdated(reaction: Reaction) -> Reaction:
    """The same reaction, made by another CasADi and another controller."""
    key = reaction.key
    sources = {**key.sources, "motion/controller.py": "0" * 64}
    return replace(reaction, key=replace(key, sources=sources, versions={**key.versions, "casadi": "1.0"}))


@pytest.fixture
def cache(cache_folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(cache_folder, tmp_path / "cache"))


@pytest.mark.slow
def test_verify_checks_everything_again(cache: Path, reactions: tuple[Reaction, ...]) -> None:
    text = told(0, "verify", "--cache", cache)
    assert "4 reactions: 0 ok, 4 implausible, 0 degraded, 0 failed, 0 damaged, 0 of other versions" in text
    torque = reactions[0].motion.torque_nm.copy()
    torque[100, 3] += 1e-3
    keep(cache, replace(reactions[0], motion=replace(reactions[0].motion, torque_nm=torque)))
    assert "average_man/high/arm failed: equation_of_motion_nm" in told(3, "verify", "--cache", cache, "--jobs", 1)
    path = cache / file_name(reactions[2].name, reactions[2].digest)
    path.write_bytes(path.read_bytes()[:-1])
    text = told(4, "verify", "--cache", cache, "--jobs", 1)
    assert f"{path.name} DAMAGED: {path}: does not match its hash" in text and path.exists()  # nothing is changed
    assert "no reaction there" in told(2, "verify", "--cache", cache / "none")


def test_list_says_what_is_there_and_of_what_use(cache: Path, reactions: tuple[Reaction, ...]) -> None:
    keep(cache, outdated(reactions[1]))
    (cache / f"x-{'0' * 16}.h5").write_bytes(b"nothing")
    text = told(0, "list", "--cache", cache)
    assert "average_man/low/back" in text and "4 reactions, 1 of other versions, 1 damaged; 10." in text
    assert text.count("made by other sources or libraries") == 1
    assert "0 reactions, 0 of other" in told(0, "list", "--cache", cache / "none")


def test_why_names_the_setting_that_has_changed(cache: Path, tmp_path: Path) -> None:
    assert "4 of 4 reactions are there." in told(0, "why", PAPER, "--cache", cache)
    mine = tmp_path / "mine.yaml"
    mine.write_text(PAPER.read_text().replace("solver: daqp", "solver: qpoases").replace("z: 0.5}", "z: 0.55}"))
    text = told(0, "why", mine, "--cache", cache)
    assert text.count('controller.solver: "daqp", now it is "qpoases"') == 4
    assert text.count("action.right_hand.position_m.z: 0.5, now it is 0.55") == 2
    assert f"0 of 4 reactions are there. `fatplan simulate {mine} --cache {cache}` simulates the others." in text


def test_why_names_the_source_and_the_library_that_have_changed(cache: Path, reactions: tuple[Reaction, ...]) -> None:
    path = ReactionCache(cache).files()[0]
    path.unlink()
    keep(cache, outdated(reactions[0]))
    text = told(0, "why", PAPER, "--cache", cache)
    assert "other code: source motion/controller.py has changed" in text
    assert f'version of casadi: "1.0", now it is "{reactions[0].key.versions["casadi"]}"' in text
    assert "3 of 4 reactions are there" in text
    for one in ReactionCache(cache).files():
        one.unlink()
    assert "average_man/low/arm: nothing like it was ever stored here" in told(0, "why", PAPER, "--cache", cache)


def test_gc_deletes_what_is_never_read_again_and_nothing_else(cache: Path, reactions: tuple[Reaction, ...]) -> None:
    wanted = {path.name for path in cache.iterdir()}
    old = keep(cache, outdated(reactions[1]))
    aside, left, young = (
        cache / "a.damaged-1",
        cache / ".x.fatplan-unfinished-1.h5",
        cache / ".y.fatplan-unfinished-2.h5",
    )
    for path in (aside, left, young):
        path.write_bytes(b"x")
    os.utime(left, (time.time() - 7200,) * 2)
    (cache / "notes.txt").write_text("mine")
    text = told(0, "gc", "--cache", cache)
    assert "3 files of 2.1 MB can go; `fatplan cache gc --delete` deletes them." in text and old.exists()
    assert "3 files of 2.1 MB deleted." in told(0, "gc", "--cache", cache, "--delete")
    assert {path.name for path in cache.iterdir()} == {*wanted, "notes.txt", young.name}
    assert "0 files of 0.0 MB can go." in told(0, "gc", "--cache", cache)


def test_what_is_exported_comes_in_elsewhere_to_the_last_bit(cache: Path, tmp_path: Path) -> None:
    bundles = [tmp_path / "one.zip", tmp_path / "two.zip"]
    for bundle in bundles:
        assert "4 reactions, 8.3 MB" in told(0, "export", PAPER, bundle, "--cache", cache)
    assert bundles[0].read_bytes() == bundles[1].read_bytes()
    elsewhere = tmp_path / "elsewhere"
    assert "4 taken, 0 there already, 0 refused" in told(0, "import", bundles[0], "--cache", elsewhere)
    assert "0 taken, 4 there already, 0 refused" in told(0, "import", bundles[0], "--cache", elsewhere)
    for path in ReactionCache(cache).files():
        assert (elsewhere / path.name).read_bytes() == path.read_bytes()
    text = told(2, "export", PAPER, tmp_path / "three.zip", "--cache", tmp_path / "empty")
    assert "4 of 4 reactions are not there" in text and not (tmp_path / "three.zip").exists()


def test_what_comes_in_replaces_a_damaged_file(cache: Path, tmp_path: Path) -> None:
    bundle, (path, *_) = tmp_path / "one.zip", ReactionCache(cache).files()
    told(0, "export", PAPER, bundle, "--cache", cache)
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    assert "does not match its hash" in told(4, "export", PAPER, tmp_path / "two.zip", "--cache", cache)
    assert not (tmp_path / "two.zip").exists()
    assert "1 taken, 3 there already, 0 refused" in told(0, "import", bundle, "--cache", cache)
    assert path.read_bytes() == whole and path.with_suffix(".damaged-1").read_bytes() == whole[:-1]


def test_nothing_in_a_bundle_is_believed(cache: Path, reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    torque = reactions[0].motion.torque_nm.copy()
    torque[100, 3] += 1e-3
    forged = replace(reactions[0], motion=replace(reactions[0].motion, torque_nm=torque))
    good, old = entry_bytes(reactions[3]), outdated(reactions[1])
    bundle = tmp_path / "bundle.zip"
    with zipfile.ZipFile(bundle, "w") as archive:
        archive.writestr(file_name(forged.name, forged.digest), entry_bytes(forged))
        archive.writestr(file_name(old.name, old.digest), entry_bytes(old))
        archive.writestr("../../evil-0123456789abcdef.h5", good)
        archive.writestr(file_name(reactions[2].name, reactions[2].digest), b"nothing")
        archive.writestr(file_name(reactions[3].name, reactions[3].digest), good)
    elsewhere = tmp_path / "a" / "b"
    text = told(3, "import", bundle, "--cache", elsewhere)
    assert "1 taken, 0 there already, 4 refused" in text
    for reason in ("equation_of_motion_nm", "other sources or libraries", "than its name says", "match its hash"):
        assert reason in text
    assert [path.name for path in elsewhere.iterdir()] == [file_name(reactions[3].name, reactions[3].digest)]
    assert not list(tmp_path.glob("evil*"))


def test_files_that_are_no_bundles(cache: Path, tmp_path: Path) -> None:
    bundle = tmp_path / "bundle.zip"
    bundle.write_bytes(b"PK nothing")
    assert "bundle.zip: is not an archive of reactions" in told(2, "import", bundle, "--cache", cache)
    with zipfile.ZipFile(bundle, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x-0123456789abcdef.h5", b"0" * 10_000_000)
    assert "is not stored as `fatplan cache export` does" in told(2, "import", bundle, "--cache", cache)
    assert "No such file" in told(2, "import", tmp_path / "none.zip", "--cache", cache)

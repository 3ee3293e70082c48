"""Files of others: whatever they say, they are refused in one line or read correctly, and nothing else happens."""

import io
import json
import os
import re
import threading
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from foreign import (
    TICKS,
    Watched,
    crafted,
    declared,
    instead,
    mutants,
    packed,
    small_entry,
    small_reaction,
    with_motion,
    zip_entry,
)
from hypothesis import given, settings
from pace import within

from fatigue_planner.core.errors import ArchiveError, DamagedFileError, OtherVersionError
from fatigue_planner.core.files import canonical_json
from fatigue_planner.motion.motion import Phase
from fatigue_planner.reactions import sandbox
from fatigue_planner.reactions.archive import import_archive
from fatigue_planner.reactions.cache import ReactionCache, read_content
from fatigue_planner.reactions.hdf5_layout import (
    ARRAYS,
    MAX_BYTES,
    MAX_TEXT,
    entry_bytes,
    read_entry,
    read_key,
    with_checksum,
)
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import Reaction, file_name

MAX_CPU_S = 2.0
MAX_MIB = 800  # of the process that reads; it has some 45 at rest, and some 620 after the longest motion there can be

Build = Callable[[Path], bytes]


def by(change: Callable[[h5py.File], object]) -> Build:
    return lambda _: crafted(change)


def external_link(outside: Path) -> bytes:
    def change(file: h5py.File) -> None:
        del file["torque_nm"]
        file["torque_nm"] = h5py.ExternalLink(str(outside), "/torque_nm")

    return crafted(change)


def external_storage(outside: Path) -> bytes:
    return crafted(declared("torque_nm", (TICKS, 39), external=[(str(outside), 0, TICKS * 39 * 8)]))


def virtual(name: str, open_ended: bool) -> Build:
    def build(outside: Path) -> bytes:
        def change(file: h5py.File) -> None:
            del file[name]
            layout = h5py.VirtualLayout((TICKS, 39), "<f8", maxshape=(None, 39) if open_ended else None)
            source = h5py.VirtualSource(str(outside), "x", (TICKS, 39), "<f8", maxshape=(None, 39))
            if open_ended:
                layout[: h5py.h5s.UNLIMITED] = source[: h5py.h5s.UNLIMITED]
            else:
                layout[:] = source
            file.create_virtual_dataset(name, layout)

        return crafted(change)

    return build


def linked(name: str, to: object) -> Build:
    def change(file: h5py.File) -> None:
        target = file[to] if isinstance(to, str) else to
        del file[name]
        file[name] = target

    return by(change)


def added(change: Callable[[h5py.File], object]) -> Build:
    return by(change)


def groups(file: h5py.File) -> None:
    for number in range(3000):
        file.create_group(f"g{number}")


def nested(file: h5py.File) -> None:
    file.create_group("/".join(["deep"] * 1500))


def large_attributes(file: h5py.File) -> None:
    for number in range(8):
        file.attrs[f"a{number}"] = b"x" * 60_000
    file["torque_nm"].attrs["units"] = b"\x1b" * 60_000


def unknown_filter(file: h5py.File) -> None:
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((TICKS, 39))
    properties.set_filter(32015, h5py.h5z.FLAG_OPTIONAL, (3,))
    del file["torque_nm"]
    space = h5py.h5s.create_simple((TICKS, 39))
    new = h5py.h5d.create(file.id, b"torque_nm", h5py.h5t.IEEE_F64LE, space, properties)
    new.write_direct_chunk((0, 0), b"nothing", filter_mask=0)


def chunk_bomb(file: h5py.File) -> None:
    packed(file, "torque_nm", TICKS, 2**31)


def rows_bomb(file: h5py.File) -> None:
    for array in ARRAYS:
        packed(file, array, 100_000)


def latest(_: Path) -> bytes:
    """The same in HDF5's newest structures: another superblock, other headers, another index of chunks."""
    content = io.BytesIO()
    with (
        h5py.File(io.BytesIO(small_entry())) as old,
        h5py.File(content, "w", libver="latest", userblock_size=512) as new,
    ):
        for name in old:
            old.copy(name, new)
    return with_checksum(content.getvalue())


def moved(_: Path) -> bytes:
    whole = small_entry()
    return with_checksum(whole[:512] + bytes(512) + whole[512:])


def superblock(version: int) -> Build:
    def build(_: Path) -> bytes:
        whole = bytearray(small_entry())
        whole[512 + 8] = version
        return with_checksum(bytes(whole))

    return build


def cut(at: float) -> Build:
    return lambda _: with_checksum(small_entry()[: int(len(small_entry()) * at)])


def committed(file: h5py.File) -> None:
    file["type"] = np.dtype("<f8")
    values = file["torque_nm"][()]
    instead("torque_nm", values, dtype=file["type"])(file)


def odd_float(file: h5py.File) -> None:
    kind = h5py.h5t.IEEE_F64LE.copy()
    kind.set_ebias(1000)
    del file["torque_nm"]
    h5py.h5d.create(file.id, b"torque_nm", kind, h5py.h5s.create_simple((TICKS, 39)))


def text(name: str, value: bytes | str) -> Build:
    return by(instead(name, np.bytes_(value) if isinstance(value, bytes) else value))


def key(value: str) -> Build:
    return text("key", value.encode())


def valid_key(**settings: object) -> str:
    return canonical_json(replace(small_reaction().key, settings=settings).plain())


def quality(**changes: object) -> Build:
    values = asdict(small_reaction().quality) | changes
    return text("quality", json.dumps(values, sort_keys=True, separators=(",", ":")).encode())


def name(*parts: bytes) -> Build:
    return by(instead("name", np.array(parts)))


def ticks(*ends: int) -> Build:
    return by(instead("phase_ticks", np.array(ends).reshape(3, 2)))


def wrong(array: str, index: tuple[int, ...], value: float) -> Build:
    def build(_: Path) -> bytes:
        numbers = getattr(small_reaction().motion, array).copy()
        numbers[index] = value
        return with_motion(**{array: numbers})

    return build


def motion(**parts: object) -> Build:
    return lambda _: with_motion(**parts)


def no_ticks(_: Path) -> bytes:
    none = {array: getattr(small_reaction().motion, array)[:0] for array in ARRAYS}
    return with_motion(phases=tuple(Phase(phase, 0, 0) for phase in ("reach", "work", "return")), **none)


def long_key(_: Path) -> bytes:
    reaction = small_reaction()
    return entry_bytes(replace(reaction, key=replace(reaction.key, settings={"long": "x" * 900_000})))


TYPE = "has numbers of type"
NOT_OURS = "is not one of our reactions"
REFUSED: dict[str, tuple[Build, str]] = {
    "external link": (external_link, r"torque_nm is a link elsewhere \(ExternalLink\)"),
    "soft link": (linked("torque_nm", h5py.SoftLink("/eased_radps2")), r"is a link elsewhere \(SoftLink\)"),
    "link to itself": (linked("torque_nm", h5py.SoftLink("/torque_nm")), r"is a link elsewhere \(SoftLink\)"),
    "root under a dataset's name": (linked("torque_nm", "/"), "torque_nm is not a dataset"),
    "one dataset for another": (linked("torque_nm", "eased_radps2"), "numbers do not match their hash"),
    "external storage": (external_storage, "has its numbers in another file"),
    "virtual dataset": (virtual("torque_nm", False), "has its numbers in another file"),
    "open-ended virtual dataset": (virtual("torque_nm", True), "has its numbers in another file"),
    "missing dataset": (by(lambda file: file.__delitem__("wrench")), "wrench is missing"),
    "object references": (by(declared("torque_nm", (TICKS, 39), h5py.ref_dtype)), TYPE),
    "region references": (by(declared("torque_nm", (TICKS, 39), h5py.regionref_dtype)), TYPE),
    "text of variable length": (text("key", "{}"), TYPE),
    "sequences of variable length": (by(declared("torque_nm", (TICKS, 39), h5py.vlen_dtype("<f8"))), TYPE),
    "compound": (by(declared("torque_nm", (TICKS, 39), [("\x1b[31m", "<f8"), ("b", "<i4", 1000)])), TYPE),
    "arrays as numbers": (by(declared("torque_nm", (TICKS,), ("<f8", (39,)))), TYPE),
    "opaque": (by(declared("torque_nm", (TICKS, 39), "V8")), TYPE),
    "single precision": (by(declared("torque_nm", (TICKS, 39), "<f4")), TYPE),
    "integers": (by(declared("torque_nm", (TICKS, 39), "<i8")), TYPE),
    "complex": (by(declared("torque_nm", (TICKS, 39), "<c16")), TYPE),
    "big-endian": (by(declared("torque_nm", (TICKS, 39), ">f8")), TYPE),
    "an exponent of its own": (by(odd_float), "."),
    "text as numbers": (by(declared("torque_nm", (TICKS, 39), "S8")), TYPE),
    "no rows": (no_ticks, "larger than itself"),
    "a scalar": (by(instead("torque_nm", 1.0)), r"has the shape \(\)"),
    "no space": (by(instead("torque_nm", h5py.Empty("<f8"))), "has the shape None"),
    "too few columns": (by(declared("torque_nm", (TICKS, 38))), "has the shape"),
    "too few rows": (by(declared("torque_nm", (TICKS - 1, 39))), "different lengths"),
    "1e12 rows, none stored": (by(declared("torque_nm", (10**12, 39), chunks=(100, 39), fillvalue=1.0)), "rows, more"),
    "1e12 rows, in one chunk": (by(declared("torque_nm", (10**12, 39))), "rows, more than 180000"),
    "a huge chunk": (by(declared("torque_nm", (TICKS, 39), maxshape=(None, 39), chunks=(10**6, 39))), "larger than"),
    "a chunk that grows without end": (by(chunk_bomb), "cannot be read as HDF5"),
    "100,000 rows of zeros": (by(rows_bomb), "phases"),
    "an unknown filter": (by(unknown_filter), "unknown filter"),
    "lzf": (by(declared("torque_nm", (TICKS, 39), compression="lzf")), "unknown filter"),
    "scale and offset": (by(declared("phase_ticks", (3, 2), "<i8", scaleoffset=0)), "unknown filter"),
    "superblock 99": (superblock(99), "cannot be read as HDF5"),
    "superblock 3 where there is none": (superblock(3), "cannot be read as HDF5"),
    "cut in the middle": (cut(0.5), "cannot be read as HDF5"),
    "cut after the superblock": (cut(0.02), "cannot be read as HDF5"),
    "nothing but a checksum": (lambda _: with_checksum(bytes(600)), "cannot be read as HDF5"),
    "deep JSON": (key("[" * 100_000 + "]" * 100_000), NOT_OURS),
    # Python 3.13 reads so deep a text; then the hash is not that of the numbers.
    "deep JSON, whole": (
        key(valid_key(x=0).replace(':0', ':' + "[" * 3000 + "]" * 3000)), f"{NOT_OURS}|do not match their hash",
    ),
    "NaN": (key(valid_key(x=0).replace('"x":0', '"x":NaN')), NOT_OURS),
    "a number too large": (key(valid_key(x=0).replace('"x":0', '"x":1e999')), NOT_OURS),
    "a key twice": (key(valid_key(x=0).replace('"x":0', '"x":0,"x":0')), "not as this program writes"),
    "lone surrogates": (key(valid_key(x=0).replace('"x":0', '"x":"\\ud800"')), NOT_OURS),
    "an escape sequence": (key(valid_key(x="\x1b[31m")), "not as this program writes"),
    "text that runs backwards": (key(valid_key(x="\u202e")), "not as this program writes"),
    "no JSON": (key("x"), NOT_OURS),
    "a list": (key("[]"), "its key is not that of a reaction"),
    "a number for a key": (key("5"), NOT_OURS),
    "a part missing": (key('{"settings":{},"sources":{}}'), "its key is not that of a reaction"),
    "settings in a list": (key('{"settings":[],"sources":{},"versions":{}}'), "its key is not that of a reaction"),
    "bytes that are not text": (text("key", b"\xff\xfe"), NOT_OURS),
    "another key": (key(valid_key(tool={"mass_kg": 4})), "numbers do not match their hash"),
    "a key of 1 MB": (text("key", b"x" * (MAX_TEXT + 1)), "key is longer than 1000000 bytes"),
    "a quality with an extra field": (quality(more=1), "not as this program writes"),
    "a quality with a text for a number": (quality(record_error="0"), "quality record_error: Input should be a valid"),
    "a quality with NaN": (quality(record_error=float("nan")), NOT_OURS),
    "a quality with an escape": (quality(largest_load_joint="\x1b]0;x\x07"), NOT_OURS),
    "an unknown joint": (quality(saturated_joint="tail"), "names an unknown joint"),
    "a quality that is not one": (text("quality", b"[" * 100_000), NOT_OURS),
    "another quality": (quality(record_error=0.0), "numbers do not match their hash"),
    "a path in the name": (name(b"../../etc", b"high", b"arm"), "its name is"),
    "NUL in the name": (name(b"a\0b", b"high", b"arm"), "its name is"),
    "an escape in the name": (name(b"a", b"\x1b[31m", b"arm"), "its name is"),
    "a name without end": (name(b"a" * 101, b"high", b"arm"), "its name is"),
    "a name that is not text": (name(b"\xff", b"high", b"arm"), NOT_OURS),
    "another name": (name(b"bob", b"high", b"arm"), "numbers do not match their hash"),
    "phases in another order": (ticks(2, 4, 0, 2, 4, 6), "phases"),
    "phases with a gap": (ticks(0, 2, 3, 4, 4, 6), "phases"),
    "an empty phase": (ticks(0, 2, 2, 2, 2, 6), "phases"),
    "negative ticks": (ticks(-2, 2, 2, 4, 4, 6), "phases"),
    "phases beyond the end": (ticks(0, 2, 2, 4, 4, 2**62), "phases"),
    "other phases": (by(instead("phases", np.array([b"reach", b"rest", b"return"]))), "phases"),
    "NaN among the numbers": (wrong("torque_nm", (2, 3), np.nan), "torque_nm has values that are not finite"),
    "infinity among the numbers": (wrong("hand_error_m", (5,), np.inf), "hand_error_m has values that are not finite"),
    "numbers too large": (wrong("wrench", (0, 0), -1e308), "wrench has values that are not finite, or beyond 1e\\+50"),
    "time step 0": (motion(time_step_s=0.0), "time_step_s is 0"),
    "time going back": (motion(time_step_s=-0.01), "time_step_s is -0.01"),
    "time step NaN": (by(instead("time_step_s", np.nan)), "time_step_s has values that are not finite"),
    "another hash": (text("content_sha256", b"0" * 64), "numbers do not match their hash"),
    "no hash": (text("content_sha256", b"\0"), "numbers do not match their hash"),
    "numbers forged": (by(lambda file: file["torque_nm"].__setitem__((1, 1), 0.5)), "do not match their hash"),
    "not a reaction": (text("format", b"something"), "is not a fatplan reaction"),
    "no format": (by(lambda file: file.__delitem__("format")), "format is missing"),
    "a format of 1 MB": (text("format", b"x" * 1_000_000), "format is longer"),
    "format 6": (by(instead("format_version", 6)), "has format 6"),
    "format -1": (by(instead("format_version", -1)), "has format -1"),
}  # fmt: skip
READ: dict[str, Build] = {
    "as written": by(lambda file: None),
    "the root within itself": by(lambda file: file.__setitem__("loop", file["/"])),
    "3,000 groups besides": by(groups),
    "1,500 groups within each other": by(nested),
    "large attributes": by(large_attributes),
    "HDF5's newest structures": latest,
    "512 bytes further on": moved,
    "a type of its own": by(committed),
    "an enumeration as numbers": by(
        instead("phase_ticks", np.array([[0, 2], [2, 4], [4, 6]]), dtype=h5py.enum_dtype({"\x1b": 0}, basetype="<i8"))
    ),
}


def cpu_s() -> float:
    """What this process and the one that reads have computed."""
    reader = sandbox._READER._process
    fields = [] if reader is None else Path(f"/proc/{reader.pid}/stat").read_text().rsplit(")")[1].split()
    return sum(os.times()[:2]) + sum(int(field) for field in fields[11:13]) / os.sysconf("SC_CLK_TCK")


def peak_mib() -> float:
    """The most memory that the process that reads has had."""
    reader = sandbox._READER._process
    if reader is None:
        return 0.0
    lines = Path(f"/proc/{reader.pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """A file that nobody may open."""
    path = tmp_path / "outside.h5"
    with h5py.File(path, "w") as file:
        file["torque_nm"] = file["x"] = np.zeros((TICKS, 39))
    return path


@pytest.mark.parametrize("case", REFUSED)
def test_a_crafted_file_is_refused_in_one_line(case: str, outside: Path) -> None:
    build, message = REFUSED[case]
    content = build(outside)
    assert read_entry(small_entry(), "own").name.worker == "anna"  # the process is there
    watched, before = Watched(outside), cpu_s()
    with pytest.raises((DamagedFileError, OtherVersionError), match=message) as caught:
        read_entry(content, "f.h5")
    assert str(caught.value).isprintable() and len(str(caught.value)) < 400
    assert within(cpu_s() - before, MAX_CPU_S) and peak_mib() < MAX_MIB
    assert read_entry(small_entry(), "own").digest == small_reaction().digest
    assert not watched.opened()
    outside.read_bytes()
    assert watched.opened()  # an opening would have been noticed
    watched.close()


@pytest.mark.parametrize("case", READ)
def test_what_is_strange_but_right_is_read_right(case: str, outside: Path) -> None:
    assert_equal(read_entry(READ[case](outside), "f.h5"), small_reaction())
    assert peak_mib() < MAX_MIB


def test_a_key_of_almost_1_mb_is_read() -> None:
    content = long_key(Path())
    assert read_key(content, "f.h5")[1] == read_entry(content, "f.h5").key


@pytest.mark.parametrize("count", [150, pytest.param(10_000, marks=pytest.mark.slow)])
def test_mutated_files_are_refused_or_read_right(count: int) -> None:
    """A reaction that is read must be the original."""
    original, ends = small_reaction(), Counter[str]()

    @settings(max_examples=count)
    @given(mutants())
    def refuse_or_read_right(content: bytes) -> None:
        try:
            read = read_entry(content, "f.h5")
        except (DamagedFileError, OtherVersionError) as error:
            text = str(error)
            assert text.isprintable() and len(text) < 500
            kind = re.search(r"ends the process .*|too long|cannot be read as HDF5|do not match", text)
            ends[kind[0] if kind else "refused by us"] += 1
        else:
            ends["read"] += 1
            assert_equal(read, original)
        assert peak_mib() < MAX_MIB

    refuse_or_read_right()
    print(f"\n{sum(ends.values())} mutated files: {dict(ends)}")
    assert 0 < ends["read"] < 0.6 * sum(ends.values())


def assert_equal(read: Reaction, original: Reaction) -> None:
    assert (read.name, read.key, read.quality) == (original.name, original.key, original.quality)
    assert read.motion.phases == original.motion.phases
    for array in ARRAYS:
        np.testing.assert_array_equal(getattr(read.motion, array), getattr(original.motion, array))


# ---- what is not a file, or not as it should be ----


def broken_files(folder: Path) -> dict[str, tuple[Path, str]]:
    with (folder / "sparse").open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    (folder / "empty").touch()
    (folder / "bare").write_bytes(small_entry()[512:])
    return {
        "sparse": (folder / "sparse", f"has {MAX_BYTES + 1} bytes; none of ours has more"),
        "empty": (folder / "empty", "does not match its hash"),
        "bare": (folder / "bare", "has no checksum"),
    }


def test_what_is_not_a_file_of_ours_is_refused_at_once(no_files: dict[str, Path], tmp_path: Path) -> None:
    del no_files["with NUL"]  # which no folder or command line can give
    wrong = {name: (path, r"cannot be read|is not a file") for name, path in no_files.items()} | broken_files(tmp_path)
    for path, message in wrong.values():
        before = cpu_s()
        with pytest.raises((DamagedFileError, OtherVersionError), match=message):
            read_entry(read_content(path), "f")
        assert within(cpu_s() - before, MAX_CPU_S)
        if path in no_files.values():
            with pytest.raises(ArchiveError, match=message):
                list(import_archive(path, ReactionCache(tmp_path / "cache")))


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may read everything")
def test_an_unreadable_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(small_entry())
    path.chmod(0)
    with pytest.raises(DamagedFileError, match="Permission denied"):
        read_content(path)


def test_names_that_would_move_the_cursor_are_not_ours(tmp_path: Path) -> None:
    (tmp_path / f"\x1b[2J-{'0' * 16}.h5").write_bytes(small_entry())
    assert ReactionCache(tmp_path).files() == []


def test_a_file_that_changes_while_it_is_read_is_refused_or_read_right(tmp_path: Path) -> None:
    path, whole, done = tmp_path / "x.h5", small_entry(), threading.Event()
    path.write_bytes(whole)

    def rewrite() -> None:
        while not done.is_set():
            with path.open("r+b") as file:
                for start in range(0, len(whole), 4096):
                    file.seek(start)
                    file.write(bytes(4096))
                    file.flush()
                file.seek(0)
                file.write(whole)
                file.truncate(len(whole))

    thread = threading.Thread(target=rewrite)
    thread.start()
    try:
        for _ in range(100):
            try:
                assert read_entry(read_content(path), "f").digest == small_reaction().digest
            except DamagedFileError as error:
                assert "does not match its hash" in str(error)
    finally:
        done.set()
        thread.join()


# ---- archives ----

ZIP_END = b"PK\5\6" + bytes(18)
MEMBER = b"anna-high-arm-0123456789abcdef.h5"
ARCHIVES: dict[str, tuple[Callable[[], bytes], str]] = {
    "nothing": (lambda: b"", "is not an archive"),
    "text": (lambda: b"PK nothing of the kind, but long enough for a header", "is not an archive"),
    "cut in an entry": (lambda: zip_entry(MEMBER, small_entry())[:-1], "was cut off in 'anna"),
    "cut after an entry": (lambda: zip_entry(MEMBER, b"x"), "was cut off"),
    "cut in a header": (lambda: zip_entry(MEMBER, b"x") + b"PK\3\4", "was cut off"),
    "packed": (lambda: zip_entry(MEMBER, b"x", method=8), "not stored as"),
    "locked": (lambda: zip_entry(MEMBER, b"x", flags=1), "not stored as"),
    "sizes afterwards": (lambda: zip_entry(MEMBER, b"x", flags=8), "not stored as"),
    "two sizes": (lambda: zip_entry(MEMBER, b"x", size=2), "not stored as"),
    "zip64": (lambda: zip_entry(MEMBER, b"x", size=2**32 - 1, stored=2**32 - 1), "none of ours has more"),
    "a lying size": (lambda: zip_entry(MEMBER, b"x", size=MAX_BYTES, stored=MAX_BYTES) + ZIP_END, "was cut off in"),
    "a size too large": (lambda: zip_entry(MEMBER, b"x", size=MAX_BYTES + 1, stored=MAX_BYTES + 1), "none of ours"),
    "entries in entries": (lambda: zip_entry(MEMBER, zip_entry(MEMBER, b"x"), size=40, stored=40), "not an archive"),
    "100,001 entries": (lambda: zip_entry(b"", b"") * 100_001 + ZIP_END, "has more than 100000 entries"),
}  # fmt: skip


@pytest.mark.parametrize("case", ARCHIVES)
def test_a_crafted_archive_is_refused_in_one_line(case: str, tmp_path: Path) -> None:
    build, message = ARCHIVES[case]
    path = tmp_path / "b.zip"
    path.write_bytes(build())
    before = cpu_s()
    with pytest.raises(ArchiveError, match=message) as caught:
        for entry in import_archive(path, ReactionCache(tmp_path / "cache")):
            assert entry.refused
    assert str(caught.value).isprintable() and within(cpu_s() - before, MAX_CPU_S)
    assert [path.name for path in tmp_path.iterdir()] == ["b.zip"]


@pytest.mark.parametrize("name", ["..\\evil.h5", "../../evil.h5", "/tmp/evil.h5", "a\0b.h5", "\x1b[31m.h5", ""])
def test_names_in_an_archive_lead_nowhere(name: str, tmp_path: Path) -> None:
    path = tmp_path / "b.zip"
    twice = zip_entry(name.encode(), small_entry()) * 2
    inner = tmp_path / "inner.zip"
    with zipfile.ZipFile(inner, "w") as archive:
        archive.writestr(zipfile.ZipInfo("x.h5"), small_entry())
    path.write_bytes(twice + zip_entry(b"inner.zip", inner.read_bytes()) + ZIP_END)
    found = list(import_archive(path, ReactionCache(tmp_path / "cache")))
    assert len(found) == 3 and all(entry.refused and entry.refused.isprintable() for entry in found)
    assert {path.name for path in tmp_path.iterdir()} == {"b.zip", "inner.zip"}


def test_an_entry_of_other_code_is_not_taken(tmp_path: Path) -> None:
    own = file_name(small_reaction().name, small_reaction().digest)
    path = tmp_path / "b.zip"
    path.write_bytes(zip_entry(own.encode(), small_entry()) + ZIP_END)
    (one,) = import_archive(path, ReactionCache(tmp_path / "cache"))
    assert "was made by other sources or libraries" in one.refused


def test_hostile_settings_are_one_line(tmp_path: Path) -> None:
    """Current in everything but what it describes: verification refuses it, and the program goes on."""
    from fatigue_planner.reactions.key import sources, versions

    hostile: list[dict[str, object]] = [
        {}, {"worker": []}, {"worker": {"height_m": 1e308}}, {"worker": 5, "tool": "x" * 10_000}, {"\u00e9": {}},
    ]  # fmt: skip
    content = b""
    for values in hostile:
        reaction = replace(small_reaction(), key=ReactionKey(values, sources(), versions()))
        content += zip_entry(file_name(reaction.name, reaction.digest).encode(), entry_bytes(reaction))
    (tmp_path / "b.zip").write_bytes(content + ZIP_END)
    found = list(import_archive(tmp_path / "b.zip", ReactionCache(tmp_path / "cache")))
    assert len(found) == len(hostile)
    for entry in found:
        assert "not those of this version" in entry.refused
        assert entry.refused.isprintable() and len(entry.refused) < 400

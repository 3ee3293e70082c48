"""A small entry of the cache, and what an attacker could make of it."""

import ctypes
import io
import os
import struct
import zlib
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import h5py
import numpy as np
from hypothesis import strategies as st
from mutations import damaged

from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.plausibility import Plausibility
from fatigue_planner.motion.quality import Quality
from fatigue_planner.reactions.hdf5_layout import ARRAYS, entry_bytes, with_checksum
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import Reaction, ReactionName, file_name

TICKS = 6
SEEN = Plausibility(**{field.name: "" if field.type is str else 0.125 for field in fields(Plausibility)})
NOT_NUMBERS = {
    "not_finite": 0, "eased_ticks": 0, "largest_load_joint": "lumbar_flexion", "saturated_joint": "",
    "plausibility": SEEN, "tested_causes": "",
}  # fmt: skip


@cache
def small_reaction() -> Reaction:
    """So few ticks that HDF5's own structures are most of its file."""
    rng = np.random.default_rng(1)
    rows = {name: rng.normal(size=(TICKS, width) if width else TICKS) for name, (width, _, _) in ARRAYS.items()}
    phases = tuple(Phase(name, 2 * index, 2 * index + 2) for index, name in enumerate(("reach", "work", "return")))
    numbers = {name: 0.125 for name in Quality.__dataclass_fields__ if name not in NOT_NUMBERS}
    return Reaction(
        ReactionName("anna", "high", "arm"),
        ReactionKey({"tool": {"mass_kg": 5}}, {"settings.py": "0" * 64}, {"numpy": "2.0"}),
        Motion(time_step_s=0.01, phases=phases, **rows),
        Quality(**numbers, **NOT_NUMBERS),  # type: ignore[arg-type]
    )


def small_entry() -> bytes:
    return entry_bytes(small_reaction())


def crafted(change: Callable[[h5py.File], object]) -> bytes:
    """The small entry, changed by HDF5 itself, with a valid checksum."""
    content = io.BytesIO(small_entry())
    with h5py.File(content, "r+") as file:
        change(file)
    return with_checksum(content.getvalue())


def instead(name: str, value: object, **how: object) -> Callable[[h5py.File], object]:
    """A change that replaces a dataset by another."""

    def change(file: h5py.File) -> None:
        del file[name]
        file.create_dataset(name, data=value, **how)

    return change


def declared(name: str, shape: tuple[int, ...], dtype: str = "<f8", **how: object) -> Callable[[h5py.File], object]:
    """A change that replaces a dataset by one of which only shape and type are declared."""

    def change(file: h5py.File) -> None:
        del file[name]
        file.create_dataset(name, shape, dtype, **how)

    return change


def with_motion(**parts: object) -> bytes:
    """An entry, hashes and all, of the small reaction with another motion."""
    reaction = small_reaction()
    return entry_bytes(replace(reaction, motion=replace(reaction.motion, **parts)))  # type: ignore[arg-type]


def zip_entry(name: bytes, content: bytes, flags: int = 0, method: int = 0, stored: int = -1, size: int = -1) -> bytes:
    """An entry of a ZIP file whose header may lie."""
    stored, size = len(content) if stored < 0 else stored, len(content) if size < 0 else size
    head = struct.pack("<4s5H3I2H", b"PK\3\4", 20, flags, method, 0, 33, 0, stored, size, len(name), 0)
    return head + name + content


def mutants() -> st.SearchStrategy[bytes]:
    """The small entry, damaged behind a renewed checksum; more where it is not empty."""
    whole = small_entry()
    used = [512 + index for index, byte in enumerate(whole[512:]) if byte]
    ends = [bytes([value]) * length for value in (0, 0xFF, 0x7F, 0x01, 0x80) for length in (1, 2, 4, 8)]  # of integers
    positions = st.sampled_from(used) | st.integers(512, len(whole) - 1)
    return damaged(whole, positions, st.sampled_from(ends) | st.binary(max_size=8)).map(with_checksum)


def packed_zeros(size: int) -> bytes:
    """So many zeros as zlib packs them, to a thousandth, without ever holding them."""
    packer, block = zlib.compressobj(9), bytes(2**18)
    first = packer.compress(block) + packer.flush(zlib.Z_FULL_FLUSH)
    again = packer.compress(block) + packer.flush(zlib.Z_FULL_FLUSH)  # refers to nothing before it
    whole, rest = divmod(size, 2**18)
    last = packer.compress(bytes(rest)) + packer.flush(zlib.Z_FULL_FLUSH) + b"\x03\0"
    return first + again * (whole - 1) + last + struct.pack(">2H", size % 65521, 1)


def packed(file: h5py.File, name: str, rows: int, packed_bytes: int | None = None) -> None:
    """A dataset of zeros in one packed chunk, which may hold more than it should."""
    shape = (rows, *file[name].shape[1:])
    del file[name]
    new = file.create_dataset(name, shape, "<f8", chunks=shape, compression="gzip")
    new.id.write_direct_chunk((0,) * len(shape), packed_zeros(packed_bytes or 8 * int(np.prod(shape))))


class Watched:
    """Whether a file was opened, by whatever process, as the system (inotify) tells."""

    def __init__(self, path: Path) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        self._descriptor = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        on_open = 0x20
        assert self._descriptor >= 0 and libc.inotify_add_watch(self._descriptor, bytes(path), on_open) >= 0

    def opened(self) -> bool:
        try:
            return bool(os.read(self._descriptor, 4096))
        except BlockingIOError:
            return False

    def close(self) -> None:
        os.close(self._descriptor)


def keep(folder: Path, reaction: Reaction) -> Path:
    """A file with a reaction under its right name."""
    folder.mkdir(exist_ok=True)
    path = folder / file_name(reaction.name, reaction.digest)
    path.write_bytes(entry_bytes(reaction))
    return path

"""The reaction library: one self-describing HDF5 file with every reaction of an experiment.

/                               attributes: format, format_version, digest, versions (JSON)
/degrees_of_freedom             names of the columns of torque_nm
/reactions/<worker>/<action>/<preference>
    attributes                  digest, settings (JSON), quality (JSON), time_step_s, content_sha256
    phases                      name, first and last + 1 tick
    torque_nm, configuration, velocity, acceleration, wrench, hand_force_n, hand_error_m, eased_radps2
                                one row per tick; attributes `units` and `columns`
"""

import hashlib
import io
import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from fatigue_planner.errors import DamagedFileError, OtherVersionError, OutputFolderError
from fatigue_planner.files import canonical_json, digest_of, publish
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.quality import Quality
from fatigue_planner.reactions.reaction import Reaction, ReactionName, versions

FORMAT = "fatplan reaction library"
FORMAT_VERSION = 2  # to be raised when Motion, Quality or the layout above change

_JOINTS = ", ".join(DEGREES_OF_FREEDOM)
_WRENCH = ", ".join(f"{side} {part}" for side in ("right", "left") for part in ("fx", "fy", "fz", "mx", "my", "mz"))
_BASE_TWIST = "pelvis vx, vy, vz, wx, wy, wz (pelvis axes)"
# What HDF5 and JSON raise on a file that is not what it was.
_UNREADABLE = (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError)
# name -> (units, columns)
ARRAYS: dict[str, tuple[str, str]] = {
    "torque_nm": ("N.m", _JOINTS),
    "configuration": ("m, -, rad", f"pelvis x, y, z, quaternion x, y, z, w; {_JOINTS}"),
    "velocity": ("m/s, rad/s", f"{_BASE_TWIST}; {_JOINTS}"),
    "acceleration": ("m/s^2, rad/s^2", f"{_BASE_TWIST}; {_JOINTS}"),
    "wrench": ("N, N.m", f"ground on sole, at its centre, in its axes: {_WRENCH}"),
    "hand_force_n": ("N", "force on the fist, world axes: right x, y, z, left x, y, z"),
    "hand_error_m": ("m", "distance of a fist from its reference, the larger of both"),
    "eased_radps2": ("rad/s^2", f"how far accelerations are outside their bounds: {_JOINTS}"),
}


def library_digest(reactions: Sequence[tuple[ReactionName, str]]) -> str:
    """Key of a library: the names and digests of its reactions."""
    return digest_of(sorted((str(name), digest) for name, digest in reactions))


def write_reaction(path: Path, reaction: Reaction) -> None:
    """Publish a library of one reaction. Raises OutputFolderError if the folder cannot be written."""
    content = io.BytesIO()  # HDF5 itself crashes on a full disk; a plain write says so
    with h5py.File(content, "w", track_order=False) as file:
        _write_head(file, [(reaction.name, reaction.digest)])
        _write_reaction(file.create_group(_place(reaction.name)), reaction)
    publish(path, lambda temporary: temporary.write_bytes(content.getbuffer()))


class Source(NamedTuple):
    """Where a reaction of a library to be is: its name there and its digest, in which file, under which name."""

    name: ReactionName
    digest: str
    path: Path
    stored_name: ReactionName


def assemble_library(path: Path, sources: Sequence[Source]) -> None:
    """Publish a library of reactions that stand in other files, copied one by one.

    Raises OutputFolderError if the folder cannot be written or has not room enough.
    """
    needed = sum({source.path: source.path.stat().st_size for source in sources}.values())
    if shutil.disk_usage(path.parent).free < needed:  # HDF5 itself crashes on a full disk
        raise OutputFolderError(f"{path}: cannot be written (no room for {needed / 1e6:.0f} MB).")

    def write(temporary: Path) -> None:
        with h5py.File(temporary, "w", track_order=False) as file:
            _write_head(file, [(source.name, source.digest) for source in sources])
            for source in sources:
                with h5py.File(source.path, "r", locking=False) as stored:
                    stored.copy(_place(source.stored_name), file, _place(source.name))

    publish(path, write)


def _place(name: ReactionName) -> str:
    return f"reactions/{name}"


def _write_head(file: h5py.File, contents: Sequence[tuple[ReactionName, str]]) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["digest"] = library_digest(contents)
    file.attrs["versions"] = canonical_json(versions())
    file["degrees_of_freedom"] = list(DEGREES_OF_FREEDOM)


def _write_reaction(group: h5py.Group, reaction: Reaction) -> None:
    motion = reaction.motion
    group.attrs["digest"] = reaction.digest
    group.attrs["settings"] = canonical_json(reaction.settings)
    group.attrs["quality"] = canonical_json(asdict(reaction.quality))
    group.attrs["time_step_s"] = motion.time_step_s
    group.attrs["content_sha256"] = _content_sha256(reaction)
    group["phases"] = [phase.name for phase in motion.phases]
    group["phase_ticks"] = [[phase.start, phase.stop] for phase in motion.phases]
    for name, (units, columns) in ARRAYS.items():
        data = group.create_dataset(
            name, data=getattr(motion, name), compression="gzip", compression_opts=1, shuffle=True, fletcher32=True
        )
        data.attrs["units"] = units
        data.attrs["columns"] = columns


def names_in(path: Path) -> dict[ReactionName, str]:
    """Names and digests of a library's reactions, in the order of the names.

    Raises OtherVersionError for a library of another format, DamagedFileError for anything else that
    is not a whole library.
    """
    try:
        with h5py.File(path, "r", locking=False) as file:  # libraries are replaced, never changed
            if file.attrs.get("format") != FORMAT:
                raise DamagedFileError(f"{path}: is not a {FORMAT}.")
            if file.attrs["format_version"] != FORMAT_VERSION:
                version = file.attrs["format_version"]
                raise OtherVersionError(f"{path}: has format {version}; this version reads {FORMAT_VERSION}.")
            if [name.decode() for name in file["degrees_of_freedom"]] != list(DEGREES_OF_FREEDOM):
                raise DamagedFileError(f"{path}: its degrees of freedom are not this version's.")
            names = {
                ReactionName(worker, action, preference): str(group.attrs["digest"])
                for worker, actions in file["reactions"].items()
                for action, preferences in actions.items()
                for preference, group in preferences.items()
            }
            if library_digest(list(names.items())) != file.attrs["digest"]:
                raise DamagedFileError(f"{path}: does not hold the reactions it was written with.")
            return names
    except _UNREADABLE as error:
        raise DamagedFileError(f"{path}: cannot be read as a reaction library ({error}).") from error


def read_reaction(path: Path, name: ReactionName) -> Reaction:
    """A reaction of a library, checked. Raises DamagedFileError if it is not what was written."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return _read_reaction(path, name, file[_place(name)])
    except _UNREADABLE as error:
        raise DamagedFileError(f"{path}: {name} cannot be read ({error}).") from error


def _read_reaction(path: Path, name: ReactionName, group: h5py.Group) -> Reaction:
    names = [phase.decode() for phase in group["phases"]]
    phases = tuple(Phase(n, int(a), int(b)) for n, (a, b) in zip(names, group["phase_ticks"][()], strict=True))
    arrays = {array: group[array][()] for array in ARRAYS}
    reaction = Reaction(
        name=name,
        digest=str(group.attrs["digest"]),
        settings=json.loads(group.attrs["settings"]),
        motion=Motion(time_step_s=float(group.attrs["time_step_s"]), phases=phases, **arrays),
        quality=Quality(**json.loads(group.attrs["quality"])),
    )
    if _content_sha256(reaction) != group.attrs["content_sha256"]:
        raise DamagedFileError(f"{path}: {name} does not match its hash; the file was altered or damaged.")
    return reaction


def _content_sha256(reaction: Reaction) -> str:
    """SHA-256 over settings, quality and arrays of a reaction; its name is in the library's digest."""
    motion = reaction.motion
    head = [reaction.digest, reaction.settings, asdict(reaction.quality)]
    digest = hashlib.sha256(canonical_json([*head, motion.time_step_s, motion.phases]).encode())
    for name in ARRAYS:
        array = np.ascontiguousarray(getattr(motion, name), dtype="<f8")
        digest.update(canonical_json([name, array.shape]).encode() + array.tobytes())
    return digest.hexdigest()

"""The reaction library: one self-describing HDF5 file with every reaction of an experiment.

/                               attributes: format, format_version, digest, versions (JSON)
/degrees_of_freedom             names of the columns of torque_nm
/reactions/<action>/<preference>
    attributes                  digest, settings (JSON), quality (JSON), time_step_s, content_sha256
    phases                      name, first and last + 1 tick
    torque_nm, configuration, velocity, acceleration, wrench, hand_error_m, foot_displacement_m
                                one row per tick; attributes `units` and `columns`
"""

import hashlib
import io
import json
from collections.abc import Container, Sequence
from dataclasses import asdict
from pathlib import Path

import h5py
import numpy as np

from fatigue_planner.errors import DamagedFileError
from fatigue_planner.files import canonical_json, digest_of, publish
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.verification import Quality
from fatigue_planner.reactions.reaction import Reaction, ReactionName, versions

FORMAT = "fatplan reaction library"
FORMAT_VERSION = 1

_JOINTS = ", ".join(DEGREES_OF_FREEDOM)
_WRENCH = ", ".join(f"{side} {part}" for side in ("right", "left") for part in ("fx", "fy", "fz", "mx", "my", "mz"))
_BASE_TWIST = "pelvis vx, vy, vz, wx, wy, wz (pelvis axes)"
# name -> (units, columns)
ARRAYS: dict[str, tuple[str, str]] = {
    "torque_nm": ("N.m", _JOINTS),
    "configuration": ("m, -, rad", f"pelvis x, y, z, quaternion x, y, z, w; {_JOINTS}"),
    "velocity": ("m/s, rad/s", f"{_BASE_TWIST}; {_JOINTS}"),
    "acceleration": ("m/s^2, rad/s^2", f"{_BASE_TWIST}; {_JOINTS}"),
    "wrench": ("N, N.m", f"ground on sole, at its centre, in its axes: {_WRENCH}"),
    "hand_error_m": ("m", "distance of the right fist from its reference"),
    "foot_displacement_m": ("m", "right sole, left sole"),
}


def library_digest(reactions: Sequence[tuple[ReactionName, str]]) -> str:
    """Key of a library: the names and digests of its reactions."""
    return digest_of(sorted((str(name), digest) for name, digest in reactions))


def write_library(path: Path, reactions: Sequence[Reaction]) -> None:
    """Publish a library whole. Raises OutputFolderError if the folder cannot be written."""

    content = io.BytesIO()  # HDF5 itself crashes on a full disk; a plain write says so
    with h5py.File(content, "w", track_order=False) as file:
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["digest"] = library_digest([(r.name, r.digest) for r in reactions])
        file.attrs["versions"] = canonical_json(versions())
        file["degrees_of_freedom"] = list(DEGREES_OF_FREEDOM)
        for reaction in reactions:
            _write_reaction(file.create_group(f"reactions/{reaction.name}"), reaction)
    publish(path, lambda temporary: temporary.write_bytes(content.getbuffer()))


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


def read_library(path: Path, wanted: Container[str] | None = None) -> tuple[Reaction, ...]:
    """The reactions of a library whose digest is wanted (all, without `wanted`), each checked.

    Raises DamagedFileError if the file is not a whole, unaltered library.
    """
    try:
        with h5py.File(path, "r", locking=False) as file:  # libraries are replaced, never changed
            if file.attrs.get("format") != FORMAT or file.attrs.get("format_version") != FORMAT_VERSION:
                raise DamagedFileError(f"{path}: is not a {FORMAT} of version {FORMAT_VERSION}.")
            if [name.decode() for name in file["degrees_of_freedom"]] != list(DEGREES_OF_FREEDOM):
                raise DamagedFileError(f"{path}: its degrees of freedom are not this version's.")
            return tuple(
                _read_reaction(path, ReactionName(action, preference), group)
                for action, preferences in file["reactions"].items()
                for preference, group in preferences.items()
                if wanted is None or str(group.attrs["digest"]) in wanted
            )
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError) as error:
        raise DamagedFileError(f"{path}: cannot be read as a reaction library ({error}).") from error


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
    """SHA-256 over name, settings, quality and arrays of a reaction."""
    motion = reaction.motion
    head = [str(reaction.name), reaction.digest, reaction.settings, asdict(reaction.quality)]
    digest = hashlib.sha256(canonical_json([*head, motion.time_step_s, motion.phases]).encode())
    for name in ARRAYS:
        array = np.ascontiguousarray(getattr(motion, name), dtype="<f8")
        digest.update(canonical_json([name, array.shape]).encode() + array.tobytes())
    return digest.hexdigest()

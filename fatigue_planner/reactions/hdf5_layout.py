"""The layout of an entry of the cache: one self-describing HDF5 file with one reaction, after its checksum.

format, format_version      "fatplan reaction", "fatplan recorded reaction" for one from a recording, or
                            "fatplan failed reaction" for one that cannot be performed
key                         JSON: settings, sources, versions; its SHA-256 is the reaction's digest (`ReactionKey`)
name                        worker, action, preference
reason                      of a failed reaction: why it cannot be performed; it has none of the following
quality                     JSON: what was measured of the motion (`Quality`), or is known of the recording
                            (`RecordedQuality`)
time_step_s
phases, phase_ticks         names; first and last + 1 tick
torque_nm, configuration, velocity, acceleration, wrench, hand_force_n, hand_error_m, eased_radps2, tissue_nm
                            one row per tick; attributes `units` and `columns`
content_sha256              of all of the above

A file may hold more than this program writes, which is never looked at. Nothing in a file is believed: it is read by a
process of its own, and its texts must be, to the letter, what this program writes, so that they can be shown.
"""

import hashlib
import io
import json
import re
from collections.abc import Callable
from dataclasses import asdict, fields
from typing import Any, TypeVar

import h5py
import numpy as np
from pydantic import TypeAdapter, ValidationError

from fatigue_planner.core.errors import DamagedFileError, OtherVersionError
from fatigue_planner.core.files import canonical_json, digest_of
from fatigue_planner.core.reading_process import Array, UnreadableError
from fatigue_planner.human.capsules import checked_pairs
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, JOINTS
from fatigue_planner.motion.contact import WRENCH
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import MAX_TICKS, PHASES
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionName
from fatigue_planner.reactions.recorded import MAX_LABEL, RecordedQuality
from fatigue_planner.reactions.sandbox import Layout, read_hdf5

T = TypeVar("T")

# What a file of ours begins with: the SHA-256 of all that follows.
CHECKSUM_BYTES = 512
_CHECKSUM_MARK = b"fatplan sha256 "
# How an HDF5 file begins that has no checksum before it.
HDF5_MARK = b"\x89HDF\r\n\x1a\n"
FORMAT = "fatplan reaction"
FAILED_FORMAT = "fatplan failed reaction"
RECORDED_FORMAT = "fatplan recorded reaction"
# To be raised when Motion, the quality or the layout below change.
FORMAT_VERSIONS = {FORMAT: 5, FAILED_FORMAT: 5, RECORDED_FORMAT: 6}

_JOINTS = ", ".join(DEGREES_OF_FREEDOM)
_WRENCH = ", ".join(f"{side} {part}" for side in ("right", "left") for part in ("fx", "fy", "fz", "mx", "my", "mz"))
_BASE_TWIST = "pelvis vx, vy, vz, wx, wy, wz (pelvis axes)"
_N = len(DEGREES_OF_FREEDOM)
# name -> (width of a row, units, columns)
ARRAYS: dict[str, tuple[int | None, str, str]] = {
    "torque_nm": (_N, "N.m", _JOINTS),
    "configuration": (_N + BASE_DOF + 1, "m, -, rad", f"pelvis x, y, z, quaternion x, y, z, w; {_JOINTS}"),
    "velocity": (_N + BASE_DOF, "m/s, rad/s", f"{_BASE_TWIST}; {_JOINTS}"),
    "acceleration": (_N + BASE_DOF, "m/s^2, rad/s^2", f"{_BASE_TWIST}; {_JOINTS}"),
    "wrench": (2 * WRENCH, "N, N.m", f"ground on sole, at its centre, in its axes: {_WRENCH}"),
    "hand_force_n": (6, "N", "force on the fist, world axes: right x, y, z, left x, y, z"),
    "hand_error_m": (None, "m", "distance of a fist from its reference, the larger of both"),
    "eased_radps2": (_N, "rad/s^2", f"how far accelerations are outside their bounds: {_JOINTS}"),
    "tissue_nm": (_N, "N.m", f"of tissue and stops, beside the muscles: {_JOINTS}"),
}
_ROW_BYTES = 8 * sum(width or 1 for width, _, _ in ARRAYS.values())
MAX_TEXT = 1_000_000
MAX_REASON = 10_000  # characters
MAX_MAGNITUDE = 1e50  # of a number in a file; the squares of what is smaller are finite, too
MAX_BYTES = MAX_TICKS * _ROW_BYTES + 4 * MAX_TEXT

_TEXT: dict[str, tuple[str, tuple[int | None, ...]]] = {"key": ("S", ()), "name": ("S", (3,))}
LAYOUT = Layout(
    datasets={
        **_TEXT,
        "quality": ("S", ()),
        "content_sha256": ("S", ()),
        "time_step_s": ("f8", ()),
        "phases": ("S", (len(PHASES),)),
        "phase_ticks": ("i8", (len(PHASES), 2)),
        **{name: ("f8", (None,) if width is None else (None, width)) for name, (width, _, _) in ARRAYS.items()},
    },
    most_rows=MAX_TICKS,
    most_text=MAX_TEXT,
)
_FAILED_LAYOUT = Layout({**_TEXT, "reason": ("S", ()), "content_sha256": ("S", ())}, most_rows=0, most_text=MAX_TEXT)
_KEY_LAYOUT = Layout(_TEXT, most_rows=0, most_text=MAX_TEXT)
HEAD = Layout(datasets={"format": ("S", ()), "format_version": ("i8", ())}, most_rows=0, most_text=100)
# What an invalid key or name raises.
_UNREADABLE = (ValueError, TypeError, RecursionError)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,99}")
_QUALITY: dict[str, TypeAdapter[Quality | RecordedQuality]] = {
    FORMAT: TypeAdapter(Quality), RECORDED_FORMAT: TypeAdapter(RecordedQuality),
}  # fmt: skip
_KEY_PARTS = {part.name for part in fields(ReactionKey)}


def entry_bytes(reaction: Reaction | FailedReaction) -> bytes:
    """The content of the file of a reaction, the same for the same reaction."""
    content = io.BytesIO()
    with h5py.File(content, "w", track_order=False, userblock_size=CHECKSUM_BYTES) as file:
        kind = _format_of(reaction)
        file["format"], file["format_version"] = np.bytes_(kind), FORMAT_VERSIONS[kind]
        file["key"] = np.bytes_(canonical_json(reaction.key.plain()).encode())
        file["name"] = np.array(reaction.name, dtype=np.bytes_)
        file["content_sha256"] = np.bytes_(_content_sha256(reaction))
        if isinstance(reaction, Reaction):
            _write_motion(file, reaction)
        else:
            file["reason"] = np.bytes_(reaction.reason.encode())
    return with_checksum(content.getvalue())


def _format_of(reaction: Reaction | FailedReaction) -> str:
    if isinstance(reaction, FailedReaction):
        return FAILED_FORMAT
    return FORMAT if isinstance(reaction.quality, Quality) else RECORDED_FORMAT


def _write_motion(file: h5py.File, reaction: Reaction) -> None:
    motion = reaction.motion
    file["quality"] = np.bytes_(canonical_json(asdict(reaction.quality)).encode())
    file["time_step_s"] = motion.time_step_s
    file["phases"] = np.array([phase.name for phase in motion.phases], dtype=np.bytes_)
    file["phase_ticks"] = np.array([[phase.start, phase.stop] for phase in motion.phases], dtype="<i8")
    for name, (_, units, columns) in ARRAYS.items():
        data = file.create_dataset(
            name, data=getattr(motion, name), compression="gzip", compression_opts=1, shuffle=True, fletcher32=True
        )
        data.attrs["units"] = units
        data.attrs["columns"] = columns
        file.flush()  # otherwise its position in the file depends on when Python frees the data set


def read_entry(content: bytes, source: str) -> Reaction | FailedReaction:
    """The reaction in the content of a file, checked; `source` is how messages call it.

    Raises OtherVersionError for a file of another format, DamagedFileError if it is not, to the bit, what was written,
    or not a reaction that could have been.
    """
    kind = _checked_format(content, source)
    if kind == FAILED_FORMAT:
        return _parsed(content, source, _FAILED_LAYOUT, lambda found: _failed_reaction(found, source))
    return _parsed(content, source, LAYOUT, lambda found: _reaction(found, source, kind))


def read_key(content: bytes, source: str) -> tuple[ReactionName, ReactionKey]:
    """Name and key of the reaction in the content of a file. Raises as `read_entry`."""
    _checked_format(content, source)
    return _parsed(content, source, _KEY_LAYOUT, lambda found: (_name(found["name"]), _key(found["key"])))


def _parsed(content: bytes, source: str, layout: Layout, parse: Callable[[dict[str, Array]], T]) -> T:
    try:
        return parse(read_hdf5(content, layout))
    except UnreadableError as error:
        raise DamagedFileError(f"{source}: {error}.") from error
    except _UNREADABLE as error:
        raise DamagedFileError(f"{source}: is not one of our reactions ({error}).") from error


def _checked_format(content: bytes, source: str) -> str:
    """Which of the formats it is."""
    if content.startswith(HDF5_MARK):
        raise OtherVersionError(f"{source}: has no checksum; it is an earlier version's, or not fatplan's.")
    if not has_valid_checksum(content):
        raise DamagedFileError(f"{source}: does not match its hash; it was altered or damaged.")
    try:
        head = read_hdf5(content, HEAD)
    except UnreadableError as error:
        raise DamagedFileError(f"{source}: {error}.") from error
    kind = {name.encode(): name for name in FORMAT_VERSIONS}.get(head["format"].item())
    if kind is None:
        raise DamagedFileError(f"{source}: is not a {FORMAT}.")
    if (found := int(head["format_version"])) != FORMAT_VERSIONS[kind]:
        raise OtherVersionError(f"{source}: has format {found}; this version reads {FORMAT_VERSIONS[kind]}.")
    return kind


def _reaction(found: dict[str, Array], source: str, kind: str) -> Reaction:
    wrong = [name for name in ("time_step_s", *ARRAYS) if not (np.abs(found[name]) < MAX_MAGNITUDE).all()]
    if wrong:
        raise ValueError(f"{wrong[0]} has values that are not finite, or beyond {MAX_MAGNITUDE:.0e}")
    reaction = Reaction(
        name=_name(found["name"]),
        key=_key(found["key"]),
        motion=Motion(
            time_step_s=_time_step(found["time_step_s"]),
            phases=_phases(found["phases"], found["phase_ticks"], len(found["torque_nm"])),
            **{name: found[name] for name in ARRAYS},
        ),
        quality=_quality(found["quality"], kind),
    )
    if bool(reaction.key.recorded) != (kind == RECORDED_FORMAT):
        raise ValueError("its key is that of another format")
    _check_content(reaction, found["content_sha256"], source)
    return reaction


def _failed_reaction(found: dict[str, Array], source: str) -> FailedReaction:
    reason = found["reason"].item().decode()
    if not reason.isprintable() or not 0 < len(reason) <= MAX_REASON:
        raise ValueError("its reason is not as this program writes it")
    reaction = FailedReaction(_name(found["name"]), _key(found["key"]), reason)
    _check_content(reaction, found["content_sha256"], source)
    return reaction


def _check_content(reaction: Reaction | FailedReaction, sha256: Array, source: str) -> None:
    if _content_sha256(reaction).encode() != sha256.item():
        raise DamagedFileError(f"{source}: its numbers do not match their hash; they were altered or damaged.")


def _time_step(found: Array) -> float:
    if not found > 0:
        raise ValueError(f"time_step_s is {float(found)}")
    return float(found)


def _phases(names: Array, ticks: Array, rows: int) -> tuple[Phase, ...]:
    """One after the other, none empty, and no ticks besides."""
    starts, stops = ticks.T.tolist()
    right = names.tolist() == [name.encode() for name in PHASES] and [*starts, rows] == [0, *stops]
    if not right or (ticks[:, 0] >= ticks[:, 1]).any():
        raise ValueError(f"phases {names.tolist()} at ticks {ticks.tolist()} of {rows}")
    return tuple(Phase(name, *ends) for name, ends in zip(PHASES, ticks.tolist(), strict=True))


def _name(found: Array) -> ReactionName:
    name = ReactionName(*(part.decode() for part in found.tolist()))
    if not all(_NAME.fullmatch(part) for part in name):
        raise ValueError(f"its name is {tuple(name)}")
    return name


def _key(found: Array) -> ReactionKey:
    """Only the text that this program writes: no NaN, no key twice; and nothing in it that JSON has to escape."""
    text = found.item().decode()
    parts: Any = json.loads(text)
    if canonical_json(parts) != text or not text.isprintable() or "\\" in text:
        raise ValueError("its key is not as this program writes it")
    if set(parts) != _KEY_PARTS or not all(isinstance(part, dict) for part in parts.values()):
        raise ValueError("its key is not that of a reaction")
    return ReactionKey(**parts)


def _quality(found: Array, kind: str) -> Quality | RecordedQuality:
    try:
        quality = _QUALITY[kind].validate_json(found.item(), strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise ValueError(f"quality {'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    if canonical_json(asdict(quality)).encode() != found.item():
        raise ValueError("its quality is not as this program writes it")
    if isinstance(quality, RecordedQuality):
        _check_recorded(quality)
        return quality
    seen = quality.plausibility
    joints = {quality.largest_load_joint, quality.saturated_joint, seen.pushing_joint, seen.torque_step_joint}
    if not joints | {seen.end_pose_joint, seen.stance_load_joint} <= {"", *DEGREES_OF_FREEDOM}:
        raise ValueError("its quality names an unknown joint")
    if not quality.tested_causes.isprintable() or len(quality.tested_causes) > MAX_REASON:
        raise ValueError("its quality is not as this program writes it")
    if seen.penetration_parts not in {"", *(f"{first} and {second}" for first, second in checked_pairs())}:
        raise ValueError("its quality names an unknown part of the body")
    return quality


def _check_recorded(quality: RecordedQuality) -> None:
    """Raise ValueError if a text of it could not have been written."""
    labels = [phase.worst_marker for phase in quality.phases]
    if not all(label.isprintable() and len(label) <= MAX_LABEL for label in labels):
        raise ValueError("its quality names a marker as no recording does")
    bodies = {phase.unseen_body for phase in quality.phases}
    if not bodies <= {"", *BODIES} or quality.largest_load_joint not in DEGREES_OF_FREEDOM:
        raise ValueError("its quality names an unknown part of the body")
    joints = {joint.name for joint in JOINTS}
    if not set(quality.assumed_joints) <= joints or [phase.name for phase in quality.phases] != list(PHASES):
        raise ValueError("its quality names an unknown joint or phase")


def _content_sha256(reaction: Reaction | FailedReaction) -> str:
    """SHA-256 over key, name, quality and arrays of a reaction, or its reason if it failed."""
    if isinstance(reaction, FailedReaction):
        return digest_of([reaction.key.plain(), reaction.name, reaction.reason])
    motion = reaction.motion
    head = [reaction.key.plain(), reaction.name, asdict(reaction.quality), motion.time_step_s, motion.phases]
    digest = hashlib.sha256(canonical_json(head).encode())
    for name in ARRAYS:
        array = np.ascontiguousarray(getattr(motion, name), dtype="<f8")
        digest.update(canonical_json([name, array.shape]).encode() + array.tobytes())
    return digest.hexdigest()


def with_checksum(content: bytes) -> bytes:
    """A content that begins with CHECKSUM_BYTES free bytes, with its checksum in them."""
    return _checksum(content) + content[CHECKSUM_BYTES:]


def has_valid_checksum(content: bytes) -> bool:
    """Whether a content is, to the bit, what its checksum was made of."""
    return len(content) > CHECKSUM_BYTES and content[:CHECKSUM_BYTES] == _checksum(content)


def _checksum(content: bytes) -> bytes:
    digest = hashlib.sha256(memoryview(content)[CHECKSUM_BYTES:]).hexdigest()
    return (_CHECKSUM_MARK + digest.encode() + b"\n").ljust(CHECKSUM_BYTES, b"\0")

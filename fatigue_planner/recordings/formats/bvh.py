"""BVH: a skeleton and its turning angles, the format of animation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, shortened
from fatigue_planner.recordings.content import Content, Segments
from fatigue_planner.recordings.formats.text import lines_of, number, refuse, table, whole

Vector = NDArray[np.float64]
MAX_DEPTH, MAX_JOINTS = 100, 1000
MAX_POSES = 10_000_000  # of joints in frames, 100 bytes each
_CHANNELS = {f"{axis}{kind}": (kind, index) for kind in ("position", "rotation") for index, axis in enumerate("xyz")}


@dataclass(frozen=True)
class _Joint:
    """A joint: the index of its parent (-1: none), its place in the parent and its channels, in the file's order."""

    name: str
    parent: int
    offset: Vector
    channels: tuple[tuple[str, int], ...]


def read_bvh(content: bytes) -> Content:
    """The poses of a BVH file's joints, by the order of its channels. Raises RecordingError, naming the line."""
    lines = lines_of(content)
    joints, line = _hierarchy(lines)
    frames, line = _stated(lines, line, "frames:")
    step, line = _stated(lines, line, "frame time:")
    count, step_s = whole(frames, "Frames", line - 2, 1), number(step, line - 1)
    if not step_s > 0:
        refuse(line - 1, f"Frame Time = {shortened(step)}: should be a positive number of seconds.")
    columns = sum(len(joint.channels) for joint in joints)
    body = [row.split() for row in lines[line:]]
    while body and not body[-1]:
        body.pop()
    if len(body) != count:
        raise RecordingError(f"has {len(body)} rows after Frame Time; Frames says {count}.")
    short = next((i for i, row in enumerate(body) if len(row) != columns), None)
    if short is not None:
        refuse(line + short, f"{len(body[short])} numbers; the channels are {columns}.")
    if count * len(joints) > MAX_POSES:
        raise RecordingError(f"has {len(joints)} joints in {count} frames; more than {MAX_POSES} poses are too many.")
    position, rotation = _poses(joints, table(body, line, columns))
    names = tuple(joint.name for joint in joints)
    rest = np.zeros((len(joints), 3))
    for index, joint in enumerate(joints):
        rest[index] = joint.offset + (rest[joint.parent] if joint.parent >= 0 else 0)
    segments = Segments(names, position, rotation, rest)
    return Content("BVH", np.arange(count, dtype=float) * step_s, 1 / step_s, segments=segments)


def _hierarchy(lines: list[str]) -> tuple[list[_Joint], int]:
    """The joints, ends of limbs among them, and the line after MOTION."""
    joints: list[_Joint] = []
    open_joints: list[int] = []
    begun = False
    for index, text in enumerate(lines):
        words = text.split()
        if not words:
            continue
        word = words[0].upper()
        if word == "HIERARCHY" and not begun:
            begun = True
        elif not begun:
            refuse(index, "should begin with HIERARCHY.")
        elif word in ("ROOT", "JOINT", "END"):
            parent = open_joints[-1] if open_joints else -1
            if (word == "ROOT") != (parent < 0):
                refuse(index, f"{word} is at the wrong place.")
            if len(joints) >= MAX_JOINTS or len(open_joints) >= MAX_DEPTH:
                refuse(index, "has more joints than any body.")
            joints.append(_Joint(_name(joints, parent, word, words[1:], index), parent, np.zeros(3), ()))
        elif word == "{" and joints and len(joints) - 1 not in open_joints:
            open_joints.append(len(joints) - 1)
        elif word == "}" and open_joints:
            open_joints.pop()
        elif word in ("OFFSET", "CHANNELS") and open_joints:
            joints[open_joints[-1]] = _with(joints[open_joints[-1]], word, words[1:], index)
        elif word == "MOTION" and joints and not open_joints:
            return joints, index + 1
        else:
            refuse(index, f"{shortened(text.strip())} is not expected here.")
    raise RecordingError("has no MOTION after its HIERARCHY.")


def _name(joints: list[_Joint], parent: int, word: str, words: list[str], line: int) -> str:
    if word == "END":
        return f"{joints[parent].name}_end"
    if not words:
        refuse(line, f"{word} has no name.")
    return " ".join(words)


def _with(joint: _Joint, word: str, words: list[str], line: int) -> _Joint:
    if word == "OFFSET":
        if len(words) != 3:
            refuse(line, "OFFSET should have three numbers.")
        offset = np.array([number(cell, line) for cell in words])
        if np.isnan(offset).any():
            refuse(line, "OFFSET should have three numbers.")
        return _Joint(joint.name, joint.parent, offset, joint.channels)
    if not words or whole(words[0], "CHANNELS", line) != len(words) - 1:
        refuse(line, "CHANNELS should say how many they are.")
    unknown = [name for name in words[1:] if name.lower() not in _CHANNELS]
    if unknown:
        refuse(line, f"{shortened(unknown[0])} is not a channel (Xposition ... Zrotation are).")
    return _Joint(joint.name, joint.parent, joint.offset, tuple(_CHANNELS[name.lower()] for name in words[1:]))


def _stated(lines: list[str], line: int, key: str) -> tuple[str, int]:
    while line < len(lines) and not lines[line].strip():
        line += 1
    if line >= len(lines) or not lines[line].strip().lower().startswith(key):
        refuse(min(line, len(lines) - 1), f"should say {key}")
    return lines[line].strip()[len(key) :].strip(), line + 1


def _poses(joints: list[_Joint], values: Vector) -> tuple[Vector, Vector]:
    """Positions (n, s, 3) and orientations (n, s, 3, 3): every channel turns about an axis as it is turned by then."""
    count = len(values)
    position, rotation = np.empty((count, len(joints), 3)), np.empty((count, len(joints), 3, 3))
    column = 0
    for index, joint in enumerate(joints):
        shift, turn = np.tile(joint.offset, (count, 1)), np.tile(np.eye(3), (count, 1, 1))
        for kind, axis in joint.channels:
            if kind == "position":  # stands for the offset, as in most programs
                shift[:, axis] = values[:, column]
            else:
                turn = turn @ _about(axis, np.radians(values[:, column]))
            column += 1
        if joint.parent >= 0:
            base = rotation[:, joint.parent]
            position[:, index] = position[:, joint.parent] + np.einsum("nij,nj->ni", base, shift)
            rotation[:, index] = base @ turn
        else:
            position[:, index], rotation[:, index] = shift, turn
    return position, rotation


def _about(axis: int, angle: Vector) -> Vector:
    """Rotations (n, 3, 3) about an axis."""
    turn = np.tile(np.eye(3), (len(angle), 1, 1))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    turn[:, one, one] = turn[:, two, two] = np.cos(angle)
    turn[:, two, one] = np.sin(angle)
    turn[:, one, two] = -np.sin(angle)
    return turn

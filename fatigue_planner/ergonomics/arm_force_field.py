"""Arm Force Field (La Delfa & Potvin 2017, Applied Ergonomics 59, 410-421): the arm's strength by place and direction.

The authors' network gives the mean strength of women of median size without gravity; the arm's weight is added along
the force. Axes of the shoulders: anterior, superior, lateral (away from the midline).
"""

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.multibody import GRAVITY_MPS2

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

VARIATION = 0.277
# Strength over a woman's (La Delfa & Potvin, as cited by PfEM).
FACTOR: dict[Sex, float] = {"female": 1.0, "male": 1.66}
# Upper arm, forearm, hand: share of the body's mass, and of the way from the near joint to the far one.
SEGMENTS = ((0.0280, 0.436), (0.0170, 0.430), (0.0060, 0.740))
# A hand within this of the shoulder's height, in m, counts as level with it.
LEVEL_M = 0.01


class Network(Settings):
    """Content of data/arm_force_field.yaml."""

    offset: tuple[float, ...]
    gain: tuple[float, ...]
    hidden_bias: tuple[float, ...]
    hidden: tuple[tuple[float, ...], ...]
    output_bias: float
    output: tuple[float, ...]
    output_gain: float
    output_offset_n: float
    least_n: tuple[float, ...]
    most_n: tuple[float, ...]


@cache
def network() -> Network:
    """The authors' coefficients."""
    return load_data(Path(__file__).parent / "data" / "arm_force_field.yaml", Network)


def shoulder_axes(right_shoulder: Matrix, left_shoulder: Matrix, c7: Matrix, l5s1: Matrix) -> NDArray[np.float64]:
    """Anterior, superior and right of the shoulders, (n, 3, 3), from points (n, 3) in any right-handed axes."""
    right = _unit(right_shoulder - left_shoulder)
    anterior = _unit(np.cross(_unit(c7 - l5s1), right))
    return np.stack([anterior, np.cross(right, anterior), right], axis=1)


def outwards(vectors: NDArray[np.float64], axes: NDArray[np.float64], side: str) -> NDArray[np.float64]:
    """Vectors (n, 3) of the world as anterior, superior and lateral parts of a side."""
    parts = np.einsum("nij,nj->ni", axes, vectors)
    return np.asarray(parts * [1.0, 1.0, 1.0 if side == "right" else -1.0])


def strength_n(hand: Matrix, force: Matrix) -> Vector:
    """Mean strength of women without gravity, (n,): hand from the shoulder (n, 3) m, direction of the force (n, 3)."""
    known = network()
    (ap, si, ml), (fa, fs, fl) = hand.T, force.T
    moment = np.stack([ap * fl - ml * fa, ml * fs - si * fl, si * fa - ap * fs])
    arm = np.linalg.norm(moment, axis=0)
    aside = np.stack([np.hypot(ap, ml), np.hypot(si, ml), np.hypot(si, ap)])
    inputs = np.stack([
        si, ap, ml, *aside, fs, fa, fl, *moment, arm, arm**2, arm**3, aside[0] * fs, aside[1] * fa, aside[2] * fl,
    ])  # fmt: skip
    scaled = np.array(known.gain)[:, None] * (inputs - np.array(known.offset)[:, None]) - 1
    hidden = np.tanh(np.array(known.hidden) @ scaled + np.array(known.hidden_bias)[:, None])
    raw = np.array(known.output) @ hidden + known.output_bias
    found = (raw + 1) / known.output_gain + known.output_offset_n
    height = np.where(np.abs(si) <= LEVEL_M, 0, np.sign(si))
    code = np.stack([height, np.sign(fa), np.sign(fs), np.sign(fl)]).astype(int) + 1
    bounds = [np.array(values).reshape(3, 3, 3, 3)[tuple(code)] for values in (known.least_n, known.most_n)]
    return np.asarray(np.clip(found, *bounds))


def gravity_n(hand: Matrix, wrist: Matrix, elbow: Matrix, force: Matrix, down: Matrix, body_kg: float) -> Vector:
    """What the arm's weight adds along the force, (n,), all as parts of one side; places from the shoulder in m."""
    near = (np.zeros_like(elbow), elbow, wrist)
    moment = np.zeros_like(hand)
    for (mass, along), start, end in zip(SEGMENTS, near, (elbow, wrist, hand), strict=True):
        moment += np.cross(start + along * (end - start), down) * (mass * body_kg * GRAVITY_MPS2)
    assist = np.cross(_unit(moment), _unit(hand))
    size = np.linalg.norm(moment, axis=1) / np.linalg.norm(hand, axis=1)
    return np.asarray(np.einsum("ni,ni->n", _unit(assist), force) * size)


def _unit(vectors: Matrix) -> Matrix:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))

"""The fatigue POMDP as a generative model (paper, sections III-A and IV-D)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.cycle_map import CycleMap
from fatigue_planner.pomdp.preference_choice import preference_probabilities

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class FatiguePomdp:
    """Transitions, choices, observations and rewards of one worker and task.

    gain, offset (A, U, L): the cycle map of every action and preference on the L live entries, those
    that some reaction or initial state makes non-zero; the other entries stay 0 and are left out.
    observation (U, O): P(o | u), rows sum to 1. expertise: beta of Eq. 4, 0 to infinity.
    """

    actions: tuple[str, ...]
    preferences: tuple[str, ...]
    gain: Array
    offset: Array
    observation: Array
    expertise: float
    discount: float
    entries: int
    live: NDArray[np.intp]

    def next_fatigue(self, fatigue: Vector, action: int) -> Array:
        """Live fatigue (U, L) after the action, one row per preference."""
        return np.asarray(self.gain[action] * fatigue + self.offset[action])

    def cost(self, fatigue: Array) -> Array:
        """Eq. 5: C(f) = sum over the 2N entries of f^2 / 2N, over the last axis."""
        return np.asarray(np.square(fatigue).sum(axis=-1) / self.entries)

    def choice(self, fatigue: Vector, action: int) -> Vector:
        """Eq. 4: P(u | f, a) for every preference, (U,)."""
        return preference_probabilities(self.cost(self.next_fatigue(fatigue, action)), self.expertise)


def build_pomdp(
    actions: Sequence[str],
    preferences: Sequence[str],
    maps: Mapping[tuple[str, str], CycleMap],
    initial_states: Array,
    expertise: float,
    discount: float,
) -> FatiguePomdp:
    """The POMDP of the reactions `maps[action, preference]`, seen without error.

    `initial_states` (n, 78) are the states the worker may start in; they decide which entries live.
    """
    gain = np.array([[maps[a, u].gain for u in preferences] for a in actions])
    offset = np.array([[maps[a, u].offset for u in preferences] for a in actions])
    ever = (offset != 0).any(axis=(0, 1)) | (initial_states != 0).any(axis=0)
    ever[0] = True  # where nothing ever tires one entry stays, so that no array is empty
    live = np.flatnonzero(ever)
    return FatiguePomdp(
        actions=tuple(actions),
        preferences=tuple(preferences),
        gain=np.ascontiguousarray(gain[:, :, live]),
        offset=np.ascontiguousarray(offset[:, :, live]),
        observation=np.eye(len(preferences)),
        expertise=expertise,
        discount=discount,
        entries=gain.shape[-1],
        live=live,
    )

"""Which pieces of physiology each human has.

A new piece is a file beside this one and a line in PIECES. Pieces that change the same thing act in this order.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from fatigue_planner.human.anthropometry import Anthropometry, HumanKind
from fatigue_planner.motion.physiology.clearance import Clearance
from fatigue_planner.motion.physiology.end_zones import EndZones
from fatigue_planner.motion.physiology.facing import Facing
from fatigue_planner.motion.physiology.gaze import Gaze
from fatigue_planner.motion.physiology.hand_turn import HandTurn
from fatigue_planner.motion.physiology.hanging_arm import HangingArm
from fatigue_planner.motion.physiology.passive_tissue import PassiveTissue
from fatigue_planner.motion.physiology.piece import Bearer, Matrix, Piece, Scene, TimedTask, Vector
from fatigue_planner.motion.physiology.range_weights import RangeWeights
from fatigue_planner.motion.physiology.stops import Stops
from fatigue_planner.motion.physiology.way_home import WayHome

PIECES: dict[HumanKind, tuple[type[Piece] | type[Bearer], ...]] = {
    "paper": (),
    "natural": (
        RangeWeights,
        Facing,
        WayHome,
        EndZones,
        PassiveTissue,
        Stops,
        Gaze,
        HangingArm,
        HandTurn,
        Clearance,
    ),
}


class Physiology:
    """All pieces of a human that move the body, and what bears his torques beside the muscles.

    Only what some piece defines is ever called.
    """

    def __init__(self, kind: HumanKind, scene: Scene) -> None:
        self.pieces = [piece(scene) for piece in PIECES[kind] if issubclass(piece, Piece)]
        self.tissue = tissue_of(kind, scene.human.anthropometry)
        self.hand_weight_factor = math.prod(piece.hand_weight_factor for piece in self.pieces)
        self.turns_either_way = any(piece.turns_either_way for piece in self.pieces)
        self.limits = sum(piece.limits for piece in self.pieces)
        self._prepare = self._defined("prepare")
        self._draw = self._defined("draw")

    def _defined(self, hook: str) -> list[Callable[..., None]]:
        return [getattr(piece, hook) for piece in self.pieces if getattr(type(piece), hook) is not getattr(Piece, hook)]

    def tasks(self) -> list[TimedTask]:
        """The tasks of all pieces."""
        return [timed for piece in self.pieces for timed in piece.tasks()]

    def aim(self) -> Vector | None:
        """See Piece.aim; the fractions of several pieces are multiplied."""
        shares = [share for piece in self.pieces for share in [piece.aim()] if share is not None]
        return np.prod(shares, axis=0) if shares else None

    def prepare(self, tick: int) -> None:
        """See Piece.prepare."""
        for prepare in self._prepare:
            prepare(tick)

    def draw(self, weight: Vector, target: Vector) -> None:
        """See Piece.draw."""
        for draw in self._draw:
            draw(weight, target)

    def limit(self, rows: Matrix, least: Vector) -> None:
        """See Piece.limit; rows (limits, 45) and least (limits,)."""
        first = 0
        for piece in self.pieces:
            if piece.limits:
                own = slice(first, first + piece.limits)
                piece.limit(rows[own], least[own])
                first = own.stop


class Tissue:
    """What bears the torques of a worker's joints beside his muscles."""

    def __init__(self, bearers: Sequence[Bearer]) -> None:
        self.bearers = bearers

    def moments(self, angles: Vector) -> tuple[Vector, Matrix]:
        """Moments (39,) N.m at joint angles (39,) rad, and their derivatives (39, 39) N.m/rad."""
        moments, slopes = np.zeros(len(angles)), np.zeros((len(angles), len(angles)))
        for bearer in self.bearers:
            bearer.bear(angles, moments)
            bearer.stiffen(angles, slopes)
        return moments, slopes

    def borne(self, angles: Vector, torque_nm: Vector) -> Vector:
        """Its part (39,) N.m of the torques that the joints need at these angles, the stops' with it."""
        borne = np.zeros(len(angles))
        for bearer in self.bearers:
            bearer.bear(angles, borne)
        for bearer in self.bearers:
            bearer.relieve(angles, torque_nm, borne)
        return borne


def tissue_of(kind: HumanKind, person: Anthropometry) -> Tissue | None:
    """The tissue of a worker; None if his muscles bear everything."""
    bearers = [piece(person) for piece in PIECES[kind] if issubclass(piece, Bearer)]
    return Tissue(bearers) if bearers else None

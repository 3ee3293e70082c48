"""Which pieces of physiology each human has.

A new piece is a file beside this one and a line in PIECES. Pieces that change the same thing act in this order.
"""

import math
from collections.abc import Callable

import numpy as np

from fatigue_planner.human.anthropometry import HumanKind
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.motion.physiology.clearance import Clearance
from fatigue_planner.motion.physiology.end_zones import EndZones
from fatigue_planner.motion.physiology.gaze import Gaze
from fatigue_planner.motion.physiology.hanging_arm import HangingArm
from fatigue_planner.motion.physiology.passive_tissue import PassiveTissue
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, TimedTask, Vector
from fatigue_planner.motion.physiology.range_weights import RangeWeights
from fatigue_planner.motion.physiology.stops import Stops
from fatigue_planner.motion.physiology.way_home import WayHome

PIECES: dict[HumanKind, tuple[type[Piece], ...]] = {
    "paper": (),
    "natural": (
        RangeWeights,
        WayHome,
        EndZones,
        PassiveTissue,
        Stops,
        Gaze,
        HangingArm,
        Clearance,
    ),
}

_NJ = len(DEGREES_OF_FREEDOM)


class Physiology:
    """All pieces of a human. Only what some piece defines is ever called."""

    def __init__(self, kind: HumanKind, scene: Scene) -> None:
        self.pieces = [piece(scene) for piece in PIECES[kind]]
        self.hand_weight_factor = math.prod(piece.hand_weight_factor for piece in self.pieces)
        self._prepare = self._defined("prepare")
        self._draw = self._defined("draw")
        self.limits = sum(piece.limits for piece in self.pieces)
        self._bear = self._defined("bear")
        self._relieve = self._defined("relieve")
        self.has_tissue = bool(self._bear or self._relieve)

    def _defined(self, hook: str) -> list[Callable[..., Vector | None]]:
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

    def tissue(self, angles: Vector) -> tuple[Vector, Matrix]:
        """Moments (39,) N.m and their derivatives (39, 39) N.m/rad at joint angles, by all pieces; see Piece.bear."""
        total, whole = np.zeros(_NJ), np.zeros((_NJ, _NJ))
        for bear in self._bear:
            moments, slopes = np.zeros(_NJ), np.zeros((_NJ, _NJ))
            bear(angles, moments, slopes)
            total += moments
            whole += slopes
        return total, whole

    def stops(self, angles: Vector, muscle_nm: Vector) -> Vector:
        """The reactions (39,) N.m of all stops; see Piece.relieve."""
        total = np.zeros(_NJ)
        for relieve in self._relieve:
            reaction = relieve(angles, muscle_nm - total)
            if reaction is not None:
                total += reaction
        return total

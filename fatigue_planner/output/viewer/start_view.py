"""Where to look from at first: a place from which the back and the working hands are seen, found from the geometry."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.output.viewer.body_shapes import Shape, body_shapes
from fatigue_planner.output.viewer.motion_clip import Instant, MotionClip

Vector = NDArray[np.float64]

FIELD_OF_VIEW_DEG = 45.0  # from top to bottom
NARROWEST = 0.5  # width of the window as a share of its height, of a phone held upright
MARGIN = 1.08  # of the distance, for what is written over the edges
HEADROOM = 1.18  # of the stature, for what is written over the head
ENOUGH = 0.5  # share of the back, and of a hand, that has to be seen
# Degrees: from straight ahead towards the working side, those behind aside first; above the horizon.
_AZIMUTHS = (135, 120, 150, 105, 90, 165, 75, 60)
_HEIGHTS = (10, 25, 40, 55)
_BACK = ("abdomen", "thorax")
_BACKWARD = -0.5  # a facet is one of the back if its normal has less than this ahead, in the axes of its body
_EVERY = 3  # of so many facets one is looked at


@dataclass(frozen=True)
class StartView:
    """A camera (3,) m and the point (3,) m at which it looks; shares of the back and of the hand seen least."""

    position_m: Vector
    look_at_m: Vector
    back_seen: float
    hand_seen: float


@dataclass(frozen=True)
class _Facets:
    """Centres (n, 3) m, outward normals (n, 3) and areas (n,) of the facets of a body in the world."""

    centres: Vector
    normals: Vector
    areas: Vector

    def some(self, chosen: NDArray[np.bool_]) -> "_Facets":
        """One of `_EVERY` of those chosen."""
        those = np.flatnonzero(chosen)[::_EVERY]
        return _Facets(self.centres[those], self.normals[those], self.areas[those])

    def across(self, camera: Vector) -> Vector:
        """Their areas (n,) m2 as the camera sees them, aslant; 0 for those turned away."""
        ways = camera - self.centres
        cosines = (ways * self.normals).sum(axis=1) / np.linalg.norm(ways, axis=1)
        return np.asarray(self.areas * np.maximum(cosines, 0.0))


def start_view(clip: MotionClip) -> StartView:
    """The first direction from which enough is seen at mid-work; if there is none, the one from which most is.

    The better side is the working hand's; whole body, objects and robot are in the picture, at the start and at work.
    """
    work = clip.motion.phase("work")
    middle = clip.instant((work.start + work.stop) // 2)
    shapes = body_shapes(clip.human.anthropometry)
    facets = {body: _facets(shapes[body], middle, body) for body in BODIES}
    points: Vector = np.concatenate([
        *(facets[body].centres for body in BODIES),
        *(_facets(shapes[body], clip.instant(0), body).centres for body in BODIES),
        *(pose.position_m[None] for pose in clip.objects),
        [(0, 0, HEADROOM * clip.human.anthropometry.stature_m)],
        *([] if clip.robot is None else [clip.robot.parts(0)[0].reshape(-1, 3)]),
    ])  # fmt: skip
    look_at = (points.min(axis=0) + points.max(axis=0)) / 2
    best: StartView | None = None
    for direction in _directions(clip):
        position = look_at + _distance(points - look_at, direction) * direction
        back = _back_seen(facets, shapes, position)
        hand = min(_hand_seen(facets, f"{side}_hand", position) for side in clip.working)
        view = StartView(position, look_at, back, hand)
        if min(back, hand) >= ENOUGH:
            return view
        if best is None or min(back, hand) > min(best.back_seen, best.hand_seen):
            best = view
    assert best is not None
    return best


def _directions(clip: MotionClip) -> Iterator[Vector]:
    """Unit vectors to the camera, the better ones first."""
    side = 1.0 if clip.working == ("left",) else -1.0
    for mirror, height, azimuth in product((side, -side), _HEIGHTS, _AZIMUTHS):
        around, up = np.radians(azimuth), np.radians(height)
        yield np.array([np.cos(up) * np.cos(around), mirror * np.cos(up) * np.sin(around), np.sin(up)])


def _distance(points: Vector, direction: Vector) -> float:
    """From how far the points (n, 3), seen from the origin's direction, are in the picture, be it a narrow one."""
    across = np.cross([0, 0, 1], direction)
    across /= np.linalg.norm(across)
    half = np.tan(np.radians(FIELD_OF_VIEW_DEG) / 2)
    needs = np.maximum(np.abs(points @ np.cross(direction, across)) / half, np.abs(points @ across) / half / NARROWEST)
    return float(MARGIN * (points @ direction + needs).max())


def _back_seen(facets: Mapping[str, _Facets], shapes: Mapping[str, Shape], camera: Vector) -> float:
    """What is seen of the back, as a share of what would be from straight behind it with nothing between."""
    seen, whole = 0.0, np.zeros(3)
    for body in _BACK:
        own = facets[body].some(_normals(shapes[body])[0][:, 0] < _BACKWARD)
        outside = ~_hidden(facets, body, own.centres, own.centres)
        seen += own.across(camera)[outside & ~_hidden(facets, body, own.centres, camera)].sum()
        whole += own.areas[outside] @ own.normals[outside]
    return float(seen / np.linalg.norm(whole))


def _hand_seen(facets: Mapping[str, _Facets], hand: str, camera: Vector) -> float:
    """What is seen of a hand, as a share of what would be with nothing before it."""
    own = facets[hand].some(facets[hand].across(camera) > 0)
    areas = own.across(camera)
    return float(areas[~_hidden(facets, hand, own.centres, camera)].sum() / areas.sum())


def _hidden(facets: Mapping[str, _Facets], own: str, points: Vector, camera: Vector) -> NDArray[np.bool_]:
    """Which segments (n,) from the points (n, 3) of a body to the camera (3,) or (n, 3) pass through another body."""
    ways = camera - points
    hidden = np.zeros(len(points), dtype=bool)
    for name in BODIES:
        if name == own:
            continue
        body = facets[name]
        middle = body.centres.mean(axis=0)
        reach = np.linalg.norm(body.centres - middle, axis=1).max()
        square = np.maximum((ways * ways).sum(axis=1), 1e-12)
        nearest = points + np.clip(((middle - points) * ways).sum(axis=1) / square, 0, 1)[:, None] * ways
        near = np.flatnonzero(~hidden & (np.linalg.norm(nearest - middle, axis=1) < 1.1 * reach))
        hidden[near] = _crosses(body, points[near], ways[near])
    return hidden


def _crosses(body: _Facets, points: Vector, ways: Vector) -> NDArray[np.bool_]:
    """Which segments from the points (n, 3) along the ways (n, 3) m have a part in a convex body."""
    start = points @ body.normals.T - (body.centres * body.normals).sum(axis=1)  # (n, facets) m, positive outside
    along = ways @ body.normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = -start / along  # share of the way at which a facet's plane is met
    enters = np.where(along < 0, meets, np.where((along == 0) & (start > 0), np.inf, 0.0)).max(axis=1, initial=0.0)
    leaves = np.where(along > 0, meets, 1.0).min(axis=1, initial=1.0)
    return np.asarray(enters < leaves)


def _normals(shape: Shape) -> tuple[Vector, Vector]:
    """Outward unit normals (n, 3) and areas (n,) m2 of a shape's triangles."""
    first, second, third = np.moveaxis(shape.vertices[shape.faces], 1, 0)
    crosses = np.cross(second - first, third - first)
    doubled = np.linalg.norm(crosses, axis=1)
    return crosses / doubled[:, None], doubled / 2


def _facets(shape: Shape, instant: Instant, body: str) -> _Facets:
    position, rotation = instant.positions[BODIES.index(body)], instant.rotations[BODIES.index(body)]
    normals, areas = _normals(shape)
    centres = shape.vertices[shape.faces].mean(axis=1)
    return _Facets(position + centres @ rotation.T, normals @ rotation.T, areas)

"""Where the viewer looks from at first: back and working hand are seen, checked by walking along the lines of sight."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from fatigue_planner.experiment.build import reaction_requests, worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.output.viewer.body_shapes import body_shapes
from fatigue_planner.output.viewer.motion_clip import Instant, MotionClip, motion_clip_of
from fatigue_planner.output.viewer.start_view import ENOUGH, FIELD_OF_VIEW_DEG, NARROWEST, StartView, start_view
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]


@pytest.fixture(scope="module")
def clips(paper: Experiment, reactions: tuple[Reaction, ...]) -> list[MotionClip]:
    parameters = worker_fatigue(paper)["average_man"]
    return [motion_clip_of(*pair, parameters) for pair in zip(reaction_requests(paper), reactions, strict=True)]


@dataclass(frozen=True)
class Stiff(MotionClip):
    """A clip that stands at ease the whole cycle, its right hand moved to a place."""

    hand_m: tuple[float, float, float] = (0, 0, 0)

    def instant(self, tick: int) -> Instant:
        first = super().instant(0)
        positions = first.positions.copy()
        positions[BODIES.index("right_hand")] = self.hand_m
        return replace(first, positions=positions)


def stiff(clip: MotionClip, *place: float) -> Stiff:
    return Stiff(**vars(clip), hand_m=place)  # type: ignore[arg-type]


def middle(clip: MotionClip) -> Instant:
    work = clip.motion.phase("work")
    return clip.instant((work.start + work.stop) // 2)


def seen(clip: MotionClip, view: StartView, *bodies: str) -> float:
    """The share of the lines of sight to bodies, a centimetre or two apart, that meet no other one before.

    Each is walked along from the camera in steps of a centimetre, from the first body on.
    """
    instant, shapes = middle(clip), body_shapes(clip.human.anthropometry)
    placed = {
        name: instant.positions[i] + shapes[name].vertices @ instant.rotations[i].T for i, name in enumerate(BODIES)
    }
    away = toward(view)
    sideways = np.cross([0, 0, 1], away) / np.linalg.norm(np.cross([0, 0, 1], away))
    upward = np.cross(away, sideways)
    goal = np.concatenate([placed[body] for body in bodies])
    step = 0.01 if len(bodies) == 1 else 0.03
    low, high = (goal @ sideways).min(), (goal @ sideways).max()
    bottom, top = (goal @ upward).min(), (goal @ upward).max()
    across, up = np.meshgrid(np.arange(low, high, step), np.arange(bottom, top, step))
    plane = across.ravel()[:, None] * sideways + up.ravel()[:, None] * upward + (goal @ away).mean() * away
    everything = np.concatenate(list(placed.values()))
    ways = plane - view.position_m
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    distances = -(everything - view.position_m) @ away
    steps = np.arange(distances.min() - 0.05, distances.max() + 0.3, 0.01)
    points = view.position_m + steps[:, None, None] * ways
    first = {}
    for name, corners in placed.items():
        centre = corners.mean(axis=0)
        reach = np.linalg.norm(corners - centre, axis=1).max()
        near = np.linalg.norm(points - centre, axis=2) < reach
        inside = np.zeros(near.shape, dtype=bool)
        planes = ConvexHull(corners).equations
        inside[near] = (points[near] @ planes[:, :3].T + planes[:, 3] < 0).all(axis=1)
        first[name] = np.where(inside.any(axis=0), inside.argmax(axis=0), len(steps))
    goal_first = np.min([first[body] for body in bodies], axis=0)
    others = np.min([each for name, each in first.items() if name not in bodies], axis=0)
    meets = goal_first < len(steps)
    return float((goal_first <= others)[meets].mean())


def toward(view: StartView) -> Vector:
    direction = view.position_m - view.look_at_m
    return np.asarray(direction / np.linalg.norm(direction))


@pytest.mark.slow
def test_the_back_and_the_working_hand_are_seen_from_behind_on_its_side(clips: list[MotionClip]) -> None:
    for clip in clips[::3]:
        view = start_view(clip)
        direction = toward(view)
        assert direction[0] < 0 and direction[1] < 0  # behind; the right hand works
        assert min(view.back_seen, view.hand_seen) >= ENOUGH
        assert seen(clip, view, "right_hand") == pytest.approx(view.hand_seen, abs=0.12)
        assert seen(clip, view, "thorax", "abdomen") > 0.5


def test_the_left_hand_is_looked_at_from_the_left(clips: list[MotionClip]) -> None:
    assert toward(start_view(replace(clips[0], working=("left",))))[1] > 0


@pytest.mark.slow
def test_a_hand_hidden_by_the_body_is_looked_for_from_elsewhere(clips: list[MotionClip]) -> None:
    """Held far left before the belly it is behind the trunk for who stands behind on the right."""
    usual, hidden = start_view(clips[0]), stiff(clips[0], 0.2, 0.25, 1.05)
    view = start_view(hidden)
    assert seen(hidden, usual, "right_hand") < 0.3
    assert view.hand_seen >= ENOUGH and seen(hidden, view, "right_hand") == pytest.approx(view.hand_seen, abs=0.12)


def test_the_whole_body_and_the_object_are_in_the_picture_of_a_narrow_window(clips: list[MotionClip]) -> None:
    half = np.tan(np.radians(FIELD_OF_VIEW_DEG) / 2)
    for clip in clips[::3]:
        view = start_view(clip)
        away = toward(view)
        across = np.cross([0, 0, 1], away)
        across /= np.linalg.norm(across)
        for instant in (clip.instant(0), middle(clip)):
            shapes = body_shapes(clip.human.anthropometry)
            points = np.concatenate([
                *(instant.positions[i] + shapes[name].vertices @ instant.rotations[i].T
                  for i, name in enumerate(BODIES)),
                [pose.position_m for pose in clip.objects],
            ]) - view.position_m  # fmt: skip
            depth = -points @ away
            assert (depth > 0).all()
            assert (np.abs(points @ across) / depth < half * NARROWEST).all()
            assert (np.abs(points @ np.cross(away, across)) / depth < half).all()

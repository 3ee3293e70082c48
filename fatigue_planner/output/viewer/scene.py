"""The scene of one motion: its viser nodes and their places at every instant."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pinocchio as pin
import viser
from matplotlib import colormaps
from numpy.typing import NDArray

from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import BODIES, JOINTS, SIDES
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.output.viewer.body_shapes import body_shapes, capsule_shape
from fatigue_planner.output.viewer.motion_clip import Instant, MotionClip

Vector = NDArray[np.float64]
Colour = tuple[int, int, int]

BODY, TOOL, OBJECT, CENTRE, FORCE, SOLE, MARKER = (
    (158, 168, 180), (0, 114, 178), (0, 158, 115), (204, 121, 167), (86, 180, 233), (60, 60, 60), (0, 0, 0)
)  # fmt: skip
ROBOT = (62, 84, 106)
UNSEEN_M = (0.0, 0.0, -1.0)  # below the ground
OPACITY = 0.4  # so that joints, centre of mass and forces are seen through the body
METRES_PER_NEWTON = 1e-3  # of the forces on the feet, some hundred N
METRES_PER_NEWTON_ON_A_HAND = 5e-3
COLOUR_STEPS = 24  # of the joints, from 0 to FULL_SHARE
FULL_SHARE = 0.6
_POSITION_STEP, _TURN_STEP = 2.0**-12, 2.0**-13  # what is not seen is not stored: 0.24 mm, 0.01 degrees


@cache
def _step_colour(step: int) -> Colour:
    red, green, blue, _ = colormaps["YlOrRd"](step / COLOUR_STEPS, bytes=True)
    return int(red), int(green), int(blue)


def load_colour(share: float) -> Colour:
    """The colour of a joint's load, the same as in the figures; share of strength."""
    return _step_colour(min(round(share / FULL_SHARE * COLOUR_STEPS), COLOUR_STEPS))


class Scene:
    """The scene of a motion; `show` brings it to an instant."""

    def __init__(self, scene: viser.SceneApi, clip: MotionClip) -> None:
        self._clip = clip
        stature = clip.human.anthropometry.stature_m
        scene.configure_environment_map("studio", environment_intensity=0.25)
        scene.add_grid(
            "/ground", 4.0, 4.0, cell_size=0.25, section_size=1.0, plane_color=(246, 246, 244), plane_opacity=1.0,
            cell_color=(225, 225, 225), section_color=(190, 190, 190), shadow_opacity=0.2,
        )  # fmt: skip
        shapes = body_shapes(clip.human.anthropometry)
        self._person = [
            scene.add_mesh_simple(
                f"/body/{body}", shapes[body].vertices, shapes[body].faces, color=BODY, opacity=OPACITY
            )
            for body in BODIES
        ]
        self._joints = [
            scene.add_icosphere(f"/joints/{joint.name}", 0.019 * stature, color=load_colour(0), cast_shadow=False)
            for joint in JOINTS
        ]
        self._tools = [
            scene.add_box(f"/tools/{side}", color=TOOL, dimensions=(0.24, 0.05, 0.05), visible=False) for side in SIDES
        ]
        objects = [
            scene.add_box(f"/objects/{i}", color=OBJECT, dimensions=(0.13, 0.1, 0.13), opacity=0.4, cast_shadow=False)
            for i in range(len(clip.objects))
        ]
        _place(objects, clip.objects)
        self._robot = _robot_nodes(scene, clip)
        self._centre = scene.add_icosphere("/centre_of_mass/centre", 0.035, color=CENTRE)
        self._plumb = scene.add_icosphere("/centre_of_mass/plumb", 0.018, color=CENTRE)
        self._forces = [
            scene.add_arrows(
                f"/forces/{place}", np.zeros((1, 2, 3)), FORCE, shaft_radius=0.012, head_radius=0.028, head_length=0.05
            )
            for place in ("right_foot", "left_foot", "right_hand", "left_hand")
        ]
        self._soles = scene.add_line_segments(
            "/soles", np.zeros((8, 2, 3)), SOLE, thickness=2.0, thickness_units="screen"
        )
        self._markers = None
        if clip.markers_m is not None:
            self._markers = scene.add_point_cloud(
                "/markers", np.zeros(clip.markers_m.shape[1:]), MARKER, point_size=0.016, point_shape="circle"
            )
        self._label = scene.add_label(
            "/label", "", position=(0, 0, 1.04 * stature), font_screen_scale=1.5, anchor="bottom-center"
        )

    def show(self, tick: int) -> None:
        """Show an instant."""
        clip, instant = self._clip, self._clip.instant(tick)
        for body, position, rotation in zip(self._person, instant.positions, instant.rotations, strict=True):
            body.position, body.wxyz = _rounded(position), _quaternion(rotation)
        for handle, joint in zip(self._joints, JOINTS, strict=True):
            handle.position = _rounded(instant.positions[BODIES.index(joint.child)])
            handle.color = load_colour(instant.joint_share[joint.name])
        _place(self._tools, instant.tools)
        for waypoint, parts in enumerate(self._robot if len(self._robot) > 1 else ()):
            for part in parts:
                part.visible = waypoint == clip.robot_waypoint(tick)
        self._centre.position = _rounded(instant.centre_of_mass_m)
        self._plumb.position = _rounded(instant.centre_of_mass_m * [1, 1, 0])
        for node, arrow in zip(self._forces, force_arrows(instant), strict=True):
            node.points = arrow[None]
            node.visible = bool((arrow[0] != arrow[1]).any())
        self._soles.points = sole_outlines(clip.human, instant)
        if self._markers is not None and clip.markers_m is not None:
            seen = np.isfinite(clip.markers_m[tick])
            self._markers.points = _rounded(np.where(seen, clip.markers_m[tick], UNSEEN_M)).astype(np.float32)
        self._label.text = f"{clip.phase(tick)}, {tick * clip.motion.time_step_s:.1f} s"


def _robot_nodes(scene: viser.SceneApi, clip: MotionClip) -> list[list[viser.MeshHandle]]:
    """The robot's capsules at each of its waypoints, if there is one."""
    if clip.robot is None:
        return []
    nodes = []
    for waypoint in range(len(clip.robot.times_s)):
        shapes = [capsule_shape(ends, radius) for ends, radius in zip(*clip.robot.parts(waypoint), strict=True)]
        nodes.append([
            scene.add_mesh_simple(f"/robot/{waypoint}/{i}", shape.vertices, shape.faces, color=ROBOT, cast_shadow=False)
            for i, shape in enumerate(shapes)
        ])  # fmt: skip
    return nodes


def force_arrows(instant: Instant) -> NDArray[np.float32]:
    """Arrows (4, 2, 3) m of the forces on feet and hands, from where they act; on the hands in a larger scale."""
    scales = (METRES_PER_NEWTON, METRES_PER_NEWTON, METRES_PER_NEWTON_ON_A_HAND, METRES_PER_NEWTON_ON_A_HAND)
    ends = [
        (force.point_m, force.point_m + scale * force.force_n)
        for force, scale in zip(instant.forces, scales, strict=True)
    ]
    return _rounded(np.array(ends)).astype(np.float32)


def sole_outlines(human: Human, instant: Instant) -> NDArray[np.float32]:
    """The edges of both soles, (8, 2, 3) m, a millimetre above the ground."""
    heel, toe, half_breadth, height = human.anthropometry.sole_rectangle()
    corners = np.array([[heel, -half_breadth], [toe, -half_breadth], [toe, half_breadth], [heel, half_breadth]])
    edges = []
    for side in SIDES:
        foot = BODIES.index(f"{side}_foot")
        local = np.column_stack([corners, np.full(4, height + 0.001)])
        world = instant.positions[foot] + local @ instant.rotations[foot].T
        edges.append(np.stack([world, np.roll(world, -1, axis=0)], axis=1))
    return _rounded(np.concatenate(edges)).astype(np.float32)


def _place(boxes: Sequence[viser.BoxHandle], poses: Sequence[Pose]) -> None:
    """Put boxes at poses and hide those left over."""
    for i, box in enumerate(boxes):
        box.visible = i < len(poses)
        if box.visible:
            box.position, box.wxyz = _rounded(poses[i].position_m), _quaternion(poses[i].rotation)


def _rounded(values: Vector) -> Vector:
    return np.asarray(np.round(values / _POSITION_STEP) * _POSITION_STEP)


def _quaternion(rotation: Vector) -> Vector:
    """Quaternion (w, x, y, z), w >= 0, rounded."""
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.asarray(np.round(np.array([w, x, y, z]) * (1 if w >= 0 else -1) / _TURN_STEP) * _TURN_STEP)

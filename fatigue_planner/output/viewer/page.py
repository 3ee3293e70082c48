"""One self-contained page in which the human performs the reactions, its viser nodes and their places."""

import contextlib
import io
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
import pinocchio as pin
import viser
from matplotlib import colormaps
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import BODIES, JOINTS, SIDES
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.output.viewer.body_shapes import body_shapes
from fatigue_planner.output.viewer.motion_clip import Instant, MotionClip

Vector = NDArray[np.float64]
Colour = tuple[int, int, int]

BODY, TOOL, OBJECT, CENTRE, FORCE, SOLE = (
    (158, 168, 180), (0, 114, 178), (0, 158, 115), (204, 121, 167), (86, 180, 233), (60, 60, 60)
)  # fmt: skip
OPACITY = 0.4  # so that joints, centre of mass and forces are seen through the body
METRES_PER_NEWTON = 1e-3  # of the forces on the feet, some hundred N
METRES_PER_NEWTON_ON_A_HAND = 5e-3
COLOUR_STEPS = 24  # of the joints, from 0 to FULL_SHARE
FULL_SHARE = 0.6
_POSITION_STEP, _TURN_STEP = 2.0**-12, 2.0**-13  # what is not seen is not stored: 0.24 mm, 0.01 degrees
FRAMES_PER_S = 25

_STYLE = (
    "position:fixed;top:14px;right:14px;z-index:1;pointer-events:none;padding:10px 14px;border-radius:6px;"
    "background:rgba(255,255,255,.85);color:#222;font:13px/1.55 system-ui,sans-serif;max-width:290px"
)


def page(clips: Sequence[MotionClip]) -> str:
    """The page (HTML): the clips one after the other, to be played, scrubbed and looked at from anywhere."""
    with _quiet_server() as server:
        server.initial_camera.position = (1.85, -2.0, 1.35)
        server.initial_camera.look_at = (0.1, -0.05, 0.92)
        server.initial_camera.fov = float(np.radians(45))
        scene = Scene(server.scene, clips)
        recording = server.get_scene_serializer()
        for clip in clips:
            for frame in range(round(clip.duration_s * FRAMES_PER_S)):
                scene.show(clip, clip.tick(frame / FRAMES_PER_S))
                recording.insert_sleep(1 / FRAMES_PER_S)
        html = recording.as_html()
    head, end, tail = html.rpartition("</body>")
    return head + _legend() + end + tail


@contextlib.contextmanager
def _quiet_server() -> Iterator[viser.ViserServer]:
    """A viser server, which its scene needs, for nobody else: on a free port of this machine, silent, stopped."""
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            yield server
        finally:
            server.stop()


@cache
def _step_colour(step: int) -> Colour:
    red, green, blue, _ = colormaps["YlOrRd"](step / COLOUR_STEPS, bytes=True)
    return int(red), int(green), int(blue)


def load_colour(share: float) -> Colour:
    """The colour of a joint's load, the same as in the figures; share of strength."""
    return _step_colour(min(round(share / FULL_SHARE * COLOUR_STEPS), COLOUR_STEPS))


class Scene:
    """The scene of some clips; `show` brings it to an instant of one of them."""

    def __init__(self, scene: viser.SceneApi, clips: Sequence[MotionClip]) -> None:
        self._scene = scene
        stature = max(clip.human.anthropometry.stature_m for clip in clips)
        scene.configure_environment_map("studio", environment_intensity=0.25)
        scene.add_grid(
            "/ground", 4.0, 4.0, cell_size=0.25, section_size=1.0, plane_color=(246, 246, 244), plane_opacity=1.0,
            cell_color=(225, 225, 225), section_color=(190, 190, 190), shadow_opacity=0.2,
        )  # fmt: skip
        workers = dict.fromkeys(clip.human.anthropometry for clip in clips)
        self._people = {worker: self._add_person(f"/people/{i}", worker) for i, worker in enumerate(workers)}
        self._joints = [
            scene.add_icosphere(f"/joints/{joint.name}", 0.019 * stature, color=load_colour(0), cast_shadow=False)
            for joint in JOINTS
        ]
        self._tools = [
            scene.add_box(f"/tools/{side}", color=TOOL, dimensions=(0.24, 0.05, 0.05), visible=False) for side in SIDES
        ]
        objects = max(len(clip.objects) for clip in clips)
        self._objects = [
            scene.add_box(f"/objects/{i}", color=OBJECT, dimensions=(0.13, 0.1, 0.13), opacity=0.4, cast_shadow=False)
            for i in range(objects)
        ]
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
        self._label = scene.add_label(
            "/label", "", position=(0, 0, 1.04 * stature), font_screen_scale=1.5, anchor="bottom-center"
        )

    def show(self, clip: MotionClip, tick: int) -> None:
        """Show an instant of a clip."""
        instant = clip.instant(tick)
        for worker, person in self._people.items():
            for body in person:
                body.visible = worker == clip.human.anthropometry
        person = self._people[clip.human.anthropometry]
        for body, position, rotation in zip(person, instant.positions, instant.rotations, strict=True):
            body.position, body.wxyz = _rounded(position), _quaternion(rotation)
        for handle, joint in zip(self._joints, JOINTS, strict=True):
            handle.position = _rounded(instant.positions[BODIES.index(joint.child)])
            handle.color = load_colour(instant.joint_share[joint.name])
        _place(self._tools, instant.tools)
        _place(self._objects, clip.objects)
        self._centre.position = _rounded(instant.centre_of_mass_m)
        self._plumb.position = _rounded(instant.centre_of_mass_m * [1, 1, 0])
        for node, arrow in zip(self._forces, force_arrows(instant), strict=True):
            node.points = arrow[None]
            node.visible = bool((arrow[0] != arrow[1]).any())
        self._soles.points = sole_outlines(clip.human, instant)
        time = tick * clip.motion.time_step_s
        self._label.text = f"{clip.title}: {clip.phase(tick)}, {time:.1f} s"

    def _add_person(self, name: str, worker: Anthropometry) -> list[viser.MeshHandle]:
        """A mesh for each of `BODIES`."""
        shapes = body_shapes(worker)
        return [
            self._scene.add_mesh_simple(
                f"{name}/{body}", shapes[body].vertices, shapes[body].faces, color=BODY, opacity=OPACITY
            )
            for body in BODIES
        ]


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


def _legend() -> str:
    """What the colours mean, in a box (HTML) that does not catch the mouse."""
    stops = [load_colour(FULL_SHARE * step / COLOUR_STEPS) for step in range(COLOUR_STEPS + 1)]
    bar = f"height:12px;margin-top:3px;background:linear-gradient(to right,{','.join(_css(stop) for stop in stops)})"
    scale = "".join(f"<span>{round(100 * FULL_SHARE * part)} %</span>" for part in (0, 0.5, 1))
    on_foot, on_hand = 100 * METRES_PER_NEWTON, 100 * METRES_PER_NEWTON_ON_A_HAND
    rows = (
        (CENTRE, "centre of mass, and the point of the ground below it"),
        (FORCE, f"force; 100 N are {on_foot:g} m on a foot, {on_hand:g} m on a hand"),
        (TOOL, "tool, or another mass in the hand"),
        (OBJECT, "where the hands have to go"),
    )
    signs = "".join(f'<div><span style="color:{_css(colour)}">&#9632;</span> {text}</div>' for colour, text in rows)
    return (
        f'<div id="legend" style="{_STYLE}"><div>spheres: largest torque at the joint, share of strength</div>'
        f'<div style="{bar}"></div><div style="display:flex;justify-content:space-between">{scale}</div>{signs}'
        "<div>space: play or pause; drag: orbit; wheel: zoom</div></div>"
    )


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)

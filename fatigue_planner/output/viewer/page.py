"""One self-contained page in which the human performs the reactions, chosen from a menu."""

import base64
import contextlib
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby
from urllib.parse import quote

import numpy as np
import viser
from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape

from fatigue_planner.output.viewer.motion_clip import MotionClip
from fatigue_planner.output.viewer.scene import (
    CENTRE,
    COLOUR_STEPS,
    FORCE,
    FULL_SHARE,
    MARKER,
    METRES_PER_NEWTON,
    METRES_PER_NEWTON_ON_A_HAND,
    OBJECT,
    ROBOT,
    TOOL,
    Colour,
    Scene,
    load_colour,
)
from fatigue_planner.output.viewer.start_view import FIELD_OF_VIEW_DEG, start_view
from fatigue_planner.reactions.reaction import ReactionName

FRAMES_PER_S = 25
MAX_PAGE_BYTES = 5_000_000  # a larger page keeps its motions in files beside it, loaded when they are chosen


@dataclass(frozen=True)
class Recording:
    """A motion as viser plays it, base64; verdict: as of its clip, and why; whether with a robot, or with markers."""

    name: ReactionName
    verdict: str
    remarks: Sequence[str]
    data: str
    robot: bool = False
    has_markers: bool = False


@dataclass(frozen=True)
class Page:
    """A page (HTML), and by name the files (JavaScript) that have to be in the folder beside it."""

    html: str
    beside: dict[str, str] = field(default_factory=dict)


def record(clip: MotionClip) -> Recording:
    """A clip, to be played, scrubbed and looked at from anywhere."""
    with _quiet_server() as server, server.atomic():
        view = start_view(clip)
        server.initial_camera.position = tuple(np.round(view.position_m, 2))
        server.initial_camera.look_at = tuple(np.round(view.look_at_m, 2))
        server.initial_camera.fov = float(np.radians(FIELD_OF_VIEW_DEG))
        scene = Scene(server.scene, clip)
        recording = server.get_scene_serializer()
        for frame in range(round(clip.duration_s * FRAMES_PER_S)):
            scene.show(clip.tick(frame / FRAMES_PER_S))
            recording.insert_sleep(1 / FRAMES_PER_S)
        data = base64.b64encode(recording.serialize()).decode()
    seen = clip.robot is not None, clip.markers_m is not None
    return Recording(clip.name, clip.verdict, clip.remarks, data, *seen)


def page(title: str, recordings: Sequence[Recording], failed: Sequence[str], folder: str) -> Page:
    """The page with a menu of the recordings, in which the first is shown, and what could not be performed.

    What does not fit into it is to be put in the `folder` beside it.
    """
    with _quiet_server() as server:
        client = server.get_scene_serializer().as_html()
    head, end_of_head, rest = client.partition("</head>")
    body, end_of_body, tail = rest.rpartition("</body>")
    outside = len(client) + sum(len(recording.data) for recording in recordings) > MAX_PAGE_BYTES
    files = {f"{number}.js": recording.data for number, recording in enumerate(recordings, 1)} if outside else {}
    reactions = [
        {
            "name": str(recording.name),
            "verdict": recording.verdict,
            "remarks": list(recording.remarks),
            "motion": f"{quote(folder)}/{file}" if outside else recording.data,
        }
        for recording, file in zip(recordings, files or [""] * len(recordings), strict=True)
    ]
    chooser = _template("head.html.j2").render(title=title, reactions=reactions, outside=outside)
    menu = _template("menu.html.j2").render(
        workers=[(worker, list(each)) for worker, each in groupby(recordings, lambda recording: recording.name.worker)],
        title=title, failed=failed, colours=_colours(), full=FULL_SHARE,
        signs=_signs(any(one.robot for one in recordings), any(one.has_markers for one in recordings)),
    )  # fmt: skip
    html = head + chooser + end_of_head + body + menu + end_of_body + tail
    return Page(html, {name: f'window.__VISER_EMBED_DATA__="{data}";\n' for name, data in files.items()})


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
def _template(name: str) -> Template:
    loader = PackageLoader("fatigue_planner.output.viewer", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(["j2"]), undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    return environment.get_template(name)


def _colours() -> str:
    """The colours of the joints from no load to the full one, for a gradient (CSS)."""
    return ",".join(_css(load_colour(FULL_SHARE * step / COLOUR_STEPS)) for step in range(COLOUR_STEPS + 1))


def _signs(robot: bool, markers: bool) -> list[tuple[str, str]]:
    """Colours (CSS) and what they stand for."""
    on_foot, on_hand = 100 * METRES_PER_NEWTON, 100 * METRES_PER_NEWTON_ON_A_HAND
    return [
        (_css(CENTRE), "centre of mass, and the point of the ground below it"),
        (_css(FORCE), f"force; 100 N are {on_foot:g} m on a foot, {on_hand:g} m on a hand"),
        (_css(TOOL), "tool, or another mass in the hand"),
        (_css(OBJECT), "where the hands have to go"),
        *([(_css(ROBOT), "robot as capsules, what it stands on, and what it holds the object with")] if robot else []),
        *([(_css(MARKER), "a marker of the recording")] if markers else []),
    ]


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)

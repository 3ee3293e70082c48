"""One self-contained page in which the human performs the reactions."""

import contextlib
import io
from collections.abc import Iterator, Sequence

import numpy as np
import viser

from fatigue_planner.output.viewer.motion_clip import MotionClip
from fatigue_planner.output.viewer.scene import (
    CENTRE,
    COLOUR_STEPS,
    FORCE,
    FULL_SHARE,
    METRES_PER_NEWTON,
    METRES_PER_NEWTON_ON_A_HAND,
    OBJECT,
    TOOL,
    Colour,
    Scene,
    load_colour,
)

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

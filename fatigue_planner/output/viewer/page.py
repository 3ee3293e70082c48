"""One self-contained page in which the human performs the reactions."""

import contextlib
import io
from collections.abc import Iterator, Sequence

import numpy as np
import viser

from fatigue_planner.output.viewer.legend import legend
from fatigue_planner.output.viewer.motion_clip import MotionClip
from fatigue_planner.output.viewer.scene import Scene

FRAMES_PER_S = 25


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
    return head + legend() + end + tail


@contextlib.contextmanager
def _quiet_server() -> Iterator[viser.ViserServer]:
    """A viser server, which its scene needs, for nobody else: on a free port of this machine, silent, stopped."""
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            yield server
        finally:
            server.stop()

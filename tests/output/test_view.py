"""`fatplan view`: what the page holds, where things stand in it, the strip of poses, and what is refused."""

import base64
import io
import json
import os
import re
import subprocess
import sys
import threading
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pinocchio as pin
import pytest
import zstandard
from commands import FATPLAN, refused
from conftest import PAPER
from PIL import Image
from scipy.spatial import ConvexHull

from fatigue_planner.cli.view import view
from fatigue_planner.core.errors import SelectionError
from fatigue_planner.experiment.build import reaction_requests, worker_fatigue
from fatigue_planner.experiment.robot_cell import RobotCell
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.output.figures.postures import filmstrip
from fatigue_planner.output.viewer.body_shapes import body_shapes, capsule_shape
from fatigue_planner.output.viewer.motion_clip import MotionClip, motion_clip_of
from fatigue_planner.output.viewer.page import FRAMES_PER_S, Recording, page, record
from fatigue_planner.output.viewer.scene import (
    METRES_PER_NEWTON,
    METRES_PER_NEWTON_ON_A_HAND,
    force_arrows,
    load_colour,
)
from fatigue_planner.output.viewer.start_view import start_view
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.robot.settings import RobotBase, RobotSettings

SHOWN = "average_man/low/back"


@pytest.fixture(scope="module")
def clips(paper: Experiment, reactions: tuple[Reaction, ...]) -> list[MotionClip]:
    parameters = worker_fatigue(paper)["average_man"]
    return [motion_clip_of(*pair, parameters) for pair in zip(reaction_requests(paper), reactions, strict=True)]


@pytest.fixture(scope="module")
def shown(clips: list[MotionClip]) -> MotionClip:
    return next(clip for clip in clips if str(clip.name) == SHOWN)


@pytest.fixture(scope="module")
def html(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The page of one reaction as the command writes and opens it; the browser notes what it is given."""
    folder = tmp_path_factory.mktemp("view")
    browser = folder / "browser.sh"
    browser.write_text(f'#!/bin/sh\necho "$1" > "{folder}/opened"\n')
    browser.chmod(0o755)
    command = [*FATPLAN, "view", str(PAPER), "--cache", str(cache_folder), "--reaction", SHOWN]
    environment = os.environ | {"BROWSER": f"{browser} %s", "PYTHONPATH": str(PAPER.parents[1])}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    path = folder / "results" / "paper" / "view.html"
    assert done.stdout.startswith(f"results/paper/view.html: {SHOWN}; ") and len(done.stdout.splitlines()) == 1
    assert not done.stderr
    assert (folder / "opened").read_text().strip() == path.as_uri()
    return path.read_text()


@pytest.fixture(scope="module")
def messages(html: str) -> list[tuple[float, dict[str, Any]]]:
    """What the page's recording tells the viewer, with times in s."""
    (reaction,) = reactions_of(html)
    return messages_of(reaction["motion"])


def messages_of(data: str) -> list[tuple[float, dict[str, Any]]]:
    stream = io.BytesIO(base64.b64decode(data)[8:])
    raw = zstandard.ZstdDecompressor().stream_reader(stream).read()
    length = int.from_bytes(raw[:8], "little")
    return [(time, message) for time, message in msgspec.msgpack.decode(raw[8 : 8 + length])["messages"]]


def reactions_of(html: str) -> list[dict[str, Any]]:
    """What the page's menu chooses from."""
    (text,) = re.findall(r'<script type="application/json" id="reactions">(.*?)</script>', html, re.DOTALL)
    return list(json.loads(text))


def test_the_page_needs_nothing_else(html: str) -> None:
    loads = re.findall(r"""(?:src|href|url|import)\s*[=(]\s*["']?((?:https?:)?//[^"')\s>]+)""", html)
    assert not loads
    assert len(html) < 2_500_000
    assert 'id="legend"' in html and "share of strength" in html


@pytest.mark.slow
def test_the_page_is_the_same_every_time(html: str, shown: MotionClip) -> None:
    before = set(threading.enumerate())
    made = page("paper", [record(shown)], [], "view_motions")
    assert made.html == html and not made.beside
    assert set(threading.enumerate()) <= before  # nor is anything left running


def test_the_page_holds_the_scene(messages: list[tuple[float, dict[str, Any]]], shown: MotionClip) -> None:
    names = {message.get("name") for _, message in messages}
    assert {
        "/ground",
        "/body/head",
        "/tools/right",
        "/objects/0",
        "/forces/right_foot",
        "/soles",
        "/label",
    } <= names
    assert {f"/joints/{joint.name}" for joint in JOINTS} <= names
    labels = [message["updates"]["text"] for _, message in messages if "text" in message.get("updates", {})]
    assert labels[0] == "reach, 0.0 s" and labels[-1] == "return, 16.0 s"
    assert max(time for time, _ in messages) == pytest.approx(shown.duration_s, abs=2 / FRAMES_PER_S)


def test_the_centre_of_mass_is_pinocchios(messages: list[tuple[float, dict[str, Any]]], shown: MotionClip) -> None:
    told = positions_of(messages, "/centre_of_mass/centre")
    model = shown.bodies[0].model
    for time, position in told[:: len(told) // 20]:
        tick = shown.tick(time)
        expected = pin.centerOfMass(model, model.createData(), shown.motion.configuration[tick])
        np.testing.assert_allclose(position, expected, atol=3e-4)


def test_the_body_follows_the_motion(messages: list[tuple[float, dict[str, Any]]], shown: MotionClip) -> None:
    hand = positions_of(messages, "/body/right_hand")
    model, data = shown.bodies[0].model, shown.bodies[0].model.createData()
    for time, position in hand[:: len(hand) // 20]:
        pin.framesForwardKinematics(model, data, shown.motion.configuration[shown.tick(time)])
        np.testing.assert_allclose(position, data.oMf[model.getFrameId("right_hand")].translation, atol=3e-4)


def positions_of(messages: list[tuple[float, dict[str, Any]]], name: str) -> list[tuple[float, Any]]:
    return [(t, m["position"]) for t, m in messages if m["type"] == "SetPositionMessage" and m["name"] == name]


def test_forces_carry_the_body(shown: MotionClip) -> None:
    """At rest they add up to the weight, point up, act on the soles and balance about the centre of mass."""
    work = shown.motion.phase("work")
    instant = shown.instant(work.stop - 1)
    total = sum(force.force_n for force in instant.forces)
    np.testing.assert_allclose(total, [0, 0, shown.bodies[0].mass_kg * GRAVITY_MPS2], atol=2.0)
    moment = sum(np.cross(force.point_m - instant.centre_of_mass_m, force.force_n) for force in instant.forces)
    np.testing.assert_allclose(moment[:2], 0, atol=2.0)
    arrows = force_arrows(instant)
    assert arrows.shape == (4, 2, 3) and (np.abs(arrows[:2, 0, 2]) < 1e-3).all()
    assert arrows[0, 0, 1] < 0 < arrows[1, 0, 1]  # right foot, left foot
    np.testing.assert_allclose(arrows[:2, 1, 2].sum() / METRES_PER_NEWTON, total[2], atol=1)


def test_shares_and_colours(shown: MotionClip, paper: Experiment) -> None:
    instant = shown.instant(shown.tick(8.0))
    assert set(instant.joint_share) == {joint.name for joint in JOINTS}
    assert max(instant.joint_share, key=instant.joint_share.__getitem__) in {"lumbar", "right_wrist", "right_hip"}
    assert load_colour(0.0) == (255, 255, 204) and load_colour(0.6) == load_colour(2.0) == (128, 0, 38)
    np.testing.assert_allclose(shown.objects[0].position_m, [0.4, -0.15, 0.5])


def test_the_tool_is_shown_while_held(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Held only for the work, it is no part of the centre of mass before; weightless, it is not there."""
    request, parameters = reaction_requests(paper)[0], worker_fatigue(paper)["average_man"]
    working = replace(request, motion=replace(request.motion, tool=paper.tool.model_copy(update={"held": "work"})))
    clip = motion_clip_of(working, reactions[0], parameters)
    assert [len(clip.instant(clip.tick(time)).tools) for time in (1.0, 8.0, 15.0)] == [0, 1, 0]
    always = motion_clip_of(request, reactions[0], parameters)
    assert always.instant(0).centre_of_mass_m[2] < clip.instant(0).centre_of_mass_m[2]
    none = replace(request, motion=replace(request.motion, tool=paper.tool.model_copy(update={"mass_kg": 0.0})))
    assert not motion_clip_of(none, reactions[0], parameters).instant(500).tools


def test_the_shapes_are_closed_and_of_the_bodys_size(shown: MotionClip) -> None:
    """Together they are somewhat larger than the body's 75 litres, as they overlap at the joints."""
    litres = 0.0
    for shape in body_shapes(shown.human.anthropometry).values():
        edges = np.sort(np.concatenate([shape.faces[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0))]), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        corners = shape.vertices[shape.faces]
        volumes = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum(axis=1) / 6
        assert 1000 * volumes.sum() == pytest.approx(1000 * ConvexHull(shape.vertices).volume)  # seen from outside
        litres += 1000 * volumes.sum()
    assert litres == pytest.approx(75, rel=0.15)  # a body is about as dense as water


def test_the_strip_has_a_panel_per_reaction_and_time(clips: list[MotionClip]) -> None:
    figure = filmstrip(clips[:2], [0.0, 8.0, 16.0])
    panels = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title() for axes in panels] == ["reach, 0 s", "work, 8 s", "return, 16 s"] * 2
    assert len([axes for axes in filmstrip(clips, []).axes if axes.get_title()]) == 16


def test_the_command_saves_a_png(cache_folder: Path, tmp_path: Path) -> None:
    paths = [tmp_path / "poses.png", tmp_path / "again.png"]
    for path in paths:
        view(PAPER, cache_folder, ["average_man/high/arm"], path, [3.0, 8.0])
    with Image.open(paths[0]) as image:
        assert 600 < image.width < 800 and 550 < image.height < 750  # two panels, a colour bar
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"save": Path("view.pdf")}, "--save view.pdf: the name must end in .html or .png"),
        ({"save": Path("a.png"), "at": [17.0]}, "--at 17: outside the cycle, which lasts from 0 to 16 s."),
        ({"save": Path("a.png"), "at": [float("nan")]}, "--at nan: outside the cycle"),
        ({"at": [3.0]}, "--at 3: only for the poses of a .png"),
    ],
)
def test_what_is_refused(cache_folder: Path, options: dict[str, Any], expected: str) -> None:
    with pytest.raises(SelectionError, match=re.escape(expected)):
        view(PAPER, cache_folder, **options)


def test_an_unknown_reaction_is_exit_code_2(cache_folder: Path) -> None:
    message = refused(2, "view", PAPER, "--cache", cache_folder, "--reaction", "high/nose")
    assert (
        "--reaction high/nose: not in the experiment; available: average_man/high/arm, average_man/high/back" in message
    )


def test_the_page_is_loaded_only_when_asked_for() -> None:
    code = "import sys; import fatigue_planner.cli.view; sys.exit('viser' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_times_of_the_recording_only_grow(messages: list[tuple[float, dict[str, Any]]]) -> None:
    assert all(before <= after for (before, _), (after, _) in pairwise(messages))


def test_forces_on_the_hands_are_drawn_larger(shown: MotionClip) -> None:
    pushed = replace(shown, motion=replace(shown.motion, hand_force_n=np.full_like(shown.motion.hand_force_n, 10.0)))
    arrows = force_arrows(pushed.instant(5))
    np.testing.assert_allclose(arrows[2:, 1] - arrows[2:, 0], METRES_PER_NEWTON_ON_A_HAND * 10, atol=1e-3)


def test_the_camera_starts_where_back_and_hand_are_seen(
    messages: list[tuple[float, dict[str, Any]]], shown: MotionClip
) -> None:
    (place,) = [message["position"] for _, message in messages if message["type"] == "SetCameraPositionMessage"]
    np.testing.assert_allclose(place, start_view(shown).position_m, atol=0.006)


def test_the_menu_tells_what_no_person_would_do(html: str, shown: MotionClip) -> None:
    (reaction,) = reactions_of(html)
    assert reaction["name"] == SHOWN and reaction["verdict"] == shown.verdict == "implausible"
    assert shown.remarks and reaction["remarks"] == list(shown.remarks)
    assert '<optgroup label="average_man">' in html and "low / back: implausible</option>" in html
    assert 'id="failed"' not in html


def test_the_robot_stands_where_it_presents(paper: Experiment, clips: list[MotionClip]) -> None:
    robot = RobotSettings(arm="ur5e", base_m=RobotBase(x=1.1, y=-0.25, z=0.5))
    cell, clip = RobotCell(paper.model_copy(update={"robot": robot})), clips[0]
    shape = cell.shape("high")
    assert shape is not None and shape.waypoint(3.0) == 0
    presented = replace(clip, robot=shape, remarks=(cell.said(clip.name, clip.motion),))
    recording = record(presented)
    told = [message for _, message in messages_of(recording.data) if message.get("name", "").startswith("/robot/")]
    meshes = [message for message in told if "vertices" in message.get("props", {})]
    ends, radii = shape.parts(0)
    assert len(meshes) == len(radii) == 1 + 11 + 1  # pedestal, arm, and what it holds the object with
    for (start, end), radius in zip(ends, radii, strict=True):
        vertices, along = capsule_shape(np.array([start, end]), radius).vertices, end - start
        share = np.clip((vertices - start) @ along / max(along @ along, 1e-12), 0, 1)
        away = np.linalg.norm(vertices - start - share[:, None] * along, axis=1)
        assert 0.95 * radius < away.min() and away.max() == pytest.approx(radius)  # spheres of flat facets
    np.testing.assert_allclose(shape.holder[0, 1], clip.objects[0].position_m, atol=1e-12)
    assert recording.robot and "robot as capsules" in page("paper", [recording], [], "m").html
    assert "robot as capsules" not in page("paper", recordings(["shelf"]), [], "m").html
    assert re.fullmatch(r"The robot comes as near as -?\d+ cm to the [a-z ]+, at \d+\.\d s.*\.", presented.remarks[0])
    assert len(filmstrip([presented], [8.0]).axes[0].patches) == len(filmstrip([clip], [8.0]).axes[0].patches) + 13


def recordings(names: list[str], data: str = "AAAA") -> list[Recording]:
    return [Recording(ReactionName("anna", name, "arm"), "ok", [], data) for name in names]


def test_the_menu_groups_by_worker_and_tells_what_failed() -> None:
    others = [Recording(ReactionName("<bob>", "shelf", "back"), "implausible", ["</script> 5 mm"], "BBBB")]
    html = page("shop", [*recordings(["shelf", "floor"]), *others], ["anna/attic/arm: too high & far"], "m").html
    groups = re.findall(r'<optgroup label="([^"]+)">(.*?)</optgroup>', html, re.DOTALL)
    options = [(worker, re.findall(r'<option value="([^"]+)">([^<]+)<', inside)) for worker, inside in groups]
    assert options == [
        ("anna", [("anna/shelf/arm", "shelf / arm: ok"), ("anna/floor/arm", "floor / arm: ok")]),
        ("&lt;bob&gt;", [("&lt;bob&gt;/shelf/back", "shelf / back: implausible")]),
    ]
    assert reactions_of(html)[2]["remarks"] == ["</script> 5 mm"]
    assert "1 cannot be performed" in html and "too high &amp; far" in html


def test_motions_too_large_for_the_page_lie_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = recordings(["shelf", "floor"])
    assert not page("shop", shown, [], "my view#_motions").beside
    monkeypatch.setattr("fatigue_planner.output.viewer.page.MAX_PAGE_BYTES", 500_000)
    made = page("shop", shown, [], "my view#_motions")
    assert made.beside == {f"{number}.js": 'window.__VISER_EMBED_DATA__="AAAA";\n' for number in (1, 2)}
    places = [reaction["motion"] for reaction in reactions_of(made.html)]
    assert places == ["my%20view%23_motions/1.js", "my%20view%23_motions/2.js"]


@pytest.mark.slow
def test_the_command_puts_motions_beside_a_large_page(
    cache_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fatigue_planner.output.viewer.page.MAX_PAGE_BYTES", 500_000)
    view(PAPER, cache_folder, [SHOWN], tmp_path / "v.html")
    (reaction,) = reactions_of((tmp_path / "v.html").read_text())
    assert reaction["motion"] == "v_motions/1.js"
    assert (tmp_path / "v_motions" / "1.js").read_text().startswith('window.__VISER_EMBED_DATA__="')

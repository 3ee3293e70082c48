"""`fatplan view`: the human performs the reactions, on a page or as poses side by side."""

import time
import webbrowser
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, talk, warn
from fatigue_planner.core.errors import FailedMotionError, SelectionError

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.output.viewer.motion_clip import MotionClip
    from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionRequest

MAX_ROWS = 12  # reactions in a picture, if none is named, and named in what is printed
SUFFIXES = (".html", ".png")


def view(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    reaction: Annotated[
        list[str] | None,
        typer.Option("--reaction", help="Show only this reaction (repeatable), as `simulate` names it."),
    ] = None,
    save: Annotated[
        Path | None, typer.Option("--save", help="Save a page (.html) or the poses side by side (.png).")
    ] = None,
    at: Annotated[
        list[float] | None, typer.Option("--at", help="Seconds of the cycle, for the poses of a .png (repeatable).")
    ] = None,
    plugins: options.Plugins = None,
) -> None:
    """Show the digital human performing the reactions of an EXPERIMENT, in a browser or as a picture.

    The page needs nothing but a browser: choose a reaction, play, scrub, orbit. Without --save it is opened at once.
    Needs the reactions of `fatplan simulate`.
    """
    from fatigue_planner.core.files import writable_folder
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.reactions.cache import ReactionCache

    begin = time.perf_counter()
    settings = load_experiment(experiment)
    path = save or options.DEFAULT_RESULTS / settings.name / "view.html"
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise SelectionError(f"--save {path}: the name must end in {' or '.join(SUFFIXES)}.")
    if at and kind != ".png":
        raise SelectionError(f"--at {at[0]:g}: only for the poses of a .png; the page shows the whole cycle.")
    writable_folder(path.parent)
    requests = _requests(settings, reaction or [])
    failed: list[FailedReaction] = []
    if kind == ".png" and not reaction and len(requests) > MAX_ROWS:
        talk().print(f"The first {MAX_ROWS} of {len(requests)} reactions; choose others with --reaction.", markup=False)
        requests = requests[:MAX_ROWS]
    how = options.command_line("simulate", experiment, cache)
    clips = _motion_clips(settings, requests, ReactionCache(cache).stream(requests, how), bool(reaction), failed)
    if kind == ".png":
        names, size = _save_poses(path, list(clips), at or [])
    else:
        names, size = _save_page(path, settings.name, clips, len(requests), failed)
    warn(map(_cannot_be_shown, failed))
    shown = ", ".join(names) if len(names) <= MAX_ROWS else f"{len(names)} reactions"
    typer.echo(f"{path}: {shown}; {size / 1e6:.1f} MB ({time.perf_counter() - begin:.1f} s).")
    if save is None and not webbrowser.open(path.resolve().as_uri()):
        typer.echo(f"No browser found; open {path} in one.")


def _requests(settings: "Experiment", wanted: Sequence[str]) -> "list[ReactionRequest]":
    """The reactions to show, in the experiment's order. Raises SelectionError for a name it does not have."""
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.study.benchmark.selection import choose

    requests = reaction_requests(settings)
    chosen = choose("reaction", [str(request.name) for request in requests], wanted)
    return [request for request in requests if str(request.name) in chosen]


def _motion_clips(
    settings: "Experiment",
    requests: "Sequence[ReactionRequest]",
    reactions: "Iterable[Reaction | FailedReaction]",
    named: bool,
    failed: "list[FailedReaction]",
) -> "Iterator[MotionClip]":
    """What there is to see of each reaction; those that cannot be performed are appended to `failed`.

    Raises SelectionError for such a one that was `named`, FailedMotionError if there is none to see.
    """
    from fatigue_planner.experiment.build import worker_fatigue
    from fatigue_planner.experiment.robot_cell import RobotCell
    from fatigue_planner.output.viewer.motion_clip import motion_clip_of
    from fatigue_planner.reactions.reaction import Reaction

    parameters, cell = worker_fatigue(settings), None if settings.robot is None else RobotCell(settings)
    for request, reaction in zip(requests, reactions, strict=True):
        if isinstance(reaction, Reaction):
            own = parameters[request.name.worker]
            if cell is None:
                yield motion_clip_of(request, reaction, own)
            else:
                said = cell.said(reaction.name, reaction.motion)
                yield motion_clip_of(request, reaction, own, cell.shape(reaction.name.action), (said,))
        elif named:
            raise SelectionError(f"--reaction {_cannot_be_shown(reaction)}")
        else:
            failed.append(reaction)
    if len(failed) == len(requests):
        raise FailedMotionError("\n".join(map(_cannot_be_shown, failed)))


def _cannot_be_shown(reaction: "FailedReaction") -> str:
    return f"{reaction.name} cannot be shown, because it cannot be performed: {reaction.reason}"


def _save_poses(path: Path, clips: "Sequence[MotionClip]", at: Sequence[float]) -> tuple[list[str], int]:
    """Save the poses side by side; the names of the reactions and the bytes."""
    from fatigue_planner.output.figures.postures import filmstrip
    from fatigue_planner.output.figures.style import publish_png

    _check_times(at, clips)
    publish_png(path, filmstrip(clips, at))
    return [str(clip.name) for clip in clips], path.stat().st_size


def _save_page(
    path: Path, title: str, clips: "Iterable[MotionClip]", many: int, failed: "Iterable[FailedReaction]"
) -> tuple[list[str], int]:
    """Save the page and, if they are too large for it, the motions in a folder beside it; names and bytes."""
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.viewer.page import page, record

    folder, recordings = path.with_name(f"{path.stem}_motions"), []
    with progress("Recording motions", many) as counter:
        for clip in clips:
            recordings.append(record(clip))
            counter.advance()
    made = page(title, recordings, [f"{one.name}: {one.reason}" for one in failed], folder.name)
    for name, text in made.beside.items():
        publish_text(writable_folder(folder) / name, text)
    publish_text(path, made.html)
    return [str(one.name) for one in recordings], path.stat().st_size + sum(map(len, made.beside.values()))


def _check_times(times_s: Sequence[float], clips: "Sequence[MotionClip]") -> None:
    """Raise SelectionError for a time outside the cycle."""
    end = min(clip.duration_s for clip in clips)
    for time_s in times_s:
        if not 0 <= time_s <= end:
            raise SelectionError(f"--at {time_s:g}: outside the cycle, which lasts from 0 to {end:g} s.")

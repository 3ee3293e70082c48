"""`fatplan view`: the human performs the reactions, on a page or as poses side by side."""

import time
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import talk, warn
from fatigue_planner.core.errors import FailedMotionError, SelectionError

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.output.viewer.motion_clip import MotionClip

MAX_UNASKED = 12  # reactions shown if none is named: 3 minutes
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

    The page needs nothing but a browser: play, scrub, orbit. Without --save it is opened at once.
    Needs the reactions of `fatplan simulate`.
    """
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.experiment.loader import load_experiment

    begin = time.perf_counter()
    settings = load_experiment(experiment)
    path = save or options.DEFAULT_RESULTS / settings.name / "view.html"
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise SelectionError(f"--save {path}: the name must end in {' or '.join(SUFFIXES)}.")
    if at and kind != ".png":
        raise SelectionError(f"--at {at[0]:g}: only for the poses of a .png; the page shows the whole cycle.")
    writable_folder(path.parent)
    clips = _motion_clips(settings, reaction or [], cache, options.command_line("simulate", experiment, cache))
    if kind == ".png":
        from fatigue_planner.output.figures.postures import filmstrip
        from fatigue_planner.output.figures.style import publish_png

        _check_times(at or [], clips)
        figure = filmstrip(clips, at or [])
        publish_png(path, figure)
    else:
        from fatigue_planner.output.viewer.page import page

        many = f"{len(clips)} reactions" if len(clips) > 1 else "1 reaction"
        talk().print(f"Recording {many}, some 3 s each ...", markup=False)
        publish_text(path, page(clips))
    size, shown = path.stat().st_size / 1e6, ", ".join(clip.title for clip in clips)
    typer.echo(f"{path}: {shown}; {size:.1f} MB ({time.perf_counter() - begin:.1f} s).")
    if save is None and not webbrowser.open(path.resolve().as_uri()):
        typer.echo(f"No browser found; open {path} in one.")


def _motion_clips(settings: "Experiment", wanted: Sequence[str], cache: Path, command: str) -> "list[MotionClip]":
    """The reactions to show, in the experiment's order.

    Raises SelectionError for a name it does not have, or of a failed one; FailedMotionError if all have failed.
    """
    from fatigue_planner.experiment.build import reaction_requests, worker_fatigue
    from fatigue_planner.output.viewer.motion_clip import motion_clip_of
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.reaction import FailedReaction
    from fatigue_planner.study.benchmark.selection import choose

    requests = reaction_requests(settings)
    chosen = choose("reaction", [str(request.name) for request in requests], wanted)
    shown = [request for request in requests if str(request.name) in chosen]
    clips, failed, parameters = [], [], worker_fatigue(settings)
    for request, reaction in zip(shown, ReactionCache(cache).stream(shown, command), strict=True):
        if isinstance(reaction, FailedReaction):
            failed.append(f"{reaction.name} cannot be shown, because it cannot be performed: {reaction.reason}")
            continue
        clips.append(motion_clip_of(request, reaction, parameters[request.name.worker]))
        if not wanted and len(clips) == MAX_UNASKED:
            break
    if len(clips) + len(failed) < len(shown):
        talk().print(f"The first {MAX_UNASKED} of {len(shown)} reactions; choose others with --reaction.", markup=False)
    if wanted and failed:
        raise SelectionError("\n".join(f"--reaction {line}" for line in failed))
    if not clips:
        raise FailedMotionError("\n".join(failed))
    warn(failed)
    return clips


def _check_times(times_s: Sequence[float], clips: "Sequence[MotionClip]") -> None:
    """Raise SelectionError for a time outside the cycle."""
    end = min(clip.duration_s for clip in clips)
    for time_s in times_s:
        if not 0 <= time_s <= end:
            raise SelectionError(f"--at {time_s:g}: outside the cycle, which lasts from 0 to {end:g} s.")

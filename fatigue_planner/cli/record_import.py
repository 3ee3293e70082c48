"""`fatplan record import`: a recorded motion becomes a reaction in the cache, beside the simulated ones."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options, record
from fatigue_planner.core.errors import ExitCode

# The page on which the body moves among the markers, beside the report.
VIEW_FILE = "view.html"

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.fatigue.parameters import FatigueParameters
    from fatigue_planner.reactions.reaction import ReactionRequest
    from fatigue_planner.reactions.recorded import PhaseQuality
    from fatigue_planner.recordings.imports.imported import Imported
    from fatigue_planner.recordings.inference.interpret import Interpreted


def import_(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="The motion and, in files of their own, its plates.")
    ],
    subject: Annotated[
        Path, typer.Option("--subject", help="YAML file of who was recorded: the body, a static trial.")
    ],
    experiment: Annotated[
        Path, typer.Option("--experiment", help="The experiment file (YAML), or the name of one that ships.")
    ],
    action: Annotated[str, typer.Option("--action", help="The experiment's action that was recorded.")],
    preference: Annotated[str, typer.Option("--preference", help="The preference with which it was done.")],
    phases: Annotated[
        str | None,
        typer.Option(
            "--phases",
            metavar="S,S,S,S",
            help="When reach, work and return begin and the return ends, in s from the first frame. Default: by the "
            "speed of the working hand.",
        ),
    ] = None,
    plate_lag: Annotated[
        float, typer.Option("--plate-lag", min=-0.5, max=0.5, help="How many seconds late the plates are.")
    ] = 0.0,
    units: record.Units = None,
    up: record.Up = None,
    rate: record.Rate = None,
    prefix: record.Prefix = None,
    mapping: record.MappingName = None,
    heading: record.Heading = None,
    exchange_sides: record.ExchangeSides = False,
    angles: record.AnglesIn = None,
    reader: record.Reader = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Make a reaction of a recorded motion (FILE...), say how far its torques can be believed, and how to use it.

    The hands hold the experiment's tool and loads. A page with markers, residuals, angles and torques, and one on which
    the body moves among the markers, go to the results folder. Exit code 3 if the torques cannot be believed by the
    experiment's `recording_accuracy`: the reaction is kept, but not used.
    """
    from fatigue_planner.core.errors import RecordingError
    from fatigue_planner.experiment.build import worker_fatigue
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.reaction import Recorded
    from fatigue_planner.recordings.check import Checked, read_recording
    from fatigue_planner.recordings.formats.registry import Choices
    from fatigue_planner.recordings.imports.imported import import_recording
    from fatigue_planner.recordings.imports.subject import load_subject, static_files, worker_of
    from fatigue_planner.recordings.inference.finding import Given
    from fatigue_planner.recordings.mapping import load_mapping

    if mapping is not None:
        load_mapping(mapping)
    settings, person = load_experiment(experiment), load_subject(subject)
    request = _request(settings, worker_of(settings, person, subject), action, preference)
    # what the plates show beside the body is told of each phase, so its mass is not asked for
    given = Given(units, up, rate, prefix, mapping, heading_deg=heading, exchange_sides=exchange_sides)
    choices = Choices(reader, None if angles is None else angles == "deg")
    form, found = read_recording(*files, given=given, choices=choices)
    static = static_files(subject, person)
    still = read_recording(*static, given=given, choices=choices)[1] if static else None
    try:
        made = import_recording(request.name, request.motion, found, still, _times(phases), plate_lag)
    except RecordingError as error:
        raise RecordingError(f"{', '.join(map(str, files))}: {error}") from error
    path = ReactionCache(cache).store(made.reaction)
    quality = made.quality
    asked = replace(request, recorded=Recorded(made.key, settings.recording_accuracy))
    faults, verdict = asked.faults(quality), asked.verdict(quality)
    worker = request.name.worker
    use = f"recorded: {{{worker}: {{{action}: {{{preference}: '{made.key}'}}}}}}"
    folder = results / settings.name / "recordings" / "-".join(request.name)
    pages = _publish_pages(folder, made, found, asked, worker_fatigue(settings)[worker], use)
    document: dict[str, Any] = {
        "files": files,
        "name": str(request.name),
        "key": made.key,
        "digest": made.reaction.digest,
        "file": path,
        "format": form,
        "mapping": found.mapping,
        "findings": (*found.findings, *made.findings),
        "remarks": (*found.remarks, *made.remarks),
        "verdict": verdict,
        "faults": faults,
        "not_good": quality.remarks(),
        "quality": quality,
        "folder": folder,
    }
    read = record.told(Checked(files[0], form, found))
    lines = [f"  {finding.what}: {finding.value} ({finding.source})" for finding in made.findings]
    lines += [f"  fault {remark.fault}: {remark.text}" for remark in made.remarks]
    lines += [_phase_text(phase) for phase in quality.phases]
    lines += [f"{verdict}: {'; '.join(faults or quality.remarks()) or 'nothing to say against it'}."]
    lines += [f"{folder}: {', '.join(pages)}", f"{path}: for the experiment:", f"  {use}"]
    options.present(document, "\n".join([read, *lines]), as_json)
    if faults:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _publish_pages(
    folder: Path,
    made: "Imported",
    found: "Interpreted",
    request: "ReactionRequest",
    parameters: "FatigueParameters",
    use: str,
) -> tuple[str, str]:
    """Publish the report and the page on which the body moves among the markers; their names."""
    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.output.reports.recording.page import recording_page
    from fatigue_planner.output.viewer.page import page
    from fatigue_planner.output.viewer.page import record as played
    from fatigue_planner.output.viewer.recorded_clip import recorded_clip

    figures = FigureFolder(writable_folder(folder))
    publish_text(folder / REPORT_FILE, recording_page(made, found, request, figures, use))
    clip = recorded_clip(made, found.recording, request, parameters)
    publish_text(folder / VIEW_FILE, page(str(request.name), [played(clip)], [], "").html)
    return REPORT_FILE, VIEW_FILE


def _request(settings: "Experiment", worker: str, action: str, preference: str) -> "ReactionRequest":
    """The request for the reaction that a recording is. Raises SelectionError for an unknown action or preference."""
    from fatigue_planner.core.errors import check_known
    from fatigue_planner.experiment.build import reaction_requests

    check_known("action", action, settings.actions, "the experiment")
    check_known("preference", preference, settings.preferences, "the experiment")
    return next(one for one in reaction_requests(settings) if one.name == (worker, action, preference))


def _times(phases: str | None) -> list[float] | None:
    from fatigue_planner.core.errors import SelectionError

    if phases is None:
        return None
    try:
        return [float(part) for part in phases.split(",")]
    except ValueError:
        raise SelectionError(
            f"--phases {phases!r}: four times in s with commas between, such as 0.5,1.8,6,7.2."
        ) from None


def _phase_text(phase: "PhaseQuality") -> str:
    parts = [
        f"markers {1000 * phase.marker_rms_m:.1f} mm (worst {phase.worst_marker} {1000 * phase.worst_marker_m:.0f} mm)"
    ]
    if phase.residual_force_share is not None:
        parts.append(
            f"unexplained {100 * phase.residual_force_share:.1f} % of the weight, {phase.residual_moment_nm:.1f} N·m"
        )
    if phase.unmeasured_share:
        parts.append(f"unmeasured contact {100 * phase.unmeasured_share:.0f} % of the time")
    parts.append(f"feet slide {100 * phase.foot_slide_m:.1f} cm")
    return f"  {phase.name}, {phase.from_s:.2f} to {phase.to_s:.2f} s: {'; '.join(parts)}; pace x {phase.stretch:.2f}"

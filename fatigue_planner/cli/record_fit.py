"""`fatplan record fit`: the weights and stiffnesses of a preference that come closest to recorded motions."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress
from fatigue_planner.core.errors import SelectionError, check_known

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.recordings.learning.preference_fit import Example, PreferenceFit

# So many joints are told, those whose angles were farthest off.
JOINTS = 5


def fit(
    experiment: options.ExperimentFile,
    preference: Annotated[str, typer.Option("--preference", help="The preference that is fitted.")],
    evaluations: Annotated[
        int, typer.Option(min=10, max=10_000, help="How often each search simulates the recorded motions.")
    ] = 100,
    write: Annotated[
        Path | None,
        typer.Option("--write", help="Write the fitted preference (YAML), to be put into an experiment."),
    ] = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    jobs: options.Jobs = options.ALL_CORES,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Fit weights and stiffnesses of a preference's tasks to the recorded reactions of an EXPERIMENT (`recorded`).

    Says how far the angles of simulated motions are off the recorded ones: with the preference as it is, with the one
    fitted to all recordings, and, where several people were recorded, of each with the one fitted to the others.
    """
    import yaml

    from fatigue_planner.core.files import publish_text, writable_folder
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.recordings.learning.preference_fit import fit_preference, searches

    settings = load_experiment(experiment)
    if write is not None:
        writable_folder(write.parent)
    examples, left_out = _examples(settings, preference, cache, options.command_line("simulate", experiment, cache))
    with progress("Searching", len(searches(examples))) as counter:
        found = fit_preference(examples, evaluations, options.executor_of(jobs, None), counter.advance)
    if write is not None:
        content = {"preferences": {preference: found.preference.plain()}}
        publish_text(write, yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120))
    document: dict[str, Any] = {
        "preference": found.preference.plain(),
        "left_out": left_out,
        **_errors(found),
        "helps": found.helps,
        "recordings": [{"name": str(name), **_errors(found, number)} for number, name in enumerate(found.names)],
        "joints": _joints(found),
        "file": write,
    }
    options.present(document, "\n".join(_lines(settings, preference, document, write)), as_json)


def _examples(
    settings: "Experiment", preference: str, cache: Path, command: str
) -> "tuple[list[Example], dict[str, str]]":
    """The recorded reactions of a preference, and why others may not be used."""
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.reaction import FailedReaction
    from fatigue_planner.recordings.learning.preference_fit import Example, angles_deg

    check_known("preference", preference, settings.preferences, "the experiment")
    if not settings.preferences[preference].tasks:
        raise SelectionError(f"--preference {preference!r}: has no tasks whose weights could be fitted.")
    requests = [
        request
        for request in reaction_requests(settings)
        if request.recorded is not None and request.name.preference == preference
    ]
    examples, left_out = [], {}
    for request, reaction in zip(requests, ReactionCache(cache).stream(requests, command), strict=True):
        if isinstance(reaction, FailedReaction):
            left_out[str(request.name)] = reaction.reason
        else:
            examples.append(Example(request.name, request.motion, angles_deg(reaction.motion)))
    if not examples:
        why = "; ".join(f"{name}: {reason}" for name, reason in left_out.items()) or "`recorded` names none"
        raise SelectionError(f"--preference {preference!r}: no recorded reaction can be used: {why}.")
    return examples, left_out


def _errors(found: "PreferenceFit", part: Any = ...) -> dict[str, float | None]:
    """How far a part of all angles is off: as it was, fitted, and fitted to other people."""
    from fatigue_planner.recordings.learning.preference_fit import rms

    every = {"before_deg": found.before_deg, "after_deg": found.after_deg, "others_deg": found.others_deg}
    return {name: None if values is None else rms(values[part]) for name, values in every.items()}


def _joints(found: "PreferenceFit") -> list[dict[str, Any]]:
    """The joints by how far they are off, the farthest first."""
    from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM

    rows = [{"joint": name, **_errors(found, (..., number))} for number, name in enumerate(DEGREES_OF_FREEDOM)]
    return sorted(rows, key=lambda row: -row["before_deg"])


def _lines(settings: "Experiment", name: str, document: dict[str, Any], write: Path | None) -> list[str]:
    from fatigue_planner.recordings.learning.preference_fit import FAILED_DEG

    def told(degrees: float | None) -> str | None:
        return None if degrees is None else "impossible" if degrees == FAILED_DEG else f"{degrees:.1f}"

    def course(row: dict[str, Any]) -> str:
        before, after, others = map(told, (row["before_deg"], row["after_deg"], row["others_deg"]))
        return f"{before} as it was, {after} fitted" + (f", {others} fitted to other people" if others else "")

    lines = [f"Left out: {left}: {reason}." for left, reason in document["left_out"].items()]
    lines.append(f"{name}: how far simulated angles are off the recorded ones, in degrees (RMS): {course(document)}")
    lines += [f"  {row['name']}: {course(row)}" for row in document["recordings"]]
    lines += [f"  {row['joint']}: {course(row)}" for row in document["joints"][:JOINTS]]
    for number, (before, after) in enumerate(
        zip(settings.preferences[name].tasks, document["preference"]["tasks"], strict=True), start=1
    ):
        stiffness = before.stiffness_per_s2
        was = "the controller's" if stiffness is None else f"{stiffness:g}"
        lines.append(
            f"  task {number}, {before.kind}: weight {before.weight:g} -> {after['weight']:g}, "
            f"stiffness {was} -> {after['stiffness_per_s2']:g} 1/s^2"
        )
    verdicts = {
        None: "Only one person was recorded: whether it is closer to others, too, is not known.",
        True: "It is closer to people to whom it was not fitted, too.",
        False: "It is not closer to people to whom it was not fitted: keep the preference as it is.",
    }
    lines.append(verdicts[document["helps"]])
    return lines if write is None else [*lines, f"{write}: the preference."]

"""`fatplan simulate`: every action with every preference, into the reaction cache."""

import time
from typing import TYPE_CHECKING, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.errors import ExitCode

if TYPE_CHECKING:
    from fatigue_planner.reactions.cache import Outcome


def simulate(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    jobs: options.Jobs = options.ALL_CORES,
    dask: options.Dask = None,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Simulate the digital human for every action and motion preference of an EXPERIMENT.

    The joint torques, motions and contact forces of every reaction go to a file (HDF5) in the cache folder.
    Reactions that are already in the cache are not simulated again. A reaction that cannot be performed, or not
    with the experiment's accuracy, is a result, too: it is kept, listed with the reason, and left out of what
    follows. A motion that slightly exceeds a limit is marked as degraded, one that a person would not make as
    implausible, with what is wrong; both are used.
    """
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.reactions.cache import ReactionCache

    begin = time.perf_counter()
    settings = load_experiment(experiment)
    if "human" not in settings.model_fields_set:
        warn([f"{experiment}: names no human; the natural one moves (human: natural; the paper's is human: paper)."])
    requests, executor = reaction_requests(settings), options.executor_of(jobs, dask)
    store = ReactionCache(cache)
    with progress("Simulating reactions", len(requests), kept=("reactions", cache)) as counter:
        outcomes = store.complete(requests, executor, lambda outcome: counter.advance(pieces=outcome.kept))
    warn(store.damaged)
    failed = sum(outcome.verdict == "failed" for outcome in outcomes)
    found = sum(outcome.found and outcome.verdict != "failed" for outcome in outcomes)
    simulated, elapsed_s = len(outcomes) - found - failed, time.perf_counter() - begin
    lines = [f"  {outcome.name!s:<32} {_outcome_text(outcome)}" for outcome in outcomes if outcome.verdict != "failed"]
    if failed:
        lines.append(f"{failed} of {len(outcomes)} reactions failed, and are left out of what follows:")
        lines += [
            f"  {outcome.name!s:<32} {_outcome_text(outcome)}" for outcome in outcomes if outcome.verdict == "failed"
        ]
    else:
        made = f"{simulated} simulated" if simulated else "nothing to simulate"
        lines.append(f"{cache}: {len(outcomes)} reactions, {found} found in the cache, {made} ({elapsed_s:.1f} s).")
    document = {
        "folder": cache,
        "reactions": [_reaction(outcome) for outcome in outcomes],
        "found": found,
        "simulated": simulated,
        "failed": failed,
        "elapsed_s": elapsed_s,
    }
    options.present(document, "\n".join(lines), as_json)
    if failed:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _reaction(outcome: "Outcome") -> dict[str, Any]:
    """A reaction in the JSON document; the numbers are null where there was no motion to measure."""
    quality = outcome.quality
    return {
        "name": str(outcome.name),
        "digest": outcome.digest,
        "verdict": outcome.verdict,
        "found": outcome.found,
        "failure": outcome.failure,
        "degradation": quality.degradation() if quality and outcome.verdict != "failed" else "",
        "findings": [found._asdict() for found in outcome.findings],
        "hand_error_m": quality and quality.work_hand_error_m,
        "largest_load_share": quality and quality.largest_load_share,
        "largest_load_joint": quality and quality.largest_load_joint,
    }


def _outcome_text(outcome: "Outcome") -> str:
    quality = outcome.quality
    if outcome.verdict == "failed" or quality is None:
        return f"FAILED: {outcome.failure}"
    made = "recorded" if outcome.is_recorded else "found" if outcome.found else "simulated"
    return (
        f"{made}, {outcome.verdict}; hand within "
        f"{quality.work_hand_error_m * 1000:.1f} mm of its target; heaviest load "
        f"{quality.largest_load_share:.0%} of the strength ({quality.largest_load_joint})"
        + "".join(f"\n      {remark}" for remark in quality.remarks())
    )

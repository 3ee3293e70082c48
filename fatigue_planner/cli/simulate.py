"""`fatplan simulate`: every action with every preference, into the reaction cache."""

import time
from collections.abc import Sequence
from pathlib import Path

import typer

from fatigue_planner.cli.json_output import SimulatedReaction, Simulation
from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    CacheFolder,
    Dask,
    ExperimentFile,
    Jobs,
    executor_of,
)
from fatigue_planner.cli.output import Json, present
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.errors import ExitCode
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.reactions.cache import Outcome, ReactionCache


def simulate(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cache: CacheFolder = DEFAULT_CACHE,
    jobs: Jobs = ALL_CORES,
    dask: Dask = None,
    as_json: Json = False,
) -> None:
    """Simulate the digital human for every action and motion preference of an EXPERIMENT.

    The joint torques, motions and contact forces of every reaction go to a file (HDF5) in the cache folder.
    What the cache holds already is not simulated again. A reaction that cannot be performed, or not with the
    experiment's accuracy, is a result, too: it is kept, listed with the reason, and left out of what follows. One that
    had to pass a limit a little is degraded, and says so.
    """
    begin = time.perf_counter()
    settings = load_experiment(experiment)
    requests, executor = reaction_requests(settings), executor_of(jobs, dask)
    store = ReactionCache(cache)
    with progress("Simulating reactions", len(requests), kept=("reactions", cache)) as counter:
        outcomes = store.complete(requests, executor, lambda outcome: counter.advance(pieces=outcome.kept))
    warn(store.damaged)
    done = _document(cache, outcomes, time.perf_counter() - begin)
    present(done, _text(done, outcomes), as_json)
    if done.failed:
        raise typer.Exit(ExitCode.FAILED_PARTS)


def _document(folder: Path, outcomes: Sequence[Outcome], elapsed_s: float) -> Simulation:
    failed = sum(outcome.verdict == "failed" for outcome in outcomes)
    found = sum(outcome.found and outcome.verdict != "failed" for outcome in outcomes)
    return Simulation(
        folder=folder,
        reactions=[_reaction(outcome) for outcome in outcomes],
        found=found,
        simulated=len(outcomes) - found - failed,
        failed=failed,
        elapsed_s=elapsed_s,
    )


def _reaction(outcome: Outcome) -> SimulatedReaction:
    quality = outcome.quality
    return SimulatedReaction(
        name=str(outcome.name),
        digest=outcome.digest,
        verdict=outcome.verdict,
        found=outcome.found,
        failure=outcome.failure,
        degradation=quality.degradation() if quality and outcome.verdict == "degraded" else "",
        hand_error_m=quality.work_hand_error_m if quality else None,
        largest_load_share=quality.largest_load_share if quality else None,
        largest_load_joint=quality.largest_load_joint if quality else None,
    )


def _text(done: Simulation, outcomes: Sequence[Outcome]) -> str:
    lines = [f"  {outcome.name!s:<32} {_words(outcome)}" for outcome in outcomes if outcome.verdict != "failed"]
    if done.failed:
        lines.append(f"{done.failed} of {len(outcomes)} reactions failed, and are left out of what follows:")
        lines += [f"  {outcome.name!s:<32} {_words(outcome)}" for outcome in outcomes if outcome.verdict == "failed"]
    else:
        made = f"{done.simulated} simulated" if done.simulated else "nothing to simulate"
        lines.append(
            f"{done.folder}: {len(outcomes)} reactions, {done.found} found in the cache, {made} "
            f"({done.elapsed_s:.1f} s)."
        )
    return "\n".join(lines)


def _words(outcome: Outcome) -> str:
    if outcome.verdict == "failed" or outcome.quality is None:
        return f"FAILED: {outcome.failure}"
    quality = outcome.quality
    return (
        f"{'found' if outcome.found else 'simulated'}, {outcome.verdict}; hand within "
        f"{quality.work_hand_error_m * 1000:.1f} mm of its target; heaviest load "
        f"{quality.largest_load_share:.0%} of the strength ({quality.largest_load_joint})"
        + (f"; {quality.degradation()}" if outcome.verdict == "degraded" else "")
    )

"""`fatplan simulate`: every action with every preference, into the reaction cache."""

import time

import typer

from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    CacheFolder,
    ExperimentFile,
    Jobs,
    counter,
    talk,
)
from fatigue_planner.errors import ExitCode
from fatigue_planner.executors.processes import LocalProcesses
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import reaction_requests
from fatigue_planner.reactions.cache import Outcome, ReactionCache


def simulate(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT, cache: CacheFolder = DEFAULT_CACHE, jobs: Jobs = ALL_CORES
) -> None:
    """Simulate the digital human for every action and motion preference of an EXPERIMENT.

    The joint torques, motions and contact forces of every reaction go to a file (HDF5) in the cache folder.
    What the cache holds already is not simulated again. A motion that misses the experiment's accuracy
    is reported and not kept; one that had to pass a limit a little is kept as degraded, and says so.
    """
    begin = time.perf_counter()
    settings = load_experiment(experiment)
    requests = reaction_requests(settings)
    store, console = ReactionCache(cache), talk()
    with counter(console) as bar:
        task = bar.add_task("Simulating reactions", total=len(requests))
        outcomes = store.complete(requests, LocalProcesses(jobs), lambda _: bar.advance(task))
    for warning in store.damaged:
        console.print(f"Warning: {warning}", markup=False)
    for outcome in outcomes:
        typer.echo(f"  {outcome.name!s:<32} {_words(outcome)}")
    failed = sum(outcome.verdict == "failed" for outcome in outcomes)
    found = sum(outcome.found for outcome in outcomes)
    if failed:
        rest = " The others are kept." if failed < len(outcomes) else ""
        typer.echo(f"{failed} of {len(outcomes)} reactions failed.{rest}")
        raise typer.Exit(ExitCode.FAILED_PARTS)
    made = "nothing to simulate" if found == len(outcomes) else f"{len(outcomes) - found} simulated"
    typer.echo(
        f"{cache}: {len(outcomes)} reactions, {found} found in the cache, {made} ({time.perf_counter() - begin:.1f} s)."
    )


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

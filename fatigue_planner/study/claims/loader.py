"""Loads a file of claims and checks every name in it, with one clear message for all faults."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.errors import ClaimsError, listed, shortened
from fatigue_planner.core.file_kinds import FileKind
from fatigue_planner.core.files import file_named_in, find_shipped
from fatigue_planner.experiment.benchmark_settings import Benchmark
from fatigue_planner.experiment.error_messages import joined_errors
from fatigue_planner.experiment.loader import load_experiment, parse_settings, read_mapping
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.study.benchmark.results import NotedGrid
from fatigue_planner.study.claims.relations import RELATIONS
from fatigue_planner.study.claims.schema import Claim, ClaimsFile


@dataclass(frozen=True)
class Claims:
    """The claims by name, and the experiment they are about with its file."""

    claims: dict[str, Claim]
    experiment: Experiment
    experiment_file: Path

    def about(self, grid: Benchmark | NotedGrid) -> dict[str, Claim]:
        """The claims that speak only of conditions, numbers of cycles and policies that a grid has."""
        return {
            name: claim
            for name, claim in self.claims.items()
            if grid.conditions.keys() >= set(claim.conditions)
            and set(grid.n_cycles) >= set(claim.n_cycles)
            and grid.policies.keys() >= {*claim.policies, *claim.others}
        }


def load_claims(path: Path) -> Claims:
    """The claims of a file and their experiment, checked completely.

    Raises ClaimsError: file, key, value, what is allowed; and as `load_experiment`.
    """
    path = find_shipped(path)
    file = parse_settings(ClaimsFile, read_mapping(path, FileKind.CLAIMS, ClaimsError), str(path), ClaimsError)
    experiment_file = file_named_in(path, "experiment", file.experiment)
    experiment = load_experiment(experiment_file)
    faults = [fault for name, claim in file.claims.items() for fault in _faults(f"claims.{name}", claim, experiment)]
    if faults:
        raise ClaimsError(joined_errors(str(path), faults))
    return Claims(file.claims, experiment, experiment_file)


def _faults(key: str, claim: Claim, experiment: Experiment) -> Iterable[str]:
    grid = experiment.benchmark
    known: dict[str, Iterable[object]] = {
        "conditions": grid.conditions, "n_cycles": grid.n_cycles, "policies": grid.policies, "others": grid.policies
    }  # fmt: skip
    for part, names in known.items():
        items = getattr(claim, part)
        unknown = [item for item in items if item not in names]
        if unknown:
            yield f"{key}.{part}: {listed(unknown)} not in {experiment.name}; known are {listed(names)}."
        if repeated := [item for item in dict.fromkeys(items) if items.count(item) > 1]:
            yield f"{key}.{part}: {listed(repeated)} {'is' if len(repeated) == 1 else 'are'} given twice."
    both = [name for name in claim.policies if name in claim.others]
    if both:
        yield f"{key}.others: {listed(both)} already among the policies."
    relation = RELATIONS.get(claim.relation)
    if relation is None:
        yield f"{key}.relation = {shortened(claim.relation)}: should be one of {listed(RELATIONS)}."
    elif fault := relation.fault(claim):
        yield f"{key}: {claim.relation} {fault}."

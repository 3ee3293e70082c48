"""`fatplan claims`: a paper's statements, one by one, against the runs of a benchmark."""

import shutil
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli.json_output import JudgedClaims
from fatigue_planner.cli.options import DEFAULT_CACHE, DEFAULT_RESULTS, ResultsFolder, command_line
from fatigue_planner.cli.output import Json, present
from fatigue_planner.core.files import digest_of_files, publish_csv
from fatigue_planner.core.provenance import MANIFEST_FILE, publish_manifest
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.benchmark.results import load_results
from fatigue_planner.study.benchmark.tables import TRIALS_FILE
from fatigue_planner.study.claims.answers import VERDICTS
from fatigue_planner.study.claims.evaluation import CLAIMS_FILE, DETAIL_FILE, evaluate
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.claims.text import claims_text
from fatigue_planner.study.statistics.pairing import records

DEFAULT_CLAIMS = Path("experiments/paper_claims.yaml")


def claims(
    claims: Annotated[Path, typer.Argument(metavar="CLAIMS", help="The file of claims (YAML).")] = DEFAULT_CLAIMS,
    results: ResultsFolder = DEFAULT_RESULTS,
    as_json: Json = False,
) -> None:
    """Judge every claim of a CLAIMS file: reproduced, not reproduced or undetermined, with numbers and reason.

    Needs the results of `fatplan benchmark` of the experiment the file names, its whole grid; with those of
    `--bound` it also says how much any policy could win. Beside the verdict stands that of the paper's own test.
    """
    loaded = load_claims(claims)
    experiment = loaded.experiment
    folder = results / experiment.name
    command = command_line("benchmark", loaded.experiment_file, DEFAULT_CACHE, results)
    tables = load_results(experiment, folder, command)
    found = evaluate(loaded.claims, tables.trials, tables.contrasts, experiment.statistics, tables.bounds)
    publish_csv(folder / CLAIMS_FILE, found.claims)
    publish_csv(folder / DETAIL_FILE, found.detail)
    read = [folder / name for name in (TRIALS_FILE, *([] if tables.bounds is None else [BOUNDS_FILE]))]
    configuration = {
        "claims": {name: claim.plain() for name, claim in loaded.claims.items()},
        "statistics": experiment.statistics.plain(),
        "tables": digest_of_files(read),
    }
    hashes = publish_manifest(folder, "claims", configuration, [folder / CLAIMS_FILE, folder / DETAIL_FILE])
    counts = Counter(found.claims["verdict"])
    document = JudgedClaims(
        folder=folder,
        files=hashes,
        counts={verdict: counts[verdict] for verdict in VERDICTS},
        claims=records(found.claims),
        bounds=tables.bounds is not None,
    )
    lines = [claims_text(found.claims, shutil.get_terminal_size().columns)]
    if tables.bounds is None:
        lines.append(f"How much any policy could win is not known; `{command} --bound` computes it.")
    lines.append(f"{folder}: {CLAIMS_FILE}, {DETAIL_FILE}, {MANIFEST_FILE}")
    present(document, "\n".join(lines), as_json)

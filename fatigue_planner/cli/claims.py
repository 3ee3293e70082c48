"""`fatplan claims`: a paper's statements, one by one, against the runs of a benchmark."""

import shutil
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import SelectionError

DEFAULT_CLAIMS = Path("paper_claims")


def claims(
    claims: Annotated[Path, typer.Argument(metavar="CLAIMS", help="The file of claims (YAML).")] = DEFAULT_CLAIMS,
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="A results folder, instead of the options that name it.")
    ] = None,
    cycles: options.Cycles = None,
    conditions: options.Conditions = None,
    policies: options.Policies = None,
    trials: options.Trials = None,
    descents: options.Descents = None,
    seed: options.Seed = None,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Judge every claim in a CLAIMS file: reproduced, not reproduced or undetermined, with numbers and reasons.

    Needs the results of `fatplan benchmark` of the experiment the file names; with those of `--bound` it also says how
    much any policy could gain. The verdict of the paper's own test is shown beside ours. For a restricted grid, give
    the options that `fatplan benchmark` was given, or the FOLDER of its results: claims about anything outside that
    grid are left out and named.
    """
    from fatigue_planner.core.files import digest_of_files, publish_csv
    from fatigue_planner.core.provenance import MANIFEST_FILE, publish_manifest
    from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
    from fatigue_planner.study.benchmark.results import load_results
    from fatigue_planner.study.benchmark.selection import Selection, selected
    from fatigue_planner.study.benchmark.tables import TRIALS_FILE
    from fatigue_planner.study.claims.evaluation import CLAIMS_FILE, DETAIL_FILE, claims_text, evaluate
    from fatigue_planner.study.claims.loader import load_claims
    from fatigue_planner.study.claims.schema import VERDICTS
    from fatigue_planner.study.statistics.pairing import records

    loaded = load_claims(claims)
    wanted = Selection(cycles, conditions, policies, trials, descents, seed)
    if folder is not None:
        results, (_, wanted) = folder.parent, options.source_of(folder, wanted)
    experiment = selected(loaded.experiment, wanted)
    folder = folder or results / (experiment.name + wanted.suffix())
    command = options.command_line("benchmark", loaded.experiment_file, options.DEFAULT_CACHE, results, wanted)
    tables = load_results(experiment, folder, command)
    about = loaded.about(tables.note.grid)
    left_out = [name for name in loaded.claims if name not in about]
    if not about:
        raise SelectionError(f"{claims}: every claim is about more than the grid that was run.")
    found = evaluate(about, tables.trials, tables.contrasts, experiment.statistics, tables.bounds)
    publish_csv(folder / CLAIMS_FILE, found.claims)
    publish_csv(folder / DETAIL_FILE, found.detail)
    read = [folder / name for name in (TRIALS_FILE, *([] if tables.bounds is None else [BOUNDS_FILE]))]
    configuration = {
        "claims": {name: claim.plain() for name, claim in about.items()},
        "statistics": experiment.statistics.plain(),
        "tables": digest_of_files(read),
    }
    hashes = publish_manifest(folder, "claims", configuration, [folder / CLAIMS_FILE, folder / DETAIL_FILE])
    counts = Counter(found.claims["verdict"])
    document = {
        "folder": folder,
        "files": hashes,
        "counts": {verdict: counts[verdict] for verdict in VERDICTS},
        "claims": records(found.claims),
        "bounds": tables.bounds is not None,
        "left_out": left_out,
    }
    lines = [claims_text(found.claims, shutil.get_terminal_size().columns)]
    if left_out:
        lines.append(f"Not judged, for they are about more than this grid: {', '.join(left_out)}.")
    if tables.bounds is None:
        lines.append(f"How much any policy could win is not known; `{command} --bound` computes it.")
    lines.append(f"{folder}: {CLAIMS_FILE}, {DETAIL_FILE}, {MANIFEST_FILE}")
    options.present(document, "\n".join(lines), as_json)

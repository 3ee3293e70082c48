"""What made the results, so that anybody can make them again."""

import hashlib
import json
from pathlib import Path

from fatigue_planner.core.provenance import versions
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.output.reports.html.blocks import Code, Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData


def provenance_section(report_data: ReportData, commands: list[str], file: Path) -> Section:
    """Commands, versions, seed, hashes and the whole configuration; `file` is the experiment's."""
    made, here = report_data.results.note.versions, versions()
    versions_used = [[name, made.get(name, "n/a"), version] for name, version in here.items()]
    hashes = [[name, digest] for name, digest in sorted(report_data.results.note.sha256.items())]
    hashes.append([file.name, hashlib.sha256(file.read_bytes()).hexdigest()])
    hashes += [[f"reaction {request.name}", request.digest] for request in reaction_requests(report_data.experiment)]
    seed = report_data.experiment.benchmark.seed
    configuration = json.dumps(report_data.experiment.plain(), indent=1, ensure_ascii=False)
    return Section(
        "Provenance",
        [
            Text("These commands make this page and every number in it again:"),
            Code("\n".join(commands)),
            Text(
                f"Seed {seed}: the world of a run is drawn from seed, condition, number of cycles and trial, the "
                "planner's chance from these and the policy's name, so that the tables are the same bytes whatever "
                "the number of workers."
            ),
            Table("Versions, of the tables and of this page.", ["what", "tables", "page"], versions_used),
            Table("SHA-256 of the files and the digests of the reactions.", ["what", "hash"], hashes, "manifest.json"),
            Text("The configuration of what was run, complete:"),
            Code(configuration),
        ],
    )

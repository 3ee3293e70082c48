"""How the results were made, so that anybody can make them again."""

import hashlib
import json

from fatigue_planner.core.provenance import versions
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Code, Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData


def provenance_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """Commands, versions, seed, hashes and the whole configuration."""
    file, made, here = report_data.file, report_data.results.note.versions, versions()
    versions_used = [[name, made.get(name, "n/a"), version] for name, version in here.items()]
    hashes = [[name, digest] for name, digest in sorted(report_data.results.note.sha256.items())]
    hashes.append([file.name, hashlib.sha256(file.read_bytes()).hexdigest()])
    hashes += [[f"reaction {request.name}", request.digest] for request in reaction_requests(report_data.experiment)]
    seed = report_data.experiment.benchmark.seed
    configuration = json.dumps(report_data.experiment.plain(), indent=1, ensure_ascii=False)
    return Section(
        "Provenance",
        [
            Text("These commands make this page and every number on it again:"),
            Code("\n".join(report_data.commands)),
            Text(
                f"The seed is {seed}. The random numbers of a run follow from the seed, the condition, the number of "
                "cycles and the trial; those of the planner also from the policy's name. So the tables have the same "
                "bytes whatever the number of processes."
            ),
            Table("The versions that made the tables and this page.", ["what", "tables", "page"], versions_used),
            Table("SHA-256 of the files, and digests of the reactions.", ["what", "hash"], hashes, "manifest.json"),
            Text("The complete configuration of what was run:"),
            Code(configuration),
        ],
    )

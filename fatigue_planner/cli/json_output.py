"""The documents that commands print with `--json`, one type each. Their keys stay; docs/command-line.md lists them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Rows = Sequence[Mapping[str, Any]]  # of a table: by column


@dataclass(frozen=True)
class SimulatedReaction:
    """A reaction of `fatplan simulate`; the numbers are null where there was no motion to measure.

    verdict: ok, degraded or failed. failure, degradation: why, in words, empty where there is none. hand_error_m: the
    largest distance of a hand from its target during work. largest_load_share: the heaviest mean load of a joint
    during work, as a share of its strength, at largest_load_joint.
    """

    name: str
    digest: str
    verdict: str
    found: bool
    failure: str
    degradation: str
    hand_error_m: float | None
    largest_load_share: float | None
    largest_load_joint: str | None


@dataclass(frozen=True)
class Simulation:
    """`fatplan simulate`. folder: the cache; found: how many reactions were there already."""

    folder: Path
    reactions: Sequence[SimulatedReaction]
    found: int
    simulated: int
    failed: int
    elapsed_s: float


@dataclass(frozen=True)
class BenchmarkRun:
    """`fatplan benchmark`. files: SHA-256 by name. The tables are null unless they were asked for.

    comparison: the rows of comparison.csv; bounds: those of bounds.csv; regret: means per policy, as summary.txt has.
    """

    folder: Path
    files: Mapping[str, str]
    runs: int
    comparison: Rows
    regret: Rows | None
    bounds: Rows | None


@dataclass(frozen=True)
class BenchmarkPlan:
    """`fatplan benchmark --dry-run`. decisions_left: those not in `store` yet, about `estimated_s` with `jobs`."""

    conditions: Sequence[str]
    n_cycles: Sequence[int]
    policies: Sequence[str]
    cells: int
    runs: int
    decisions: int
    decisions_left: int
    store: Path
    jobs: int
    estimated_s: float


@dataclass(frozen=True)
class Fault:
    """One fault of a file."""

    message: str


@dataclass(frozen=True)
class Validation:
    """`fatplan validate`. kind: null if the file cannot be read. about: of a valid file, in words, else empty."""

    file: Path
    kind: str | None
    valid: bool
    faults: Sequence[Fault]
    about: str


@dataclass(frozen=True)
class JudgedClaims:
    """`fatplan claims`. counts: claims by verdict; claims: the rows of claims.csv; bounds: whether they were known."""

    folder: Path
    files: Mapping[str, str]
    counts: Mapping[str, int]
    claims: Rows
    bounds: bool


@dataclass(frozen=True)
class FilesOf:
    """`fatplan figures`, and `fatplan report`, whose files have report.html among them. files: SHA-256 by name."""

    folder: Path
    files: Mapping[str, str]


@dataclass(frozen=True)
class SideBySide:
    """`fatplan compare`. settings, versions: what differs, [in A, in B] by key; only: cells in one folder only.

    same_worlds: whether the seeds agree, so that runs are paired. contrasts: the rows of the table.
    files: those of --save.
    """

    folders: Sequence[str]
    settings: Mapping[str, Sequence[str]]
    versions: Mapping[str, Sequence[str]]
    only: Sequence[Sequence[str]]
    same_worlds: bool
    contrasts: Rows
    files: Sequence[Path]


@dataclass(frozen=True)
class StudyRun:
    """`fatplan sensitivity`. files: SHA-256 by name; feasible: points that can be performed."""

    folder: Path
    files: Mapping[str, str]
    points: int
    feasible: int
    lessons: Sequence[str]


@dataclass(frozen=True)
class Finding:
    """What a check of `fatplan doctor` found; remedy: null if all is well; vital: nothing works without it."""

    what: str
    found: str
    remedy: str | None = None
    vital: bool = True


@dataclass(frozen=True)
class Examination:
    """`fatplan doctor`. healthy: nothing vital is missing."""

    healthy: bool
    findings: Sequence[Finding]


@dataclass(frozen=True)
class ExportedHuman:
    """`fatplan human export`: a URDF file with so many joints. joint_order: their names as all motions count them."""

    file: Path
    worker: str
    joints: int
    mass_kg: float
    joint_order: Sequence[str]


@dataclass(frozen=True)
class HumanPage:
    """`fatplan human report`: a page; outside: how many values lie outside the literature's band or range."""

    file: Path
    worker: str
    outside: int


@dataclass(frozen=True)
class StoredReaction:
    """A reaction in the cache. current: this version of fatplan, with these libraries, can find it."""

    name: str
    digest: str
    file: str
    size_bytes: int
    current: bool


@dataclass(frozen=True)
class UnreadableFile:
    """A file of the cache that this version cannot read. damaged: else it has another version's format."""

    file: str
    damaged: bool
    reason: str


@dataclass(frozen=True)
class CacheContents:
    """`fatplan cache list`."""

    folder: Path
    reactions: Sequence[StoredReaction]
    unreadable: Sequence[UnreadableFile]
    size_bytes: int


@dataclass(frozen=True)
class CheckedReaction:
    """A file checked by `fatplan cache verify`. verdict: ok, degraded, failed, damaged or other version."""

    file: str
    name: str | None
    verdict: str
    reason: str


@dataclass(frozen=True)
class CacheCheck:
    """`fatplan cache verify`. counts: files by verdict."""

    folder: Path
    counts: Mapping[str, int]
    reactions: Sequence[CheckedReaction]


@dataclass(frozen=True)
class KeyDifference:
    """A part of a reaction's key: a setting's path, `source FILE` or `version of LIBRARY`; null where there is none."""

    part: str
    wanted: Any
    stored: Any


@dataclass(frozen=True)
class MissingReaction:
    """A reaction that is not in the cache, and in what the nearest one differs; nearest is null if there is none."""

    name: str
    nearest: str | None
    nearest_name: str | None
    differences: Sequence[KeyDifference]


@dataclass(frozen=True)
class CacheMisses:
    """`fatplan cache why`. found: how many of `wanted` reactions are there; damaged: files, with what is wrong."""

    folder: Path
    wanted: int
    found: int
    missing: Sequence[MissingReaction]
    damaged: Sequence[str]


@dataclass(frozen=True)
class UselessFile:
    """A file that no run of this version will read again, and why."""

    file: str
    reason: str
    size_bytes: int


@dataclass(frozen=True)
class CacheRubbish:
    """`fatplan cache gc`."""

    folder: Path
    files: Sequence[UselessFile]
    deleted: bool


@dataclass(frozen=True)
class ExportedArchive:
    """`fatplan cache export`."""

    file: Path
    reactions: int
    size_bytes: int


@dataclass(frozen=True)
class ImportedReaction:
    """An entry of a bundle: where it is now, or why it was refused. new: it was not there before."""

    member: str
    path: Path | None
    new: bool
    refused: str


@dataclass(frozen=True)
class ImportedArchive:
    """`fatplan cache import`."""

    folder: Path
    reactions: Sequence[ImportedReaction]
    taken: int
    refused: int

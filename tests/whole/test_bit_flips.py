"""A single bit that changes, anywhere in any kind of file that is kept, is noticed before anything is made of it."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from published import COMMAND, publish

from fatigue_planner.core.errors import ArchiveError, DamagedFileError, FatplanError, OtherVersionError
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions import hdf5_layout
from fatigue_planner.reactions.archive import export_archive, import_archive
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.results import load_results
from fatigue_planner.study.benchmark.runner import TrialStore, run_grid
from fatigue_planner.study.benchmark.selection import Selection, cells, selected

# kind -> flips in the slow test
SLOW = {"entry": 400, "archive": 100, "trials": 400, "table": 150, "actions": 150, "manifest": 300}


@pytest.fixture(scope="module")
def small(paper: Experiment) -> Experiment:
    return selected(paper, Selection([5], None, ["random", "greedy"], 4, None, None))


@pytest.fixture(scope="module")
def grid(small: Experiment, reactions: tuple[Reaction, ...]) -> list[Cell]:
    return cells(small, cycle_profiles(small, reactions))


@pytest.fixture(scope="module")
def kept(
    small: Experiment, reactions: tuple[Reaction, ...], cache_folder: Path, grid: list[Cell],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:  # fmt: skip
    """One folder with every kind of file."""
    folder = tmp_path_factory.mktemp("kept")
    shutil.copytree(cache_folder, folder / "cache")
    export_archive(ReactionCache(cache_folder), reaction_requests(small)[:1], folder / "own.zip", "fatplan simulate")
    publish(small, reactions, folder / "results")
    run_grid(grid[:1], folder / "trials", LocalProcesses(1), lambda cell, n: None)
    return folder


class Noticed:
    """Where the file of a kind is, and whether reading it, as the program does, says that it is damaged."""

    def __init__(self, kept: Path, folder: Path, small: Experiment, grid: list[Cell]) -> None:
        self.folder = Path(shutil.copytree(kept, folder / "kept"))
        self._small, self._grid = small, grid

    def path(self, kind: str) -> Path:
        files = {
            "entry": "cache/*.h5", "archive": "own.zip", "trials": "trials/*/*.json",
            "table": "results/trials.csv", "actions": "results/actions.csv", "manifest": "results/manifest.json",
        }  # fmt: skip
        return sorted(self.folder.glob(files[kind]))[0]

    def by(self, kind: str) -> bool:
        ways: dict[str, Callable[[], object]] = {
            "entry": self._entry, "archive": self._archive, "trials": self._trials,
        }  # fmt: skip
        try:
            return bool(ways.get(kind, self._results)())
        except (DamagedFileError, OtherVersionError, ArchiveError):
            return True

    def _entry(self) -> bool:
        ReactionCache(self.folder / "cache").read(self.path("entry"))
        return False

    def _archive(self) -> bool:
        """Refused; or the flip is in the table of contents at the end, which is not read, and the import is right."""
        into = ReactionCache(self.folder / "into")
        (entry,) = import_archive(self.path("archive"), into)
        if entry.path is None:
            return True
        original = self.folder / "cache" / entry.path.name
        return entry.path.read_bytes() == original.read_bytes()

    def _trials(self) -> bool:
        store = TrialStore(self.folder / "trials")
        store.load(self._grid[0])
        for path in self.folder.glob("*/**/*.damaged-1"):
            path.rename(path.with_suffix(".json"))
        return len(store.warnings) == 1

    def _results(self) -> bool:
        load_results(self._small, self.folder / "results", COMMAND)
        return False


def flip(noticed: Noticed, kind: str, count: int, seed: int) -> None:
    path, rng = noticed.path(kind), np.random.default_rng(seed)
    whole = path.read_bytes()
    assert kind == "archive" or not noticed.by(kind), "intact, but called damaged"
    for _ in range(count):
        index, bit = int(rng.integers(len(whole))), int(rng.integers(8))
        data = bytearray(whole)
        data[index] ^= 1 << bit
        path.write_bytes(data)
        assert noticed.by(kind), f"bit {bit} of byte {index} of {path.name}"
    path.write_bytes(whole)


@pytest.mark.parametrize("kind", SLOW)
def test_flipped_bits_are_noticed(kind: str, kept: Path, small: Experiment, grid: list[Cell], tmp_path: Path) -> None:
    flip(Noticed(kept, tmp_path, small, grid), kind, 10, seed=1)


@pytest.mark.parametrize("kind", ["trials", "table", "actions", "manifest"])
def test_a_changed_digit_is_noticed(kind: str, kept: Path, small: Experiment, grid: list[Cell], tmp_path: Path) -> None:
    """The lowest bit of a digit makes it another one, so that nothing but a checksum tells."""
    noticed = Noticed(kept, tmp_path, small, grid)
    path = noticed.path(kind)
    whole = path.read_bytes()
    digits = [index for index, letter in enumerate(whole) if chr(letter).isdigit()]
    for index in np.random.default_rng(3).choice(digits, 10, replace=False):
        path.write_bytes(whole[:index] + bytes([whole[index] ^ 1]) + whole[index + 1 :])
        assert noticed.by(kind), f"byte {index} of {path.name}"


@pytest.mark.slow
@pytest.mark.parametrize("kind", SLOW)
def test_many_flipped_bits_are_noticed(
    kind: str, kept: Path, small: Experiment, grid: list[Cell], tmp_path: Path
) -> None:
    assert sum(SLOW.values()) >= 1_000
    flip(Noticed(kept, tmp_path, small, grid), kind, SLOW[kind], seed=2)


def test_a_damaged_entry_is_refused_before_hdf5_sees_it(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = ReactionCache(kept / "cache").files()[0]
    whole = path.read_bytes()
    seen: list[int] = []
    monkeypatch.setattr(hdf5_layout, "read_hdf5", lambda content, layout: seen.append(len(content)))
    for index in (0, 20, 511, 512, 600, len(whole) - 1):
        data = bytearray(whole)
        data[index] ^= 1
        with pytest.raises(FatplanError):
            hdf5_layout.read_entry(bytes(data), "f")
    assert seen == []

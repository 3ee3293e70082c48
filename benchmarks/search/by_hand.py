"""search.cpp from Python: built by the system's compiler into the user's cache, called through ctypes."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp

from fatigue_planner.files import DIGEST_LENGTH, digest_of

SOURCE = Path(__file__).with_name("search.cpp")
FLAGS = ("-std=c++17", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-shared", "-fPIC")
LANES = 8


class CompilerMissingError(Exception):
    """The C++ search cannot be built here."""


@dataclass(frozen=True)
class Root:
    """What a search found: values and counts of the root's actions, and how deep its descents went on average."""

    values: np.ndarray
    tried: np.ndarray
    depth: float


def compiler() -> str:
    for name in (os.environ.get("CXX"), "c++", "g++", "clang++"):
        if name and shutil.which(name):
            return name
    raise CompilerMissingError("no C++ compiler (c++, g++ or clang++) is installed")


def library() -> ctypes.CDLL:
    """The compiled search; built once per source, compiler and processor."""
    command = compiler()
    said = subprocess.run([command, "--version"], check=True, capture_output=True, text=True).stdout
    key = digest_of([SOURCE.read_text(), said, " ".join(FLAGS), _processor()])[:DIGEST_LENGTH]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fatplan"
    path = cache / f"search-{key}.so"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as folder:
            built = Path(folder) / path.name
            ran = subprocess.run([command, *FLAGS, "-o", built, SOURCE], check=False, capture_output=True, text=True)
            if ran.returncode:
                raise CompilerMissingError(f"{command} cannot build {SOURCE.name}: {ran.stderr.strip()[:500]}")
            built.replace(path)
    return ctypes.CDLL(str(path))


def _processor() -> str:
    """What -march=native depends on."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return ""
    return "".join(line for line in lines[:40] if line.startswith(("flags", "model name", "Features")))


class SearchByHand:
    """The C++ search of one model. Not for threads: its memory stays between calls."""

    def __init__(self, model: FatiguePomdp) -> None:
        self._search = library().search
        self._search.restype = ctypes.c_double
        self.actions, _, entries = model.gain.shape
        self._gain, self._offset = (_padded(rows.reshape(-1, entries)) for rows in (model.gain, model.offset))
        self._observation = np.ascontiguousarray(model.observation)
        sharp = bool((model.observation == np.eye(*model.observation.shape)).all())
        # ctypes needs to be told of every double and of every 64-bit number
        self._model = (
            *(ctypes.c_int(n) for n in (self.actions, *self._observation.shape, self._gain.shape[1])),
            *(ctypes.c_void_p(array.ctypes.data) for array in (self._gain, self._offset, self._observation)),
            ctypes.c_int(sharp),
            *(ctypes.c_double(x) for x in (model.expertise, model.discount, 1 / model.entries)),
        )
        self._values, self._tried = np.empty(self.actions), np.empty(self.actions, np.int64)

    def __call__(self, belief: Belief, descents: int, exploration_constant: float, maximise: bool, seed: int) -> Root:
        states, weights = _padded(belief.states), np.ascontiguousarray(belief.weights)
        depth = self._search(
            *self._model,
            ctypes.c_void_p(states.ctypes.data),
            ctypes.c_void_p(weights.ctypes.data),
            ctypes.c_int(weights.size),
            ctypes.c_int(descents),
            ctypes.c_double(exploration_constant),
            ctypes.c_int(maximise),
            ctypes.c_uint64(seed),
            ctypes.c_void_p(self._values.ctypes.data),
            ctypes.c_void_p(self._tried.ctypes.data),
        )
        return Root(self._values.copy(), self._tried.copy(), depth)


def _padded(rows: np.ndarray) -> np.ndarray:
    """Rows with zeros after them to a multiple of LANES, starting at a cache line."""
    width = -(-rows.shape[1] // LANES) * LANES
    memory = np.zeros(rows.shape[0] * width + LANES)
    skip = (-memory.ctypes.data % 64) // 8
    wide = memory[skip : skip + rows.shape[0] * width].reshape(-1, width)
    wide[:, : rows.shape[1]] = rows
    return wide

"""search.cpp from Python: built by the system's compiler into the user's cache, called through ctypes."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fatigue_planner.core.files import DIGEST_LENGTH, digest_of
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.simd import aligned

SOURCE = Path(__file__).with_name("search.cpp")
FLAGS = ("-std=c++17", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-shared", "-fPIC")


class CompilerMissingError(Exception):
    """The C++ search cannot be built here."""


@dataclass(frozen=True)
class Root:
    """The result of a search: values and counts of the root's actions, and the mean depth of a descent."""

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
    version = subprocess.run([command, "--version"], check=True, capture_output=True, text=True).stdout
    key = digest_of([SOURCE.read_text(), version, " ".join(FLAGS), _processor()])[:DIGEST_LENGTH]
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
    """The description of the processor, on which -march=native depends."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return ""
    return "".join(line for line in lines[:40] if line.startswith(("flags", "model name", "Features")))


class SearchByHand:
    """The C++ search of one model. Not thread-safe: its memory is kept between calls."""

    def __init__(self, model: FatiguePomdp) -> None:
        self._search = library().search
        self._search.restype = ctypes.c_double
        arrays = model.arrays
        assert arrays.expertise.size == 1
        self.actions = arrays.n_actions
        self._kept = arrays.gain, arrays.offset, np.ascontiguousarray(arrays.observation)
        # ctypes must know which arguments are doubles and which have 64 bits
        self._model = (
            *(ctypes.c_int(n) for n in (self.actions, *arrays.observation.shape, arrays.gain.shape[1])),
            *(ctypes.c_void_p(array.ctypes.data) for array in self._kept),
            ctypes.c_int(arrays.observation_reveals_outcome),
            *(ctypes.c_double(x) for x in (arrays.expertise[0], model.discount, arrays.cost.scale)),
        )
        self._values, self._tried = np.empty(self.actions), np.empty(self.actions, np.int64)

    def __call__(self, belief: Belief, descents: int, exploration_constant: float, maximise: bool, seed: int) -> Root:
        """Search from a belief."""
        states = aligned(belief.states[:, :-1])  # the last element is the worker
        weights = np.ascontiguousarray(belief.weights)
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

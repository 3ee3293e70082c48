"""Files damaged by chance: each is read, or refused with one message that names a file; none takes long or grows."""

import copy
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import ROOT
from hypothesis import Phase, given, seed, settings
from hypothesis import strategies as st
from mutations import damaged
from pace import within

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.core.yaml_reader import _READ_DIFFERENTLY, _FastLoader, _Loader, read_yaml
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.sensitivity.study import load_study

MAX_SECONDS = 2.0
TRIES = 3
MAX_MIB = 100  # that a single file may cost
EXAMPLES_OF_A_RUN = 500
EXPERIMENTS = ROOT / "experiments"
# How a file is read, and those that damaged ones are made from; of ten, seven are experiments, and two are claims.
EXPERIMENT_NAMES = ["paper", "pose_grid", "co_transport", "workers", "line", "hidden_worker", "planners"]
KINDS: list[tuple[Callable[[Path], object], list[str]]] = [
    *[(load_experiment, EXPERIMENT_NAMES)] * 7, *[(load_claims, ["paper_claims"])] * 2, (load_study, ["sensitivity"]),
]  # fmt: skip

SNIPPETS = [
    b"\x00", b"\xff", b"\xfe\xff", b"\xed\xa0\x80", b"\xc2\x85", "\ufeff".encode(), "\u202e".encode(),
    "\u2028".encode(), b"!!python/object/apply:os.system [id]", b"!!bool x", b"!<t>", b"!", b"&a ", b"*a", b"<<: ",
    b"? ", b"- ", b"[", b"{", b"]", b"}", b": ", b"#", b"|\n", b">\n", b"%YAML 9.9\n", b"%TAG ! x\n", b"---\n",
    b"...\n", b"\t", b"'", b'"', b'"\\ud800"', b'"\\UFFFFFFFF"', b'"\\e[2J"', b"\x1b[31m", b"1e999", b"1e-999", b"-0",
    b".nan", b"-.inf", b"9" * 400, b"9" * 20000, b"~", b"=", b"0x10", b"{" * 50, b"[" * 3000, b"\r", b"\r\n", b"@",
    b"`", b"a" * 5000, b"2023-99-99",
]  # fmt: skip
WORDS = ["..", "/dev/zero", "paper", "average_man", "random", "pomcp", "lookahead", "exact", "mean", "1e3", "%s{0}", ""]
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.sampled_from(WORDS)
VALUES = st.recursive(
    SCALARS | st.sampled_from([10**9, 10**18, 1e300, "x" * 3000]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=3) | st.sampled_from(["kind", "from", "to", "count"]), inner, max_size=3)
    ),
    max_leaves=5,
)
FACTORS = st.sampled_from([1.001, 0.5, 2.0, 100.0, 1e-6, -1.0, 1e9])


def holders(content: Any) -> Iterator[tuple[Any, Any]]:
    """Every mapping with a key of it, every list with an index."""
    for key, value in list(content.items() if isinstance(content, dict) else enumerate(content)):
        yield content, key
        if isinstance(value, dict | list):
            yield from holders(value)


@st.composite
def restructured(draw: st.DrawFn, content: Any) -> bytes:
    """Content as JSON, which is YAML but for two words, with one to three other values, keys or lengths."""
    content = copy.deepcopy(content)
    for _ in range(draw(st.sampled_from([1, 1, 1, 2, 3]))):
        found = list(holders(content)) or [([content], 0)]
        (holder, key), (other, other_key) = (found[draw(st.integers(0, len(found) - 1))] for _ in range(2))
        value = holder[key]
        change = draw(st.sampled_from(["near", "near", "value", "lose", "swap", "rename", "copy"]))
        if change == "near" and isinstance(value, list):
            holder[key] = draw(st.sampled_from([value[::-1], value[:1], value * 2]))
        elif change == "near" and isinstance(value, int | float):
            holder[key] = type(value)(value * draw(FACTORS)) if abs(value) < 1e9 else -value
        elif change == "lose":
            del holder[key]
        elif change == "swap":
            holder[key], other[other_key] = copy.deepcopy((other[other_key], value))
        elif change == "rename" and isinstance(holder, dict):
            new = draw(st.sampled_from([f"{key}s", key[1:], key.upper(), str(other_key), "\u202e"]) | st.text())
            holder[new] = holder.pop(key)
        elif change == "copy":
            count = min(draw(st.sampled_from([1, 10, 3000])), 1_000_000 // len(json.dumps(value)))
            if isinstance(holder, dict):
                holder |= {f"{key}_{number}": value for number in range(count)}
            else:
                holder[key:key] = [value] * count
            content = json.loads(json.dumps(content))  # else a change of one copy is one of all: files of 500 MB
        else:
            holder[key] = draw(VALUES)
    return json.dumps(content, indent=1).replace("NaN", ".nan").replace("Infinity", ".inf").encode()


def peak_mib() -> float:
    """The most memory this process has had since the peak was reset."""
    return int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024


def end_of(path: Path, load: Callable[[Path], object]) -> str:
    """What becomes of a file: it is read or refused, as a bad file must be.

    A file that takes long takes long each time: a second reading tells it from a pause of the machine.
    """
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak
    before, message = peak_mib(), ""
    for _ in range(TRIES):
        begin = time.thread_time()
        try:
            load(path)
        except FatplanError as error:
            message = str(error)
        if within(time.thread_time() - begin, MAX_SECONDS):
            break
    else:
        pytest.fail(f"{path} took more than {MAX_SECONDS} s of CPU time {TRIES} times")
    assert peak_mib() - before < MAX_MIB
    if not message:
        return "read"
    # a file may name another one, anywhere, that is not a file
    assert message.startswith(str(path.parent)) or "cannot be read (" in message, message
    assert all(character.isprintable() or character == "\n" for character in message)
    assert len(message) < 30_000
    return "refused"


def plain(content: Any) -> Any:
    """The same with lists in place of tuples."""
    if isinstance(content, dict):
        return {key: plain(value) for key, value in content.items()}
    return [plain(item) for item in content] if isinstance(content, tuple) else content


def damages(change: str, path: Path) -> st.SearchStrategy[bytes]:
    """A file changed in its bytes or in what it says."""
    if change == "structure":
        return restructured(plain(read_yaml(path, FatplanError)))
    text = path.read_bytes()
    others = [file.read_bytes()[1000:1400] for file in EXPERIMENTS.glob("*.yaml")]
    return damaged(text, st.integers(0, len(text)), st.sampled_from(SNIPPETS + others) | st.binary(max_size=8))


@pytest.mark.parametrize("change", ["bytes", "structure"])
@pytest.mark.parametrize(
    "files",
    [
        range(100),
        *(pytest.param(range(first, first + 1000), marks=pytest.mark.slow) for first in range(0, 5000, 1000)),
    ],
    ids=str,
)
def test_damaged_files_are_read_or_refused(change: str, files: range, tmp_path: Path) -> None:
    """Both ends must be reached, or this says nothing about one of them."""
    for file in EXPERIMENTS.glob("*.yaml"):  # so that the damaged files find those they name
        (tmp_path / file.name).write_bytes(file.read_bytes())
    for name, load in {name: load for load, names in KINDS for name in names}.items():
        load(EXPERIMENTS / f"{name}.yaml")  # what the first file of a program costs, such as compiling, is not a file's
    path = tmp_path / "damaged.yaml"
    ends = Counter[str]()
    known = {name: damages(change, EXPERIMENTS / f"{name}.yaml") for _, names in KINDS for name in names}

    def read_or_refuse(data: st.DataObject) -> None:
        load, names = data.draw(st.sampled_from(KINDS))
        path.write_bytes(data.draw(known[data.draw(st.sampled_from(names))]))
        ends[end_of(path, load)] += 1

    # Hypothesis remembers every example of a run: of thousands, the garbage collector alone would take seconds. Its
    # phase `explain` traces each line, so that a file would seem to take twenty times as long.
    phases = (Phase.generate, Phase.shrink)
    for number in files[::EXAMPLES_OF_A_RUN]:
        examples = settings(max_examples=min(len(files), EXAMPLES_OF_A_RUN), derandomize=False, phases=phases)
        seed(number)(examples(given(st.data())(read_or_refuse)))()
    assert min(ends["read"], ends["refused"]) >= sum(ends.values()) / 50, ends


# Most of YAML's grammar on few lines, so that damages meet it.
GRAMMAR = """a: [1, 2, {b: c, 'd': "e"}]
f: |
  x
  y
g: >-
  z

  w
h: &q {i: 1.0, j: ~}
k: *q
l:
  - m
  - n: o # c
    p: q
  - - r
    - true
's t': "u\\tv"
w: x y
  z
<<: {1a: \u00e4}
"""


@st.composite
def rewritten(draw: st.DrawFn) -> str:
    """GRAMMAR with a piece left out, put in or repeated, at one or two places."""
    text = GRAMMAR
    for _ in range(draw(st.sampled_from([1, 1, 2]))):
        start, end = draw(st.integers(0, len(text))), draw(st.sampled_from([0, 0, 0, 1, 2, 5, 30]))
        piece = st.sampled_from(
            [*" \n:-,[]{}#&*!|>'\"%@`~=\\\r0a.<", "", ": ", "- ", "? ", "  ", "\n\n", text[start:][:9]]
        )
        text = text[:start] + draw(piece | st.text(max_size=2)) + text[start + end :]
    return text


@pytest.mark.parametrize("files", [range(1), pytest.param(range(1, 5), marks=pytest.mark.slow)], ids=str)
def test_libyaml_reads_nothing_else_than_the_parser_that_decides(files: range) -> None:
    accepted = 0

    def compare(text: str) -> None:
        nonlocal accepted
        if not _READ_DIFFERENTLY.isdisjoint(text):
            return
        try:
            found = yaml.load(text, Loader=_FastLoader)
        except (yaml.YAMLError, ValueError, OverflowError):
            return
        accepted += 1
        assert repr(found) == repr(yaml.load(text, Loader=_Loader)), text

    for number in files:
        seed(number)(settings(max_examples=EXAMPLES_OF_A_RUN, derandomize=False)(given(rewritten())(compare)))()
    assert accepted > len(files) * EXAMPLES_OF_A_RUN / 10

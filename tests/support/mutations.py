"""A small seeded fuzzer: files changed in their bytes or their structure. `python mutations.py FIRST LAST` runs it."""

import copy
import json
import random
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.sensitivity.study import load_study

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
SEED = 20230
LOADERS: dict[str, Callable[[Path], object]] = {
    "experiment": load_experiment,
    "claims": load_claims,
    "study": load_study,
}
# Of ten inputs so many are of each kind; a study reads three files.
SHARES = ("experiment",) * 7 + ("claims",) * 2 + ("study",)
SOURCES = {
    "experiment": ["paper", "pose_grid", "co_transport", "workers", "hidden_worker", "planners"],
    "claims": ["paper_claims"],
    "study": ["sensitivity"],
}
ALL_SOURCES = [name for names in SOURCES.values() for name in names]
MAX_SECONDS = 2.0
MAX_BYTES = 1_000_000
GOOD_ENDS = ("read", "refused")

SNIPPETS = [
    b"\x00", b"\xff", b"\xfe\xff", b"\xed\xa0\x80", b"\xc2\x85", "\ufeff".encode(), "\u202e".encode(),
    "\u2028".encode(), b"!!python/object/apply:os.system [id]", b"!!bool x", b"!<t>", b"!", b"&a ", b"*a", b"<<: ",
    b"? ", b"- ", b"[", b"{", b"]", b"}", b": ", b"#", b"|\n", b">\n", b"%YAML 9.9\n", b"%TAG ! x\n", b"---\n",
    b"...\n", b"\t", b"'", b'"', b'"\\ud800"', b'"\\UFFFFFFFF"', b'"\\e[2J"', b"\x1b[31m", b"1e999", b"1e-999", b"-0",
    b".nan", b"-.inf", b"9" * 400, b"9" * 20000, b"~", b"=", b"0x10", b"{" * 50, b"[" * 3000, b"\r", b"\r\n", b"@",
    b"`", b"a" * 5000, b"2023-99-99",
]  # fmt: skip
VALUES: list[Any] = [
    None, True, False, 0, 1, -1, 2, 5, 100, 10**6, 10**9, 10**18, 10**29, -(10**29), 0.5, -0.5, 1e-300, 1e300, -1e300,
    5e-324, float("nan"), float("inf"), float("-inf"), "", "a", "x" * 50, "x" * 3000, "../..", "/dev/zero", "/",
    "paper", "average_man", "random", "pomcp", "lookahead", "particles", "exact", "choice", "mean", "bound", "1e3",
    "nan", "ä", "a\nb", "%s{0}", [], {}, [[]], [{}], {"": ""}, {"kind": "choice"}, [1, 2, 3],
    {"from": -3, "to": 3, "count": 1000}, {"from": 0, "to": 1e308, "count": 2}, {"kind": "lookahead", "depth": 30},
    {"kind": []}, [float("nan")] * 3,
]  # fmt: skip


def mutated(number: int) -> tuple[str, bytes]:
    """The kind of the input with a number, and the input; the same for ever."""
    rng = random.Random(f"{SEED}/{number}")
    kind = SHARES[number % len(SHARES)]
    source = EXPERIMENTS / f"{rng.choice(SOURCES[kind])}.yaml"
    if rng.random() < 0.5:
        return kind, _changed_bytes(rng, source.read_bytes())
    content = _content(source)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        content = _changed_structure(rng, content)
    # JSON is YAML but for these two words, and quickly written
    text = json.dumps(content, ensure_ascii=False, indent=1).replace("NaN", ".nan").replace("Infinity", ".inf")
    return kind, text.encode()


def read(number: int, folder: Path) -> str:
    """What becomes of an input: `read`; `refused`, as a bad file must be; or in words what is wrong with that."""
    kind, content = mutated(number)
    path = folder / f"{kind}.yaml"
    path.write_bytes(content)
    begin = time.process_time()
    end = "read"
    try:
        LOADERS[kind](path)
    except FatplanError as error:
        end = _wrong_with(str(error), folder) or "refused"
    except BaseException:
        end = traceback.format_exc()
    spent = time.process_time() - begin
    return end if spent < MAX_SECONDS else f"took {spent:.1f} s: {end}"


def told(number: int, end: str) -> str:
    """What became of an input, so that it can be found again."""
    kind, content = mutated(number)
    return f"input {number} of seed {SEED}, {kind}: {end}\n{content[:500]!r}"


def _wrong_with(message: str, folder: Path) -> str:
    # a file may name another one, anywhere, that is no file
    if not message.startswith(str(folder)) and "cannot be read (" not in message:
        return f"the message names no file: {message[:300]}"
    if not all(one.isprintable() or one == "\n" for one in message):
        return f"the message has control characters: {message[:300]!r}"
    return f"the message has {len(message)} characters" if len(message) > 30_000 else ""


def folder_of_experiments(folder: Path) -> Path:
    """A folder in which the mutated files find the files they name."""
    for file in EXPERIMENTS.glob("*.yaml"):
        (folder / file.name).write_bytes(file.read_bytes())
    return folder


def _changed_bytes(rng: random.Random, content: bytes) -> bytes:
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        start = rng.randrange(len(data) + 1)
        span = slice(start, start + rng.choice((1, 2, 10, 100, 1000)))
        change = rng.randrange(7)
        if change == 0 and start < len(data):
            data[start] ^= 1 << rng.randrange(8)
        elif change == 1:
            del data[span]
        elif change == 2:
            data[start:start] = rng.choice(SNIPPETS)
        elif change == 3:
            data[span] = rng.choice(SNIPPETS)
        elif change == 4:
            data[start:start] = data[span] * rng.choice((1, 2, 50))
        elif change == 5:
            other = (EXPERIMENTS / f"{rng.choice(ALL_SOURCES)}.yaml").read_bytes()
            begin = rng.randrange(len(other))
            data[span] = other[begin : begin + rng.choice((10, 100, 1000))]
        else:
            del data[start:]
    return bytes(data)


def _changed_structure(rng: random.Random, content: Any) -> Any:
    content = copy.deepcopy(content)
    holders = list(_holders(content))
    if not holders:
        return rng.choice(VALUES)
    holder, key = rng.choice(holders)
    other, other_key = rng.choice(holders)
    change = rng.randrange(7)
    if change <= 1:
        holder[key] = _near(rng, holder[key]) if rng.random() < 0.7 else copy.deepcopy(rng.choice(VALUES))
    elif change == 2:
        del holder[key]
    elif change == 3:
        holder[key], other[other_key] = copy.deepcopy(other[other_key]), copy.deepcopy(holder[key])
    elif change == 4 and isinstance(holder, dict):
        holder[_renamed(rng, key, other_key)] = holder.pop(key)
    elif change == 5 and isinstance(other, dict):
        other[_renamed(rng, str(key), other_key)] = copy.deepcopy(holder[key])
    elif isinstance(holder, dict):
        for copies in range(min(rng.choice((1, 10, 300)), _room(holder[key]))):
            holder[f"{key}_{copies}"] = copy.deepcopy(holder[key])
    else:
        count = min(rng.choice((1, 10, 3000)), _room(holder[key]))
        holder[key:key] = [copy.deepcopy(holder[key]) for _ in range(count)]
    return content


def _room(value: Any) -> int:
    """How many copies of a value may be made, so that it is not the fuzzer's own memory that is measured."""
    return MAX_BYTES // len(json.dumps(value))


def _near(rng: random.Random, value: Any) -> Any:
    """A value of the same type where there is one at hand, so that it is not only forms that are wrong."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return rng.choice((value + 1, value - 1, value * 2, value * 10**4, 1, 0, -value))
    if isinstance(value, float):
        return value * rng.choice((1.001, 0.5, 2.0, 100.0, 1e-6, -1.0, 1e9))
    if isinstance(value, list):
        return rng.choice((value[::-1], value[:1], value * 2, value + value[:1]))
    return copy.deepcopy(rng.choice(VALUES))


def _renamed(rng: random.Random, key: str, other: object) -> str:
    return rng.choice(
        (key + "s", key[1:], key.upper(), str(other), "", "a b", "kind", "x" * 200, "\u202e", "a\nb", "1")
    )


def _holders(content: Any) -> Any:
    """Every dict with a key of it, every list with an index."""
    for key, value in list(content.items() if isinstance(content, dict) else enumerate(content)):
        yield content, key
        if isinstance(value, dict | list):
            yield from _holders(value)


@cache
def _content(source: Path) -> Any:
    """What a file says; `_changed_structure` leaves it as it is."""
    return _plain(read_yaml(source, FatplanError))


def _plain(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _plain(value) for key, value in content.items()}
    return [_plain(item) for item in content] if isinstance(content, tuple) else content


def _peak_mib() -> float:
    """The most memory this process ever had; its resource usage would have the parent's in it."""
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def main() -> None:
    """Run a range of inputs; print every fault, and at the end the number of inputs and the peak of memory in MiB."""
    warnings.simplefilter("error")
    first, last = map(int, sys.argv[1:])
    with tempfile.TemporaryDirectory() as name:
        folder = folder_of_experiments(Path(name))
        faults = 0
        for number in range(first, last):
            if (end := read(number, folder)) not in GOOD_ENDS:
                faults += 1
                print(told(number, end), flush=True)
    print(last - first, _peak_mib())
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()

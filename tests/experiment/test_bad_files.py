"""Every bad file gets one clear message with file, key, value and what is allowed; soon, and in little memory."""

import copy
import math
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from conftest import PAPER, ROOT
from deciding_settings import EXPERIMENT, LEAVES, WHOLE, inside, parsed
from pace import within
from settings_leaves import Path as Keys
from settings_leaves import groups

from fatigue_planner.core.errors import ExperimentError, FatplanError
from fatigue_planner.experiment.error_messages import dotted
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.study.claims.loader import load_claims
from fatigue_planner.study.sensitivity.study import load_study

linux = pytest.mark.skipif(not Path("/proc/self/mem").is_file(), reason="needs Linux' /proc")
MAX_SECONDS = 2.0  # of CPU time
MAX_MIB = 300
# The sections that the paper's file leaves out.
FURTHER = """
cost:
  fatigue: mean_square
  weights: {wrist: 0}
  posture: [{kind: upper_arm_raised, angle_deg: 60, weight: 0.01}]
hidden_workers:
  rates:
    fatigue_rate_factor: {kind: choice, values: [0.5, 1, 2], probabilities: [0.25, 0.5, 0.25]}
    recovery_rate_factor: {kind: lognormal, median: 1, sigma: 0.5}
  skill:
    expertise: {kind: uniform, from: 0, to: 5000}
recognition:
  arm: {arm: 0.9, back: 0.1}
  back: {arm: 0.2, back: 0.7, unclear: 0.1}
recognition_by_action:
  low: {arm: {arm: 0.8, back: 0.2}, back: {back: 1}}
recorded:
  average_man: {low: {arm: 0123456789abcdef}}
recording_accuracy: {marker_rms_m: 0.03, wrist_load_kg: 1}
robot:
  arm: ur5e
  base_m: {x: 1.1, z: 0.5}
  hold: {direction: {x: -1}, mass_kg: 2}
choice_models:
  habit: {kind: inertia, inertia: 1.5, offsets: {arm: -0.5}}
  liked: {kind: offset, offsets: {back: 1}}
belief: {kind: particles, count: 300}
"""
SECTIONS = {
    section.split(":")[0]: section for section in re.split(r"(?m)^(?=[a-z_]+:)", PAPER.read_text() + FURTHER)[1:]
}
CASES: dict[str, list[tuple[str, str, str]]] = yaml.safe_load(
    (ROOT / "tests" / "experiment" / "bad_experiments.yaml").read_text(encoding="utf-8")
)


def changed(section: str, old: str, new: str) -> str:
    """The complete experiment with one change in one section."""
    assert old in SECTIONS[section], f"{section} has no {old!r}"
    return "".join(text.replace(old, new, 1) if name == section else text for name, text in SECTIONS.items())


def message_of(path: Path, load: Any = load_experiment) -> str:
    """The message about a bad file, without its name, which each line must have; two seconds are enough."""
    begin = time.thread_time()
    with pytest.raises(FatplanError) as caught:
        load(path)
    assert within(time.thread_time() - begin, MAX_SECONDS)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines), lines
    return "\n".join(line.removeprefix(f"{path}: ") for line in lines)


def test_the_complete_experiment_is_valid(tmp_path: Path) -> None:
    file = tmp_path / "whole.yaml"
    file.write_text("".join(SECTIONS.values()))
    assert load_experiment(file).belief is not None
    assert set(SECTIONS) == set(CASES) == set(Experiment.model_fields)


# Values of types that most settings do not have, as messages show them; and the message by the type of the setting.
OTHER_TYPES = {"True": True, "'1'": "1", "[1]": (1,), "{'a': 1}": {"a": 1}, "nan": math.nan, "-inf": -math.inf}
NUMBER = r"input should be (a valid (number|integer)|a finite number|greater than or equal to 0)\."
SAID = {
    float: NUMBER,
    int: NUMBER,
    bool: r"input should be a valid boolean\.",
    str: r"input should be a valid string\.|(input )?should be (one of )?'.*\.",
}


def first_line(path: Keys, *value: object, renamed: str = "") -> str:
    """The first line about the experiment with every setting, with another value, another key or none at a path."""
    content = copy.deepcopy(EXPERIMENT)
    group = inside(content, path[:-1])
    if value:
        group[path[-1]] = value[0]
    else:
        old = group.pop(path[-1])
        group |= {renamed: old} if renamed else {}
    with pytest.raises(ExperimentError) as caught:
        parsed(content)
    return str(caught.value).splitlines()[0].removeprefix("the experiment: ")


@pytest.mark.parametrize("section", Experiment.model_fields)
def test_every_setting_refuses_values_of_other_types(section: str) -> None:
    named = {leaf.name: leaf for leaf in LEAVES if leaf.path[0] == section}
    for leaf in named.values():
        kind = type(leaf.value)
        for shown, value in OTHER_TYPES.items():
            if kind is float or type(value) is not kind:
                begin = f"{dotted(leaf.path)} = {shown}: "
                line = first_line(leaf.path, value)
                assert line.startswith(begin) and re.fullmatch(SAID[kind], line.removeprefix(begin)), line


def test_every_key_that_is_misspelt_missing_or_of_another_form_is_refused() -> None:
    """Where things come in several kinds, it is the kind that is missed first."""
    for path, group in {type(group): (path, group) for path, group in groups(WHOLE)}.values():
        written = inside(EXPERIMENT, path)
        if path:
            assert first_line(path, "x") == f"{dotted(path)} = 'x': should be a mapping of keys and values."
        for name, field in type(group).model_fields.items():
            key = field.alias or name
            here = (*path, key)
            if key not in written:
                continue
            kinds = f"{dotted(path)}: needs a kind: one of "
            assert first_line(here, renamed=f"{key}_").startswith(
                (f"{dotted(here)}_: unknown key; did you mean '{key}'?", kinds)
            )
            if field.is_required():
                assert first_line(here).startswith((f"{dotted(here)}: is missing.", kinds))
                assert first_line(here, None).startswith(f"{dotted(here)} = None: ")
            form = {dict: "a mapping of keys and values", list: "a list"}.get(type(written[key]))
            if form:
                assert first_line(here, "x") == f"{dotted(here)} = 'x': should be {form}."


@pytest.mark.parametrize("section", SECTIONS)
def test_each_bad_section_is_refused(section: str, tmp_path: Path) -> None:
    """One thing is wrong, and the first line is about it; the others are about its consequences."""
    file = tmp_path / "mine.yaml"
    wrong = []
    for old, new, expected in CASES[section]:
        file.write_text(changed(section, old, new), encoding="utf-8")
        message = re.sub(r"^line \d+, column \d+:", "line N, column N:", message_of(file))
        if not message.startswith(expected):
            wrong.append((new, message))
    assert not wrong


# Files of valid form that would make the check of their meaning, or what follows it, endless.
PLACES = "{from: 0.3, to: 0.5, count: 71}"
GRID = f"right_hand: {{position_m: {{x: {PLACES}, y: {PLACES}, z: 1}}}}"
WORKER = "height_m: 1.75, mass_kg: 75, sex: male, strength: average_man, natural_posture_deg: {}"
TOO_LARGE = {
    "a strength set with too long a name": (
        "workers", "strength: average_man", f"strength: {'x' * 300}", "workers.average_man: strength set 'xxx",
    ),
    "a name of a file that no system takes": (
        "workers", "strength: average_man", f"strength: {'x' * 3000}", "workers.average_man.strength = 'xxx",
    ),
    "workers": (
        "workers", "  average_man:", "".join(f"  w{i}: {{{WORKER}}}\n" for i in range(400)) + "  average_man:",
        "workers = {'w0': {'height_m': 1.75, 'mass_kg': 75, 'sex': 'male', 'str…: should have at most 50 of them.",
    ),
    "a grid of 10^9 positions": (
        "actions", "x: 0.5, y: -0.25, z: 1.2", ", ".join(f"{axis}: {{from: 0, to: 1, count: 1000}}" for axis in "xyz"),
        "actions.high: its grid has 1000000000 points; at most 10000 actions are allowed in all.",
    ),
    "several grids": (
        "actions", "  high:", "".join(f"  g{i}: {{{GRID}}}\n" for i in range(100)) + "  high:",
        "actions.g1: its grid has 5041 points; at most 10000 actions are allowed in all.",
    ),
    "a grid that is wrong at every position": (
        "actions", "  high:", f"  g: {{{GRID.replace('z: 1', 'z: 9')}}}\n  high:",
        "actions.g_x0.3_y0.3.right_hand.position_m.z = 9: input should be less than or equal to 3.",
    ),
    "a grid that is out of reach at every position": (
        "actions", "  high:", f"  g: {{{GRID.replace('z: 1', 'z: 2.9').replace('71', '70')}}}\n  high:",
        "actions.g_x0.3_y0.3.right_hand.position_m: 2.93 m from the feet;",
    ),
    "ticks": ("controller", "time_step_s: 0.01", "time_step_s: 1e-4", None),
    "tasks": (
        "preferences", "tasks:\n", "tasks:\n" + "      - {kind: segment_upright, segment: head, weight: 1}\n" * 1000,
        "preferences.arm.tasks = [{'kind': 'segment_upright', 'segment': 'head', 'weight': 1}…: should have at most 50",
    ),
    "preferences": (
        "preferences", "  arm:", "".join(f"  p{i}: {{tasks: []}}\n" for i in range(2000)) + "  arm:",
        "preferences = {'p0': {'tasks': ()}, 'p1': {'tasks': ()}, 'p2': {'tasks': (…: should have at most 100 of",
    ),
    "waypoints": (
        "actions", "position_m: {x: 0.5, y: -0.25, z: 1.2}\n      orientation_deg: {y: -90}",
        f"waypoints: [{', '.join(['{work_time_s: 0}'] * 3000)}]",
        "actions.high.right_hand.waypoints.0.position_m: is missing.",
    ),
    "digits": ("discount", "discount: 0.95", f"discount: {'9' * 100_000}", "line N, column N: 99999"),
    "states": (
        "initial_beliefs", "    - {probability: 1}", f"    [{', '.join(['{probability: 0.0005}'] * 2000)}]",
        "initial_beliefs.single = [{'probability': 0.0005}, {'probability': 0.0005}, {'probabi…: should have at most ",
    ),
    "values": (
        "hidden_workers", "values: [0.5, 1, 2]", f"values: [{', '.join(['1'] * 5000)}]",
        "hidden_workers.rates.fatigue_rate_factor.values = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1",
    ),
    "names x names": (
        "recognition", "arm: {arm: 0.9, back: 0.1}", f"arm: {{{', '.join(f'a{i}: 0.1' for i in range(4000))}}}",
        "recognition.arm: probabilities sum to 400, not to 1.",
    ),
    "lengths": (
        "benchmark", "n_cycles: [5, 20, 100]", f"n_cycles: [{', '.join(['7'] * 9000)}]",
        "benchmark.n_cycles = [7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7,…: should have at most 1000",
    ),
    "values in all": (
        "benchmark", "n_cycles: [5, 20, 100]", f"n_cycles: [{', '.join(['7'] * 100_000)}]",
        "line N, column N: more than 10000 keys and values; settings need a few hundred.",
    ),
    "cells": (
        "benchmark", "    random: {kind: random}\n", "".join(f"    r{i}: {{kind: random}}\n" for i in range(999)), None,
    ),
    "unknown keys": (
        "tool", "  mass_kg: 5", "".join(f"  mass_{i}: 5\n" for i in range(3000)) + "  mass_kg: 5",
        "tool.mass_0: unknown key; did you mean 'mass_kg'?",
    ),
    "unknown conditions": (
        "figures", "figure5b: [multiple_novice]", f"figure5b: [{', '.join(f'c{i}' for i in range(5000))}]",
        "figures.figure5b: c0, c1, c2",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [name for name, case in TOO_LARGE.items() if case[3] is not None])
def test_too_much_is_refused_before_it_costs_anything(name: str, tmp_path: Path) -> None:
    section, old, new, expected = TOO_LARGE[name]
    file = tmp_path / "mine.yaml"
    file.write_text(changed(section, old, new))
    message = re.sub(r"^line \d+, column \d+:", "line N, column N:", message_of(file))
    assert expected is not None and message.startswith(expected), message
    assert len(message) < 30_000 and len(message.splitlines()) <= 51


def test_products_that_are_too_large_are_refused(tmp_path: Path) -> None:
    """Each list may be as long as it is, but not all together."""
    file = tmp_path / "mine.yaml"
    text = changed("controller", "time_step_s: 0.01", "time_step_s: 1e-4").replace("work_s: 6", "work_s: 60")
    file.write_text(text)
    assert message_of(file).startswith("controller.time_step_s = 0.0001: a cycle of 70 s has 700000 of them; at most ")
    policies = "".join(f"    r{i}: {{kind: random}}\n" for i in range(500))
    lengths = f"n_cycles: [5, 20, {', '.join(map(str, range(101, 300)))}]"
    text = changed("benchmark", "    random: {kind: random}\n", policies + "    random: {kind: random}\n")
    file.write_text(text.replace("n_cycles: [5, 20, 100]", lengths))
    message = message_of(file)
    assert "benchmark: 309339 combinations of conditions, n_cycles and policies; at most 100000." in message, message
    preferences = "".join(f"  p{i}: {{tasks: []}}\n" for i in range(30))
    text = changed("preferences", "  arm:", preferences + "  arm:")
    file.write_text(text.replace("  high:", f"  g: {{{GRID}}}\n  high:"))
    assert "actions: with all workers and preferences 161376 reactions; at most 100000." in message_of(file)


def _laughs() -> bytes:
    """Ten keys, each of which merges the one before it ten times."""
    lines = ["a0: &a0 {x: lol}", *(f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 10)}]}}" for i in range(1, 10))]
    return "\n".join(lines).encode()


class WholeFile(NamedTuple):
    """A file that is not an experiment: bytes, repeated; and how the message begins after the file's name."""

    content: bytes
    expected: str
    times: int = 1

    def write(self, path: Path) -> Path:
        """Write the file."""
        path.write_bytes(self.content * self.times)
        return path


PAPER_BYTES = PAPER.read_bytes()
TEXT = PAPER_BYTES.decode()
WHOLE_FILES = {
    "empty": WholeFile(b"", "is not a mapping of settings;"),
    "comments only": WholeFile(b"# nothing\n" * 1000, "is not a mapping of settings;"),
    "a list": WholeFile(b"- name: paper\n", "is not a mapping of settings;"),
    "text": WholeFile(b"paper", "is not a mapping of settings;"),
    "a number": WholeFile(b"5", "is not a mapping of settings;"),
    "alias bomb": WholeFile(
        b"a: &a [x, x]\n" + b"".join(b"%c: &%c [*%c, *%c]\n" % (i, i, i - 1, i - 1) for i in b"bcdefghijkl"),
        "line 12, column 8: more than 10000 keys and values, aliases written out;",
    ),
    "billion laughs by merge keys": WholeFile(_laughs(), "line 5, column 20: more than 10000 keys and values, aliases"),
    "long text by aliases": WholeFile(
        b"a: &a " + b"x" * 100_000 + b"\nb: [*a, *a, *a, *a, *a, *a]\n",
        "line 2, column 17: more than 500000 characters,",
    ),
    "depth by aliases": WholeFile(
        b"a0: &a0 [x]\n" + b"".join(b"a%d: &a%d [*a%d]\n" % (i, i, i - 1) for i in range(1, 60)),
        "line 39, column 12: nested more than 40 deep, aliases written out.",
    ),
    "an unknown key by a merge key": WholeFile(
        b"<<: {nmae: x}\n" + PAPER_BYTES, "nmae: unknown key; did you mean 'name'?"
    ),
    "two merge keys": WholeFile(b"<<: {name: x}\n<<: {name: y}\n", "line 2, column 1: key '<<' is given twice."),
    "a key twice in what is merged": WholeFile(b"<<: {x: 1, x: 2}\n", "line 1, column 12: key 'x' is given twice."),
    "a merge key without a mapping": WholeFile(b"<<: 5\n", "line 1, column 5: expected a mapping or list of mappings"),
    "an anchor to itself": WholeFile(b"name: &a [*a]\n", "line 1, column 11: alias *a is inside what it stands for."),
    "an alias of nothing": WholeFile(b"name: *a\n", "line 1, column 7: found undefined alias 'a'."),
    "an anchor twice": WholeFile(b"name: &a x\ntool: &a y\n", "line 2, column 7: anchor &a is given twice."),
    "50 MB": WholeFile(b"# paper\n", "is larger than 500000 bytes; settings need a few thousand.", 6_250_000),
    "half a megabyte of brackets": WholeFile(b"[" * 400_000, "line 1, column 41: nested more than 40 deep."),
    "100,000 brackets": WholeFile(b"name: " + b"[" * 100_000 + b"]" * 100_000, "line 1, column 46: nested more"),
    "100,000 braces": WholeFile(b"{a: " * 100_000, "line 1, column 158: nested more than 40 deep."),
    "100,000 dashes": WholeFile(b"- " * 100_000, "line 1, column 81: nested more than 40 deep."),
    "100,000 question marks": WholeFile(b"? " * 100_000, "line 1, column 81: nested more than 40 deep."),
    "python object": WholeFile(
        b"name: !!python/object/apply:os.system [touch harmed]\n",
        "line 1, column 7: tags (here 'tag:yaml.org,2002:python/object/apply:os.system') are not allowed.",
    ),
    "python name": WholeFile(b"name: !!python/name:os.system\n", "line 1, column 7: tags (here "),
    "bool tag": WholeFile(b"name: !!bool maybe\n", "line 1, column 7: tags (here 'tag:yaml.org,2002:bool') are not"),
    "int tag": WholeFile(b"name: !!int five\n", "line 1, column 7: tags (here "),
    "binary tag": WholeFile(b"name: !!binary aGFsbG8=\n", "line 1, column 7: tags (here "),
    "set tag": WholeFile(b"!!set {name, workers}\n", "line 1, column 1: tags (here "),
    "own tag": WholeFile(b"name: !paper x\n", "line 1, column 7: tags (here '!paper') are not allowed."),
    "tag without name": WholeFile(b"name: ! x\n", "line 1, column 7: tags (here '!') are not allowed."),
    "NUL": WholeFile(b"name: pa\x00per\n", "line 1: the character \\u0000 is not allowed in a file."),
    "only NUL": WholeFile(b"\x00" * 1000, "line 1: the character \\u0000 is not allowed in a file."),
    "bell": WholeFile(b"name: paper\nworkers: \x07\n", "line 2: the character \\u0007 is not allowed in a file."),
    "escape sequence": WholeFile(b"name: \x1b[2J\n", "line 1: the character \\u001b is not allowed in a file."),
    "escape sequence in quotes": WholeFile(b'name: "\\e]0;x\\a"\n', "line 1, column 7: the character \\u001b is not"),
    "escape sequence in a key": WholeFile(b'"\\e[31m": 1\n', "line 1, column 1: the character \\u001b is not"),
    "C1 control in quotes": WholeFile(b'name: "\\x9b31m"\n', "line 1, column 7: the character \\u009b is not"),
    "direction turned round": WholeFile(
        PAPER_BYTES + '"\u202egip": 1'.encode(), r"'\u202egip': unknown key; allowed are name,"
    ),
    "UTF-16 with BOM": WholeFile(TEXT.encode("utf-16"), "line 1: is not a text file in UTF-8."),
    "UTF-16 without BOM": WholeFile(
        TEXT.encode("utf-16-le"), "line 1: the character \\u0000 is not allowed in a file."
    ),
    "UTF-32": WholeFile(TEXT.encode("utf-32"), "line 1: is not a text file in UTF-8."),
    "Latin-1": WholeFile("# e\nname: Käse\n".encode("latin-1"), "line 2: is not a text file in UTF-8."),
    "surrogates in UTF-8": WholeFile(b"name: \xed\xa0\x80\n", "line 1: is not a text file in UTF-8."),
    "lone surrogate": WholeFile(
        b'name: "\\ud800"\n', "line 1, column 7: the character \\ud800 is not allowed in text."
    ),
    "no character": WholeFile(b'name: "\\UFFFFFFFF"\n', "is not valid YAML ("),
    "cut in a key": WholeFile(PAPER_BYTES.split(b"ver: daqp")[0] + b"\n  b: 1\n", "line "),
    "cut in quotes": WholeFile(b'name: "paper\n', "line 2, column 1: found unexpected end of stream."),
    "tabs": WholeFile(b"name: paper\nworkers:\n\tanna: {}\n", "line 3, column 1: found character '\\t' that cannot"),
    "two documents": WholeFile(PAPER_BYTES + b"---\n" + PAPER_BYTES, "line "),
    "another YAML": WholeFile(b"%YAML 9.9\n---\nname: paper\n", "line 1, column 1: found incompatible YAML document"),
    "a version without end": WholeFile(b"%YAML 1." + b"9" * 5000 + b"\n---\nname: paper\n", "is not valid YAML ("),
    "JSON with comments": WholeFile(b'{"name": "paper", // mine\n "workers": {}}', "line 2, column "),
    "HTML": WholeFile(b"<!DOCTYPE html>\n<html><body>Not found</body></html>\n", "is not a mapping of settings;"),
    "a very long key": WholeFile(b"k" * 100_000 + b": 1\n", "line 1, column 100001: mapping values are not"),
    "a very long explicit key": WholeFile(PAPER_BYTES + b"? " + b"k" * 100_000 + b"\n: 1\n", "'kkkkkkkk"),
    "a number of 10^5 digits": WholeFile(b"name: " + b"9" * 100_000, "line 1, column 7: 99999999999999999999"),
    "a key that is a list": WholeFile(b"? [a]\n: 1\n", "line 1, column 3: key a list or mapping is not text;"),
    "a key that is nothing": WholeFile(b"?\n: 1\n", "line 1, column 2: key (nothing) is not text;"),
    "a key that is a truth": WholeFile(b"no: 1\n", "line 1, column 1: key no is not text; put it in quotes"),
    "10,000 keys": WholeFile(b"".join(b"k%d: 1\n" % i for i in range(4999)), "name: is missing."),
    "10,000 equal keys": WholeFile(b"k: 1\n" * 4999, "line 2, column 1: key 'k' is given twice."),
}


@pytest.mark.parametrize("name", WHOLE_FILES)
def test_files_that_are_not_experiments_are_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "mine.yaml"
    WHOLE_FILES[name].write(file)
    message = message_of(file)
    assert message.startswith(WHOLE_FILES[name].expected), message
    assert all(letter.isprintable() or letter == "\n" for letter in message) and len(message) < 30_000
    assert not (tmp_path / "harmed").exists()


@pytest.mark.parametrize(
    ("ending", "mark"), [(b"\r\n", b""), (b"\r", b""), (b"\n", b"\xef\xbb\xbf"), (b"\r\n", b"\xef\xbb\xbf")]
)
def test_the_line_endings_and_byte_order_marks_of_other_systems_do_not_matter(
    ending: bytes, mark: bytes, tmp_path: Path, paper: Experiment
) -> None:
    file = tmp_path / "paper.yaml"
    file.write_bytes(mark + PAPER_BYTES.replace(b"\n", ending))
    assert load_experiment(file) == paper


@pytest.mark.parametrize("load", [load_experiment, load_claims, load_study])
def test_what_is_not_a_file_is_refused_at_once(load: Any, no_files: dict[str, Path]) -> None:
    """A pipe nobody writes to would be waited for, a device be read for ever."""
    for path in no_files.values():
        with pytest.raises(FatplanError, match=r"cannot be read \((is not a file|No such file|File name too long|Too)"):
            load(path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(TEXT)
    file.chmod(0)
    assert message_of(file) == "cannot be read (Permission denied)."


@linux
def test_a_file_that_says_it_is_empty_and_cannot_be_read_is_refused() -> None:
    with pytest.raises(ExperimentError, match="/proc/self/mem: cannot be read"):
        load_experiment(Path("/proc/self/mem"))


CLAIM = """
experiment: paper.yaml
claims:
  one: {place: V, quote: words, conditions: [single_novice], n_cycles: [5], relation: better_mean, policies: [greedy],
        others: [random]}
"""
BAD_CLAIMS = [
    ("experiment: paper.yaml", "experiment: ''", "experiment = '': string should have at least 1 character."),
    ("experiment: paper.yaml", "experiment: 5", "experiment = 5: input should be a valid string."),
    ("experiment: paper.yaml", f"experiment: {'x' * 2000}", "experiment = 'xxxxx"),
    ("experiment: paper.yaml", "experimnet: paper.yaml", "experimnet: unknown key; did you mean 'experiment'?"),
    ("  one:", "  one thing:", "claims.one thing = 'one thing': should begin with a letter"),
    ("place: V, ", "", "claims.one.place: is missing."),
    ("quote: words", "quote: ''", "claims.one.quote = '': string should have at least 1 character."),
    ("quote: words", 'quote: "\\e[2J"', "line 4, column 26: the character \\u001b is not allowed in text."),
    ("relation: better_mean", "relation: best", "claims.one.relation = 'best': should be one of "),
    (
        "relation: better_mean",
        "relation: [better_mean]",
        "claims.one.relation = ['better_mean']: input should be a valid",
    ),
    ("n_cycles: [5]", "n_cycles: [.nan]", "claims.one.n_cycles.0 = nan: input should be a valid integer."),
    ("n_cycles: [5]", "n_cycles: 5", "claims.one.n_cycles = 5: should be a list."),
    ("n_cycles: [5]", f"n_cycles: [{', '.join(map(str, range(8000)))}]", "claims.one.n_cycles: 0, 1, 2, 3, 4, 6, "),
    ("policies: [greedy]", "policies: [greedy, greedy]", "claims.one.policies: greedy is given twice."),
    ("others: [random]", "others: [greedy]", "claims.one.others: greedy already among the policies."),
    ("others: [random]", "others: [random], weight: 2", "claims.one.weight: unknown key; allowed are place, quote,"),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD_CLAIMS)
def test_each_bad_file_of_claims_is_refused(old: str, new: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "paper.yaml").write_text(TEXT)
    file = tmp_path / "claims.yaml"
    file.write_text(CLAIM)
    assert load_claims(file).claims
    assert old in CLAIM
    file.write_text(CLAIM.replace(old, new))
    assert message_of(file, load_claims).startswith(expected)


STUDY = """
name: mine
base: paper.yaml
grid: {trials: 20}
planners: [pomcp_0.1]
baselines: [greedy]
headline: {planner: pomcp_0.1, condition: single_novice, n_cycles: 100}
space_filling: {points: 64, seed: 1}
factors:
  height: {kind: range, keys: [workers.average_man.height_m], from: 1.6, to: 1.9, reason: people}
  tool: {kind: choice, reason: open, levels: {always: {tool.held: cycle}, at_work: {tool.held: work}}}
"""
LEVELS = "{always: {tool.held: cycle}, at_work: {tool.held: work}}"
RANGE = "from: 1.6, to: 1.9"
BAD_STUDIES = [
    ("base: paper.yaml", "base: ''", "base = '': string should have at least 1 character."),
    ("base: paper.yaml", "base: none.yaml", "base = 'none.yaml': "),
    ("points: 64", "points: 65", "space_filling: points = 65: should be a power of two"),
    ("seed: 1", "seed: 1e3", "space_filling.seed = 1000.0: input should be a valid integer."),
    ("seed: 1", f"seed: {2**63}", "space_filling.seed = 9223372036854775808: input should be less than"),
    ("planners: [pomcp_0.1]", "planners: [best]", "planners: best; known are random, alternating"),
    (
        "planners: [pomcp_0.1]",
        "planners: [pomcp_0.1, pomcp_0.1]",
        "planners: pomcp_0.1, pomcp_0.1: a name is given",
    ),
    ("trials: 20", "trials: 20, policies: [nobody]", "grid.policies: nobody; known are "),
    (
        "trials: 20",
        "trials: 20, further_policies: {a: {kind: dice}}",
        "grid.further_policies.a.kind = 'dice': should",
    ),
    (
        "trials: 20",
        "trials: 20, further_policies: {a: {kind: lookahead}}",
        "grid.further_policies.a.depth: is missi",
    ),
    (RANGE, "from: 1.9, to: 1.6", "factors.height: from = 1.9 must be below to = 1.6."),
    (RANGE, "from: .nan, to: 1.9", "factors.height.from = nan: input should be a finite number."),
    (RANGE, "from: 1e300, to: 1e308, integer: true", "factors.height.from = 1e+300: input should be less than"),
    (RANGE, "from: -1e308, to: 1e308", "factors.height.from = -1e+308: input should be greater than"),
    (RANGE, "from: 1e-300, to: 1.9, scale: log", "factors.height: from = 1e-300 must be above 0 on a log scale, 1e-12"),
    (RANGE, "from: 1.6, to: 19", "factors.height at 7.4: workers.average_man.height_m = 7.4: input should be less"),
    ("kind: range", "kind: rang", "factors.height.kind = 'rang': should be one of 'range', 'scale', 'ch"),
    (
        "workers.average_man.height_m",
        "workers.average_man.hight_m",
        "factors.height: workers.average_man.hight_m: unk",
    ),
    ("workers.average_man.height_m", "name", "factors.height: name: must be the same at all points."),
    ("workers.average_man.height_m", "workers.average_man", "factors.height.keys: workers.average_man = {'height_m': "),
    ("workers.average_man.height_m", "k" * 5000, "factors.height: kkk"),
    (
        LEVELS,
        "{always: {tool.held: cycle}}",
        "factors.tool.levels = {'always': {'tool.held': 'cycle'}}: should have",
    ),
    (LEVELS, "{a: {tool.held: cycle}, b: {tool.held: cycle}}", "factors.tool: its levels 'a' and 'b' are the same."),
    (LEVELS, "{a: {tool.held: cycle}, b: {tool.held: [cycle]}}", "factors.tool at 'b': tool.held = ['cycle']: input"),
    (LEVELS, "{a: {}, b: {}}", "factors.tool: levels: give no key a value."),
    (LEVELS, f"{{{', '.join(f'l{i}: {{tool.mass_kg: {i}}}' for i in range(1000))}}}", "factors.tool.levels = {'l0': "),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD_STUDIES)
def test_each_bad_study_is_refused(old: str, new: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "paper.yaml").write_text(TEXT)
    file = tmp_path / "study.yaml"
    assert old in STUDY
    file.write_text(STUDY.replace(old, new, 1))
    message = message_of(file, load_study)
    assert message.startswith(expected) and len(message) < 30_000, message


def test_the_study_they_are_made_from_is_valid(tmp_path: Path) -> None:
    (tmp_path / "paper.yaml").write_text(TEXT)
    (tmp_path / "study.yaml").write_text(STUDY)
    assert len(load_study(tmp_path / "study.yaml").settings.factors) == 2


def test_strength_files_that_build_on_each_other_without_end_are_refused(tmp_path: Path) -> None:
    for number in range(20):
        (tmp_path / f"s{number}.yaml").write_text(
            f"population: p\nbased_on: s{number + 1}.yaml\ndegrees_of_freedom: {{}}\n"
        )
    file = tmp_path / "mine.yaml"
    file.write_text(changed("workers", "strength: average_man", f"strength: {tmp_path}/s0.yaml"))
    assert "based_on: more than 10 files build on each other." in message_of(file)


class Child(NamedTuple):
    """How a command ended: exit code, stderr, processor time and peak memory."""

    code: int
    said: str
    seconds: float
    peak_mib: float


# The peak of a child's resources would have its parent's memory in it.
RUN = """
import atexit, pathlib
atexit.register(lambda: pathlib.Path("status").write_text(pathlib.Path("/proc/self/status").read_text()))
from fatigue_planner.cli.entry import run
run()
"""


def validated(path: Path, folder: Path) -> Child:
    """`fatplan validate` in a process of its own."""
    with (folder / "said.txt").open("w+b") as said:
        command = [sys.executable, "-c", RUN, "validate", str(path)]
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said, cwd=folder)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read().decode()
    peak = re.search(r"VmHWM:\s*(\d+) kB", (folder / "status").read_text())
    assert peak is not None
    return Child(child.returncode, text, usage.ru_utime + usage.ru_stime, int(peak[1]) / 1024)


def check_end_to_end(files: dict[str, Path], folder: Path) -> None:
    """A bad file costs no more than a second beyond what a good one does; most of that is the start of the program."""
    good = validated(PAPER, folder)
    assert good.code == 0, good.said
    for name, path in files.items():
        child = validated(path, folder)
        assert child.code == 2, (name, child)
        assert child.said.startswith("Error: ") and "Traceback" not in child.said, (name, child.said)
        assert str(path) in child.said or repr(str(path)) in child.said, (name, child.said)
        assert all(letter.isprintable() or letter == "\n" for letter in child.said), (name, child.said)
        assert within(child.seconds - good.seconds, MAX_SECONDS / 2), (name, child.seconds, good.seconds)
        assert child.peak_mib < MAX_MIB, (name, child.peak_mib)


def written(names: list[str], folder: Path) -> dict[str, Path]:
    """Whole files of these names, written."""
    return {name: WHOLE_FILES[name].write(folder / f"{number}.yaml") for number, name in enumerate(names)}


@linux
def test_some_bad_files_end_to_end(tmp_path: Path, no_files: dict[str, Path]) -> None:
    check_end_to_end(written(["50 MB"], tmp_path) | {"pipe": no_files["pipe"]}, tmp_path)


@linux
@pytest.mark.slow
def test_kinds_of_bad_files_end_to_end(tmp_path: Path, no_files: dict[str, Path]) -> None:
    """Every fourth of all, as each is a start of the program."""
    files = written(list(WHOLE_FILES), tmp_path) | {name: path for name, path in no_files.items() if name != "with NUL"}
    for name, (section, old, new, expected) in TOO_LARGE.items():
        if expected is not None:
            files[name] = tmp_path / f"{len(files)}.yaml"
            files[name].write_text(changed(section, old, new))
    check_end_to_end(dict(list(files.items())[::4]), tmp_path)

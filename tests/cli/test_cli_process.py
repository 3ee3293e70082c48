"""The program as a process: how fast it answers, its streams, what it does on a terminal, and every way it can end."""

import contextlib
import json
import os
import pty
import re
import resource
import select
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from commands import fatplan, finished, process, small_files
from conftest import PAPER
from pace import within

from fatigue_planner.cli.main import app
from fatigue_planner.core.errors import ExitCode

HEAVY = {"numpy", "numba", "pandas", "scipy", "matplotlib", "pinocchio", "casadi", "h5py", "fatigue_planner.experiment"}
ESCAPE = "\x1b"
COLOUR = re.compile(r"\x1b\[[0-9;]*(?:3[0-8]|4[0-8]|9[0-7]|10[0-7])[0-9;]*m")


def test_every_commands_help_names_the_exit_codes() -> None:
    root = typer.main.get_command(app)
    commands: list[tuple[str, ...]] = [(), *((name,) for name, command in root.commands.items() if not command.hidden)]
    commands += [
        (group, name) for group in ("human", "cache", "live", "record") for name in root.commands[group].commands
    ]
    assert len(commands) == 1 + 19 + 3 + 6 + 12 + 5
    for words in commands:
        done = fatplan(*words, "--help")
        assert done.returncode == 0 and "Exit codes: 0 done; 1 internal error;" in " ".join(done.stdout.split()), words
        assert ESCAPE not in done.stdout


def test_a_command_of_former_times_names_its_successor() -> None:
    for more in ((), (PAPER, "--results", "x"), ("--help",)):
        assert fatplan("figures", *more).stderr == "Error: `fatplan figures` is now `fatplan report --figures-only`.\n"
        assert fatplan("figures", *more).returncode == ExitCode.BAD_INPUT


@pytest.mark.parametrize("words", [("--version",), ("--help",), ("nonsense",), ("validate", "none.yaml")])
def test_what_needs_no_work_loads_nothing_heavy(words: tuple[str, ...]) -> None:
    code = f"""
import sys
from fatigue_planner.cli.entry import execute
execute({list(words)!r})
print(sorted(set(sys.modules) & {HEAVY!r}), file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.splitlines()[-1] == "[]"


def test_what_takes_long_to_load_is_loaded_by_those_who_need_it() -> None:
    code = f"""
import sys
from fatigue_planner.cli.entry import execute
assert execute(["validate", {str(PAPER)!r}]) == 0
import fatigue_planner.experiment.build
import fatigue_planner.study.benchmark.results
print(sorted(name for name in sys.modules if name in ("scipy.stats", "scipy.optimize", "matplotlib", "mujoco")))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_bad_file_is_refused_soon_and_in_little_memory(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PAPER.read_text().replace("discount: 0.95", "discount: 2"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert finished("validate", path).returncode == 2
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert within(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 2)
    assert finished("--version").stdout.startswith("fatplan ")


def on_a_terminal(*arguments: object, env: dict[str, str]) -> str:
    """What a command shows on a terminal of 50 columns."""
    master, slave = pty.openpty()
    running = process(*arguments, env={"TERM": "xterm-256color", "COLUMNS": "50"} | env, stdout=slave, stderr=slave)
    os.close(slave)
    shown = b""
    with contextlib.suppress(OSError):  # the terminal is closed when the command has ended
        while select.select([master], [], [], 120)[0] and (piece := os.read(master, 65536)):
            shown += piece
    os.close(master)
    assert running.wait(timeout=60) == 0
    return shown.decode()


def test_a_terminal_has_a_bar_and_colours_unless_they_are_not_wanted(cache_folder: Path) -> None:
    command = ["simulate", PAPER, "--cache", cache_folder]
    coloured = on_a_terminal(*command, env={"NO_COLOR": ""})
    assert "Simulating reactions" in coloured and "100 %" in coloured and COLOUR.search(coloured)
    plain = on_a_terminal(*command, env={"NO_COLOR": "1"})
    assert "100 %" in plain and not COLOUR.search(plain)
    assert ESCAPE not in on_a_terminal(*command, env={"TERM": "dumb", "NO_COLOR": ""})


def test_help_has_colours_on_a_terminal_only() -> None:
    assert COLOUR.search(on_a_terminal("--help", env={"NO_COLOR": ""}))
    for env in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        shown = on_a_terminal("--help", env=env)
        assert ESCAPE not in shown and "sensitivity" in shown
    for forced in ({}, {"GITHUB_ACTIONS": "1"}):
        assert ESCAPE not in finished("nonsense", env=forced).stderr + finished("--help", env=forced).stdout


@pytest.mark.parametrize("columns", ["0", "1", "-5", "12345678901234567890", "wide", "1e3", ""])
def test_a_terminal_of_no_sensible_width_is_one_of_a_usual_width(columns: str) -> None:
    for name in ("COLUMNS", "TERMINAL_WIDTH"):
        done = finished("--help", env={name: columns})
        assert done.returncode == 0 and "Simulate the digital human for every action" in done.stdout, done.stderr
        assert {len(line) for line in done.stdout.splitlines() if line.startswith("╭")} == {80}


def test_a_pipe_gets_no_bar_and_stdout_nothing_but_results(cache_folder: Path) -> None:
    done = finished("simulate", PAPER, "--cache", cache_folder, env={})
    assert done.returncode == 0 and done.stderr == ""
    said = [
        line for line in done.stdout.splitlines() if not line.startswith("      ")
    ]  # what is implausible of a motion
    assert ESCAPE not in done.stdout and len(said) == 5


def test_a_long_run_says_a_line_now_and_then(cache_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fatigue_planner.cli.progress.SECONDS_BETWEEN_LINES", 0.0)
    said = fatplan("simulate", PAPER, "--cache", cache_folder).stderr.splitlines()
    assert said == [f"Simulating reactions: {share}%" for share in (25, 50, 75, 100)]


def test_a_reader_that_has_gone_is_no_fault() -> None:
    with process("schema", stderr=None) as running:
        assert running.stdout is not None
        running.stdout.close()
        assert running.wait(timeout=60) == -13  # as the shell's own programs: SIGPIPE


@pytest.mark.slow
def test_as_a_module_it_is_the_same_program() -> None:
    module = [sys.executable, "-m", "fatigue_planner"]
    for words in (["--version"], ["simulate", "none.yaml", "--json"]):
        done = subprocess.run([*module, *words], capture_output=True, text=True, check=False)
        same = finished(*words)
        assert (done.returncode, done.stdout, done.stderr) == (same.returncode, same.stdout, same.stderr)


def test_full_and_closed_streams() -> None:
    with Path("/dev/full").open("w") as full:
        done = finished("schema", stdout=full)
        assert done.returncode == 2 and done.stderr == "Error: cannot be written (No space left on device).\n"
        assert finished("nonsense", stderr=full).returncode == 2
    done = finished("nonsense", "--json", begin=lambda: (os.close(0), os.close(1)))
    assert done.returncode == 2 and "No such command" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_full_disk_is_one_message(tmp_path: Path, cache_folder: Path) -> None:
    """One message, exit code 2, nothing of the broken files left; with room again the commands go on."""
    grid = ["--cycles", 5, "--conditions", "single_expert", "--policies", "greedy", "--policies", "alternating"]
    run = ["benchmark", PAPER, "--cache", cache_folder, "--results", tmp_path / "results", *grid]
    assert fatplan(*run).returncode == 0  # so that compiled code is there already

    def contents() -> dict[str, bytes]:
        names = ("trials.csv", "actions.csv", "comparison.csv", "contrasts.csv", "summary.txt", "manifest.json")
        return {name: next((tmp_path / "results").glob(f"paper_*/{name}")).read_bytes() for name in names}

    whole = contents()
    shutil.rmtree(tmp_path / "results")
    coarse = tmp_path / "coarse.yaml"
    coarse.write_text(PAPER.read_text().replace("time_step_s: 0.01", "time_step_s: 0.02"))
    export = ["human", "export", PAPER, "--output", tmp_path / "human.urdf"]
    report = ["human", "report", PAPER, "--cache", cache_folder, "--output", tmp_path / "human.md"]
    for command in (run, export, report, ["simulate", coarse, "--cache", tmp_path / "cache"]):
        done = finished(*command, begin=small_files)
        assert done.returncode == 2, (command, done.stderr)
        assert "cannot be written (" in done.stderr and "File too large" in done.stderr, done.stderr
        assert done.stderr.count("Error: ") == 1 and "Traceback" not in done.stderr and done.stdout == ""
    assert not (tmp_path / "human.urdf").exists() and not (tmp_path / "human.md").exists()
    assert not [path for path in tmp_path.rglob(".*") if path.is_file()]
    assert fatplan(*run).returncode == 0 and contents() == whole


@pytest.mark.slow
def test_every_exit_code_but_the_interrupts(tmp_path: Path, cache_folder: Path) -> None:
    """130 and 143 are in test_cli_signals; each other code is provoked by a process of its own."""
    assert finished("schema").returncode == ExitCode.OK
    assert finished("simulate", tmp_path / "none.yaml").returncode == ExitCode.BAD_INPUT
    far = tmp_path / "far.yaml"
    text = PAPER.read_text().replace("x: 0.5, y: -0.25, z: 1.2", "x: 1.3, y: -0.25, z: 1.2")
    far.write_text(text.replace("time_step_s: 0.01", "time_step_s: 0.02"))
    assert finished("simulate", far, "--cache", tmp_path / "far").returncode == ExitCode.FAILED_PARTS
    cache = tmp_path / "cache"
    shutil.copytree(cache_folder, cache)
    entry = next(cache.glob("*.h5"))
    entry.write_bytes(entry.read_bytes()[:5000])
    done = finished("benchmark", PAPER, "--cache", cache, "--results", tmp_path)
    assert done.returncode == ExitCode.DAMAGED_STORE


BROKEN = """
import fatigue_planner.experiment.schema as schema
from fatigue_planner.cli.entry import run
schema.Experiment.model_validate = classmethod(lambda *_, **__: 1 / 0)
run()
"""


def test_a_fault_of_the_program_is_told_with_where_it_is_written_down(tmp_path: Path) -> None:
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    command = [sys.executable, "-c", BROKEN, "validate", str(PAPER), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == ExitCode.INTERNAL_ERROR
    assert len(done.stderr.splitlines()) == 1 and "ZeroDivisionError: division by zero" in done.stderr
    error = json.loads(done.stdout)["error"]
    assert error["type"] == "InternalError" and error["exit_code"] == 1
    (note,) = tmp_path.glob("fatplan-*.txt")
    assert str(note) in done.stderr and "ZeroDivisionError" in note.read_text()
    assert note.read_text().startswith(f"fatplan validate {PAPER} --json\n")


def test_what_is_kept_stands_with_whatever_ends_the_work(tmp_path: Path) -> None:
    from fatigue_planner.cli.entry import kept_text
    from fatigue_planner.cli.progress import progress

    with pytest.raises(ZeroDivisionError) as caught, progress("Working", 3, kept=("runs", tmp_path)) as counter:
        counter.advance()
        raise ZeroDivisionError
    assert kept_text(caught.value) == f"1 of 3 runs are kept in {tmp_path}."

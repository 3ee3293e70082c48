"""Running the commands as a user types them: in this process where that is enough, as a process where it matters."""

import io
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from fatigue_planner.cli.entry import execute

FATPLAN = [sys.executable, "-c", "from fatigue_planner.cli.entry import run; run()"]
PLAIN = {"COLUMNS": "200", "NO_COLOR": "1"}


def fatplan(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """A command in this process: all of the command line but signals and the streams of a process."""
    before, columns = Path.cwd(), os.environ.get("COLUMNS")
    out, err = io.StringIO(), io.StringIO()
    words = [str(one) for one in arguments]
    try:
        os.environ["COLUMNS"] = PLAIN["COLUMNS"]
        os.chdir(cwd or before)
        with redirect_stdout(out), redirect_stderr(err):
            code = execute(words)
    finally:
        os.chdir(before)
        os.environ.pop("COLUMNS")
        if columns is not None:
            os.environ["COLUMNS"] = columns
    return subprocess.CompletedProcess(words, code, out.getvalue(), err.getvalue())


class Running(subprocess.Popen[str]):
    """A process that is ended where a test fails beside it: `with` would wait for ever for one that serves."""

    def __exit__(self, kind: type[BaseException] | None, *others: Any) -> None:
        if kind is not None:
            self.kill()
        super().__exit__(kind, *others)


def process(*arguments: object, env: Mapping[str, str] | None = None, **options: Any) -> Running:
    """A command as a process of its own that has begun; a shell's background jobs ignore SIGINT, it does not."""

    def begin() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        options_begin()

    options_begin = options.pop("begin", lambda: None)
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    command = [*FATPLAN, *map(str, arguments)]
    environment = os.environ | (PLAIN if env is None else env)
    return Running(command, text=True, env=environment, preexec_fn=begin, **streams)


def finished(*arguments: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """A command as a process of its own that has ended."""
    running = process(*arguments, **options)
    out, err = running.communicate(timeout=240)
    return subprocess.CompletedProcess(running.args, running.returncode, out, err)


def listens(running: subprocess.Popen[str]) -> bool:
    """Wait until a process handles SIGTERM itself; False if it has ended before."""
    while running.poll() is None:
        for line in Path(f"/proc/{running.pid}/status").read_text().splitlines():
            if line.startswith("SigCgt:") and int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1:
                return True
        time.sleep(0.002)
    return False


def refused(code: int, *arguments: object) -> str:
    """The one message of a command that must fail with an exit code."""
    done = fatplan(*arguments)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    return done.stderr


def small_files() -> None:
    """For `begin`: no file may become larger than 2 kB, as if the disk were full at every write that goes beyond."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

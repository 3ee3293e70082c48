"""How a command that does not succeed says so: a message on stderr and, with `--json`, the one document on stdout."""

import contextlib
import json
import shlex
import sys
from collections.abc import Sequence
from typing import Any

from fatigue_planner.cli.signals import Stopped


def wants_json(arguments: Sequence[str]) -> bool:
    """Whether a command line asks for JSON, even if it is wrong otherwise."""
    options = arguments[: arguments.index("--")] if "--" in arguments else arguments
    return "--json" in options


def tell_failure(arguments: Sequence[str], kind: str, message: str, exit_code: int, begin: str = "Error: ") -> int:
    """Say what is wrong; returns the exit code. `kind` is the type of the error."""
    with contextlib.suppress(OSError):  # the exit code says it, too
        print(f"{begin}{message}", file=sys.stderr, flush=True)
    if wants_json(arguments):
        document: dict[str, Any] = {"error": {"type": kind, "message": message, "exit_code": int(exit_code)}}
        with contextlib.suppress(OSError):
            print(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False), flush=True)
    return int(exit_code)


def tell_stopped(arguments: Sequence[str], stopped: Stopped) -> int:
    """Say what is kept and the command that goes on; returns the exit code."""
    kept = kept_text(stopped) or "What is finished is kept."
    command = shlex.join(["fatplan", *arguments])
    return tell_failure(arguments, "Stopped", f"{kept} Go on with: {command}", stopped.exit_code, "Stopped. ")


def kept_text(error: BaseException) -> str:
    """What `progress` has noted of the finished work on an error that ended it."""
    return " ".join(getattr(error, "__notes__", ()))

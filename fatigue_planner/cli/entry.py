"""Where the process starts and ends: signals and streams first, so that even its loading can be stopped in good order.

Every way in which a command can end has its message and its exit code here.
"""

import contextlib
import errno
import gc
import json
import os
import shlex
import signal
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from fatigue_planner.core.errors import ExitCode, FatplanError
from fatigue_planner.core.interrupts import Stopped, ignore_signals, stop_on_signals

if TYPE_CHECKING:
    from typer.exceptions import TyperException

# What a disk, or a limit on it, says when nothing more can be written.
DISK_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO)
# The widths of a terminal that can be: 20 to 999 columns.
MIN_COLUMNS, MAX_DIGITS = 20, 3


def run() -> None:
    """Run the command line of this process and end it; every mistake of the user is one message and its exit code."""
    arguments = sys.argv[1:]
    try:
        stop_on_signals(lambda stopped: tell_stopped(arguments, stopped))
        _prepare_streams()
        code = _run_and_flush(arguments)
        ignore_signals()
    except Stopped as stopped:
        code = tell_stopped(arguments, stopped)
    _give_up_unwritten()
    gc.freeze()  # else Python looks through all it holds once more: a quarter of a short command's time
    sys.exit(code)


def execute(arguments: Sequence[str]) -> int:
    """Run a command line (without the program's name) and say what goes wrong; the exit code.

    Raises BrokenPipeError if whoever reads the output has stopped, as in `fatplan ... | head -1`, and what is no
    Exception.
    """
    import typer  # after the signals, as all that takes time
    from typer.exceptions import TyperException

    from fatigue_planner.cli.main import app

    try:
        command = typer.main.get_command(app)
        with command.make_context("fatplan", list(arguments)) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except TyperException as error:
        return _wrong_usage(arguments, error)
    except FatplanError as error:
        message = "\n".join(filter(None, [str(error), kept_text(error)]))
        return _tell(arguments, type(error).__name__, message, error.exit_code)
    except BrokenPipeError:
        raise
    except SystemExit as error:  # rich makes it of a BrokenPipeError; nobody else exits
        raise BrokenPipeError from error
    except Exception as error:
        if isinstance(error, OSError) and error.errno in DISK_FAULTS:
            return _disk_fault(arguments, error)
        from fatigue_planner.core.plugins import fault_of_plugin

        if fault := fault_of_plugin(error):
            return _tell(arguments, "PluginError", f"{fault} {kept_text(error)}".strip(), fault.exit_code)
        return _internal_error(arguments, error)
    return ExitCode.OK


def tell_stopped(arguments: Sequence[str], stopped: Stopped) -> int:
    """Say what is kept and the command that goes on; returns the exit code."""
    kept = kept_text(stopped) or "What is finished is kept."
    command = shlex.join(["fatplan", *arguments])
    return _tell(arguments, "Stopped", f"{kept} Continue with: {command}", stopped.exit_code, "Stopped. ")


def kept_text(error: BaseException) -> str:
    """What `progress` has noted of the finished work on an error that ended it."""
    return " ".join(getattr(error, "__notes__", ()))


def _tell(arguments: Sequence[str], kind: str, message: str, exit_code: int, begin: str = "Error: ") -> int:
    """A message on stderr and, if the arguments ask for JSON (however wrong they are otherwise), a document on stdout.

    Returns the exit code, which says it, too, if neither can be written. `kind` is the type of the error.
    """
    with contextlib.suppress(OSError):
        print(f"{begin}{message}", file=sys.stderr, flush=True)
    options = arguments[: arguments.index("--")] if "--" in arguments else arguments
    if "--json" in options:
        document = {"error": {"type": kind, "message": message, "exit_code": int(exit_code)}}
        with contextlib.suppress(OSError):
            print(json.dumps(document, indent=1, ensure_ascii=False), flush=True)
    return int(exit_code)


def _wrong_usage(arguments: Sequence[str], error: "TyperException") -> int:
    message = error.format_message()
    if not message:  # a group without a command has shown its help
        return ExitCode.BAD_INPUT
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "fatplan"
    full_stop = "" if message.endswith((".", "?", "!")) else "."
    message = f"{' '.join(message.split())}{full_stop} `{path} --help` says what is allowed."
    return _tell(arguments, "UsageError", message, ExitCode.BAD_INPUT)


def _disk_fault(arguments: Sequence[str], error: OSError) -> int:
    """Say that the disk takes no more, wherever it was that something should be written."""
    where = f"{error.filename}: " if error.filename else ""
    message = f"{where}cannot be written ({error.strerror}). {kept_text(error)}".strip()
    return _tell(arguments, "OutputFolderError", message, ExitCode.BAD_INPUT)


def _internal_error(arguments: Sequence[str], error: Exception) -> int:
    """Say that this is nobody's fault but the program's; its details go into a file."""
    import tempfile
    import traceback

    details = "".join(traceback.format_exception(error))
    what = " ".join(f"{type(error).__name__}: {error}".split())
    try:
        with tempfile.NamedTemporaryFile("w", prefix="fatplan-", suffix=".txt", delete=False, encoding="utf-8") as file:
            file.write(f"fatplan {' '.join(arguments)}\n\n{details}")
        where = f"Please report it with {file.name}, which says where."
    except OSError:
        where = f"Please report it with this:\n{details}"
    kept = kept_text(error) or "What is finished is kept."
    message = f"internal error, a fault of fatplan ({what}). {kept} {where}"
    return _tell(arguments, "InternalError", message, ExitCode.INTERNAL_ERROR)


def _run_and_flush(arguments: Sequence[str]) -> int:
    try:
        code = execute(arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # end as every program does whose reader has gone
        os.kill(os.getpid(), signal.SIGPIPE)
        raise
    except OSError as error:  # what should have been printed cannot be written
        return _disk_fault(arguments, error)
    return code


def _prepare_streams() -> None:
    """Keep files from getting the number of a closed standard stream; believe no absurd width; no unwanted colours."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number, this one
    for name in ("COLUMNS", "TERMINAL_WIDTH", "LINES"):  # what rich and typer believe, else they ask the terminal
        size = os.environ.get(name, "")
        if not (size.isdecimal() and len(size) <= MAX_DIGITS and int(size) >= MIN_COLUMNS):
            os.environ.pop(name, None)
    terminal = sys.stdout is not None and sys.stdout.isatty()
    if os.environ.get("NO_COLOR") or not (terminal or os.environ.get("FORCE_COLOR")):
        os.environ["_TYPER_FORCE_DISABLE_TERMINAL"] = "1"  # of the help; NO_COLOR alone leaves it bold and dim


def _give_up_unwritten() -> None:
    """Python would complain at its end about what its streams could not write."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())

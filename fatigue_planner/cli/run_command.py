"""A command line in, an exit code out: every way a command can end, in one place."""

import errno
import tempfile
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path

import typer
from typer.exceptions import TyperException

from fatigue_planner.cli.failure import kept_text, tell_failure
from fatigue_planner.cli.main import app
from fatigue_planner.core.errors import ExitCode, FatplanError

# What a disk, or a limit on it, says when nothing more can be written.
DISK_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO)


class ReaderGoneError(Exception):
    """Whoever reads what the program prints has stopped reading, as in `fatplan ... | head -1`."""


def outcome(arguments: Sequence[str], loaded: Callable[[], None] | None = None) -> int:
    """Run a command line (without the program's name) and tell what goes wrong; the exit code.

    `loaded` is called when the command's program has been loaded and its work is about to begin.
    Raises ReaderGoneError, and what is no Exception.
    """
    try:
        command = typer.main.get_command(app)
        with command.make_context("fatplan", list(arguments), obj=loaded) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except TyperException as error:
        return _wrong_usage(arguments, error)
    except FatplanError as error:
        message = "\n".join(filter(None, [str(error), kept_text(error)]))
        return tell_failure(arguments, type(error).__name__, message, error.exit_code)
    except (BrokenPipeError, SystemExit) as error:  # rich makes one of the other, nobody else exits
        raise ReaderGoneError from error
    except Exception as error:
        if isinstance(error, OSError) and error.errno in DISK_FAULTS:
            return disk_fault(arguments, error)
        return _internal_error(arguments, error)
    return ExitCode.OK


def disk_fault(arguments: Sequence[str], error: OSError) -> int:
    """Say that the disk takes no more, wherever it was that something should be written."""
    where = f"{error.filename}: " if error.filename else ""
    message = f"{where}cannot be written ({error.strerror}). {kept_text(error)}".strip()
    return tell_failure(arguments, "OutputFolderError", message, ExitCode.BAD_INPUT)


def _wrong_usage(arguments: Sequence[str], error: TyperException) -> int:
    message = error.format_message()
    if not message:  # a group without a command has shown its help
        return ExitCode.BAD_INPUT
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "fatplan"
    full_stop = "" if message.endswith((".", "?", "!")) else "."
    message = f"{' '.join(message.split())}{full_stop} `{path} --help` says what is allowed."
    return tell_failure(arguments, "UsageError", message, ExitCode.BAD_INPUT)


def _internal_error(arguments: Sequence[str], error: Exception) -> int:
    """Say that this is nobody's fault but the program's; its details go into a file."""
    details = "".join(traceback.format_exception(error))
    what = " ".join(f"{type(error).__name__}: {error}".split())
    try:
        with tempfile.NamedTemporaryFile("w", prefix="fatplan-", suffix=".txt", delete=False, encoding="utf-8") as file:
            file.write(f"fatplan {' '.join(arguments)}\n\n{details}")
        where = f"Please report it with {Path(file.name)}, which says where."
    except OSError:
        where = f"Please report it with this:\n{details}"
    kept = kept_text(error) or "What is finished is kept."
    message = f"internal error, a fault of fatplan ({what}). {kept} {where}"
    return tell_failure(arguments, "InternalError", message, ExitCode.INTERNAL_ERROR)

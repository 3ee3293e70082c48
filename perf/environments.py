"""Separate environments for the programs that fatplan is compared with, made when first needed."""

import os
import subprocess
import sys
from pathlib import Path


class PeerMissingError(Exception):
    """A program's environment cannot be made or does not work."""


def environment_of(name: str, module: str, requirements: Path) -> Path:
    """The Python of a program's environment. Raises PeerMissingError, with the reason, if there is none."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fatplan" / f"{name}-env"
    python, made_from = folder / "bin" / "python", folder / requirements.name
    wanted = requirements.read_text()
    try:
        if not made_from.exists() or made_from.read_text() != wanted:
            print(f"setting up {name} in {folder} (once)", flush=True)
            _run(sys.executable, "-m", "venv", "--clear", folder)
            _run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", requirements)
            made_from.write_text(wanted)
        _run(python, "-c", f"import {module}")
    except subprocess.CalledProcessError as error:
        lines = (error.stderr or error.stdout or str(error)).strip().splitlines()
        raise PeerMissingError(lines[-1]) from error
    except OSError as error:
        raise PeerMissingError(str(error)) from error
    return python


def _run(*command: str | Path) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True)

"""Reading the YAML files of body data that ship with the package, or a user's own."""

from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import TypeAdapter, ValidationError

from fatigue_planner.errors import DataFileError

DATA = Path(__file__).parent / "data"

T = TypeVar("T")


def load_data(path: Path, kind: type[T]) -> T:
    """The content of a data file, checked against `kind`.

    Raises DataFileError naming the file and every offending key.
    """
    try:
        content: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
        return TypeAdapter(kind).validate_python(content)
    except OSError as error:
        raise DataFileError(f"{path}: cannot be read ({error.strerror}).") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise DataFileError(f"{path}: is not valid YAML: {error}") from error
    except ValidationError as error:
        faults = "; ".join(f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors())
        raise DataFileError(f"{path}: {faults}") from error

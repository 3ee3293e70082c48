"""Reading the YAML files of body data that ship with the package, or a user's own."""

from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from fatigue_planner.errors import DataFileError
from fatigue_planner.yaml_reader import read_yaml

DATA = Path(__file__).parent / "data"

T = TypeVar("T")


def load_data(path: Path, kind: type[T]) -> T:
    """The content of a data file, checked against `kind`.

    Raises DataFileError naming the file and every offending key.
    """
    try:
        return TypeAdapter(kind).validate_python(read_yaml(path, DataFileError), strict=True)
    except ValidationError as error:
        faults = "; ".join(f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors())
        raise DataFileError(f"{path}: {faults}") from error

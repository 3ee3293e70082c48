"""Reading the YAML files of body data that ship with the package, or a user's own."""

from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.core.errors import DataFileError, shortened
from fatigue_planner.core.yaml_reader import read_yaml

DATA = Path(__file__).parent / "data"

# More of them help nobody.
MOST_FAULTS = 20

T = TypeVar("T")


def load_data(path: Path, kind: type[T]) -> T:
    """The content of a data file, checked against `kind`.

    Raises DataFileError naming the file and every offending key.
    """
    try:
        return TypeAdapter(kind).validate_python(read_yaml(path, DataFileError), strict=True)
    except ValidationError as error:
        faults = "; ".join(_described(fault) for fault in error.errors(include_url=False)[:MOST_FAULTS])
        raise DataFileError(f"{path}: {faults}") from error


def _described(fault: ErrorDetails) -> str:
    place = ".".join(map(str, fault["loc"]))
    value = "" if fault["type"] == "missing" else f" = {shortened(fault['input'])}"
    return f"{place}{value}: {fault['msg']}"

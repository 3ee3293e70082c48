"""The base of every group of settings: frozen, strict, finite, no unknown key; and data files checked against it."""

import json
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.core.errors import DataFileError, shortened
from fatigue_planner.core.yaml_reader import decimal_comma_hint, read_yaml

T = TypeVar("T")

MAX_NAME_LENGTH = 40
# More errors than these in one message help nobody.
MAX_FAULTS = 20
# What files, columns and folders can be called.
Name = Annotated[str, StringConstraints(pattern=rf"^[A-Za-z][A-Za-z0-9_.-]{{0,{MAX_NAME_LENGTH - 1}}}$")]
# Seeds beyond it differ between programs that read the JSON of a manifest.
Seed = Annotated[int, Field(ge=0, lt=2**63)]


class Settings(BaseModel):
    """A group of settings in a file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="strings")

    def plain(self) -> dict[str, Any]:
        """The settings as JSON values; an infinite number is the text "Infinity"."""
        return dict(json.loads(self.model_dump_json()))


def load_data(path: Path, kind: type[T]) -> T:
    """The content of a data file, checked against `kind`.

    Raises DataFileError naming the file and every offending key.
    """
    try:
        return TypeAdapter(kind).validate_python(read_yaml(path, DataFileError), strict=True)
    except ValidationError as error:
        faults = "; ".join(_described(fault) for fault in error.errors(include_url=False)[:MAX_FAULTS])
        raise DataFileError(f"{path}: {faults}") from error


def _described(fault: ErrorDetails) -> str:
    key = ".".join(map(str, fault["loc"]))
    value = "" if fault["type"] == "missing" else f" = {shortened(fault['input'])}"
    hint = decimal_comma_hint(fault["input"]) if fault["type"] == "float_type" else ""
    return f"{key}{value}: {fault['msg']}{hint}"

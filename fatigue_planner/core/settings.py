"""The base of every group of settings: frozen, strict, finite, no unknown key."""

import json
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

LONGEST_NAME = 40
# What files, columns and folders can be called.
Name = Annotated[str, StringConstraints(pattern=rf"^[A-Za-z][A-Za-z0-9_.-]{{0,{LONGEST_NAME - 1}}}$")]
# Seeds beyond it differ between programs that read the JSON of a manifest.
Seed = Annotated[int, Field(ge=0, lt=2**63)]


class Settings(BaseModel):
    """A group of settings as it stands in an experiment file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="strings")

    def plain(self) -> dict[str, Any]:
        """The settings as JSON values; an infinite number is the text "Infinity"."""
        return dict(json.loads(self.model_dump_json()))

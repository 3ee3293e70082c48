"""The base of every group of settings: frozen, strict, finite, no unknown key."""

import json
from typing import Any

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """A group of settings as it stands in an experiment file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="strings")

    def plain(self) -> dict[str, Any]:
        """The settings as JSON values; an infinite number is the text "Infinity"."""
        return dict(json.loads(self.model_dump_json()))

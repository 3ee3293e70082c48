"""The base of every group of settings: frozen, strict, finite, no unknown key."""

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """A group of settings as it stands in an experiment file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

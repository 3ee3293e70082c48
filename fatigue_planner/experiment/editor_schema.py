"""The JSON Schema of a kind of settings, as an editor needs it for YAML."""

from typing import Any

from fatigue_planner.core.settings import Settings
from fatigue_planner.experiment.pose_grid import Range
from fatigue_planner.motion.action import Position

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def editor_schema(kind: type[Settings]) -> dict[str, Any]:
    """The schema of a file's whole content; coordinates of a hand's place may be ranges (see `grids`)."""
    found = kind.model_json_schema()
    definitions = found.get("$defs", {})
    if Position.__name__ in definitions:
        definitions[Range.__name__] = Range.model_json_schema()
        place = definitions[Position.__name__]["properties"]
        for axis, number in place.items():
            place[axis] = {"anyOf": [number, {"$ref": f"#/$defs/{Range.__name__}"}]}
    return {"$schema": DIALECT, **found}

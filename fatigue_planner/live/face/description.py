"""The description of the face as OpenAPI 3.1, from the models of what is sent and answered."""

from typing import Any

from pydantic import TypeAdapter

from fatigue_planner.live.face.requests import CALLS
from fatigue_planner.live.state import SessionState
from fatigue_planner.live.turn import CycleDecision

REFUSALS = {
    "400": "A header is there twice.",
    "401": "No token, or a wrong one.",
    "403": "The token may only look, or the request comes from a page elsewhere.",
    "408": "The body did not come in time.",
    "409": "The cycle was observed otherwise before; the first stands.",
    "413": "The body is too large.",
    "421": "The Host header names another program.",
    "422": "What was sent cannot be: the message names the field or the cycle.",
    "503": "Too many are watching already.",
}
# Calls that are answered with null.
SILENT = frozenset({"acknowledge", "note", "clock"})
SCHEMAS = "#/components/schemas/"


def openapi(version: str) -> dict[str, Any]:
    """The description. Every path that the face answers is in it."""
    schemas: dict[str, Any] = {"Refusal": REFUSAL}
    for answer in (CycleDecision, SessionState):
        described = TypeAdapter(answer).json_schema(mode="serialization", ref_template=SCHEMAS + "{model}")
        schemas |= described.pop("$defs", {}) | {answer.__name__: _without_examples(described)}
    paths = {
        f"/v1/{name}": {
            "post": {
                "operationId": name,
                "summary": (kind.__doc__ or "").partition("\n")[0],
                "requestBody": {"content": {"application/json": {"schema": kind.model_json_schema()}}},
                "responses": {
                    "200": {"description": "Done."} if name in SILENT else _answer("What to do.", "CycleDecision"),
                    **_refusals("400", "401", "403", "408", "409", "413", "421", "422"),
                },
            }
        }
        for name, kind in CALLS.items()
    }
    stream = {"description": "Events whose data are states.", "content": {"text/event-stream": {}}}
    looks: dict[str, tuple[str, dict[str, Any], tuple[str, ...]]] = {
        "/v1/state": ("Where the shift stands.", _answer("The state.", "SessionState"), ("401",)),
        "/v1/events": ("The state, whole, once a second and after every change.", stream, ("401", "503")),
    }
    open_to_all: dict[str, tuple[str, dict[str, Any]]] = {
        "/healthz": ("Whether the program answers.", {"description": "It does."}),
        "/openapi.json": ("This description.", {"description": "OpenAPI 3.1."}),
        "/": ("The operators' page.", {"description": "HTML.", "content": {"text/html": {}}}),
    }
    schemas["SessionState"]["properties"]["watchers"] = {"type": "integer", "description": "How many read events."}
    for path, (summary, answer_of, refusals) in looks.items():
        paths[path] = {
            "get": {"summary": summary, "responses": {"200": answer_of, **_refusals("400", "421", *refusals)}}
        }
    for path, (summary, answer_of) in open_to_all.items():
        responses = {"200": answer_of, **_refusals("400", "421")}
        paths[path] = {"get": {"summary": summary, "security": [], "responses": responses}}
    return {
        "openapi": "3.1.0",
        "info": {"title": "fatplan live", "version": version},
        "paths": paths,
        "components": {"schemas": schemas, "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}}},
        "security": [{"token": []}],
    }


REFUSAL = {
    "description": "Why something was refused.",
    "type": "object",
    "required": ["error"],
    "properties": {
        "error": {"type": "string", "description": "What is wrong, and what is allowed."},
        "expected_cycle": {"type": "integer", "description": "The cycle going on."},
    },
}


def _answer(text: str, schema: str) -> dict[str, Any]:
    return {"description": text, "content": {"application/json": {"schema": {"$ref": SCHEMAS + schema}}}}


def _refusals(*codes: str) -> dict[str, Any]:
    return {code: _answer(REFUSALS[code], "Refusal") for code in codes}


def _without_examples(schema: dict[str, Any]) -> dict[str, Any]:
    """A schema whose description is for clients: without the examples in Python."""
    return schema | {"description": schema.get("description", "").partition("\n\n>>>")[0]}

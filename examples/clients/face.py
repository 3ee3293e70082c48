"""What every client needs: a call of the face. Python's standard library only, so it runs in any environment."""

import http.client
import json
import os
import sys
import time
import urllib.request
from pathlib import Path
from typing import Any

SERVER = os.environ.get("FATPLAN_SERVER", "http://127.0.0.1:8765")
TOKEN_FILE = Path(os.environ.get("FATPLAN_TOKEN_FILE", "shift.fatplan.act-token"))
# How long the last answer took to come: what is late here, the server does not see.
_waited: dict[str, float] = {}


def ask(call: str, **said: Any) -> Any:
    """Call the face; its answer. Raises urllib.error.HTTPError with the reason in its body for what is refused."""
    headers = {"Authorization": f"Bearer {TOKEN_FILE.read_text().strip()}"}  # a new one after every start
    begin = time.monotonic()
    request = urllib.request.Request(f"{SERVER}/v1/{call}", json.dumps(_waited | said).encode(), headers)
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:
            return json.load(answer)
    finally:
        _waited["waited_s"] = time.monotonic() - begin


def tried(call: str, **said: Any) -> Any:
    """The same for a program that must go on: None for what is refused or not answered, and a line that says why."""
    try:
        return ask(call, **said)
    except (OSError, ValueError, http.client.HTTPException) as error:
        print(f"{call}: {error}", file=sys.stderr)
        return None

"""A client's connection to the face: what was said is kept until it is on the disk, and said again after a restart."""

import http.client
import json
import ssl
import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from fatigue_planner.core.errors import FaceRefusedError, FaceUnreachableError, SelectionError, shortened
from fatigue_planner.live.limits import MAX_SECONDS

LOOPBACK = ("127.0.0.1", "::1", "localhost")
TIMEOUT_S = 10.0
RETRY_EVERY_S = 0.2
MAX_KEPT = 1000
# Said twice, these change nothing; nor does what has a key.
REPEATABLE = frozenset({"decide", "executed", "observe", "skip", "worker", "advise", "clock"})
# What clients read in a state, see `SessionState`; beside it "action", which is one of the actions, or none yet.
STATE = {"cycle": int, "actions": list, "reactions": list, "rehearsal": bool, "resumed_at": int}
# The face sends its state once a second; a connection that is silent for longer is dead.
SILENT_S = 5.0


@dataclass(frozen=True)
class Answer:
    """What the face decided, as far as clients need it; see `CycleDecision`."""

    cycle: int
    action: str
    fallback: str
    recorded: int
    durable_up_to: int


@dataclass(frozen=True)
class Address:
    """Where a face is, and the file with the token, which is new after every start.

    url: such as http://127.0.0.1:8765; beyond this machine only https. authority: a file with the certificates to
    trust, by default the system's.
    """

    url: str
    token_file: Path
    authority: Path | None = None

    def __post_init__(self) -> None:
        """Raise SelectionError for what is no such address."""
        try:
            parts = urlsplit(self.url)
            usable = parts.scheme in ("http", "https") and parts.hostname is not None and parts.port is not None
        except ValueError:
            usable = False
        if not usable or parts.path.strip("/") or parts.query:
            raise SelectionError(f"{shortened(self.url)}: should be an address such as http://127.0.0.1:8765.")
        if parts.scheme == "http" and parts.hostname not in LOOPBACK:
            raise SelectionError(f"{shortened(self.url)}: beyond this machine the token needs https.")

    def token(self) -> str:
        """The token that is valid now. Raises FaceUnreachableError if there is none."""
        try:
            return self.token_file.read_text(encoding="ascii").strip()
        except (OSError, ValueError) as error:
            raise FaceUnreachableError(f"{self.token_file}: holds no token ({error}).") from error

    def connect(self, timeout_s: float) -> http.client.HTTPConnection:
        """A connection that is made with the first request."""
        parts = urlsplit(self.url)
        assert parts.hostname is not None
        if parts.scheme == "http":
            return http.client.HTTPConnection(parts.hostname, parts.port, timeout=timeout_s)
        context = ssl.create_default_context(cafile=self.authority)
        return http.client.HTTPSConnection(parts.hostname, parts.port, timeout=timeout_s, context=context)


class Connection:
    """Calls of the face, one at a time, on a connection that is kept and made anew when it breaks.

    With every call it says how long the answer before took to come, which only this end knows.

    patience_s: how long a face that is away is tried again, as while it starts anew.
    """

    def __init__(self, address: Address, patience_s: float = 60.0) -> None:
        self.address, self.patience_s = address, patience_s
        self.restarts = 0
        self._connection: http.client.HTTPConnection | None = None
        self._token, self._sent = "", False
        self._waited_s: float | None = None
        self._kept: deque[tuple[int, str, dict[str, Any]]] = deque(maxlen=MAX_KEPT)

    def call(self, name: str, **said: Any) -> Answer | None:
        """Say something; the decision that stands then.

        Raises FaceRefusedError for what the face refuses, FaceUnreachableError if it does not answer. What cannot be
        repeated, such as a pause without a key, is not said again where it is not known whether it was heard.
        """
        may_repeat = name in REPEATABLE or said.get("key") is not None
        told = said if self._waited_s is None else {**said, "waited_s": self._waited_s}
        begin = time.monotonic()
        try:
            content = self._ask("POST", f"/v1/{name}", told, may_repeat)
        finally:  # a refusal, too, has heard how long the one before took
            self._waited_s = min(time.monotonic() - begin, MAX_SECONDS)
        if content is None:
            return None
        answer = _answer(content)
        if may_repeat and answer.recorded > answer.durable_up_to:
            self._kept.append((answer.recorded, name, said))
        while self._kept and self._kept[0][0] <= answer.durable_up_to:
            self._kept.popleft()
        return answer

    def decide(self, cycle: int | None = None) -> Answer:
        """What to do; see `Session.decide`."""
        answer = self.call("decide", **({} if cycle is None else {"cycle": cycle}))
        assert answer is not None
        return answer

    def state(self) -> dict[str, Any]:
        """Where the shift stands."""
        content = self._ask("GET", "/v1/state", None, may_repeat=True)
        if not is_state(content):
            raise FaceUnreachableError(f"{self.address.url}: its state is none of fatplan's.")
        return dict(content)

    def close(self) -> None:
        """Close the connection."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _ask(self, method: str, path: str, said: dict[str, Any] | None, may_repeat: bool) -> Any:
        until = time.monotonic() + self.patience_s
        if not may_repeat:
            self.close()  # a kept connection may be dead, and whether it was is not known afterwards
        while True:
            self._sent = False
            try:
                code, content = self._once(method, path, said)
            except (OSError, http.client.HTTPException, ValueError, FaceUnreachableError) as error:
                self.close()
                if time.monotonic() > until or (self._sent and not may_repeat):
                    raise FaceUnreachableError(f"{self.address.url}: does not answer ({error}).") from error
                time.sleep(RETRY_EVERY_S)
                continue
            if code == 401 and self._renew():
                continue
            if code != 200:
                raise FaceRefusedError(code, _reason(content))
            return content

    def _once(self, method: str, path: str, said: dict[str, Any] | None) -> tuple[int, Any]:
        if not self._token:
            self._token = self.address.token()
        if self._connection is None:
            self._connection = self.address.connect(TIMEOUT_S)
            self._connection.connect()
        body = None if said is None else json.dumps(said).encode()
        self._sent = True
        self._connection.request(method, path, body, {"Authorization": f"Bearer {self._token}"})
        answer = self._connection.getresponse()
        content = json.loads(answer.read())
        return answer.status, content

    def _renew(self) -> bool:
        """After a 401: whether the file has another token, because the face was started anew; then say again."""
        before, self._token = self._token, self.address.token()
        if self._token == before:
            return False
        again, self._kept = deque(self._kept), deque(maxlen=MAX_KEPT)
        try:
            lost_from = self.state()["resumed_at"]
            while again:
                number, name, said = again[0]
                if 0 < lost_from <= number:
                    with suppress(FaceRefusedError):  # too old
                        self.call(name, **said)
                again.popleft()
        except FaceUnreachableError:  # away again: with the token of before, all this is done once more
            self._kept.extendleft(reversed(again))
            self._token = before
            raise
        self.restarts += 1
        return True


class Watch(threading.Thread):
    """The newest state of a face, as its events bring it; made anew when they stop."""

    def __init__(self, address: Address) -> None:
        super().__init__(name="fatplan watch", daemon=True)
        self._address = address
        self._changed = threading.Condition()
        self._state: dict[str, Any] | None = None
        self._number = 0
        self._ended = threading.Event()

    def newest(self, after: int, timeout_s: float) -> tuple[int, dict[str, Any] | None]:
        """The newest state and its number, as soon as that is more than `after`; None: there is none now."""
        with self._changed:
            self._changed.wait_for(lambda: self._number > after, timeout_s)
            return self._number, self._state

    def end(self) -> None:
        """Stop watching."""
        self._ended.set()
        self.join()

    def run(self) -> None:
        """Read events until the end."""
        while not self._ended.is_set():
            with suppress(OSError, http.client.HTTPException, ValueError, FaceUnreachableError):
                self._read()
            self._put(None)
            self._ended.wait(RETRY_EVERY_S)

    def _read(self) -> None:
        connection = self._address.connect(SILENT_S)
        try:
            connection.request("GET", "/v1/events", headers={"Authorization": f"Bearer {self._address.token()}"})
            events = connection.getresponse()
            while not self._ended.is_set() and events.status == 200 and (line := events.readline()):
                if line.startswith(b"data: "):
                    state = json.loads(line[6:])
                    if is_state(state):
                        self._put(state)
        finally:
            connection.close()

    def _put(self, state: dict[str, Any] | None) -> None:
        with self._changed:
            if state is not None or self._state is not None:
                self._state = state
                self._number += 1
                self._changed.notify_all()


def is_state(content: Any) -> bool:
    """Whether something is a shift's state, as far as clients read it; else it comes from some other program."""
    if not isinstance(content, dict) or not all(isinstance(content.get(key), kind) for key, kind in STATE.items()):
        return False
    names = [*content["actions"], *content["reactions"]]
    return all(isinstance(name, str) for name in names) and content.get("action") in (None, *content["actions"])


def _answer(content: Any) -> Answer:
    """What the face decided. Raises FaceUnreachableError for what is no decision: it is some other program."""
    try:
        answer = Answer(**{name: content[name] for name in Answer.__dataclass_fields__})
        if not all(isinstance(value, int | str) for value in vars(answer).values()):
            raise TypeError
    except (KeyError, TypeError) as error:
        raise FaceUnreachableError(f"the face answered {shortened(content)}, which is no decision.") from error
    return answer


def _reason(content: Any) -> str:
    return str(content.get("error", "")) if isinstance(content, dict) else shortened(content)

"""Who may call the face: known hosts, pages of its own, tokens to look and to act; and how much may be sent."""

import asyncio
import hashlib
import hmac
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MAX_BODY_BYTES = 65_536
# A client sends its body in one go; one that does not is not waited for.
BODY_WAIT_S = 5.0
# More refusals than these are answered late.
MAX_REFUSALS_PER_S, REFUSAL_WAIT_S = 50, 1.0
OPEN_PATHS = frozenset({"/", "/healthz", "/openapi.json"})
HEADERS = {
    "cache-control": "no-store",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'",
}

Right = Literal["view", "act"]


@dataclass(frozen=True)
class Tokens:
    """Two tokens of 256 bits: one to look, one to act. Only their digests are kept."""

    view: bytes
    act: bytes

    @staticmethod
    def make() -> tuple["Tokens", str, str]:
        """New tokens, and their texts: to look and to act."""
        view, act = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        return Tokens(_digest(view), _digest(act)), view, act

    def right(self, token: str) -> Right | None:
        """What a token permits. Takes as long for any text."""
        given = _digest(token)
        may_act, may_view = hmac.compare_digest(given, self.act), hmac.compare_digest(given, self.view)
        return "act" if may_act else "view" if may_view else None


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()


class Guard:
    """Lets through what may pass: ASGI middleware. `hosts`: what the Host header may say, such as 127.0.0.1:8765.

    The scope of what it hands on says what the token permits, as `right`. Every refusal's status is told to `refused`.
    """

    def __init__(
        self, app: ASGIApp, tokens: Tokens, hosts: frozenset[str], refused: Callable[[int], None] = lambda _: None
    ) -> None:
        self._app, self._tokens, self._hosts, self._refused = app, tokens, hosts, refused
        self._second = self._in_second = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what may not pass, hand on the rest."""
        if scope["type"] != "http":
            return
        refusal = self._refusal(scope)
        body = b""
        if refusal is None and scope["method"] == "POST":
            try:
                body = await asyncio.wait_for(_whole_body(receive), BODY_WAIT_S)
            except TimeoutError:
                refusal = 408, "the body did not come in time"
            if len(body) > MAX_BODY_BYTES:
                refusal = 413, f"the body is larger than {MAX_BODY_BYTES} bytes"
        if refusal is not None:
            code, text = refusal
            self._refused(code)
            await self._slow_down()
            await JSONResponse({"error": text}, code, {**HEADERS, "connection": "close"})(scope, receive, send)
            return
        await self._app(scope, _replayed(body, receive) if scope["method"] == "POST" else receive, send)

    async def _slow_down(self) -> None:
        """Keep who is refused often waiting."""
        second = int(time.monotonic())
        self._in_second = self._in_second + 1 if second == self._second else 1
        self._second = second
        if self._in_second > MAX_REFUSALS_PER_S:
            await asyncio.sleep(REFUSAL_WAIT_S)

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        """Why a request may not pass."""
        headers: dict[bytes, bytes] = {}
        for name, value in scope["headers"]:
            if name in (b"host", b"origin", b"authorization", b"content-length") and name in headers:
                return 400, f"the header {name.decode()} is there twice"
            headers[name] = value
        host = headers.get(b"host", b"").decode("latin-1").lower()
        if host not in self._hosts:
            return 421, "this program is not at that address"  # a page elsewhere that has been given our address
        origin = headers.get(b"origin")
        if origin is not None and origin.decode("latin-1").lower() not in (f"http://{host}", f"https://{host}"):
            return 403, "the request comes from a page elsewhere"
        length = headers.get(b"content-length", b"0")
        if not length.isdigit() or int(length[:20]) > MAX_BODY_BYTES:
            return 413, f"the body is larger than {MAX_BODY_BYTES} bytes"
        if scope["path"] in OPEN_PATHS:
            return None
        kind, _, token = headers.get(b"authorization", b"").decode("latin-1").partition(" ")
        right = self._tokens.right(token.strip()) if kind.lower() == "bearer" else None
        if right is None:
            return 401, "a token is needed: Authorization: Bearer TOKEN"
        if right == "view" and scope["method"] not in ("GET", "HEAD"):
            return 403, "this token may only look"
        scope["right"] = right
        return None


async def _whole_body(receive: Receive) -> bytes:
    """The body, or as much of it as shows that it is too large."""
    body = bytearray()
    while len(body) <= MAX_BODY_BYTES:
        message = await receive()
        if message["type"] != "http.request":
            break
        body += message.get("body", b"")
        if not message.get("more_body", False):
            break
    return bytes(body)


def _replayed(body: bytes, receive: Receive) -> Receive:
    """The body that was read, once more."""
    told = False

    async def again() -> Message:
        nonlocal told
        if told:
            return await receive()
        told = True
        return {"type": "http.request", "body": body, "more_body": False}

    return again

"""The calls of a session over HTTP."""

import asyncio
import json
import math
import time
from collections import Counter
from collections.abc import AsyncIterator
from dataclasses import asdict
from functools import partial
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request as HttpRequest
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from fatigue_planner import __version__
from fatigue_planner.core.errors import ContradictionError, EvidenceError, FatplanError
from fatigue_planner.live.clock import RehearsalClock
from fatigue_planner.live.face.description import openapi
from fatigue_planner.live.face.guard import HEADERS, Guard, Tokens
from fatigue_planner.live.face.page import PAGE, PAGE_HEADERS
from fatigue_planner.live.face.requests import CALLS, parse
from fatigue_planner.live.session import Session

# Those who watch get the newest state so often, and after every change.
EVENT_EVERY_S = 1.0
MAX_WATCHERS = 50
# Refusals are journalled so often at most, however many there are.
REFUSALS_EVERY_S = 1.0


class Face:
    """A session as an ASGI application; see `description.openapi` for what it offers."""

    def __init__(self, session: Session, rehearsal: RehearsalClock | None = None) -> None:
        self._session, self._rehearsal = session, rehearsal
        self._changed = asyncio.Event()
        self._watchers = self._changes = 0
        self._event_of: tuple[int, int] | None = None
        self._text = ""
        self._refusals: Counter[str] = Counter()
        self._refusals_told_s = -math.inf

    def application(self, tokens: Tokens, hosts: frozenset[str]) -> Guard:
        """The application, guarded."""
        return Guard(Starlette(routes=self.routes()), tokens, hosts, self._refused)

    def routes(self) -> list[Route]:
        """What is answered, path by path."""
        routes = [Route(f"/v1/{name}", self._call, methods=["POST"], name=name) for name in CALLS]
        return [
            *routes,
            Route("/v1/state", self._state),
            Route("/v1/events", self._events),
            Route("/healthz", self._health),
            Route("/openapi.json", self._openapi),
            Route("/", self._page),
        ]

    async def _call(self, request: HttpRequest) -> Response:
        name = request.url.path.rpartition("/")[2]
        try:
            said = dict(parse(CALLS[name], await request.body()))
            if (waited_s := said.pop("waited_s")) is not None:
                self._session.waited(waited_s)
            call = self._move if name == "clock" else getattr(self._session, name)
            # what must be compiled first keeps nobody waiting
            told = partial(call, **said)
            answer = await asyncio.to_thread(told) if name == "configure" else told()
        except FatplanError as error:
            code = 409 if isinstance(error, ContradictionError) else 422
            return JSONResponse({"error": str(error), "expected_cycle": self._session.cycle}, code, HEADERS)
        self._changes += 1
        self._changed.set()
        self._changed = asyncio.Event()
        return JSONResponse(None if answer is None else asdict(answer), headers=HEADERS)

    def _move(self, seconds: float) -> None:
        if self._rehearsal is None:
            raise EvidenceError("clock: this is no rehearsal; the clock is the machine's.")
        self._rehearsal.move(seconds)

    async def _state(self, _: HttpRequest) -> Response:
        return JSONResponse(self._snapshot(), headers=HEADERS)

    def _refused(self, code: int) -> None:
        self._refusals[str(code)] += 1
        self.tell_refusals(REFUSALS_EVERY_S)

    def tell_refusals(self, after_s: float = 0.0) -> None:
        """Journal what was refused, if it has been so long since the last time."""
        if self._refusals and time.monotonic() - self._refusals_told_s >= after_s:
            self._session.refused(self._refusals)
            self._refusals.clear()
            self._refusals_told_s = time.monotonic()

    def _snapshot(self) -> dict[str, Any]:
        self.tell_refusals(REFUSALS_EVERY_S)
        return {**asdict(self._session.state()), "watchers": self._watchers}

    def _event(self) -> str:
        """The newest state as an event, made once for all who watch."""
        key = (self._changes, int(time.monotonic() / EVENT_EVERY_S))
        if key != self._event_of:
            self._event_of = key
            self._text = f"data: {json.dumps(self._snapshot(), separators=(',', ':'))}\n\n"
        return self._text

    async def _events(self, request: HttpRequest) -> Response:
        if self._watchers >= MAX_WATCHERS:
            return JSONResponse({"error": f"{MAX_WATCHERS} are watching already"}, 503, HEADERS)
        headers = {**HEADERS, "x-accel-buffering": "no", "fatplan-right": request.scope["right"]}
        return StreamingResponse(self._stream(request), media_type="text/event-stream", headers=headers)

    async def _stream(self, request: HttpRequest) -> AsyncIterator[str]:
        """The newest state, whole, for as long as it is read: who is slow misses states, and none are kept for him."""
        if self._watchers >= MAX_WATCHERS:  # many began at once
            return
        self._watchers += 1
        try:
            while not await request.is_disconnected():
                changed = self._changed
                yield self._event()
                try:
                    await asyncio.wait_for(changed.wait(), EVENT_EVERY_S)
                except TimeoutError:
                    continue
        finally:
            self._watchers -= 1

    async def _health(self, _: HttpRequest) -> Response:
        return JSONResponse({"ok": True}, headers=HEADERS)

    async def _openapi(self, _: HttpRequest) -> Response:
        return JSONResponse(openapi(__version__), headers=HEADERS)

    async def _page(self, _: HttpRequest) -> Response:
        return Response(PAGE, media_type="text/html", headers=PAGE_HEADERS)

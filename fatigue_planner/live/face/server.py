"""Serving the face: uvicorn, with limits on slow and on many connections."""

import asyncio
import resource
import socket
from contextlib import suppress
from pathlib import Path

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.live.clock import RehearsalClock
from fatigue_planner.live.face.app import Face
from fatigue_planner.live.face.guard import Tokens
from fatigue_planner.live.session import Session

# A request's headers come in one go; a connection that sends them drop by drop is closed.
HEADERS_WAIT_S = 5.0
KEEP_ALIVE_S = 75
MAX_CONNECTIONS = 400
LOOPBACK = ("127.0.0.1", "::1", "localhost")


class LimitedProtocol(H11Protocol):
    """HTTP/1.1 for a limited number of clients that send whole requests."""

    _too_slow: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """See H11Protocol; one connection too many is closed, those that are there stay."""
        if len(self.connections) >= MAX_CONNECTIONS:
            self.transport = transport
            transport.abort()
            return
        super().connection_made(transport)
        self._wait_for_headers()

    def data_received(self, data: bytes) -> None:
        """See H11Protocol."""
        super().data_received(data)
        if self.conn.their_state is h11.IDLE and not self.transport.is_closing():
            self._wait_for_headers()
        else:
            self._stop_waiting()

    def connection_lost(self, exc: Exception | None) -> None:
        """See H11Protocol."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _wait_for_headers(self) -> None:
        if self._too_slow is None:
            self._too_slow = self.loop.call_later(HEADERS_WAIT_S, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._too_slow is not None:
            self._too_slow.cancel()
            self._too_slow = None


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens on this machine. Raises SelectionError if it cannot, or is not this machine alone."""
    if host not in LOOPBACK:
        raise SelectionError(f"host {host}: the face serves this machine only; use one of {', '.join(LOOPBACK)}.")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # with the protocol named, asyncio sends what is written at once (TCP_NODELAY)
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
    except OSError as error:
        listening.close()
        raise SelectionError(f"port {port}: cannot be used ({error.strerror}).") from error
    return listening


def write_token(path: Path, token: str) -> None:
    """Keep a token in a file that only its owner can read."""
    path.touch(mode=0o600)
    path.chmod(0o600)
    path.write_text(f"{token}\n", encoding="ascii")


def serve(session: Session, listening: socket.socket, tokens: Tokens, rehearsal: RehearsalClock | None = None) -> None:
    """Serve until the program is stopped; the session of a rehearsal has its clock."""
    port = listening.getsockname()[1]
    hosts = frozenset(f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]"))
    with suppress(OSError, ValueError):
        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    config = uvicorn.Config(
        Face(session, rehearsal).application(tokens, hosts),
        http=LimitedProtocol,
        ws="none",
        lifespan="off",
        log_level="error",
        access_log=False,
        server_header=False,
        timeout_keep_alive=KEEP_ALIVE_S,
        timeout_graceful_shutdown=2,
        backlog=1024,
    )
    uvicorn.Server(config).run(sockets=[listening])

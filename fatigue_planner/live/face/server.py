"""Serving the face: uvicorn, with limits on slow and on many connections."""

import asyncio
import resource
import socket
from asyncio import constants
from contextlib import suppress
from pathlib import Path

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.live.clock import RehearsalClock
from fatigue_planner.live.face.app import Face
from fatigue_planner.live.face.guard import Tokens
from fatigue_planner.live.face.tls import Certificate
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


def check_host(host: str, shown: Certificate | None) -> None:
    """Raise SelectionError for an address beyond this machine without a certificate."""
    if host not in LOOPBACK and shown is None:
        raise SelectionError(
            f"--host {host}: beyond this machine the face speaks TLS only; give --tls-cert and --tls-key, or use one "
            f"of {', '.join(LOOPBACK)}."
        )


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens at an address of this machine. Raises SelectionError if it cannot."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # with the protocol named, asyncio sends what is written at once (TCP_NODELAY)
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
    except OSError as error:
        listening.close()
        raise SelectionError(f"--host {host} --port {port}: cannot be used ({error.strerror}).") from error
    return listening


def names_of(host: str, port: int, shown: Certificate | None) -> tuple[str, ...]:
    """By which names and ports clients may call, the one to tell first: loopback, or those of the certificate."""
    names = LOOPBACK if shown is None else shown.names
    if host in names:
        names = (host, *(name for name in names if name != host))
    written = [f"[{name}]" if ":" in name else name.lower() for name in names]
    usual = 80 if shown is None else 443
    return tuple(f"{name}:{port}" for name in written) + tuple(written if port == usual else ())


def write_token(path: Path, token: str) -> None:
    """Keep a token in a file that only its owner can read."""
    path.touch(mode=0o600)
    path.chmod(0o600)
    path.write_text(f"{token}\n", encoding="ascii")


def serve(
    session: Session,
    listening: socket.socket,
    tokens: Tokens,
    hosts: frozenset[str],
    shown: Certificate | None = None,
    rehearsal: RehearsalClock | None = None,
) -> None:
    """Serve until the program is stopped, clients that call by one of the `hosts`; a rehearsal has its clock."""
    # asyncio has no public place for it where uvicorn makes the server
    constants.SSL_HANDSHAKE_TIMEOUT = HEADERS_WAIT_S
    with suppress(OSError, ValueError):
        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    face = Face(session, rehearsal)
    config = uvicorn.Config(
        face.application(tokens, hosts),
        http=LimitedProtocol,
        ws="none",
        lifespan="off",
        log_level="error",
        access_log=False,
        server_header=False,
        timeout_keep_alive=KEEP_ALIVE_S,
        timeout_graceful_shutdown=2,
        backlog=1024,
        ssl_certfile=None if shown is None else shown.chain,
        ssl_keyfile=None if shown is None else shown.key,
    )
    try:
        uvicorn.Server(config).run(sockets=[listening])
    finally:
        face.tell_refusals()

"""Servers of a shift: processes of their own, and how to talk to them."""

import http.client
import json
import re
import socket
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import commands

SERVE = ("live", "serve", "paper", "--condition", "multiple_novice", "--port", 0)


@dataclass
class Server:
    """A running server, its tokens, and a connection that is kept."""

    process: "subprocess.Popen[str]"
    port: int
    view: str
    act: str
    journal: Path

    def call(
        self, path: str, body: object = None, token: str | None = None, method: str | None = None, **headers: str
    ) -> tuple[int, Any]:
        """A request on a connection of its own: status, and the answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        content = body if isinstance(body, bytes) else None if body is None else json.dumps(body).encode()
        sent = {"Authorization": f"Bearer {self.act if token is None else token}"} | headers
        connection.request(method or ("GET" if body is None else "POST"), path, content, sent)
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, json.loads(text) if text[:1] in (b"{", b"n") else text


def start(journal: Path, cache: Path, *options: object) -> Server:
    """A server of the paper's task that listens."""
    running = commands.process(*SERVE, "--journal", journal, "--cache", cache, *options)
    assert running.stdout is not None
    line = running.stdout.readline()
    found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#(\S+)\n", line)
    assert found, (line, running.stderr and running.stderr.read())
    act = journal.with_name(f"{journal.name}.act-token")
    assert act.stat().st_mode & 0o777 == 0o600
    server = Server(running, int(found[1]), found[2], act.read_text().strip(), journal)
    for _ in range(100):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", server.port)) == 0:
                return server
        time.sleep(0.05)
    raise AssertionError("the server does not listen")

"""Beyond its own machine the face speaks TLS only: what is refused before any work, and a real server."""

import http.client
import json
import re
import shutil
import socket
import ssl
import subprocess
import time
from pathlib import Path

import pytest
from commands import process, refused
from servers import SERVE

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.live.face.server import names_of
from fatigue_planner.live.face.tls import certificate

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="needs openssl")
# Of this machine, but not one of the addresses that need no certificate.
ADDRESS = "127.0.0.2"
NAMES = f"subjectAltName=DNS:Cell.example,IP:{ADDRESS},IP:::1"


def made(folder: Path, *options: str, names: str = NAMES) -> tuple[Path, Path]:
    """A self-made certificate and its key."""
    folder.mkdir(exist_ok=True)
    chain, key = folder / "cert.pem", folder / "key.pem"
    kind = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-subj", "/CN=cell", "-addext", names]
    made = ["openssl", "req", "-x509", *kind, "-keyout", key, "-out", chain, *(options or ["-nodes"])]
    subprocess.run(made, check=True, capture_output=True, timeout=60)
    return chain, key


def test_a_certificate_says_who_it_is(tmp_path: Path) -> None:
    shown = certificate(*made(tmp_path))
    assert shown.names == ("Cell.example", ADDRESS, "::1")
    assert names_of(ADDRESS, 8765, shown)[0] == f"{ADDRESS}:8765"
    assert names_of("0.0.0.0", 443, shown)[::3] == ("cell.example:443", "cell.example")
    assert names_of("::1", 8765, None)[0] == "[::1]:8765"


def test_what_is_no_certificate_is_refused(tmp_path: Path) -> None:
    chain, key = made(tmp_path / "one")
    other_chain, other_key = made(tmp_path / "other", names="keyUsage=digitalSignature")
    protected, its_key = made(tmp_path / "protected", "-passout", "pass:secret")
    expired = tmp_path / "expired.pem"
    again = ["openssl", "x509", "-in", chain, "-signkey", key, "-days", "0", "-out", expired]
    subprocess.run(again, check=True, capture_output=True, timeout=60)
    time.sleep(1.1)
    (tmp_path / "text").write_text("no certificate")
    for files, message in {
        (tmp_path / "none", key): "--tls-cert .*none: there is no such file",
        (chain, tmp_path / "none"): "--tls-key .*none: there is no such file",
        (tmp_path / "text", key): "should be a certificate and its own key in PEM",
        (chain, other_key): r"its own key .*\(KEY_VALUES_MISMATCH\)",
        (protected, its_key): r"without a password \(it has one\)",
        (expired, key): r"cannot be used \(certificate has expired\)",
        (other_chain, other_key): r"should name the host or address it is for \(subjectAltName\)",
    }.items():
        with pytest.raises(SelectionError, match=message):
            certificate(*files)


def test_nothing_begins_without_a_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    message = refused(2, "live", "serve", "paper", "--host", "0.0.0.0")
    assert "--host 0.0.0.0: beyond this machine the face speaks TLS only; give --tls-cert and --tls-key" in message
    message = refused(2, "live", "serve", "paper", "--host", "0.0.0.0", "--tls-cert", "cert.pem")
    assert "--tls-cert and --tls-key: give both, or none" in message
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_server_beyond_loopback(tmp_path: Path, cache_folder: Path) -> None:
    """Its own certificate, known names, tokens as ever; nothing in clear, and who never shakes hands is closed."""
    chain, key = made(tmp_path)
    options = ["--host", ADDRESS, "--tls-cert", chain, "--tls-key", key]
    running = process(*SERVE, "--journal", tmp_path / "shift.fatplan", "--cache", cache_folder, *options)
    with running:
        assert running.stdout is not None
        line = running.stdout.readline()
        found = re.fullmatch(rf"https://{ADDRESS}:(\d+)/#(\S+)\n", line)
        assert found, (line, running.stderr and running.stderr.read())
        port, view = int(found[1]), found[2]
        trusted = ssl.create_default_context(cafile=chain)

        def asked(path: str, **headers: str) -> int:
            connection = http.client.HTTPSConnection(ADDRESS, port, context=trusted, timeout=20)
            connection.request("GET", path, headers=headers)
            answer = connection.getresponse()
            answer.read()
            connection.close()
            return answer.status

        for _ in range(100):
            with socket.socket() as probe:
                if probe.connect_ex((ADDRESS, port)) == 0:
                    break
            time.sleep(0.1)
        silent = socket.create_connection((ADDRESS, port), timeout=30)
        assert asked("/v1/state") == 401
        assert asked("/v1/state", Authorization=f"Bearer {view}") == 200
        assert asked("/v1/state", Authorization=f"Bearer {view}", Host=f"CELL.example:{port}") == 200
        assert asked("/v1/state", Authorization=f"Bearer {view}", Host=f"127.0.0.1:{port}") == 421
        with socket.create_connection((ADDRESS, port), timeout=20) as plain:
            plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: cell.example\r\n\r\n")
            assert b"HTTP" not in plain.recv(1000)
        with socket.create_connection((ADDRESS, port), timeout=20) as raw, pytest.raises(ssl.SSLCertVerificationError):
            ssl.create_default_context().wrap_socket(raw, server_hostname="cell.example")
        act = (tmp_path / "shift.fatplan.act-token").read_text().strip()
        connection = http.client.HTTPSConnection(ADDRESS, port, context=trusted, timeout=20)
        connection.request("POST", "/v1/decide", "{}", {"Authorization": f"Bearer {act}"})
        assert json.loads(connection.getresponse().read())["cycle"] == 1
        connection.close()
        assert silent.recv(1) == b""  # within the timeout of the socket; asyncio would wait 60 s by itself
        silent.close()
        running.kill()

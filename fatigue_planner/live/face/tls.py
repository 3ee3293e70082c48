"""The certificate with which the face shows itself beyond its own machine, checked before any work starts."""

import ssl
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import SelectionError


@dataclass(frozen=True)
class Certificate:
    """Files in PEM, and the names and addresses for which the certificate was made."""

    chain: Path
    key: Path
    names: tuple[str, ...]


def certificate(chain: Path, key: Path) -> Certificate:
    """Try a certificate and its key on each other, as a client would see them.

    Raises SelectionError if a file is missing or is no PEM, the key is another's or has a password, the time of the
    certificate has not come or is over, or it names no host.
    """
    for option, file in (("--tls-cert", chain), ("--tls-key", key)):
        if not file.is_file():
            raise SelectionError(f"{option} {file}: there is no such file.")
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        server.load_cert_chain(chain, key, password=_no_password)
    except (OSError, ValueError) as error:
        why = getattr(error, "reason", None) or getattr(error, "strerror", None) or str(error)
        raise SelectionError(
            f"--tls-cert {chain}, --tls-key {key}: should be a certificate and its own key in PEM, the key without a "
            f"password ({why})."
        ) from error
    client = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    client.check_hostname = False
    client.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN  # who trusts it is not our business
    client.load_verify_locations(chain)
    try:
        found = _seen_by(client, server)
    except ssl.SSLCertVerificationError as error:
        raise SelectionError(f"--tls-cert {chain}: cannot be used ({error.verify_message}).") from error
    names = tuple(
        str(ip_address(name)) if kind == "IP Address" else name
        for kind, name in found
        if kind == "IP Address" or (kind == "DNS" and "*" not in name)
    )
    if not names:
        raise SelectionError(
            f"--tls-cert {chain}: should name the host or address it is for (subjectAltName), without *."
        )
    return Certificate(chain, key, names)


def _no_password() -> str:
    raise ValueError("it has one")


def _seen_by(client: ssl.SSLContext, server: ssl.SSLContext) -> tuple[tuple[str, str], ...]:
    """The names in the certificate that a server shows a client; the two shake hands in memory."""
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    asks = client.wrap_bio(to_client, to_server)
    shows = server.wrap_bio(to_server, to_client, server_side=True)
    left = [asks, shows]
    while left:
        for side in list(left):
            try:
                side.do_handshake()
            except ssl.SSLWantReadError:
                continue
            left.remove(side)
    names: Any = (asks.getpeercert() or {}).get("subjectAltName", ())
    return tuple((str(kind), str(name)) for kind, name in names)

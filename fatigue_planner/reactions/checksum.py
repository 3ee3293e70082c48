"""The seal of a file: its first bytes carry the SHA-256 of all others, so that not one bit can change unnoticed.

HDF5 leaves room for that: it looks for its own beginning at byte 0, 512, 1024 ...
"""

import hashlib

SEAL_BYTES = 512
_MARK = b"fatplan sha256 "


def sealed(content: bytes) -> bytes:
    """A content that begins with SEAL_BYTES free bytes, with its seal in them."""
    return _seal(content) + content[SEAL_BYTES:]


def is_sealed(content: bytes) -> bool:
    """Whether a content is, to the bit, what was sealed."""
    return len(content) > SEAL_BYTES and content[:SEAL_BYTES] == _seal(content)


def _seal(content: bytes) -> bytes:
    digest = hashlib.sha256(memoryview(content)[SEAL_BYTES:]).hexdigest()
    return (_MARK + digest.encode() + b"\n").ljust(SEAL_BYTES, b"\0")

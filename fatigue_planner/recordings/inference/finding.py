"""What was inferred, and why; and what a user says instead."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Given:
    """What a user says of a file; None is inferred.

    units: of length, mm, cm or m; up: an axis like +y; rate_hz: of the frames; prefix: before the labels of the person
    who is meant; mapping: a name or a file; mass_kg: of the body.
    """

    units: str | None = None
    up: str | None = None
    rate_hz: float | None = None
    prefix: str | None = None
    mapping: str | None = None
    mass_kg: float | None = None


@dataclass(frozen=True)
class Finding:
    """One thing that was read, given or inferred: what, its value as text, and from what."""

    what: str
    value: str
    source: str

"""What was inferred, and why; and what a user says instead."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Given:
    """What a user says of a file; None is inferred.

    units: of length, mm, cm or m; up: an axis like +y; rate_hz: of the frames; prefix: before the labels of the person
    who is meant; mapping: a name or a file; mass_kg: of the body; heading_deg: where he faces at first, from x towards
    y, once z is up; exchange_sides: labels say left where right is, and the other way round.
    """

    units: str | None = None
    up: str | None = None
    rate_hz: float | None = None
    prefix: str | None = None
    mapping: str | None = None
    mass_kg: float | None = None
    heading_deg: float | None = None
    exchange_sides: bool = False


@dataclass(frozen=True)
class Finding:
    """One thing that was read, given or inferred: what, its value as text, and from what."""

    what: str
    value: str
    source: str

"""The unit of length: what the header says, or the body shows."""

from fatigue_planner.core.errors import RecordingError, shortened
from fatigue_planner.recordings.inference.axes import STATURE_M
from fatigue_planner.recordings.inference.finding import Finding

METRES = {
    "mm": 1e-3, "millimeter": 1e-3, "millimeters": 1e-3, "millimetre": 1e-3, "millimetres": 1e-3,
    "cm": 1e-2, "centimeter": 1e-2, "centimeters": 1e-2, "centimetre": 1e-2, "centimetres": 1e-2,
    "m": 1.0, "mete": 1.0, "meter": 1.0, "meters": 1.0, "metre": 1.0, "metres": 1.0,
}  # fmt: skip


def unit_of_length(said: str | None, given: str | None, stature: float | None) -> tuple[float, Finding]:
    """Metres of a unit that is said or given, or in which a body's `stature` is a person's.

    Raises RecordingError if it is unknown, or the body would be none.
    """
    low, high = STATURE_M
    said, source = (given, "given") if given else (said, "the file")
    if said is None:
        fits = [unit for unit in ("mm", "cm", "m") if stature is not None and low <= stature * METRES[unit] <= high]
        if not fits or stature is None:
            raise RecordingError("says no unit of length, and no body shows it. Say it with --units: mm, cm or m.")
        metres = METRES[fits[0]]
        return metres, Finding("unit", fits[0], f"the body is about {stature * metres:.2f} m tall")
    if said.strip().lower() not in METRES:
        raise RecordingError(f"unit {shortened(said)} is unknown; say it with --units: mm, cm or m.")
    metres = METRES[said.strip().lower()]
    if stature is not None and not low <= stature * metres <= high:
        raise RecordingError(
            f"in {said} ({source}) the body would be {stature * metres:.3g} m tall. Say the unit with --units."
        )
    tall = "" if stature is None else f"; the body is about {stature * metres:.2f} m tall"
    return metres, Finding("unit", said, source + tall)

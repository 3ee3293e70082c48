"""Limits that a shift and its clients share; clients load this and nothing else of the shift."""

# An observation may come so many cycles late and still be taken.
LATE_CYCLES = 5
# A day and a half: longer is no pause of a shift.
MAX_SECONDS = 129_600.0

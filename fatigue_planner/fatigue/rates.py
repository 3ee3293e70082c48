"""Sets of rates: how fast every joint tires and recovers under a law, from data files with sources."""

from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import DataFileError, listed
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices

Vector = NDArray[np.float64]

RATE_SETS = Path(__file__).parent / "data" / "rates"
MAX_PATH_LENGTH = 1000

# In 1/s: nobody tires or recovers within a hundredth of a second.
Rate = Annotated[float, Field(gt=0, le=100)]
Multiplier = Annotated[float, Field(ge=1, le=1000)]

KEYS = ("fatigue_rate_per_s", "recovery_rate_per_s", "rest_multiplier")


class JointRates(Settings):
    """The rates of a joint, or of several, and where they come from."""

    fatigue_rate_per_s: Rate
    recovery_rate_per_s: Rate
    rest_multiplier: Multiplier = 1.0
    source: str


class RateFile(Settings):
    """A set of rates: `law` is the kind of the law they belong to; a later row counts where two name the same entry."""

    law: str
    population: str
    joints: dict[str, JointRates]


def shipped_rates() -> tuple[str, ...]:
    """Names of the sets that ship with the package, in alphabetical order."""
    return tuple(sorted(path.stem for path in RATE_SETS.glob("*.yaml")))


def rate_file(name: str) -> RateFile:
    """A set that ships with the package, by name, or a user's own, by path. Raises DataFileError if it is no such."""
    path = RATE_SETS / f"{name}.yaml" if name in shipped_rates() else Path(name)
    try:
        found = path.is_file()
    except (OSError, ValueError):  # the system takes no such name
        found = False
    if not found:
        raise DataFileError(f"neither one of {', '.join(shipped_rates())} nor a file ({path.absolute()}).")
    return load_data(path, RateFile)


def rates_by_entry(content: RateFile, name: str) -> dict[str, Vector]:
    """Fatigue rate, recovery rate and rest multiplier of every entry, each (78,), by key.

    Raises DataFileError, naming the set, for an unknown joint or one without rates.
    """
    rates = {key: np.full(len(ENTRIES), np.nan) for key in KEYS}
    for joint, row in content.joints.items():
        for key in KEYS:
            rates[key][entry_indices(joint, f"{name}: joints.{joint}")] = getattr(row, key)
    missing = [entry for entry, rate in zip(ENTRIES, rates[KEYS[0]], strict=True) if np.isnan(rate)]
    if missing:
        raise DataFileError(f"{name}: joints: no rates for {listed(missing)}; `all` names every joint.")
    return rates

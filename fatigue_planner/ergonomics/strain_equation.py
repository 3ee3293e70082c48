"""The revised strain index (Garg, Moore & Kapellusch 2017, Ergonomics 60, 912-922), and what is made of several.

The composite index (COSI) of one task and the cumulative index (CUSI) of a day (ibid. 1033-1041) add up alike: the
worst first, and of each further one what it adds, by efforts per minute or by hours.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple


class Effort(NamedTuple):
    """One kind of effort of a hand: share of its strength, efforts per minute, s per effort, degrees of the wrist.

    wrist_deg: negative in (palmar) flexion, as in the source.
    """

    intensity: float
    per_minute: float
    duration_s: float
    wrist_deg: float


def intensity_multiplier(share: float) -> float:
    """IM of a share of the strength, 0 to 1."""
    if share <= 0.4:
        return 30 * share**3 - 15.6 * share**2 + 13 * share + 0.4
    return 36 * share**3 - 33.3 * share**2 + 24.77 * share - 1.86


def frequency_multiplier(per_minute: float) -> float:
    """EM of efforts per minute."""
    return 0.10 + 0.25 * per_minute if per_minute <= 90 else 0.00334 * per_minute**1.96


def duration_multiplier(duration_s: float) -> float:
    """DM of the seconds of one effort."""
    return 0.45 + 0.31 * duration_s if duration_s <= 60 else 19.17 * math.log(duration_s) - 59.44


def posture_multiplier(wrist_deg: float) -> float:
    """PM of the wrist, flexion negative."""
    if wrist_deg < 0:
        return 1.2 * math.exp(0.009 * -wrist_deg) - 0.2
    return 1.0 if wrist_deg <= 30 else 1 + 0.00028 * (wrist_deg - 30) ** 2


def hours_multiplier(hours: float) -> float:
    """HM of hours a day."""
    return 0.20 if hours <= 0.05 else 0.042 * hours + 0.090 * math.log(hours) + 0.477


def strain_index(effort: Effort, hours: float) -> float:
    """RSI of one kind of effort."""
    return (
        intensity_multiplier(effort.intensity)
        * frequency_multiplier(effort.per_minute)
        * duration_multiplier(effort.duration_s)
        * posture_multiplier(effort.wrist_deg)
        * hours_multiplier(hours)
    )


def composite_index(efforts: Sequence[Effort], hours: float) -> float:
    """COSI of the kinds of efforts in one task: the highest RSI, and what each further one adds by its frequency."""
    ordered = sorted(efforts, key=lambda effort: -strain_index(effort, hours))
    index, per_minute = 0.0, 0.0
    for effort in ordered:
        before = frequency_multiplier(per_minute) if per_minute else 0.0
        per_minute += effort.per_minute
        added = frequency_multiplier(per_minute) - before
        index += strain_index(effort, hours) / frequency_multiplier(effort.per_minute) * added
    return index


class Task(NamedTuple):
    """What a hand does for some hours of a day: its composite index at these hours."""

    composite: float
    hours: float


def cumulative_index(tasks: Sequence[Task]) -> float:
    """CUSI of the tasks of a day: the highest COSI, and what each further one adds by its hours.

    Tasks that are alike are as one task of all their hours, and a single one keeps its COSI.
    """
    index, hours = 0.0, 0.0
    for task in sorted(tasks, key=lambda task: -task.composite):
        before = hours_multiplier(hours) if hours else 0.0
        hours += task.hours
        index += task.composite / hours_multiplier(task.hours) * (hours_multiplier(hours) - before)
    return index

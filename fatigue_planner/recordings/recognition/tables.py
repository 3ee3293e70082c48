"""What a recogniser can do, as tables: confusion with intervals, pairs, and how soon reactions are known."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.recordings.recognition.calibration import (
    blocks_of,
    calibration_error,
    chance_errors,
    reliability,
)
from fatigue_planner.recordings.recognition.recogniser import HeldOut, Recogniser
from fatigue_planner.recordings.recognition.repetitions import N_PARTS, PARTS, part_ends_s

if TYPE_CHECKING:
    import pandas as pd

KNOWN_FROM = 0.95  # the share that is right from which on a reaction is called known
DRAWS = 1000  # of what chance makes of a calibration error
# By what has passed, the last part of it: when probabilities are compared with the truth.
MOMENTS = {
    "half the reach": PARTS["reach"] // 2 - 1,
    "the reach": PARTS["reach"] - 1,
    "the work": PARTS["reach"] + PARTS["work"] - 1,
    "the return": N_PARTS - 1,
}


def confusion_table(recogniser: Recogniser) -> "pd.DataFrame":
    """A row for every action, preference and what it is recognised as: count, probability, 95 % interval."""
    import pandas as pd  # noqa: PLC0415 - takes half a second, which other commands do without

    rows = []
    for action, known in recogniser.actions.items():
        confusion = known.confusion
        probability, (lower, upper) = confusion.probability(), confusion.interval()
        for one, preference in enumerate(confusion.preferences):
            for other, recognised in enumerate(confusion.recognised):
                at = one, other
                rows.append(
                    (action, preference, recognised, confusion.counts[at], probability[at], lower[at], upper[at])
                )
    columns = ["action", "preference", "recognised", "repetitions", "probability", "lower", "upper"]
    return pd.DataFrame(rows, columns=columns)


def pair_table(recogniser: Recogniser) -> "pd.DataFrame":
    """A row for every action and pair: how far apart during work, how many are told apart, whether they are one."""
    import pandas as pd  # noqa: PLC0415

    rows = []
    for action, known in recogniser.actions.items():
        names, difference = known.model.preferences, known.model.difference_deg()
        for one, name in enumerate(names):
            for other in range(one + 1, len(names)):
                merged = bool(known.groups[one] == known.groups[other])
                rows.append((action, name, names[other], difference[one, other], known.apart[one, other], merged))
    return pd.DataFrame(rows, columns=["action", "one", "other", "difference_deg", "told_apart", "merged"])


def early_table(recogniser: Recogniser, held_out: Mapping[str, HeldOut]) -> "pd.DataFrame":
    """A row for every action and part of the cycle: when it is over, and the share that is recognised by then."""
    import pandas as pd  # noqa: PLC0415

    ends = part_ends_s(recogniser.cycle)
    phases = [phase for phase, parts in PARTS.items() for _ in range(parts)]
    tables = []
    for action, one in held_out.items():
        share = one.right_share(recogniser.temperature, recogniser.actions[action].groups)
        tables.append(
            pd.DataFrame({"action": [action] * N_PARTS, "phase": phases, "time_s": ends, "recognised": share})
        )
    return pd.concat(tables, ignore_index=True)


def calibration_table(recogniser: Recogniser, held_out: Mapping[str, HeldOut]) -> "pd.DataFrame":
    """A row for every action and moment: the calibration error, and what chance alone makes of it.

    expected, chance: the mean and the 95 % quantile of the errors that a recogniser whose probabilities are true shows
    on as many repetitions, of people who are as alike in themselves.
    """
    import pandas as pd  # noqa: PLC0415

    rows = []
    for action, one in held_out.items():
        known = recogniser.actions[action]
        probability = one.probability(recogniser.temperature, known.groups, known.lapse)
        truth = known.groups[one.truth]
        effect = known.confusion.counts.sum() / known.confusion.effective.sum()
        blocks = blocks_of(one.people, one.truth, int(np.ceil(effect)))
        for moment, part in MOMENTS.items():
            now = probability[:, :, part]
            chance = chance_errors(now, blocks, random_stream(0, "calibration", action, moment), DRAWS)
            error, beyond = calibration_error(now, truth), float(np.quantile(chance, 0.95))
            rows.append((action, moment, len(truth), error, float(chance.mean()), beyond))
    return pd.DataFrame(rows, columns=["action", "after", "repetitions", "error", "expected", "chance"])


def reliability_table(recogniser: Recogniser, held_out: Mapping[str, HeldOut]) -> "pd.DataFrame":
    """A row for every moment and bin of probability, over all actions: how many, and the share right."""
    import pandas as pd  # noqa: PLC0415

    rows = []
    for moment, part in MOMENTS.items():
        told = []
        for action, one in held_out.items():
            known = recogniser.actions[action]
            probability = one.probability(recogniser.temperature, known.groups, known.lapse)[:, :, part]
            told.append((probability.max(axis=1), probability.argmax(axis=1) == known.groups[one.truth]))
        confidence, right = (np.concatenate(values) for values in zip(*told, strict=True))
        rows += [(moment, *row) for row in reliability(confidence, right)]
    return pd.DataFrame(rows, columns=["after", "repetitions", "probability", "right"])


def known_from_s(recogniser: Recogniser, held_out: HeldOut, action: str) -> float | None:
    """From when on in s since the cycle began `KNOWN_FROM` of the repetitions are recognised; None if never."""
    share = held_out.right_share(recogniser.temperature, recogniser.actions[action].groups)
    late = np.flatnonzero(share < KNOWN_FROM)
    first = late[-1] + 1 if len(late) else 0
    return None if first == N_PARTS else float(part_ends_s(recogniser.cycle)[first])


def lines(recogniser: Recogniser, known_from: Mapping[str, float | None]) -> list[str]:
    """The confusion matrices in words: a block for every action."""
    found = []
    for action, known in recogniser.actions.items():
        confusion = known.confusion
        probability, (lower, upper) = confusion.probability(), confusion.interval()
        names = confusion.recognised
        width = max(map(len, (*confusion.preferences, *names)))
        columns = [max(len(name), 18) for name in names]
        since = known_from[action]
        when = "not even after the whole cycle" if since is None else f"after {since:.1f} s of the cycle"
        found.append(f"{action}: 95 % are recognised {when}; what a reaction is recognised as, with 95 % intervals:")
        found.append(
            "  " + " " * width + "".join(f"  {name:>{size}}" for name, size in zip(names, columns, strict=True))
        )
        for row, preference in enumerate(confusion.preferences):
            cells = zip(probability[row], lower[row], upper[row], columns, strict=True)
            shown = "".join(f"  {f'{p:.2f} ({low:.2f}-{high:.2f})':>{size}}" for p, low, high, size in cells)
            found.append(f"  {preference:<{width}}{shown}")
    pairs = pair_table(recogniser)
    for one in pairs[pairs["merged"]].itertuples():
        found.append(
            f"{one.action}: {one.one} and {one.other} are one reaction to the robot: {one.difference_deg:.1f}° apart "
            f"during work, {one.told_apart:.0%} told apart."
        )
    return found

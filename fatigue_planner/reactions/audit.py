"""Checking stored reactions once more: are they what was written, and do the motions keep what they promise?"""

from dataclasses import asdict, dataclass
from pathlib import Path

from fatigue_planner.errors import DamagedFileError
from fatigue_planner.motion.quality import Verdict
from fatigue_planner.motion.verification import MismatchError, measure
from fatigue_planner.reactions.library import read_reaction
from fatigue_planner.reactions.reaction import ReactionName, request_of

# What a check recomputed on another machine may differ by from the stored one (SI).
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Audit:
    """The verdict on a stored reaction and, if it is not good, why; `damaged` if it is not what was written."""

    path: Path
    name: ReactionName
    verdict: Verdict
    reason: str = ""
    damaged: bool = False


def audit(place: tuple[Path, ReactionName]) -> Audit:
    """Read a reaction, recompute every check of its motion, and compare with what is stored."""
    path, name = place
    try:
        reaction = read_reaction(path, name)
        request = request_of(name, reaction.settings)
    except DamagedFileError as error:
        return Audit(path, name, "failed", str(error), damaged=True)
    except (ValueError, KeyError, TypeError) as error:
        return Audit(path, name, "failed", f"its settings are not those of this version ({error})")
    try:
        quality = measure(request.motion, reaction.motion)
    except MismatchError as error:
        return Audit(path, name, "failed", str(error))
    faults = quality.faults(request.accuracy)
    stored = asdict(reaction.quality)
    faults += [
        f"{check} = {value}, stored as {stored[check]}"
        for check, value in asdict(quality).items()
        if not isinstance(value, str) and not abs(value - stored[check]) <= TOLERANCE
    ]
    if faults:
        return Audit(path, name, "failed", "; ".join(faults))
    verdict = quality.kept_as()
    return Audit(path, name, verdict, quality.degradation() if verdict == "degraded" else "")

"""Checking stored reactions once more: are they what was written, and do the motions keep what they promise?"""

from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import ValidationError

from fatigue_planner.core.errors import DamagedFileError, OtherVersionError
from fatigue_planner.motion.quality import Verdict
from fatigue_planner.motion.verification import MismatchError, measure
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction, ReactionName, request_of

# What a check recomputed on another machine may differ by from the stored one (SI).
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Verification:
    """The verdict on a stored reaction and, if it is not good, why; None: of another version, not checked.

    damaged: it is not what was written; nothing is known of it then.
    """

    path: Path
    verdict: Verdict | None
    name: ReactionName | None = None
    reason: str = ""
    damaged: bool = False


def verify_entry(path: Path) -> Verification:
    """Read a reaction of the cache, recompute every check of its motion, and compare with what is stored."""
    try:
        reaction = ReactionCache(path.parent).read(path)
    except OtherVersionError as error:
        return Verification(path, None, reason=str(error))
    except DamagedFileError as error:
        return Verification(path, "failed", reason=str(error), damaged=True)
    faults = faults_of(reaction)
    if faults:
        return Verification(path, "failed", reaction.name, "; ".join(faults))
    verdict = reaction.quality.kept_as()
    return Verification(path, verdict, reaction.name, reaction.quality.degradation() if verdict == "degraded" else "")


def faults_of(reaction: Reaction) -> list[str]:
    """What a reaction's motion does not keep of what is stored of it."""
    try:
        request = request_of(reaction.name, reaction.key.settings)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        return [f"its settings are not those of this version ({'.'.join(map(str, first['loc']))}: {first['msg']})"]
    except (ValueError, KeyError, TypeError) as error:
        return [f"its settings are not those of this version ({error})"]
    try:
        quality = measure(request.motion, reaction.motion)
    except MismatchError as error:
        return [str(error)]
    stored = asdict(reaction.quality)
    return quality.faults(request.accuracy) + [
        f"{check} = {value}, stored as {stored[check]}"
        for check, value in asdict(quality).items()
        if not isinstance(value, str) and not abs(value - stored[check]) <= TOLERANCE
    ]

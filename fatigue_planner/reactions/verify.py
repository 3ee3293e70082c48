"""Checking stored reactions once more: are they what was written, and are the motions what is stored of them?"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fatigue_planner.core.errors import DamagedFileError, DataFileError, OtherVersionError
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality, Verdict
from fatigue_planner.motion.verification import MismatchError, check_shape, measure
from fatigue_planner.reactions.cache import ReactionCache, simulate_and_measure
from fatigue_planner.reactions.reaction import FailedReaction, Reaction, ReactionName
from fatigue_planner.reactions.recorded import RecordedQuality, largest_load

# What a check recomputed on another machine may differ by from the stored one (SI); below every bar of the accuracy.
TOLERANCE = 1e-9


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
    """Read a reaction of the cache, recompute every check of its motion, and compare with what is stored.

    One that is stored as failed is simulated again.
    """
    try:
        reaction = ReactionCache(path.parent).read(path)
    except OtherVersionError as error:
        return Verification(path, None, reason=str(error))
    except DamagedFileError as error:
        return Verification(path, "failed", reason=str(error), damaged=True)
    faults = faults_of(reaction)
    if faults:
        return Verification(path, "failed", reaction.name, "; ".join(faults))
    if isinstance(reaction, FailedReaction):
        return Verification(path, "ok", reaction.name, f"cannot be performed: {reaction.reason}")
    return Verification(path, reaction.quality.kept_as(), reaction.name, "; ".join(reaction.quality.remarks()))


def faults_of(stored: Reaction | FailedReaction) -> list[str]:
    """What in a stored reaction is not what its settings lead to."""
    try:
        request = stored.key.motion_request()
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        return [f"its settings are not those of this version ({'.'.join(map(str, first['loc']))}: {first['msg']})"]
    except (ValueError, KeyError, TypeError) as error:
        return [f"its settings are not those of this version ({error})"]
    try:
        if isinstance(stored, FailedReaction):
            as_stored = simulate_and_measure(request) == stored.reason
            return [] if as_stored else ["is stored as failed, for another reason than its simulation has"]
        if isinstance(stored.quality, RecordedQuality):
            return _recorded_faults(request, stored.motion, stored.quality)
        quality = _flat(measure(request, stored.motion))
    except (MismatchError, DataFileError) as error:
        return [str(error)]
    noted = _flat(stored.quality)
    return [
        f"{check} = {value}, stored as {noted[check]}"
        for check, value in quality.items()
        if (value != noted[check] if isinstance(value, str) else not abs(value - noted[check]) <= TOLERANCE)
    ]


def _recorded_faults(request: MotionRequest, motion: Motion, quality: RecordedQuality) -> list[str]:
    """What of a recorded motion is not what is stored of it. What only the recording shows cannot be computed again."""
    check_shape(request, motion)
    share, joint = largest_load(request.maximum_torque, motion)
    if abs(share - quality.largest_load_share) <= TOLERANCE and joint == quality.largest_load_joint:
        return []
    stored = f"{quality.largest_load_share} ({quality.largest_load_joint})"
    return [f"largest_load_share = {share} ({joint}), stored as {stored}"]


def _flat(quality: Quality) -> dict[str, Any]:
    """All that can be measured of a stored motion, by name."""
    measures = asdict(quality)
    del measures["tested_causes"]
    seen: dict[str, Any] = measures.pop("plausibility")
    return measures | seen

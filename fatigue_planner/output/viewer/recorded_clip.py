"""A recorded reaction to be looked at: the person's own body among the markers that were seen."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.motion.quality import Verdict
from fatigue_planner.output.viewer.motion_clip import MotionClip, motion_clip_of
from fatigue_planner.reactions.reaction import ReactionRequest
from fatigue_planner.recordings.imports.imported import Imported
from fatigue_planner.recordings.imports.on_ticks import loaded
from fatigue_planner.recordings.recording import Recording

Vector = NDArray[np.float64]


def recorded_clip(
    made: Imported, recording: Recording, request: ReactionRequest, parameters: FatigueParameters
) -> MotionClip:
    """What there is to see of an import: the verdict is that by the accuracy of the request's experiment."""
    clip = motion_clip_of(request, made.reaction, parameters)
    person = made.calibration.person
    verdict: Verdict = request.verdict(made.quality)
    return replace(
        clip,
        human=replace(clip.human, model=person.model(), anthropometry=person),
        bodies=tuple(
            replace(human, model=loaded(person, run), anthropometry=person)
            for human, run in zip(clip.bodies, clip.runs, strict=True)
        ),
        verdict=verdict,
        remarks=tuple(request.faults(made.quality) or made.quality.remarks()),
        markers_m=markers_on_ticks(made, recording),
    )


def markers_on_ticks(made: Imported, recording: Recording) -> Vector:
    """Where the markers are (T, k, 3) m at the ticks of the cycle, in the reaction's world; NaN where unseen."""
    assert recording.points_m is not None
    times = made.bounds.times_s(made.reaction.motion.phases)
    frames = np.minimum(np.round(times * recording.rate_hz).astype(int), recording.frames - 1)
    shown = [recording.labels.index(label) for label in made.track.labels]
    return np.asarray(recording.points_m[frames][:, shown] - made.origin_m)

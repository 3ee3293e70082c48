"""The kinds of tasks a motion preference can have.

A new kind is a file beside this one and a name in KINDS; from outside the package, `fatigue_planner.register`.
"""

from typing import Annotated

from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.motion.tasks.centre_of_mass import CentreOfMass
from fatigue_planner.motion.tasks.hand import Hand
from fatigue_planner.motion.tasks.joint_posture import JointPosture
from fatigue_planner.motion.tasks.segment_orientation import SegmentOrientation
from fatigue_planner.motion.tasks.segment_position import SegmentPosition
from fatigue_planner.motion.tasks.segment_upright import SegmentUpright
from fatigue_planner.motion.tasks.task import TASKS, PreferenceTask

KINDS = (SegmentUpright, SegmentOrientation, SegmentPosition, CentreOfMass, JointPosture, Hand)
for kind in KINDS:
    TASKS.add(kind)

# The settings of any task.
AnyTask = Annotated[PreferenceTask, TASKS]


class Preference(Settings):
    """A motion preference: tasks added to those every motion has."""

    tasks: tuple[AnyTask, ...] = Field(
        max_length=50, description="Tasks added to those every motion has: balance, hands and natural posture."
    )

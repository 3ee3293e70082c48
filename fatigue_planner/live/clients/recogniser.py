"""A recogniser beside a shift: it watches a tracker's joint angles, and says how likely each reaction was.

The face is told at the end of a cycle, because what is said of it ends it; what is known earlier is published. A cycle
that another client ends before is told late, by what was measured until then.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import FaceRefusedError, FaceUnreachableError, SelectionError, listed
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.live.clients.client import Client
from fatigue_planner.live.clients.connection import Address
from fatigue_planner.live.limits import LATE_CYCLES
from fatigue_planner.recordings.recognition.recogniser import Recogniser
from fatigue_planner.recordings.recognition.repetitions import Growing, part_ends_s

Array = NDArray[np.float64]

# A tracker's samples are waited for so long after the end of a cycle.
WAIT_S = 1.0
# No whole cycle has all its angles below this: degrees would be radians, or nobody moves.
LEAST_DEG = math.pi


@dataclass(frozen=True)
class Samples:
    """What a tracker has measured since it was last asked: when, by this machine's clock, and angles in degrees.

    stamps_s (T,); angles_deg (T, all degrees of freedom), NaN where nothing was measured. remarks: for people.
    """

    stamps_s: Array
    angles_deg: Array
    remarks: tuple[str, ...] = ()

    @classmethod
    def none(cls, *remarks: str) -> Self:
        """Nothing was measured."""
        return cls(np.empty(0), np.empty((0, len(DEGREES_OF_FREEDOM))), remarks)


class Tracker(ABC):
    """Where joint angles come from."""

    @abstractmethod
    def read(self) -> Samples:
        """What is new; without waiting."""

    @abstractmethod
    def close(self) -> None:
        """Let go of it."""


class _Motion:
    """What is measured of a cycle of a worker.

    began_s: None until it has begun; is_whole: whether its beginning was seen; ended_s: when the shift went on, if it
    has; executed: what the robot said it does. told: how many of its parts were published; is_said: whether the face
    knows all that there is to say.
    """

    def __init__(self, cycle: int, worker: str, growing: Growing) -> None:
        self.cycle, self.worker, self.growing = cycle, worker, growing
        self.action = ""
        self.executed: str | None = None
        self.began_s: float | None = None
        self.ended_s = math.inf
        self.is_whole = self.is_said = False
        self.told = 0

    def add(self, samples: Samples) -> None:
        """What was measured of it."""
        if self.began_s is not None:
            own = (samples.stamps_s >= self.began_s) & (samples.stamps_s < self.ended_s)
            self.growing.add(samples.stamps_s[own] - self.began_s, samples.angles_deg[own])


class RecogniserClient(Client):
    """Watches a tracker and tells the face how likely each reaction was.

    clock: this machine's, in s, by which the tracker stamps. publish: where the likelihoods of the cycle going on go,
    after every part of it.

    A cycle begins when the robot says that it does it; then the robot ends it, too, or its planned duration. Where no
    robot says anything, it begins when it is decided and lasts as long as planned. A cycle whose beginning was not seen
    is not judged.
    """

    def __init__(
        self,
        address: Address,
        recogniser: Recogniser,
        tracker: Tracker,
        clock: Callable[[], float],
        publish: Callable[[dict[str, Any]], None] = lambda _: None,
        say: Callable[[str], None] = lambda _: None,
    ) -> None:
        super().__init__(address, say)
        self._recogniser, self._tracker, self._clock, self._publish = recogniser, tracker, clock, publish
        self._ends_s = part_ends_s(recogniser.cycle)
        self._motions: list[_Motion] = []
        self._newest_s = -math.inf
        self._remarks: set[str] = set()

    def check(self, actions: tuple[str, ...], reactions: tuple[str, ...]) -> None:
        """See Client.check: the recogniser must know every action, with the same preferences and durations."""
        del reactions
        known = self._recogniser.actions
        if missing := [name for name in actions if name not in known]:
            raise SelectionError(f"the recogniser knows {listed(known)}; the shift has {listed(missing)}, too.")
        preferences = self.state.get("preferences") or ()
        for action in actions:
            own = known[action].model.preferences
            if sorted(own) != sorted(preferences):
                raise SelectionError(
                    f"action {action}: the recogniser knows {listed(own)}; the preferences of the shift are "
                    f"{listed(preferences)}."
                )
        planned_s, own_s = self.state.get("planned_s"), self._ends_s[-1]
        if not isinstance(planned_s, int | float) or not math.isclose(planned_s, own_s, rel_tol=1e-6):
            raise SelectionError(f"the recogniser's cycle lasts {own_s:g} s; the shift's {planned_s} s.")

    def look(self, cycle: int, action: str) -> None:
        """See Client.look."""
        now_s = self._clock()
        self._follow(cycle, action, now_s)
        samples = self._tracker.read()
        for remark in samples.remarks:
            self._remark(remark)
        self._newest_s = max(self._newest_s, samples.stamps_s.max(initial=-math.inf))
        now = self._motions[-1]
        if now.began_s is None and not self._robot_answers():  # it begins when somebody is seen again
            seen = samples.stamps_s[np.isfinite(samples.angles_deg).any(axis=1)]
            now.began_s = float(seen.min()) if len(seen) else None
        for motion in self._motions:
            motion.add(samples)
            if not motion.is_said and motion.began_s is not None:
                self._judge(motion, motion.began_s, now_s)
        self._motions = [one for one in self._motions if not one.is_said or one is now][-LATE_CYCLES:]

    def close_device(self) -> None:
        """See Client.close_device."""
        self._tracker.close()

    def _follow(self, cycle: int, action: str, now_s: float) -> None:
        """Know which cycle goes on, since when, and what the robot does in it."""
        executed, worker = self.state.get("executed"), str(self.state.get("worker"))
        now = self._motions[-1] if self._motions else None
        if now is None or (cycle, worker) != (now.cycle, now.worker):
            is_next = now is not None and worker == now.worker and cycle == now.cycle + 1
            if now is not None and is_next:
                now.ended_s = now_s
            else:  # another shift, another person, or what happened meanwhile is not known
                self._motions.clear()
            now = _Motion(cycle, worker, self._nothing())
            self._motions.append(now)
            self._remarks.clear()
            if executed is not None or not self._robot_answers():
                now.began_s, now.is_whole = now_s, is_next
        elif executed is not None and now.executed is None and not now.is_said:  # the robot begins it only now
            now.growing, now.began_s, now.is_whole, now.told = self._nothing(), now_s, True, 0
        now.executed, now.action = executed, executed or action

    def _nothing(self) -> Growing:
        return Growing(self._recogniser.cycle, len(DEGREES_OF_FREEDOM))

    def _robot_answers(self) -> bool:
        return bool(self.state.get("robot") == "answers")

    def _judge(self, motion: _Motion, began_s: float, now_s: float) -> None:
        """Publish what is known of a cycle so far, and tell the face at its end."""
        end_s = min(began_s + self._ends_s[-1], motion.ended_s)
        is_wanted = motion.is_whole and self.state.get("advised") is True
        if is_wanted and motion is self._motions[-1]:
            self._publish_growing(motion, motion.growing.parts(self._newest_s - began_s))
        if self._newest_s < end_s and now_s < end_s + WAIT_S:
            return
        parts = motion.growing.parts(end_s - began_s)
        if is_wanted and self._can_be_judged(motion, parts):
            self._conclude(motion, likelihood=self._recogniser.probabilities(motion.action, parts))
        elif motion.ended_s < math.inf:
            motion.is_said = True  # the face counts it as not seen
        elif self._robot_answers():
            return  # the robot's client ends it
        elif np.isfinite(parts).any():
            self._conclude(motion)
        else:  # nobody is there, as in a pause
            motion.began_s, motion.is_whole = None, False

    def _can_be_judged(self, motion: _Motion, parts: Array) -> bool:
        """Whether enough was measured of a cycle, by the mean angles (K, J) of its parts."""
        joints = self._recogniser.actions[motion.action].model.joints
        is_seen = np.isfinite(parts[:, joints])
        if not len(parts) or not is_seen[0].any():
            self._remark(f"cycle {motion.cycle}: nothing was measured of its beginning; it counts as not seen")
            return False
        if not is_seen.any(axis=1).all():
            self._remark(f"cycle {motion.cycle}: parts were not measured; what came after the first does not count")
        if len(parts) == len(self._ends_s) and np.nanmax(np.abs(parts)) < LEAST_DEG:
            self._remark(
                f"cycle {motion.cycle}: no angle was above {LEAST_DEG:.1f} degrees, so that they are radians or nobody "
                "moved; it counts as not seen"
            )
            return False
        return True

    def _publish_growing(self, motion: _Motion, parts: Array) -> None:
        """Say what is known after another part of the cycle going on, for whoever wants to know it early."""
        if len(parts) > motion.told:
            motion.told = len(parts)
            self._publish(
                {
                    "cycle": motion.cycle,
                    "action": motion.action,
                    "seconds": round(float(self._ends_s[len(parts) - 1]), 6),
                    "likelihood": self._recogniser.probabilities(motion.action, parts),
                }
            )

    def _conclude(self, motion: _Motion, **said: dict[str, float]) -> None:
        """Say what was seen of a cycle; while the face is away, again and again."""
        try:
            self.connection.call("observe", cycle=motion.cycle, **said)
        except FaceRefusedError as error:
            self.ignore(str(error))
        except FaceUnreachableError as error:
            self.say(str(error))
            return
        motion.is_said = True

    def _remark(self, remark: str) -> None:
        """Something that people should know, once in a cycle."""
        if remark not in self._remarks:
            self._remarks.add(remark)
            self.ignore(remark)
